#pragma once

#include <optional>
#include <string>

#include "prediction/pipeline.hpp"

namespace battery_sof {

/// The question of a request: what it leaves out (askedFor()) is not asked, or its default.
CrankingQuery asked(CrankingQuery request);

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
 * cranks ask for (voltageAnswer()). valid and the message follow extrapolationOf().
 *
 * @param model    event begins at its saved state.
 * @param capacity [Ah], nominal, > 0.
 */
CrankingAnswer predictCranking(const FittedModel& model, const CrankingQuery& query,
                               double capacity = 50.0);

/// @return every fault of a query, as one sentence each; empty when there is none.
std::string faultsOf(const CrankingQuery& query);

/// Lowest voltage of a crank, of the model's series string, that begins where a simulation stands,
/// `ahead` [s] after the model's state. @param fall openCircuitFall() until then.
/// @param beyond_identified raised to Simulation::beyondIdentified() of any moment of the crank
/// [V]; nullptr: not needed.
Interval lowestOfCrank(Simulation simulation, const FittedModel& model, const CrankingQuery& query,
                       double ahead, const ErrorForecast& fall = {},
                       double* beyond_identified = nullptr);

/// What a crank misses by itself, beyond normal driving [V].
double crankError(const Fit& fit, double current);

}  // namespace battery_sof
