#include "report/results.hpp"

#include <algorithm>
#include <cmath>

#include "battery_sof/version.hpp"
#include "descriptions.hpp"
#include "recording/series_blocks.hpp"
#include "util/printable.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

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
  text += format("window       %.2f to %.2f s, %zu samples, current %.1f to %.1f A\n",
                 model.fit.window.from, model.fit.window.to, model.fit.window.samples,
                 model.fit.excited.min_current, model.fit.excited.max_current);
  if (model.fit.series_blocks != 1.0)
    text += "blocks       " + seriesBlocksSentence(model.fit.series_blocks) + "\n";
  text += format("%-26s %12s %12s\n", "parameter", "value", "std. error");
  for (const auto& e : model.fit.estimates) {
    if (e.std)
      text += format("%-26s %12.6g %12.2g %-4s %s\n", e.name.c_str(), e.value, *e.std,
                     e.unit.c_str(), remarkOn(e));
    else
      text += format("%-26s %12.6g %12s %-4s %s\n", e.name.c_str(), e.value, "-", e.unit.c_str(),
                     remarkOn(e));
  }
  text += format("fit          Q_dyn %.1f %%, RMS error %.1f mV, residual correlated over %.2f s\n",
                 model.fit.scores.q_dyn_percent, 1e3 * model.fit.scores.rmse,
                 model.fit.scores.residual_correlation_time);
  if (model.fit.scores.cranks > 0)
    text += format("cranks       %d in the window, minima missed by %.0f mV (RMS)\n",
                   model.fit.scores.cranks, 1e3 * model.fit.scores.crank_error_std);
  text += format("state        u_c2 = %.4f V at %.2f s\n", model.state.u_c2, model.state.time);
  text += format("quality      %.2f of the window for this model\n", model.fit.window_quality);
  text += format("%s: %s (%.1f ms)\n", toString(model.fit.status).c_str(),
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

}  // namespace

DESCRIBED(BothWaysScores, MEMBERS("", cranks), visit("crank_mae", of.crank_mean_abs_error, "v"),
          visit("share_percent", of.mixed.share_percent),
          visit("current_share_percent", of.mixed.current_share_percent),
          visit("voltage_share_percent", of.mixed.voltage_share_percent),
          visit("current_rmse", of.mixed.current_rmse, "a"),
          visit("charges", chargesOver(10.0, of.mixed.charges)),
          visit("charges_60s", chargesOver(60.0, of.mixed.charges)))

namespace {

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
  text += format("%-9s %9s %9s %9s %10s %10s %10s\n", name,
                 percentOf(scores.mixed.share_percent).c_str(),
                 percentOf(scores.mixed.current_share_percent).c_str(),
                 percentOf(scores.mixed.voltage_share_percent).c_str(),
                 amperesOf(medianChargeError(charges, 10.0)).c_str(),
                 amperesOf(medianChargeError(charges, 60.0)).c_str(),
                 millivoltsOf(scores.crank_mean_abs_error).c_str());
}

}  // namespace

DESCRIBED(PredictionScores, MEMBERS("", window, q_dyn_percent, coverage_90, cranks),
          MEMBERS("v", rmse, max_abs), visit("crank_mae", of.crank_mean_abs_error, "v"),
          visit("samples", of.window.samples))

nlohmann::json resultJson(const PredictionReport& report) {
  const auto& line = report.baseline_from_current;
  nlohmann::json baseline = jsonOf(report.baseline);
  baseline["q_dyn_percent"] = jsonOf(line ? line->q_dyn_percent : std::nullopt);
  baseline["rmse_v"] = jsonOf(line ? std::optional<double>(line->rmse) : std::nullopt);
  JsonFields visit;
  describe(visit, report.from_current);
  visit("schema", "battery_sof/prediction/1");
  visit("mixed", report.both_ways);
  visit("baseline", baseline);
  return visit.json;
}

std::string resultText(const PredictionReport& report) {
  const PredictionScores& scores = report.from_current;
  std::string text;
  text += format("window    %.2f to %.2f s, %zu samples\n", scores.window.from, scores.window.to,
                 scores.window.samples);
  if (report.both_ways) {
    text += format("voltage as input where a source controls it, current elsewhere:\n");
    text += format("%-9s %9s %9s %9s %10s %10s %10s\n", "", "explained", "current", "voltage",
                   "10 s", "60 s", "cranks");
    appendBothWays(text, "model", *report.both_ways);
    appendBothWays(text, "baseline", report.baseline);
    text += format(
        "(explained variation, 1 - RMS error / standard deviation; median error of a charge's "
        "mean current; mean error of cranks' minima)\n");
    text += format("current as input throughout:\n");
  }
  if (scores.q_dyn_percent)
    text += format(
        "Q_dyn     %.1f %%%s\n", *scores.q_dyn_percent,
        report.baseline_from_current && report.baseline_from_current->q_dyn_percent
            ? format("; baseline %.1f %%", *report.baseline_from_current->q_dyn_percent).c_str()
            : "");
  else
    text += format("Q_dyn     undefined: the measured voltage never changes\n");
  text +=
      format("error     RMS %.1f mV, largest %.1f mV; %.0f %% of samples inside the 90 %% band\n",
             1e3 * scores.rmse, 1e3 * scores.max_abs, 100.0 * scores.coverage_90);
  if (scores.cranks.empty()) {
    text += format("cranks    none\n");
    return text;
  }
  text += format("cranks    %zu, minima missed by %.0f mV on average; baseline %s\n",
                 scores.cranks.size(), 1e3 * scores.crank_mean_abs_error.value_or(0.0),
                 millivoltsOf(report.baseline.crank_mean_abs_error).c_str());
  text += format("%12s %9s %10s %10s %22s\n", "time [s]", "I [A]", "measured", "predicted",
                 "90 % interval [V]");
  for (const auto& c : scores.cranks)
    text +=
        format("%12.2f %9.1f %10.3f %10.3f %10.3f to %.3f\n", c.time, c.current, c.measured_minimum,
               c.predicted_minimum.value, c.predicted_minimum.lower, c.predicted_minimum.upper);
  return text;
}

}  // namespace battery_sof
