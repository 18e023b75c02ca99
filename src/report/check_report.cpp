#include "report/results.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "battery_sof/intake.hpp"
#include "descriptions.hpp"
#include "recording/control_mode.hpp"
#include "recording/events.hpp"
#include "recording/resample.hpp"
#include "util/constants.hpp"
#include "util/text.hpp"
#include "wording.hpp"

namespace battery_sof {
namespace {

constexpr EventKind kKinds[] = {EventKind::kCrank, EventKind::kDischarge, EventKind::kCharge,
                                EventKind::kRest};

EventSummary summaryOf(const Recording& recording, const CheckReport& report) {
  return summarise(recording.series,
                   detectEvents(recording.series, EventLimits{report.crank.current}));
}

/// Lowest and highest. @param zero where a scale begins that they are shown on.
std::vector<double> extremesOf(const std::vector<double>& values, double zero = 0.0) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return {*low - zero, *high - zero};
}

// ---------------------------------------------------------------------------------------------
// text

/// Five significant digits; times of 1000 s and more to a tenth.
std::string number(double value) {
  const bool is_large = std::abs(value) >= 1e3 && std::abs(value) < 1e12;
  return format(is_large ? "%.14g" : "%.5g", is_large ? std::round(10.0 * value) / 10.0 : value);
}

/// "6 h 16 min 43 s"; below a minute with fractions.
std::string duration(double seconds) {
  if (seconds < 60.0) return number(seconds) + " s";
  const long whole = std::lround(seconds);
  const long days = whole / 86400, hours = whole / 3600 % 24, minutes = whole / 60 % 60;
  std::string text;
  if (days > 0) text += std::to_string(days) + " d ";
  if (days > 0 || hours > 0) text += std::to_string(hours) + " h ";
  text += std::to_string(minutes) + " min";
  return days > 0 ? text : text + " " + std::to_string(whole % 60) + " s";
}

std::string entry(const std::string& label, const std::string& text) {
  constexpr std::size_t kLabelWidth = 15;
  std::string lead = "  " + label;
  lead.resize(std::max(lead.size() + 1, kLabelWidth), ' ');
  return wrapped(lead, text);
}

std::string rangeText(const std::vector<double>& extremes, const std::string& unit,
                      const std::optional<double>& step = std::nullopt) {
  return number(extremes[0]) + " " + unit + " to " + number(extremes[1]) + " " + unit +
         (step ? ", in steps of " + threeDigits(*step) + " " + unit : "");
}

std::string overviewText(const Recording& recording, const CheckReport& report) {
  const Series& series = recording.series;
  const double interval = report.median_interval;
  std::string rate = interval <= 0.0 ? "a single sample" : "one every " + number(interval) + " s";
  if (interval > 0.0 && interval <= 2.0) rate += " (" + number(1.0 / interval) + " Hz)";
  std::string text =
      entry("samples", std::to_string(report.samples) + " of " + std::to_string(recording.offered) +
                           " over " + duration(report.to - report.from) + ", " + rate) +
      entry("time", number(report.from) + " s to " + number(report.to) + " s") +
      entry("refused", recording.rejected.total() > 0 ? reasonsOf(recording.rejected) : "none") +
      entry("current", rangeText(extremesOf(series.current), "A", report.current_lsb)) +
      entry("voltage", rangeText(extremesOf(series.voltage), "V", report.voltage_lsb));
  if (series.temperature.empty()) return text;
  return text +
         entry("temperature", rangeText(extremesOf(series.temperature, kZeroCelsius), "degC"));
}

/// What counts as an engine start, how many do, and who says so.
std::string crankText(const CrankCurrent& crank, std::size_t count) {
  const std::string what =
      format("%zu %s taken as engine start%s: %s %s A or below for at most %g s", count,
             count == 1 ? "pulse is" : "pulses are", count == 1 ? "" : "s",
             count == 1 ? "it reaches" : "they reach", number(crank.current).c_str(),
             EventLimits::kCrankMaxDuration);
  const char* why = "";
  switch (crank.source) {
    case CrankCurrent::Source::kGiven: why = " (--crank-current)"; break;
    case CrankCurrent::Source::kUsual:
      if (crank.pulse)
        return what + " (the usual value, which most of the short pulses here reach)";
      why =
          " (the usual value, because no short pulse here lowers the voltage enough to suggest "
          "another)";
      break;
    case CrankCurrent::Source::kRecording:
      return what + " (read off the largest repeated pulses, of " + number(*crank.pulse) + " A)";
  }
  return what + why;
}

std::string eventsText(const EventSummary& summary, const CrankCurrent& crank) {
  std::string text = "\n  events          count   in all\n";
  for (const EventKind kind : kKinds) {
    const EventTotals& totals = summary.of(kind);
    text += format("    %-10s %8zu   %s\n", toString(kind).c_str(), totals.count,
                   duration(totals.duration).c_str());
  }
  text += wrapped("    ", crankText(crank, summary.of(EventKind::kCrank).count));
  text += "    " + number(summary.charge_in / kSecondsPerHour) + " Ah in, " +
          number((0.0 - summary.charge_out) / kSecondsPerHour) + " Ah out\n";
  if (!summary.max_charge_voltage) return text;
  return text + "    charges: " + std::to_string(summary.long_charges) +
         " longer than 10 s, the longest " + duration(summary.longest_charge) + ", at " +
         number(*summary.min_charge_voltage) + " V to " + number(*summary.max_charge_voltage) +
         " V\n";
}

/// What a line of a list begins with.
std::string leadOf(const std::string& word) { return format("    %-9s", word.c_str()); }

std::string sourceText(const ControlModes& source) {
  std::string text = "\n  source\n" + wrapped("    ", source.summary);
  for (const ControlModeTotals& totals : source.totals) {
    text +=
        wrapped(leadOf(toString(totals.mode)),
                std::to_string(totals.samples) + " samples in " + std::to_string(totals.stretches) +
                    (totals.stretches == 1 ? " stretch: " : " stretches: ") + totals.reason);
  }
  return text;
}

std::string findingText(const Finding& finding) {
  const std::string lead = leadOf(toString(finding.severity)), indent = leadOf("");
  std::vector<std::string> times;
  for (const double at : finding.at) times.push_back(number(at) + " s");
  return wrapped(lead, finding.id + ": " + finding.what) + wrapped(indent, finding.meaning) +
         (times.empty() ? "" : wrapped(indent, "at " + join(times)));
}

}  // namespace

// ---------------------------------------------------------------------------------------------
// JSON

DESCRIBED(RejectedCounts, MEMBERS("", missing_value, not_finite, duplicate_stamp),
          MEMBERS("", clock_step_back, out_of_range))

DESCRIBED(EventTotals, MEMBERS("", count), MEMBERS("s", duration))

template <typename Visit>
void describe(Visit& visit, const EventSummary& summary) {
  using Range = std::optional<std::vector<double>>;
  const auto &low = summary.min_charge_voltage, &high = summary.max_charge_voltage;
  visit("charge_in", summary.charge_in / kSecondsPerHour, "ah");
  visit("charge_out", summary.charge_out / kSecondsPerHour, "ah");
  visit("longest_charge", summary.longest_charge, "s");
  visit("charges_over_10", summary.long_charges, "s");
  visit("charge_voltage_range", low && high ? Range({*low, *high}) : Range(), "v");
  for (const EventKind kind : kKinds) visit(toString(kind), summary.of(kind));
}

DESCRIBED(ControlModes, MEMBERS("", seen, share, summary), visit("reasons", of.totals),
          visit("min_current", of.seen ? std::optional(of.rule.min_current) : std::nullopt, "a"),
          visit("charges_begin_with", toString(of.rule.charge_begins)),
          visit("stretches", std::accumulate(of.totals.begin(), of.totals.end(), std::size_t{0},
                                             [](std::size_t sum, const ControlModeTotals& totals) {
                                               return sum + totals.stretches;
                                             })))

DESCRIBED(Finding, MEMBERS("", id, what, meaning, value, unit, samples), MEMBERS("s", at),
          visit("severity", toString(of.severity)))

std::string checkReportText(const Recording& recording, const CheckReport& report) {
  std::string text = recording.name + "\n" + overviewText(recording, report) +
                     eventsText(summaryOf(recording, report), report.crank) +
                     sourceText(detectControlMode(atDesignRate(recording.series),
                                                  EventLimits{report.crank.current})) +
                     (report.findings.empty() ? "\n  findings: none\n" : "\n  findings\n");
  for (const Finding& finding : report.findings) text += findingText(finding);
  if (!report.not_judged.empty()) text += "\n  not judged\n";
  for (const std::string& line : report.not_judged) text += wrapped("    ", line);
  return text;
}

nlohmann::json checkReportJson(const Recording& recording, const CheckReport& of) {
  const Series& series = recording.series;
  std::optional<std::vector<double>> celsius;
  if (!series.temperature.empty()) celsius = extremesOf(series.temperature, kZeroCelsius);
  JsonFields visit;
  MEMBERS("", samples, findings, not_judged);
  MEMBERS("s", from, to, median_interval);
  MEMBERS("v", voltage_lsb);
  MEMBERS("a", current_lsb);
  visit("schema", "battery_sof/check/1");
  visit("recording", recording.name);
  visit("offered", recording.offered);
  visit("largest_step_back", recording.largest_step_back, "s");
  visit("rejected", recording.rejected);
  visit("voltage_range", extremesOf(series.voltage), "v");
  visit("current_range", extremesOf(series.current), "a");
  visit("temperature_range", celsius, "c");
  visit("events", summaryOf(recording, of));
  visit("crank_current", of.crank.current, "a");
  visit("crank_current_from", toString(of.crank.source));
  visit("source", detectControlMode(atDesignRate(series), EventLimits{of.crank.current}));
  return visit.json;
}

}  // namespace battery_sof
