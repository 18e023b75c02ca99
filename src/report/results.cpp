#include "report/results.hpp"

#include <algorithm>
#include <cmath>
#include <cstdarg>

#include "battery_sof/version.hpp"
#include "descriptions.hpp"
#include "recording/series_blocks.hpp"
#include "util/printable.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

/// A sentence onto the end of a text.
__attribute__((format(printf, 2, 3))) void appendLine(std::string& text, const char* pattern, ...) {
  std::va_list arguments;
  va_start(arguments, pattern);
  text += sentenceOf(pattern, arguments) + '\n';
  va_end(arguments);
}

const char* remarkOn(const ParameterEstimate& estimate) {
  if (estimate.held) return "held";
  if (estimate.at_bound) return "at a bound";
  return estimate.determined ? "" : "not determined by this window";
}

}  // namespace

nlohmann::json resultJson(const FittedModel& model) {
  JsonFields visit;
  describe(visit, model);
  visit("schema", "battery_sof/model/1");
  visit("program", "battery_sof " + version());
  visit("recording", printable(model.provenance.recording));
  visit("series_blocks", model.fit.series_blocks);
  visit("window", model.fit.window);
  visit("samples", model.fit.window.samples);
  visit("start", model.fit.start);
  visit("iterations", model.fit.iterations);
  visit("parameters", model.fit.estimates);
  visit("state", [&](auto& state) {
    state("time", model.state.time, "s");
    state("u_c2", model.state.u_c2, "v");
  });
  return visit.json;
}

std::string resultText(const FittedModel& model) {
  std::string text;
  appendLine(text, "window       %.2f to %.2f s, %zu samples, current %.1f to %.1f A",
             model.fit.window.from, model.fit.window.to, model.fit.window.samples,
             model.fit.excited.min_current, model.fit.excited.max_current);
  if (model.fit.series_blocks != 1.0)
    text += "blocks       " + seriesBlocksSentence(model.fit.series_blocks) + "\n";
  appendLine(text, "%-26s %12s %12s", "parameter", "value", "std. error");
  for (const auto& e : model.fit.estimates) {
    if (e.std)
      appendLine(text, "%-26s %12.6g %12.2g %-4s %s", e.name.c_str(), e.value, *e.std,
                 e.unit.c_str(), remarkOn(e));
    else
      appendLine(text, "%-26s %12.6g %12s %-4s %s", e.name.c_str(), e.value, "-", e.unit.c_str(),
                 remarkOn(e));
  }
  appendLine(text, "fit          Q_dyn %.1f %%, RMS error %.1f mV, residual correlated over %.2f s",
             model.fit.scores.q_dyn_percent, 1e3 * model.fit.scores.rmse,
             model.fit.scores.residual_correlation_time);
  if (model.fit.scores.cranks > 0)
    appendLine(text, "cranks       %d in the window, minima missed by %.0f mV (RMS)",
               model.fit.scores.cranks, 1e3 * model.fit.scores.crank_error_std);
  appendLine(text, "state        u_c2 = %.4f V at %.2f s", model.state.u_c2, model.state.time);
  appendLine(text, "quality      %.2f of the window for this model", model.fit.window_quality);
  appendLine(text, "%s: %s (%.1f ms)", toString(model.fit.status).c_str(),
             model.fit.message.c_str(), model.provenance.fit_ms);
  return text;
}

namespace {

template <typename Visit>
void describeInterval(Visit& visit, const char* name, const Interval& interval, const char* unit) {
  visit(name, interval.value, unit);
  visit("lower", interval.lower, unit);
  visit("upper", interval.upper, unit);
}

}  // namespace

DESCRIBED(CrankScore, MEMBERS("s", time), MEMBERS("a", current),
          visit("measured_min", of.measured_minimum, "v"),
          describeInterval(visit, "predicted_min", of.predicted_minimum, "v"))

DESCRIBED(ChargeScore, MEMBERS("s", time, duration), MEMBERS("a", measured),
          describeInterval(visit, "predicted", of.predicted, "a"))

namespace {

std::vector<ChargeScore> chargesOver(double duration, std::vector<ChargeScore> charges) {
  const auto is_other = [&](const ChargeScore& charge) { return charge.duration != duration; };
  charges.erase(std::remove_if(charges.begin(), charges.end(), is_other), charges.end());
  return charges;
}

std::optional<double> medianChargeError(const std::vector<ChargeScore>& charges, double duration) {
  std::vector<double> errors;
  for (const ChargeScore& charge : chargesOver(duration, charges))
    errors.push_back(std::abs(charge.measured - charge.predicted.value));
  if (errors.empty()) return std::nullopt;
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  return *middle;
}

nlohmann::json bothWaysJson(const BothWaysScores& scores) {
  JsonFields visit;
  const MixedScores& mixed = scores.mixed;
  visit("share_percent", mixed.share_percent);
  visit("current_share_percent", mixed.current_share_percent);
  visit("voltage_share_percent", mixed.voltage_share_percent);
  visit("current_rmse", mixed.current_rmse, "a");
  visit("charges", chargesOver(10.0, mixed.charges));
  visit("charges_60s", chargesOver(60.0, mixed.charges));
  visit("cranks", scores.cranks);
  visit("crank_mae", scores.crank_mean_abs_error, "v");
  return visit.json;
}

std::string percentOf(const std::optional<double>& share) {
  return share ? format("%.1f %%", *share) : "-";
}
std::string amperesOf(const std::optional<double>& current) {
  return current ? format("%.2f A", *current) : "-";
}
std::string millivoltsOf(const std::optional<double>& voltage) {
  return voltage ? format("%.0f mV", 1e3 * *voltage) : "-";
}

/// One line of the comparison with what needs no physics.
void appendBothWays(std::string& text, const char* name, const BothWaysScores& scores) {
  const auto& charges = scores.mixed.charges;
  appendLine(text, "%-9s %9s %9s %9s %10s %10s %10s", name,
             percentOf(scores.mixed.share_percent).c_str(),
             percentOf(scores.mixed.current_share_percent).c_str(),
             percentOf(scores.mixed.voltage_share_percent).c_str(),
             amperesOf(medianChargeError(charges, 10.0)).c_str(),
             amperesOf(medianChargeError(charges, 60.0)).c_str(),
             millivoltsOf(scores.crank_mean_abs_error).c_str());
}

}  // namespace

nlohmann::json resultJson(const PredictionReport& report) {
  const PredictionScores& scores = report.from_current;
  const auto& line = report.baseline_from_current;
  nlohmann::json baseline = bothWaysJson(report.baseline);
  baseline["q_dyn_percent"] = jsonOf(line ? line->q_dyn_percent : std::nullopt);
  baseline["rmse_v"] = jsonOf(line ? std::optional<double>(line->rmse) : std::nullopt);
  JsonFields visit;
  visit("schema", "battery_sof/prediction/1");
  visit("window", scores.window);
  visit("samples", scores.window.samples);
  visit("q_dyn_percent", scores.q_dyn_percent);
  visit("rmse", scores.rmse, "v");
  visit("max_abs", scores.max_abs, "v");
  visit("coverage_90", scores.coverage_90);
  visit("crank_mae", scores.crank_mean_abs_error, "v");
  visit("cranks", scores.cranks);
  visit("mixed", report.both_ways ? bothWaysJson(*report.both_ways) : nullptr);
  visit("baseline", baseline);
  return visit.json;
}

std::string resultText(const PredictionReport& report) {
  const PredictionScores& scores = report.from_current;
  std::string text;
  appendLine(text, "window    %.2f to %.2f s, %zu samples", scores.window.from, scores.window.to,
             scores.window.samples);
  if (report.both_ways) {
    appendLine(text, "voltage as input where a source controls it, current elsewhere:");
    appendLine(text, "%-9s %9s %9s %9s %10s %10s %10s", "", "explained", "current", "voltage",
               "10 s", "60 s", "cranks");
    appendBothWays(text, "model", *report.both_ways);
    appendBothWays(text, "baseline", report.baseline);
    appendLine(
        text,
        "(explained variation, 1 - RMS error / standard deviation; median error of a charge's "
        "mean current; mean error of cranks' minima)");
    appendLine(text, "current as input throughout:");
  }
  if (scores.q_dyn_percent)
    appendLine(
        text, "Q_dyn     %.1f %%%s", *scores.q_dyn_percent,
        report.baseline_from_current && report.baseline_from_current->q_dyn_percent
            ? format("; baseline %.1f %%", *report.baseline_from_current->q_dyn_percent).c_str()
            : "");
  else
    appendLine(text, "Q_dyn     undefined: the measured voltage never changes");
  appendLine(text,
             "error     RMS %.1f mV, largest %.1f mV; %.0f %% of samples inside the 90 %% band",
             1e3 * scores.rmse, 1e3 * scores.max_abs, 100.0 * scores.coverage_90);
  if (scores.cranks.empty()) {
    appendLine(text, "cranks    none");
    return text;
  }
  appendLine(text, "cranks    %zu, minima missed by %.0f mV on average; baseline %s",
             scores.cranks.size(), 1e3 * scores.crank_mean_abs_error.value_or(0.0),
             millivoltsOf(report.baseline.crank_mean_abs_error).c_str());
  appendLine(text, "%12s %9s %10s %10s %22s", "time [s]", "I [A]", "measured", "predicted",
             "90 % interval [V]");
  for (const auto& c : scores.cranks)
    appendLine(text, "%12.2f %9.1f %10.3f %10.3f %10.3f to %.3f", c.time, c.current,
               c.measured_minimum, c.predicted_minimum.value, c.predicted_minimum.lower,
               c.predicted_minimum.upper);
  return text;
}

}  // namespace battery_sof
