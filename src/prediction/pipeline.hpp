#pragma once

#include "prediction/query.hpp"

/**
 * The steps from a question to its answer, the same for cranks, stops and charges:
 *
 *     physics -> residual filter -> event history -> interval calibration -> validity
 *
 * cranking, charge_acceptance and stop_time supply the physics: a simulation with the directions of
 * the covariance, and what it takes the battery through (QueryRange).
 */
namespace battery_sof {

/**
 * @brief Residual filter and calibration of a simulated voltage.
 *
 *     value = u_m + e,   var = factor^2 ( sum_k (du / d tangent_k)^2 + var(e) + own^2 + beyond^2 )
 *
 * beyond: Simulation::beyondIdentified().
 * @param error what the model will miss then (ResidualFilter).  @param own what the event adds [V].
 */
Interval voltageAnswer(const Simulation& simulation, const ErrorForecast& error, double own,
                       const IntervalCalibration& scale);

/// Event history of a crank's lowest voltage (correctCrankPrediction()), after the open-circuit
/// voltage fell. @param current lowest of the crank [A].  @param lowest [V], voltageAnswer() of a
/// block.  @param fall openCircuitFall().  @return [V] of the model's series string.
Interval crankAnswer(const FittedModel& model, double current, const Interval& lowest,
                     const ErrorForecast& fall);

/// Event history of a charge's mean current (correctChargePrediction()), held to the source's limit
/// [A]: at the limit the current is the source's, and past charges have no say.
Interval chargeAnswer(const FittedModel& model, const ChargeBeginning& charge,
                      const Interval& modelled, double i_limit);

/**
 * @brief Updates from an event how wide its kind of interval must be: adaptive conformal inference
 * (Gibbs and Candes 2021) on the logarithm of the width.
 *
 *     outside: factor <- factor e^(0.9 eta),   inside: factor <- factor e^(-0.1 eta),   eta = 0.25
 *
 * The share inside tends to 90 % for any sequence of events, calibrated model or not: over n events
 * it is off by at most
 * |ln(last factor / first factor)| / (eta n). The factor stays in [0.1, 50].
 */
void update(IntervalCalibration& scale, double measured, const Interval& expected);

/// Makes of an answer with numbers one that is valid, or outside the identified range for these
/// reasons. @param reasons empty for none.
template <typename Answer>
void judge(Answer& answer, const std::string& reasons) {
  answer.valid = reasons.empty();
  answer.code = answer.valid ? AnswerCode::kOk : AnswerCode::kExtrapolation;
  if (!answer.valid) answer.message += "; outside the identified range: " + reasons;
}

/// Marks an answer that has none to give. @param faults of the query, empty when it is sound.
/// @return whether there is none.
template <typename Answer>
bool isRefused(Answer& answer, const Fit& fit, const std::string& faults) {
  if (faults.empty() && isUsable(fit)) return false;
  answer.code = faults.empty() ? AnswerCode::kNoModel : AnswerCode::kInvalidQuery;
  answer.message = faults.empty() ? "the model cannot be used: " + fit.message : faults;
  return true;
}

/// An answer without numbers: the model makes none that are finite of a question (kNoModel).
template <typename Answer>
Answer withoutNumbers() {
  Answer answer;
  answer.code = AnswerCode::kNoModel;
  answer.message =
      "the model makes no finite numbers of this query: it is far beyond what its equations hold "
      "for";
  return answer;
}

/**
 * @brief A question's answer, all steps.
 * @param faults of the query; empty when it is sound.
 * @param expect std::optional<QueryRange>(Answer&): the number by physics, residual filter and
 * event history, its sentence, and what the query takes the battery through; none where a number
 * is not finite.
 */
template <typename Answer, typename Expect>
Answer answered(const FittedModel& model, const std::string& faults, double capacity,
                Expect&& expect) {
  Answer answer;
  if (isRefused(answer, model.fit, faults)) return answer;
  const std::optional<QueryRange> range = expect(answer);
  if (!range) return withoutNumbers<Answer>();
  judge(answer, extrapolationOf(model, *range, capacity));
  return answer;
}

}  // namespace battery_sof
