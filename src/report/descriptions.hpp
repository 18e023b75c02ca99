#pragma once

#include <optional>
#include <string>
#include <vector>

#include "diagnosis/diagnosis.hpp"
#include "prediction/charge_acceptance.hpp"
#include "prediction/maps.hpp"
#include "prediction/stop_time.hpp"
#include "report/fields.hpp"
#include "wording.hpp"

/// What results consist of, for JSON and messages alike: see fields.hpp.
namespace battery_sof {

// ---------------------------------------------------------------------------------------------
// answers

template <typename Visit, typename Access>
void describeInterval(Visit& visit, const Field<Access>& name,
                      const std::optional<Interval>& interval) {
  const auto part = [&](double Interval::*end) {
    return interval ? std::optional<double>(*interval.*end) : std::nullopt;
  };
  visit(name, part(&Interval::value));
  visit(FIELD(lower), part(&Interval::lower));
  visit(FIELD(upper), part(&Interval::upper));
}

template <typename Visit>
void describeCode(Visit& visit, bool valid, AnswerCode code, const std::string& message) {
  visit(FIELD(valid), valid);
  visit(FIELD(code), static_cast<int>(code));
  visit(FIELD(message), message);
}

template <typename Visit>
void describe(Visit& visit, const CrankingAnswer& answer) {
  describeInterval(visit, FIELD(u_min), answer.u_min);
  visit(FIELD(capable), answer.capable);
  describeCode(visit, answer.valid, answer.code, answer.message);
}

template <typename Visit>
void describe(Visit& visit, const StopTimeAnswer& answer) {
  describeInterval(visit, FIELD(t_stop), answer.t_stop);
  std::optional<std::string> outcome;
  if (answer.t_stop) outcome = toString(answer.outcome);
  visit(FIELD(outcome), outcome);
  visit(FIELD(monotone), answer.t_stop ? std::optional<bool>(answer.monotone) : std::nullopt);
  describeCode(visit, answer.valid, answer.code, answer.message);
}

template <typename Visit>
void describe(Visit& visit, const ChargeAcceptanceAnswer& answer) {
  describeInterval(visit, FIELD(i_boost), answer.i_boost);
  describeCode(visit, answer.valid, answer.code, answer.message);
}

template <typename Visit>
void describe(Visit& visit, const ProfileAnswer& answer) {
  visit(FIELD(voltage), answer.predicted.voltage);
  visit(FIELD(lower), answer.predicted.lower);
  visit(FIELD(upper), answer.predicted.upper);
  describeCode(visit, answer.valid, answer.code, answer.message);
}

/// What `sof map` and ~predict_map were asked and got; a map that was not asked has no answers.
struct MapResult {
  std::vector<double> i_load, t_stop;  ///< [A], [s]
  std::optional<CrankingMap> cranking;
  std::vector<double> u_boost, t_sof2;  ///< [V], [s]
  std::optional<ChargeAcceptanceMap> charge;
};

/// A map's answers as lists, row by row.
struct MapColumns {
  std::vector<std::optional<double>> value, lower, upper;
  std::vector<int> code;

  template <typename Answer>
  MapColumns(const std::vector<Answer>& answers, std::optional<Interval> Answer::*number) {
    for (const Answer& answer : answers) {
      const std::optional<Interval>& interval = answer.*number;
      value.push_back(interval ? std::optional(interval->value) : std::nullopt);
      lower.push_back(interval ? std::optional(interval->lower) : std::nullopt);
      upper.push_back(interval ? std::optional(interval->upper) : std::nullopt);
      code.push_back(static_cast<int>(answer.code));
    }
  }
};

template <typename Visit>
void describe(Visit& visit, const MapResult& result) {
  visit("schema", "battery_sof/map/1");
  if (result.cranking) {
    const MapColumns u_min(result.cranking->answers, &CrankingAnswer::u_min);
    std::vector<std::optional<bool>> capable;
    for (const CrankingAnswer& answer : result.cranking->answers) capable.push_back(answer.capable);
    visit(FIELD(i_load), result.i_load);
    visit(FIELD(t_stop), result.t_stop);
    visit(FIELD(u_min), u_min.value);
    visit(FIELD(u_min_lower), u_min.lower);
    visit(FIELD(u_min_upper), u_min.upper);
    visit(FIELD(u_min_code), u_min.code);
    visit(FIELD(capable), capable);
  }
  if (result.charge) {
    const MapColumns i_boost(result.charge->answers, &ChargeAcceptanceAnswer::i_boost);
    visit(FIELD(u_boost), result.u_boost);
    visit(FIELD(t_sof2), result.t_sof2);
    visit(FIELD(i_boost), i_boost.value);
    visit(FIELD(i_boost_lower), i_boost.lower);
    visit(FIELD(i_boost_upper), i_boost.upper);
    visit(FIELD(i_boost_code), i_boost.code);
  }
  const MapVerdict verdict = verdictOf(result.cranking, result.charge);
  describeCode(visit, verdict.code == AnswerCode::kOk, verdict.code, verdict.message);
}

// ---------------------------------------------------------------------------------------------
// models

template <typename Visit>
void describe(Visit& visit, const ParameterEstimate& estimate) {
  visit(FIELD(name), estimate.name);
  visit(FIELD(value), estimate.value);
  visit(FIELD_AS("std_error", std), estimate.std);
  visit(FIELD(unit), estimate.unit);
  visit(FIELD(held), estimate.held);
  visit(FIELD(at_bound), estimate.at_bound);
  visit(FIELD(determined), estimate.determined);
}

template <typename Visit>
void describe(Visit& visit, const FitWindow& window) {
  visit(FIELD(from), window.from, "s");
  visit(FIELD(to), window.to, "s");
}

/// What `sof identify` and ~model report of an identification.
template <typename Visit>
void describe(Visit& visit, const FittedModel& model) {
  visit(FIELD(effects), model.fit.effects);
  visit(FIELD(status), toString(model.fit.status));
  visit(FIELD(message), model.fit.message);
  visit(FIELD(q_dyn_percent), model.fit.scores.q_dyn_percent);
  visit(FIELD(rmse), model.fit.scores.rmse, "v");
  visit(FIELD(window_quality), model.fit.window_quality);
  visit(FIELD(fit_ms), model.provenance.fit_ms);
}

// ---------------------------------------------------------------------------------------------
// diagnoses

template <typename Visit>
void describe(Visit& visit, const DiagnosedParameter& parameter) {
  visit(FIELD(name), parameter.name);
  visit(FIELD(value), parameter.value);
  visit(FIELD(std), parameter.std);
  visit(FIELD(unit), parameter.unit);
  visit(FIELD(lower), parameter.lower);
  visit(FIELD(upper), parameter.upper);
  visit(FIELD(at_bound), parameter.at_bound);
}

template <typename Visit>
void describe(Visit& visit, const NamedEffect& effect) {
  visit(FIELD(id), effect.id);
  visit("title", titleOf(effect.id));
  visit(FIELD(mechanism), effect.mechanism);
  visit(FIELD(probability), effect.probability);
  visit(FIELD(confidence), effect.confidence);
  visit(FIELD_AS("absorbed_into", biased_parameters), effect.biased_parameters);
  visit(FIELD(parameters), effect.parameters);
  visit(FIELD(evidence), effect.evidence);
  visit(FIELD(voltage_rms), effect.voltage_rms, "v");
  visit(FIELD(indistinguishable_from), effect.indistinguishable_from);
}

template <typename Visit>
void describe(Visit& visit, const Candidate& candidate) {
  visit(FIELD(id), candidate.id);
  visit("title", titleOf(candidate.id));
  visit(FIELD(mechanism), candidate.mechanism);
  visit("probability", candidate.confidence);
  visit(FIELD(holdout_gain_percent), candidate.holdout_gain_percent);
  visit(FIELD(evidence), candidate.evidence);
  visit(FIELD(confidence), candidate.confidence);
  visit(FIELD(rejected_because), candidate.rejected_because);
}

template <typename Visit>
void describe(Visit& visit, const MismatchSegment& segment) {
  visit(FIELD(from), segment.from, "s");
  visit(FIELD(to), segment.to, "s");
  visit(FIELD(regime), segment.regime);
  visit(FIELD(mean_error), segment.mean_error, "v");
  visit(FIELD(peak_error), segment.peak_error, "v");
  visit(FIELD(p_value), segment.p_value);
}

template <typename Visit>
void describe(Visit& visit, const ErrorMetrics& metrics) {
  visit(FIELD(q_dyn_percent), metrics.q_dyn_percent);
  visit(FIELD(rmse), metrics.rmse, "v");
  visit(FIELD(max_abs), metrics.max_abs, "v");
  visit(FIELD(crank_mae), metrics.crank_mae, "v");
  visit(FIELD(cranks), metrics.cranks);
  visit(FIELD(charge_bias), metrics.charge_bias, "v");
  visit(FIELD(charge_current_error), metrics.charge_current_error, "a");
  visit(FIELD(share_percent), metrics.share_percent);
  visit(FIELD(current_share_percent), metrics.current_share_percent);
  visit(FIELD(voltage_share_percent), metrics.voltage_share_percent);
}

inline std::optional<std::string> idOf(const std::optional<Mechanism>& mechanism) {
  return mechanism ? std::optional(mechanismId(*mechanism)) : std::nullopt;
}

/// What JSON and ~diagnosis have at their top.
template <typename Visit>
void describe(Visit& visit, const Diagnosis& d) {
  visit(FIELD(verdict), toString(d.verdict));
  visit(FIELD(summary), d.summary);
  visit(FIELD(mechanism), idOf(d.mechanism));
  visit(FIELD(effects), d.effects);
  visit(FIELD(candidates), d.candidates);
  visit(FIELD(mismatch), d.mismatch);
  visit(FIELD(next_experiment), d.next_experiment);
  visit(FIELD(instrument), d.instrument);
  visit(FIELD(unobservable), d.outside);
}

}  // namespace battery_sof
