#pragma once

#include <optional>
#include <string>
#include <vector>

#include "prediction/pipeline.hpp"

namespace battery_sof {

/// The question of a request: what it leaves out (askedFor()) is not asked, or its default. Without
/// an u_required a stop has no question, and the answer says so.
CrankingQuery asked(CrankingQuery request);
StopTimeQuery asked(StopTimeQuery request);
ChargeAcceptanceQuery asked(ChargeAcceptanceQuery request);

/**
 * @brief Lowest voltage during a crank after a stop phase (paper, Fig. 1; docs/physics.md#sof1).
 *
 *     u_SOF1 = min over (t_stop, t_stop + t_cranking] of u_b(t),   i = i_load, then i_cranking
 *
 * Under a held current the base model's state moves monotonically, so its minimum stands at one end
 * of the crank: two exact steps. With effects the crank is looked at after 0, 5, 20, 50 and 100 %
 * of its time, a profile at each point.
 *
 * The value is the model's plus what ResidualFilter expects it to miss; the interval holds
 * parameters, state, that error and the window's own crank error, widened as the battery's past
 * cranks ask for (voltageAnswer()). Past cranks and the open-circuit voltage's fall with the charge
 * that is drawn correct it (crankAnswer()). valid and the message follow extrapolationOf().
 *
 * @param model    event begins at its saved state.
 * @param capacity [Ah], nominal, > 0.
 */
CrankingAnswer predictCranking(const FittedModel& model, const CrankingQuery& query,
                               double capacity = kTypicalCapacity);

/// @return every fault of a query.
Faults faultsOf(const CrankingQuery& query);
Faults faultsOf(const StopTimeQuery& query);
Faults faultsOf(const ChargeAcceptanceQuery& query);
Faults faultsOfProfile(const std::vector<double>& time, const std::vector<double>& current);
/// Of the lists of a map.
Faults faultsOfMap(const std::vector<double>& rows, const char* row_name,
                   const std::vector<double>& columns, const char* column_name);

/// What a crank misses by itself, beyond normal driving [V].
double crankError(const Fit& fit, double current);

/**
 * @brief Longest stop after which the crank still holds u_required (docs/physics.md#stop-time).
 *
 *     t_stop = sup { t : u_SOF1(t') >= u_required for all t' <= t }
 *
 * Looked for on stops of 0, 0.5 s and half as much more each, then by regula falsi to 0.1 s or 1 %.
 * u_SOF1 rises at first when the battery recovers from a heavy discharge: the first crossing
 * counts, and monotone says so.
 *
 * A stop is no longer than a day and draws no more than the capacity: t_stop |i_load| <= capacity,
 * the interval's ends too. Where the crank still holds after the charge that the equations hold for
 * (supportedCharge()), t_stop is that stop and the outcome kAtLeast; the message says what the
 * model puts the end at. valid follows extrapolationOf(); an interval from no stop to the longest
 * says nothing, and neither does one that rests on a crank whose interval says nothing.
 *
 * @param capacity [Ah], nominal, > 0.
 */
StopTimeAnswer predictStopTime(const FittedModel& model, const StopTimeQuery& query,
                               double capacity = kTypicalCapacity);

/**
 * @brief Mean current at a held voltage with a current limit (paper, Fig. 2; docs/physics.md#sof2).
 *
 *     u_b(t) = u_boost  or  i(t) = i_limit,    i_boost = 1/t_sof2 int_0^t_sof2 i dt
 *
 * The current of every step is solved exactly (Simulation::advanceAtVoltage()); steps grow from 20
 * ms to a hundredth of t_sof2. What the model is expected to miss (ResidualFilter) is taken off the
 * voltage. Interval: the current's own derivatives, and the voltage's error through the current it
 * makes, widened as past charges ask for.
 *
 * @param model event begins at its saved state.  @param capacity [Ah], nominal, > 0.
 */
ChargeAcceptanceAnswer predictChargeAcceptance(const FittedModel& model,
                                               const ChargeAcceptanceQuery& query,
                                               double capacity = kTypicalCapacity);

/**
 * @brief A charge as it was measured, and what a model expects to flow at its voltage, by the same
 * means as predictChargeAcceptance(). `modelled` is without the correction by past charges.
 *
 * A model with a source follows the voltage sample by sample (StateEstimator) and is compared with past
 * charges (correctChargePrediction()).
 *
 * @param series samples after the model's state, not empty; without a source means over at least
 * 0.1 s are taken for a step.
 * @param driving [V], the voltage put right (VoltageRepair), one a sample; not used without a
 * source.
 */
EventComparison currentAtVoltage(const FittedModel& model, const Series& series,
                                 const std::vector<double>& driving = {});

/**
 * @brief What the battery would answer to a current profile from the model's saved state on.
 *
 * @param time    [s] after the saved state, >= 0, each at least kShortestStep after the one before.
 * @param current [A], same length; linear between the samples, and from the state's own current to
 * the first sample.
 * @param watch   asked before every sample; broken off, the answer is kInvalidQuery and says how far it came.
 */
ProfileAnswer simulateProfile(const FittedModel& model, const std::vector<double>& time,
                              const std::vector<double>& current, const WorkWatch& watch = nullptr);

/// Most points of a map along one side.
inline constexpr std::size_t kMaxMapSide = 200;

/// Answers to every combination of two lists, row by row: answers[row * columns + column].
template <typename Answer>
struct AnswerMap {
  std::vector<Answer> answers;  ///< empty unless code is kOk
  /// kInvalidQuery for a list that is empty or too long and for too much work, kNoModel
  AnswerCode code = AnswerCode::kOk;
  std::string message;
};
using CrankingMap = AnswerMap<CrankingAnswer>;                  ///< rows: i_load, columns: t_stop
using ChargeAcceptanceMap = AnswerMap<ChargeAcceptanceAnswer>;  ///< rows: u_boost, columns: t_sof2

/// SOF1 over (i_load, t_stop). @param query the crank; its i_load and t_stop are taken from the
/// lists.
/// @param watch asked before every answer; a map that is broken off has no answers, is
/// kInvalidQuery and says how far it came.
CrankingMap mapCranking(const FittedModel& model, const CrankingQuery& query,
                        const std::vector<double>& i_load, const std::vector<double>& t_stop,
                        double capacity = kTypicalCapacity, const WorkWatch& watch = nullptr);

/// SOF2 over (u_boost, t_sof2). @param query the limit; its u_boost and t_sof2 are taken from the
/// lists.
ChargeAcceptanceMap mapChargeAcceptance(const FittedModel& model,
                                        const ChargeAcceptanceQuery& query,
                                        const std::vector<double>& u_boost,
                                        const std::vector<double>& t_sof2,
                                        double capacity = kTypicalCapacity,
                                        const WorkWatch& watch = nullptr);

/// What maps come to as a whole.
struct MapVerdict {
  /// the gravest: invalid_query, then no_model, then extrapolation
  AnswerCode code = AnswerCode::kOk;
  /// one sentence: of the first answer with that code, or how many answers there are
  std::string message;
  std::size_t not_assured = 0;  ///< cranks that may miss the limit
  bool has_limit = false;       ///< whether the cranks were asked for one
};

/// @return "not valid" where one of the answers is, else "not assured" where one of the cranks may
/// miss its limit, else "holds" where there is a limit.
std::optional<Assurance> assuranceOf(const MapVerdict& verdict);

/// @param cranking, charge the maps that were asked; kInvalidQuery when neither was.
MapVerdict verdictOf(const std::optional<CrankingMap>& cranking,
                     const std::optional<ChargeAcceptanceMap>& charge);

}  // namespace battery_sof
