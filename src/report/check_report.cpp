#include "report/check_report.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "recording/control_mode.hpp"
#include "recording/events.hpp"
#include "util/constants.hpp"
#include "util/text.hpp"
#include "wording.hpp"

namespace battery_sof {
namespace {

using nlohmann::json;

constexpr EventKind kKinds[] = {EventKind::kCrank, EventKind::kDischarge, EventKind::kCharge,
                                EventKind::kRest};

EventSummary summaryOf(const Recording& recording) {
  return summarise(recording.series, detectEvents(recording.series));
}

struct Extremes {
  double low, high;
};

Extremes extremesOf(const std::vector<double>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return {*low, *high};
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

std::string describeRate(double interval) {
  if (interval <= 0.0) return "a single sample";
  std::string text = "one every " + number(interval) + " s";
  return interval <= 2.0 ? text + " (" + number(1.0 / interval) + " Hz)" : text;
}

std::string describeRejected(const RejectedCounts& rejected) {
  std::string text;
  const auto add = [&text](std::size_t count, const char* reason) {
    if (count > 0) text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + reason;
  };
  add(rejected.missing_value, "missing value");
  add(rejected.not_finite, "not finite");
  add(rejected.duplicate_stamp, "duplicate stamp");
  add(rejected.clock_step_back, "clock step back");
  add(rejected.out_of_range, "out of range");
  return text.empty() ? "none" : text;
}

std::string describeRange(const std::vector<double>& values, std::optional<double> step,
                          const std::string& unit) {
  const Extremes extremes = extremesOf(values);
  std::string text =
      number(extremes.low) + " " + unit + " to " + number(extremes.high) + " " + unit;
  return step ? text + ", in steps of " + threeDigits(*step) + " " + unit : text;
}

std::string temperatureText(const Series& series) {
  if (series.temperature.empty()) return "";
  const Extremes kelvin = extremesOf(series.temperature);
  return entry("temperature", number(kelvin.low - kZeroCelsius) + " degC to " +
                                  number(kelvin.high - kZeroCelsius) + " degC");
}

std::string overviewText(const Recording& recording, const CheckReport& report) {
  const Series& series = recording.series;
  return entry("samples", std::to_string(report.samples) + " of " +
                              std::to_string(recording.offered) + " over " +
                              duration(report.to - report.from) + ", " +
                              describeRate(report.median_interval)) +
         entry("time", number(report.from) + " s to " + number(report.to) + " s") +
         entry("refused", describeRejected(recording.rejected)) +
         entry("current", describeRange(series.current, report.current_lsb, "A")) +
         entry("voltage", describeRange(series.voltage, report.voltage_lsb, "V")) +
         temperatureText(series);
}

std::string eventsText(const EventSummary& summary) {
  std::string text = "\n  events          count   in all\n";
  for (const EventKind kind : kKinds) {
    const EventTotals& totals = summary.of(kind);
    text += format("    %-10s %8zu   %s\n", toString(kind).c_str(), totals.count,
                   duration(totals.duration).c_str());
  }
  text += "    " + number(summary.charge_in / kSecondsPerHour) + " Ah in, " +
          number(-summary.charge_out / kSecondsPerHour) + " Ah out\n";
  if (!summary.max_charge_voltage) return text;
  return text + "    charges: " + std::to_string(summary.long_charges) +
         " longer than 10 s, the longest " + duration(summary.longest_charge) + ", at " +
         number(*summary.min_charge_voltage) + " V to " + number(*summary.max_charge_voltage) +
         " V\n";
}

std::string sourceText(const ControlModes& source) {
  std::string text = "\n  source\n" + wrapped("    ", source.summary);
  for (const ControlModeTotals& totals : totalsOf(source)) {
    std::string lead = "    " + toString(totals.mode);
    lead.resize(13, ' ');
    text += wrapped(
        lead, std::to_string(totals.samples) + " samples in " + std::to_string(totals.stretches) +
                  (totals.stretches == 1 ? " stretch: " : " stretches: ") + totals.reason);
  }
  return text;
}

std::string timesText(const Finding& finding) {
  std::string text = "at ";
  for (std::size_t k = 0; k < finding.at.size(); ++k) {
    text += (k == 0 ? "" : ", ") + number(finding.at[k]) + " s";
  }
  return text;
}

std::string findingText(const Finding& finding) {
  std::string lead = "    " + toString(finding.severity);
  lead.resize(13, ' ');
  const std::string indent(lead.size(), ' ');
  std::string text = wrapped(lead, finding.id + ": " + finding.what);
  text += wrapped(indent, finding.meaning);
  if (!finding.at.empty()) text += wrapped(indent, timesText(finding));
  return text;
}

std::string findingsText(const CheckReport& report) {
  if (report.findings.empty()) return "\n  findings: none\n";
  std::string text = "\n  findings\n";
  for (const Finding& finding : report.findings) text += findingText(finding);
  return text;
}

std::string notJudgedText(const CheckReport& report) {
  if (report.not_judged.empty()) return "";
  std::string text = "\n  not judged\n";
  for (const std::string& line : report.not_judged) text += wrapped("    ", line);
  return text;
}

// ---------------------------------------------------------------------------------------------
// JSON

json orNull(std::optional<double> value) { return value ? json(*value) : json(nullptr); }

json rangeJson(const std::vector<double>& values) {
  const Extremes extremes = extremesOf(values);
  return {extremes.low, extremes.high};
}

json temperatureJson(const Series& series) {
  if (series.temperature.empty()) return nullptr;
  const Extremes kelvin = extremesOf(series.temperature);
  return {kelvin.low - kZeroCelsius, kelvin.high - kZeroCelsius};
}

json rejectedJson(const RejectedCounts& rejected) {
  return {{"missing_value", rejected.missing_value},
          {"not_finite", rejected.not_finite},
          {"duplicate_stamp", rejected.duplicate_stamp},
          {"clock_step_back", rejected.clock_step_back},
          {"out_of_range", rejected.out_of_range}};
}

json eventsJson(const EventSummary& summary) {
  json events = {{"charge_in_ah", summary.charge_in / kSecondsPerHour},
                 {"charge_out_ah", summary.charge_out / kSecondsPerHour},
                 {"longest_charge_s", summary.longest_charge},
                 {"charges_over_10_s", summary.long_charges},
                 {"charge_voltage_range_v", nullptr}};
  if (summary.min_charge_voltage && summary.max_charge_voltage) {
    events["charge_voltage_range_v"] = {*summary.min_charge_voltage, *summary.max_charge_voltage};
  }
  for (const EventKind kind : kKinds) {
    const EventTotals& totals = summary.of(kind);
    events[toString(kind)] = {{"count", totals.count}, {"duration_s", totals.duration}};
  }
  return events;
}

json sourceJson(const ControlModes& source) {
  json reasons = json::array();
  for (const ControlModeTotals& totals : totalsOf(source))
    reasons.push_back({{"reason", totals.reason},
                       {"mode", toString(totals.mode)},
                       {"stretches", totals.stretches},
                       {"samples", totals.samples}});
  return {{"seen", source.seen},
          {"share", source.share},
          {"min_current_a", source.seen ? json(source.rule.min_current) : json(nullptr)},
          {"charges_begin_with", toString(source.rule.charge_begins)},
          {"stretches", source.stretches.size()},
          {"reasons", reasons},
          {"summary", source.summary}};
}

json findingJson(const Finding& finding) {
  return {{"id", finding.id},
          {"severity", toString(finding.severity)},
          {"what", finding.what},
          {"meaning", finding.meaning},
          {"value", orNull(finding.value)},
          {"unit", finding.unit},
          {"samples", finding.samples},
          {"at_s", finding.at}};
}

}  // namespace

std::string checkReportText(const std::string& name, const Recording& recording,
                            const CheckReport& report) {
  return name + "\n" + overviewText(recording, report) + eventsText(summaryOf(recording)) +
         sourceText(detectControlMode(recording.series)) + findingsText(report) +
         notJudgedText(report);
}

json checkReportJson(const std::string& name, const Recording& recording,
                     const CheckReport& report) {
  json findings = json::array();
  for (const Finding& finding : report.findings) findings.push_back(findingJson(finding));
  return {{"schema", "battery_sof/check/1"},
          {"recording", name},
          {"samples", report.samples},
          {"offered", recording.offered},
          {"from_s", report.from},
          {"to_s", report.to},
          {"median_interval_s", report.median_interval},
          {"largest_step_back_s", recording.largest_step_back},
          {"rejected", rejectedJson(recording.rejected)},
          {"voltage_lsb_v", orNull(report.voltage_lsb)},
          {"current_lsb_a", orNull(report.current_lsb)},
          {"voltage_range_v", rangeJson(recording.series.voltage)},
          {"current_range_a", rangeJson(recording.series.current)},
          {"temperature_range_c", temperatureJson(recording.series)},
          {"events", eventsJson(summaryOf(recording))},
          {"source", sourceJson(detectControlMode(recording.series))},
          {"findings", findings},
          {"not_judged", report.not_judged}};
}

}  // namespace battery_sof
