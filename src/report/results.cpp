#include "report/results.hpp"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <nlohmann/json.hpp>

#include "battery_sof/version.hpp"
#include "prediction/query.hpp"
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

template <typename T>
nlohmann::json orNull(const std::optional<T>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json(nullptr);
}

nlohmann::json windowJson(const FitWindow& window) {
  return {{"from_s", window.from}, {"to_s", window.to}};
}

const char* remarkOn(const ParameterEstimate& estimate) {
  if (estimate.held) return "held";
  if (estimate.at_bound) return "at a bound";
  return estimate.determined ? "" : "not determined by this window";
}

std::string toString(const std::optional<Interval>& interval) {
  if (!interval) return "-";
  return format("%.3f V, 90 %% between %.3f and %.3f V", interval->value, interval->lower,
                interval->upper);
}

}  // namespace

nlohmann::json identifyJson(const FittedModel& model) {
  nlohmann::json parameters = nlohmann::json::array();
  for (const auto& estimate : model.fit.estimates)
    parameters.push_back({{"name", estimate.name},
                          {"value", estimate.value},
                          {"std_error", orNull(estimate.std)},
                          {"unit", estimate.unit},
                          {"held", estimate.held},
                          {"at_bound", estimate.at_bound},
                          {"determined", estimate.determined}});
  return {{"schema", "battery_sof/model/1"},
          {"program", "battery_sof " + version()},
          {"recording", printable(model.provenance.recording)},
          {"series_blocks", model.fit.series_blocks},
          {"window", windowJson(model.fit.window)},
          {"samples", model.fit.window.samples},
          {"effects", model.fit.effects},
          {"status", toString(model.fit.status)},
          {"message", model.fit.message},
          {"start", model.fit.start},
          {"iterations", model.fit.iterations},
          {"parameters", parameters},
          {"state", {{"time_s", model.state.time}, {"u_c2_v", model.state.u_c2}}},
          {"q_dyn_percent", model.fit.scores.q_dyn_percent},
          {"rmse_v", model.fit.scores.rmse},
          {"window_quality", model.fit.window_quality},
          {"fit_ms", model.provenance.fit_ms}};
}

std::string identifyText(const FittedModel& model) {
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

nlohmann::json cranksJson(const std::vector<CrankScore>& scores) {
  nlohmann::json cranks = nlohmann::json::array();
  for (const auto& crank : scores)
    cranks.push_back({{"time_s", crank.time},
                      {"current_a", crank.current},
                      {"measured_min_v", crank.measured_minimum},
                      {"predicted_min_v", crank.predicted_minimum.value},
                      {"lower_v", crank.predicted_minimum.lower},
                      {"upper_v", crank.predicted_minimum.upper}});
  return cranks;
}

nlohmann::json chargesJson(const std::vector<ChargeScore>& scores, double duration) {
  nlohmann::json charges = nlohmann::json::array();
  for (const auto& charge : scores)
    if (charge.duration == duration)
      charges.push_back({{"time_s", charge.time},
                         {"duration_s", charge.duration},
                         {"measured_a", charge.measured},
                         {"predicted_a", charge.predicted.value},
                         {"lower_a", charge.predicted.lower},
                         {"upper_a", charge.predicted.upper}});
  return charges;
}

std::optional<double> medianChargeError(const std::vector<ChargeScore>& charges, double duration) {
  std::vector<double> errors;
  for (const auto& charge : charges)
    if (charge.duration == duration)
      errors.push_back(std::abs(charge.measured - charge.predicted.value));
  if (errors.empty()) return std::nullopt;
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  return *middle;
}

nlohmann::json bothWaysJson(const BothWaysScores& scores) {
  const MixedScores& mixed = scores.mixed;
  return {{"share_percent", orNull(mixed.share_percent)},
          {"current_share_percent", orNull(mixed.current_share_percent)},
          {"voltage_share_percent", orNull(mixed.voltage_share_percent)},
          {"current_rmse_a", orNull(mixed.current_rmse)},
          {"charges", chargesJson(mixed.charges, 10.0)},
          {"charges_60s", chargesJson(mixed.charges, 60.0)},
          {"cranks", cranksJson(scores.cranks)},
          {"crank_mae_v", orNull(scores.crank_mean_abs_error)}};
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

nlohmann::json predictionJson(const PredictionReport& report) {
  const PredictionScores& scores = report.from_current;
  nlohmann::json baseline = bothWaysJson(report.baseline);
  baseline["q_dyn_percent"] =
      report.baseline_from_current ? orNull(report.baseline_from_current->q_dyn_percent) : nullptr;
  baseline["rmse_v"] =
      report.baseline_from_current ? nlohmann::json(report.baseline_from_current->rmse) : nullptr;
  return {{"schema", "battery_sof/prediction/1"},
          {"window", windowJson(scores.window)},
          {"samples", scores.window.samples},
          {"q_dyn_percent", orNull(scores.q_dyn_percent)},
          {"rmse_v", scores.rmse},
          {"max_abs_v", scores.max_abs},
          {"coverage_90", scores.coverage_90},
          {"crank_mae_v", orNull(scores.crank_mean_abs_error)},
          {"cranks", cranksJson(scores.cranks)},
          {"mixed", report.both_ways ? bothWaysJson(*report.both_ways) : nlohmann::json(nullptr)},
          {"baseline", baseline}};
}

std::string predictionText(const PredictionReport& report) {
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

nlohmann::json crankingJson(const CrankingAnswer& answer) {
  nlohmann::json json;
  json["u_min"] = answer.u_min ? nlohmann::json(answer.u_min->value) : nlohmann::json(nullptr);
  json["lower"] = answer.u_min ? nlohmann::json(answer.u_min->lower) : nlohmann::json(nullptr);
  json["upper"] = answer.u_min ? nlohmann::json(answer.u_min->upper) : nlohmann::json(nullptr);
  json["capable"] = orNull(answer.capable);
  json["valid"] = answer.valid;
  json["code"] = static_cast<int>(answer.code);
  json["message"] = answer.message;
  return json;
}

std::string crankingText(const CrankingQuery& query, const CrankingAnswer& answer) {
  std::string text;
  if (query.load.empty())
    appendLine(text, "stop      %.1f s at %.1f A", query.t_stop, query.i_load);
  else
    appendLine(text, "stop      %.1f s of the given profile", query.load.duration());
  if (query.crank.empty())
    appendLine(text, "crank     %.2f s at %.1f A", query.t_cranking, query.i_cranking);
  else
    appendLine(text, "crank     %.2f s of the given profile", query.crank.duration());
  appendLine(text, "lowest    %s", toString(answer.u_min).c_str());
  if (answer.capable)
    appendLine(text, "verdict   %s %.2f V", *answer.capable ? "holds" : "may not hold",
               query.u_required.value_or(0.0));
  appendLine(text, "%s: %s", toString(answer.code).c_str(), answer.message.c_str());
  return text;
}

}  // namespace battery_sof
