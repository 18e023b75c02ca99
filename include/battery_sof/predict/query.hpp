#pragma once

#include <optional>
#include <string>
#include <vector>

#include "battery_sof/identify/error_tracker.hpp"
#include "battery_sof/identify/fitted_model.hpp"
#include "battery_sof/model/simulation.hpp"
#include "battery_sof/predict/answer.hpp"
#include "battery_sof/predict/experienced.hpp"
#include "battery_sof/recording/words.hpp"

namespace battery_sof {

/// @return the first fault of a profile with what was expected; empty when sound. @param name for the sentence.
std::string faultOf(const CurrentProfile& profile, const char* name);

/// What a query takes the battery through, for comparison with what its model's window did.
struct QueryRange {
  std::optional<double> least_current;     ///< [A], largest discharge
  std::optional<double> most_current;      ///< [A], largest charge
  std::optional<double> most_voltage;      ///< [V]
  std::optional<double> charge_duration;   ///< [s]
  double charge_moved = 0.0;               ///< [Ah], magnitude
  std::optional<double> temperature;       ///< [K], at which it will happen; else the model's state's
  bool charges = false;                    ///< needs r_charge, else r_discharge
  ChargeEvidence evidence = {};            ///< what past charges say of a charge
  std::optional<double> answered_voltage;  ///< [V], what the model makes of it
  double beyond_learned = 0.0;             ///< [V] of one block, most by which a learnt force was held inside what it was learnt on
};

/**
 * @brief The most charge that a query may move [Ah].
 *
 *     1 % of the capacity (paper, section V), the open-circuit voltage being held constant
 *
 * As far as the window itself moved charge (ExcitedRange::charge_swing), at most the capacity, where it determined how the
 * open-circuit voltage follows the charge (ocv_slope of ocv_soc) and that slope is a battery's: 0.8 to 1.8 V of a block for a unit of
 * state of charge (docs/physics.md#ocv_soc). acid_transport relaxes with time and holds no such slope.
 */
double supportedCharge(const Fit& fit, double capacity);

/**
 * @brief Why a model should not be relied on for a query: what its window did not excite and its equations do not hold.
 *
 * A charge is vouched for by evidence: three past charges or more at its voltage and duration that were predicted well
 * (ChargeEvidence). Then neither its current nor the lack of a law of charge acceptance speaks against it; past charges that
 * were missed do, and for a model with a source so does their absence.
 *
 * Currents up to 1.25 times, voltages up to 0.3 V above and temperatures within 10 K of the window's; a charge moved of at most
 * supportedCharge(); for charges beyond
 * 10 s a limit of charge acceptance (charge_acceptance) and a charge as long as 10 s in the window (docs/physics.md#sof2).
 *
 * More than the capacity is never held, and no battery has a voltage below 0 or above 16 V a block of six cells: a model that
 * answers with one is beyond what its equations hold for. A learnt force that would differ by more than 10 mV if it were not held inside
 * its range is not to be relied on.
 *
 * @return reasons, joined by "; "; empty when there is none.
 */
std::string extrapolationOf(const FittedModel& model, const QueryRange& range, double capacity);

/// Moves on under a held current. @param duration >= 0.
void hold(Simulation& simulation, double current, double duration);

/**
 * @brief A predicted voltage with its 90 % interval.
 *
 *     value = u_m + e,   var = factor^2 ( sum_k (du / d lane_k)^2 + var(e) + own^2 + beyond^2 )
 *
 * beyond: Simulation::beyondLearned().
 * @param error what the model will miss then (ErrorTracker).  @param own what the event adds [V].
 */
Interval voltageAnswer(const Simulation& simulation, const ErrorForecast& error, double own, const IntervalScale& scale);

/// Whether a value and the ends of its interval are finite.
bool areNumbers(const Interval& answer);

/// An answer without numbers: the model makes none that are finite of a question (kNoModel).
template <typename Answer>
Answer withoutNumbers() {
  Answer answer;
  answer.code = AnswerCode::kNoModel;
  answer.message = "the model makes no finite numbers of this query: it is far beyond what its equations hold for";
  return answer;
}

}  // namespace battery_sof
