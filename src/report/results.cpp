#include "report/results.hpp"

#include <algorithm>
#include <cmath>

#include "battery_sof/version.hpp"
#include "descriptions.hpp"
#include "prediction/capacity.hpp"
#include "recording/channel_statistics.hpp"
#include "recording/series_blocks.hpp"
#include "report/model_yaml.hpp"
#include "util/text.hpp"
#include "wording.hpp"

namespace battery_sof {
namespace {

const char* remarkOn(const ParameterEstimate& estimate) {
  if (estimate.held) return "held";
  if (estimate.at_bound) return "at a bound";
  return estimate.determined ? "" : "not determined by this window";
}

std::vector<EventComparison> chargesOver(double duration, std::vector<EventComparison> charges) {
  const auto is_other = [&](const EventComparison& charge) { return charge.duration != duration; };
  charges.erase(std::remove_if(charges.begin(), charges.end(), is_other), charges.end());
  return charges;
}

std::optional<double> medianChargeError(const std::vector<EventComparison>& charges,
                                        double duration) {
  std::vector<double> errors;
  for (const EventComparison& charge : chargesOver(duration, charges))
    errors.push_back(charge.absError());
  return errors.empty() ? std::nullopt : std::optional(quantile(errors, 0.5));
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
  text += format("%-9s %9s %9s %9s %10s %10s %10s\n", name,
                 percentOf(scores.mixed.share_percent).c_str(),
                 percentOf(scores.mixed.current_share_percent).c_str(),
                 percentOf(scores.mixed.voltage_share_percent).c_str(),
                 amperesOf(medianChargeError(charges, 10.0)).c_str(),
                 amperesOf(medianChargeError(charges, 60.0)).c_str(),
                 millivoltsOf(scores.crank_mean_abs_error).c_str());
}

/// The answer in one line. An answer's message begins with its assurance where it has one.
template <typename Answer>
std::string lastLine(const Answer& answer) {
  return (assuranceOf(answer) ? "" : toString(answer.code) + ": ") + answer.message + "\n";
}

std::string seconds(double duration) {
  return std::isinf(duration) ? "no end" : format("%.1f s", duration);
}

template <typename Answer>
std::string cell(const Answer& answer, const std::optional<Interval>& interval, int digits) {
  if (!interval) return format("%25s", "-");
  const std::string text =
      format("%.*f [%.*f, %.*f]%s", digits, interval->value, digits, interval->lower, digits,
             interval->upper, answer.valid ? "" : "*");
  return format("%25s", text.c_str());
}

template <typename Answer>
std::string table(const std::string& corner, const std::vector<double>& rows,
                  const std::vector<double>& columns, const std::vector<Answer>& answers,
                  std::optional<Interval> Answer::*value, int digits) {
  std::string text = format("%-18s", corner.c_str());
  for (const double column : columns) text += format("%25g", column);
  text += '\n';
  for (std::size_t k = 0; k < answers.size(); ++k) {
    if (k % columns.size() == 0) text += format("%-18g", rows[k / columns.size()]);
    text += cell(answers[k], answers[k].*value, digits);
    if ((k + 1) % columns.size() == 0) text += '\n';
  }
  return text;
}

bool wasFitted(const Fit& fit) { return isUsable(fit) || fit.status == FitStatus::kStalled; }

}  // namespace

nlohmann::json resultJson(const FittedModel& model) {
  JsonFields visit;
  describe(visit, model);
  visit("schema", kIdentificationSchema);
  visit("program", "battery_sof " + version());
  visit("recording", printable(model.provenance.recording));
  visit("series_blocks", model.fit.series_blocks);
  visit("window", model.fit.window);
  visit("samples", model.fit.window.samples);
  visit("start", model.fit.start);
  visit("iterations", model.fit.iterations);
  visit("parameters", model.fit.estimates);
  visit("state", nlohmann::json{{"time_s", jsonOf(model.state.time)},
                                {"u_c2_v", jsonOf(model.state.states[0])}});
  const std::optional<Interval> capacity = estimatedCapacity(model.fit);
  visit("capacity_ah", partOf(capacity, &Interval::value));
  visit("capacity_lower_ah", partOf(capacity, &Interval::lower));
  visit("capacity_upper_ah", partOf(capacity, &Interval::upper));
  if (wasFitted(model.fit)) return visit.json;
  for (const char* of_a_fit : {"q_dyn_percent", "rmse_v"}) visit.json[of_a_fit] = nullptr;
  for (auto& value : visit.json["state"]) value = nullptr;
  return visit.json;
}

std::string resultText(const FittedModel& model, const ControlModeOverview& mode) {
  const std::string conclusion = format("%s: %s (%.1f ms)\n", toString(model.fit.status).c_str(),
                                        model.fit.message.c_str(), model.provenance.fit_ms);
  if (!wasFitted(model.fit)) return conclusion;
  std::string text;
  text += format("window       %.2f to %.2f s, %zu samples, current %.1f to %.1f A\n",
                 model.fit.window.from, model.fit.window.to, model.fit.window.samples,
                 model.fit.excited.min_current, model.fit.excited.max_current);
  if (model.fit.series_blocks != 1.0)
    text += "blocks       " + seriesBlocksSentence(model.fit.series_blocks) + "\n";
  text += format("%-26s %12s %12s\n", "parameter", "value", "std. error");
  for (const auto& e : model.fit.estimates)
    text += format("%-26s %12.6g %12s %-4s %s\n", e.name.c_str(), e.value,
                   e.std ? format("%.2g", *e.std).c_str() : "-", e.unit.c_str(), remarkOn(e));
  text +=
      format("fit          Q_dyn %.1f %%, RMS error %.1f mV, residuals correlated over %.2f s\n",
             model.fit.scores.q_dyn_percent, 1e3 * model.fit.scores.rmse,
             model.fit.scores.residual_correlation_time);
  if (!mode.summary.empty())
    text += wrapped("source       ",
                    mode.summary + (model.fit.source ? " There the voltage is the input of the fit."
                                                     : " The current is the input of the fit."));
  if (model.fit.scores.cranks > 0)
    text += format(
        "cranks       %d in the window; the equations miss their lowest voltages by %.0f mV RMS\n",
        model.fit.scores.cranks, 1e3 * model.fit.scores.crank_error_std);
  if (const auto capacity = estimatedCapacity(model.fit))
    text += format("capacity     %.3g Ah from full to exhausted, 90 %% between %.3g and %.3g Ah\n",
                   capacity->value, capacity->lower, capacity->upper);
  text += format("state        u_c2 = %.4f V at %.2f s\n", model.state.states[0], model.state.time);
  text += format("quality      %.2f (window quality for this model, 0 to 1)\n",
                 model.fit.window_quality);
  return text + conclusion;
}

DESCRIBED(BothWaysScores, MEMBERS("", cranks), visit("crank_mae", of.crank_mean_abs_error, "v"),
          visit("crank_equations_rms", of.crank_equations_rms, "v"),
          visit("share_percent", of.mixed.share_percent),
          visit("current_share_percent", of.mixed.current_share_percent),
          visit("voltage_share_percent", of.mixed.voltage_share_percent),
          visit("current_rmse", of.mixed.current_rmse, "a"),
          visit("charges", chargesOver(10.0, of.mixed.charges)),
          visit("charges_60s", chargesOver(60.0, of.mixed.charges)))

DESCRIBED(PredictionScores, MEMBERS("", window, q_dyn_percent, coverage_90, cranks),
          MEMBERS("v", rmse, max_abs), visit("crank_mae", of.crank_mean_abs_error, "v"),
          visit("crank_equations_rms", of.crank_equations_rms, "v"),
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
  visit("model_age_s", report.model_age);
  visit("cranks_beyond_window", report.cranks_beyond_window);
  return visit.json;
}

std::string resultText(const PredictionReport& report) {
  const PredictionScores& scores = report.from_current;
  std::string text;
  text += format("window    %.2f to %.2f s, %zu samples\n", scores.window.from, scores.window.to,
                 scores.window.samples);
  if (!report.model_age)
    text += "model     fitted to a recording on another clock, so its age is not known\n";
  else if (*report.model_age > 0.0)
    text += format(
        "model     fitted %.0f s before the end of this range; intervals grow with its age\n",
        *report.model_age);
  if (report.cranks_beyond_window > 0)
    text += format(
        "cranks    %zu draw more than the %.0f A of the model's window, so their predictions are "
        "extrapolations and not valid\n",
        report.cranks_beyond_window, -report.largest_discharge);
  if (report.both_ways) {
    text += format("input: the voltage where a source controls it, the current elsewhere\n");
    text += format("%-9s %9s %9s %9s %10s %10s %10s\n", "", "explained", "current", "voltage",
                   "10 s", "60 s", "cranks");
    appendBothWays(text, "model", *report.both_ways);
    appendBothWays(text, "baseline", report.baseline);
    text += format(
        "(explained variation = 1 - RMS error / standard deviation; 10 s, 60 s: median error of "
        "the mean current of charges; cranks: mean error of the lowest voltage)\n");
    text += format("input: the current throughout\n");
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
  text += format(
      "cranks    %zu; the answers miss their lowest voltages by %.0f mV on average, the equations "
      "without correction by past cranks by %s RMS, the baseline by %s on average\n",
      scores.cranks.size(), 1e3 * scores.crank_mean_abs_error.value_or(0.0),
      millivoltsOf(scores.crank_equations_rms).c_str(),
      millivoltsOf(report.baseline.crank_mean_abs_error).c_str());
  text += format("%12s %9s %10s %10s %22s\n", "time [s]", "I [A]", "measured", "predicted",
                 "90 % interval [V]");
  for (const auto& c : scores.cranks)
    text += format("%12.2f %9.1f %10.3f %10.3f %10.3f to %.3f\n", c.time, c.current, c.measured,
                   c.expected.value, c.expected.lower, c.expected.upper);
  return text;
}

std::string jsonText(const nlohmann::json& json, int indent) {
  return json.dump(indent, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string resultText(const CrankingQuery& query, const CrankingAnswer& answer) {
  std::string text = query.load.empty()
                         ? format("stop      %.1f s at %.1f A\n", query.t_stop, query.i_load)
                         : format("stop      %.1f s of the given profile\n", query.load.duration());
  text += query.crank.empty()
              ? format("crank     %.2f s at %.1f A\n", query.t_cranking, query.i_cranking)
              : format("crank     %.2f s of the given profile\n", query.crank.duration());
  text += answer.u_min ? format("lowest    %.3f V, 90 %% between %.3f and %.3f V\n",
                                answer.u_min->value, answer.u_min->lower, answer.u_min->upper)
                       : "lowest    -\n";
  return text + lastLine(answer);
}

std::string resultText(const StopTimeQuery& query, const StopTimeAnswer& answer) {
  std::string text = format(
      "question  longest stop at %.1f A after which a crank of %.2f s at %.1f A holds %.2f V\n",
      query.i_load, query.t_cranking, query.i_cranking, query.u_required);
  const char* recovers = answer.monotone ? "" : "; the battery recovers for a while";
  if (answer.t_stop && answer.outcome == StopTimeOutcome::kAtLeast)
    text += format(
        "stop      at least %s, the longest that is valid; lower end of the 90 %% interval %s%s\n",
        seconds(answer.t_stop->value).c_str(), seconds(answer.t_stop->lower).c_str(), recovers);
  else if (answer.t_stop)
    text +=
        format("stop      %s, 90 %% between %s and %s: %s%s\n",
               seconds(answer.t_stop->value).c_str(), seconds(answer.t_stop->lower).c_str(),
               seconds(answer.t_stop->upper).c_str(), toString(answer.outcome).c_str(), recovers);
  return text + lastLine(answer);
}

std::string resultText(const ChargeAcceptanceQuery& query, const ChargeAcceptanceAnswer& answer) {
  std::string text = format("question  current over %.1f s at %.2f V, at most %.0f A\n",
                            query.t_sof2, query.u_boost, query.i_limit);
  if (answer.i_boost)
    text += format("mean      %.1f A, 90 %% between %.1f and %.1f A\n", answer.i_boost->value,
                   answer.i_boost->lower, answer.i_boost->upper);
  return text + lastLine(answer);
}

std::string resultText(const MapResult& result) {
  std::string text;
  if (result.cranking) {
    text += "lowest voltage of the crank [V], 90 % interval; * not valid\n";
    text += table("i_load \\ t_stop", result.i_load, result.t_stop, result.cranking->answers,
                  &CrankingAnswer::u_min, 2);
  }
  if (result.charge) {
    text += "mean charge current [A], 90 % interval; * not valid\n";
    text += table("u_boost \\ t_sof2", result.u_boost, result.t_sof2, result.charge->answers,
                  &ChargeAcceptanceAnswer::i_boost, 1);
  }
  return text + lastLine(verdictOf(result.cranking, result.charge));
}

}  // namespace battery_sof
