#pragma once

#include <optional>
#include <string>
#include <vector>

#include "model/simulation.hpp"
#include "prediction/event_corrections.hpp"
#include "prediction/reasons.hpp"
#include "state/fitted_model.hpp"
#include "state/present_error.hpp"
#include "state/state_estimator.hpp"
#include "util/text.hpp"

/**
 * The steps from a question to its answer, the same for cranks, stops and charges:
 *
 *     physics -> residual filter, interval calibration -> event history -> validity
 *
 * cranking and charge_acceptance supply the physics: a simulation with the directions of the
 * covariance, and what it takes the battery through (QueryRange). All of it is of one block of a
 * row; a query's voltages are divided and an answer's multiplied by Fit::series_blocks there.
 */
namespace battery_sof {

/// A number of a request whose zero has no meaning: 0 and NaN, as in a request that was never
/// filled in, request nothing.
std::optional<double> askedFor(std::optional<double> given);

/// What is wrong with a query, a sentence each.
using Faults = std::vector<std::string>;

/// Adds the fault of a value that is not ok.
void requireOf(Faults& faults, bool ok, const char* name, double value, const char* expected);

/// @return the first fault of a current over time with what was expected; none when sound. @param
/// name for the sentence.  @param most points.
std::optional<std::string> faultOf(const std::vector<double>& time,
                                   const std::vector<double>& current, const char* name,
                                   std::size_t most);

/// The longest stop or profile that a query may take [s]: a day.
inline constexpr double kLongestQuery = 86400.0;

/// What a query takes the battery through, for comparison with what its model's window did.
struct QueryRange {
  std::optional<double> min_current;      ///< [A], largest discharge
  std::optional<double> max_current;      ///< [A], largest charge
  std::optional<double> max_voltage;      ///< [V] of one block
  std::optional<double> charge_duration;  ///< [s]
  double charge_moved = 0.0;              ///< [Ah], magnitude
  /// [K], at which it will happen; else the model's state's
  std::optional<double> temperature;
  bool charges = false;                      ///< needs r_charge, else r_discharge
  ChargeEvidence evidence = {};              ///< what past charges say of a charge
  std::optional<Interval> answered_current;  ///< [A], of a charge
  std::optional<Interval> answered_voltage;  ///< [V] of one block, what the model makes of it
  /// of an interval of another quantity: why, see widthSaysNothing()
  std::optional<Reason> says_nothing = std::nullopt;
  /// [V] of one block, most by which a discrepancy model was held inside what it was estimated on
  double beyond_identified = 0.0;
};

/**
 * @brief The most charge that a query may move [Ah].
 *
 *     2 % of the capacity: up to 1 % the open-circuit voltage is held constant (paper, section V),
 *     beyond it falls by openCircuitFall();   1 % of a charge
 *
 * As far as the window itself moved charge (ExcitedRange::charge_swing), at most the capacity,
 * where it determined how the open-circuit voltage follows the charge (ocv_slope of ocv_soc) and
 * that slope is a battery's: 0.8 to 1.8 V of a block for a unit of state of charge
 * (docs/physics.md#ocv_soc). All of the capacity of a discharge whose end the model has
 * (end_of_discharge). acid_transport relaxes with time and holds no such slope.
 */
double supportedCharge(const Fit& fit, double capacity, bool charges = false);

/**
 * @brief What a charge drawn changes of the open-circuit voltage where the equations hold it
 * constant.
 *
 *     -(12 +- 4) mV a block for each percent of the capacity beyond the first
 *
 * 12 mV is a lead-acid battery's between 50 and 90 % (docs/physics.md#ocv_soc). Nothing where the
 * window determined it.
 * @param drawn [Ah], positive out of the battery.
 * @return of a block [V], [V^2].
 */
ErrorForecast openCircuitFall(const Fit& fit, double drawn, double capacity);

/**
 * @brief Why a model answers nothing that is valid; none when it may.
 *
 * One rule: it was missed by more than the whole interval that it was given, by the last crank
 * (MissedAnswer) or by the present voltage (expectedPresentError()).
 */
Reasons denialOf(const FittedModel& model);

/**
 * @brief Why a model should not be relied on for a query: denialOf(), and what its window did not excite and its
 * equations do not hold.
 *
 * A charge that past charges support (ChargeEvidence) may have more current than the window's, and
 * needs no law of charge acceptance. Else a model with a source answers where its interval is of
 * use: at most 10 A wide, or half of the window's largest charge. Before a window was fitted no
 * charge is supported.
 *
 * Currents up to 1.25 times, voltages up to 0.3 V above and temperatures within 10 K of the
 * window's; a charge moved of at most supportedCharge(); for charges beyond 10 s a limit of charge
 * acceptance (charge_acceptance) and a charge as long as 10 s in the window (docs/physics.md#sof2).
 *
 * More than the capacity is never held, and no battery has a voltage below 0 or above 16 V a block
 * of six cells: a model that answers with one is beyond what its equations hold for. An interval
 * that says nothing is no answer (voltageSaysNothing()). A discrepancy model that would differ by
 * more than 10 mV if it were not held inside its range is outside the identified range.
 *
 * A crank or a stop needs r_discharge and u_dc determined, a window whose own cranks the equations
 * miss by no more than the baseline does (BaselineCranks), and, without a source, a
 * window quality of 0.05; but for the load that a discharge held (end_of_discharge), to a tenth.
 * Three past cranks answer for themselves: they correct the answer and make
 * its interval.
 *
 */
Reasons extrapolationOf(const FittedModel& model, const QueryRange& range, double capacity);

/// @return why a model answers no crank and no stop, whatever its current; none when it answers
/// some.
Reasons whyNoCrank(const FittedModel& model);

/**
 * @brief Why the 90 % interval of a voltage says nothing; none when it says something.
 *
 * It does where it stays inside 0 to 16 V a block of six cells and is narrower than 10 V, from 6 V
 * (1 V a cell: empty under load) to 16 V.
 *
 * @param voltage [V], of one block.
 */
std::optional<Reason> voltageSaysNothing(const Fit& fit, const Interval& voltage);

/// The same of a quantity whose values lie within a width. @param kind kWideCurrent or kWideStop.
/// @param whose what has that width.
std::optional<Reason> widthSaysNothing(ReasonKind kind, const Interval& answer, double width,
                                       const std::string& whose);

/// Whether a value and the ends of its interval are finite.
bool areNumbers(const Interval& answer);

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

/// A crank's lowest voltage as it is answered.
struct LowestVoltage {
  Interval by_model;       ///< [V], voltageAnswer() of a block
  double equations = 0.0;  ///< [V], the equations' own
  double ahead = 0.0;      ///< [s], after the model's state
};

/// Event history of a crank's lowest voltage (correctCrankPrediction()), the present error
/// (beginAtPresent()), and the open-circuit voltage's fall. @param current lowest of the crank
/// [A].  @param fall openCircuitFall().  @return [V] of one block.
Interval crankAnswer(const FittedModel& model, double current, const LowestVoltage& lowest,
                     const ErrorForecast& fall);

/**
 * @brief An answer that begins at what is measured: the present error, taken into it by what it
 * says of the load that is queried for.
 *
 *     R = D + (1 / rho^2 - 1) V,   w = V / (V + R),   d = u_m + level - u,
 *     u <- u + w d,   V <- (1 - w) (V + w d^2)
 *
 * V is the interval's variance, D and rho those of PresentForecast. At the present load (rho = 1)
 * the answer is the measured voltage as far as such a level lasted in the past; far from it what
 * the model and its past events say. What both say differs by d: beyond the interval of their
 * variances the model is off, and V grows first until it is not; a level beyond the interval of
 * expectedPresentError() adds the square of what is beyond.
 *
 * @param modelled of a block [V].  @param equations [V], the same by equations alone.
 */
Interval beginAtPresent(const FittedModel& model, const Interval& modelled, double equations,
                        double current, double ahead);

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

/// What the message of an answer with numbers begins with: "holds: ", "not assured: ",
/// "not valid: ", or nothing.
template <typename Answer>
std::string beginningOf(const Answer& answer) {
  const std::optional<Assurance> assurance = assuranceOf(answer);
  return assurance ? toString(*assurance) + ": " : "";
}

/// Makes of an answer with numbers one that is valid, or outside the identified range for these
/// reasons. @param series_blocks whose voltages the message tells.
template <typename Answer>
void judge(Answer& answer, const Reasons& reasons, double series_blocks) {
  answer.valid = reasons.empty();
  answer.code = answer.valid ? AnswerCode::kOk : AnswerCode::kExtrapolation;
  if (!answer.valid)
    answer.message += "; outside the identified range: " + toString(reasons, series_blocks);
  answer.message = beginningOf(answer) + answer.message;
}

/// Takes the validity from an answer with numbers. @param why one clause.
template <typename Answer>
void invalidate(Answer& answer, const std::string& why) {
  const std::string sentence = answer.message.substr(beginningOf(answer).size());
  answer.valid = false;
  answer.code = AnswerCode::kExtrapolation;
  answer.message = beginningOf(answer) + why + "; " + sentence;
}

/// An answer where there is no model. @param faults of the query.  @param why there is no model.
template <typename Answer>
Answer withoutModel(const Faults& faults, const std::string& why) {
  Answer answer;
  answer.code = faults.empty() ? AnswerCode::kNoModel : AnswerCode::kInvalidQuery;
  answer.message = faults.empty() ? why : join(faults, "; ");
  return answer;
}

/// Marks an answer that has none to give. @param faults of the query.  @return whether there is none.
template <typename Answer>
bool isRefused(Answer& answer, const Fit& fit, const Faults& faults) {
  if (faults.empty() && isUsable(fit)) return false;
  answer = withoutModel<Answer>(faults, "the model cannot be used: " + fit.message);
  return true;
}

/// Asks a watch whether work goes on; broken off, the answer is emptied and says how far it came.
/// @param what is counted, behind the numbers.  @return whether it is broken off.
template <typename Answer>
bool isBrokenOff(Answer& answer, const WorkWatch& watch, std::size_t done, std::size_t all,
                 const char* what) {
  const std::string why = watch ? watch(static_cast<double>(done) / static_cast<double>(all)) : "";
  if (why.empty()) return false;
  answer = {};
  answer.code = AnswerCode::kInvalidQuery;
  answer.message = format("stopped after %zu of %zu %s: ", done, all, what) + why;
  return true;
}

/// An answer without numbers: the model makes none that are finite of a question (kNoModel).
template <typename Answer>
Answer withoutNumbers() {
  Answer answer;
  answer.code = AnswerCode::kNoModel;
  answer.message =
      "the model gives no finite result, because the query is far outside the range of its "
      "equations";
  return answer;
}

/**
 * @brief A question's answer, all steps.
 * @param faults of the query.
 * @param expect std::optional<QueryRange>(Answer&): the number by physics, residual filter and
 * event history, its sentence, and what the query takes the battery through; none where a number
 * is not finite.
 */
template <typename Answer, typename Expect>
Answer answered(const FittedModel& model, const Faults& faults, double capacity, Expect&& expect) {
  Answer answer;
  if (isRefused(answer, model.fit, faults)) return answer;
  const std::optional<QueryRange> range = expect(answer);
  if (!range) return withoutNumbers<Answer>();
  judge(answer, extrapolationOf(model, *range, capacity), model.fit.series_blocks);
  return answer;
}

}  // namespace battery_sof
