#pragma once

#include "prediction/pipeline.hpp"

namespace battery_sof {

/// The question of a request, as asked() of a crank.
ChargeAcceptanceQuery asked(ChargeAcceptanceQuery request);

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
                                               double capacity = 50.0);

/// A model's mean current at a measured voltage, and the measured one.
struct MeanChargeCurrent {
  Interval current;           ///< [A], with its 90 % interval
  double modelled = 0.0;      ///< [A], of the model alone, without the correction by past charges
  double measured = 0.0;      ///< [A]
  double mean_voltage = 0.0;  ///< [V]
};

/**
 * @brief What a model expects to flow while the voltage is as measured, by the same means as
 * predictChargeAcceptance().
 *
 * A model with a source follows the voltage sample by sample (StateEstimator) and is compared with past
 * charges (correctChargePrediction()).
 *
 * @param series samples after the model's state, not empty; without a source means over at least
 * 0.1 s are taken for a step.
 * @param driving [V], the voltage put right (VoltageRepair), one a sample; not used without a
 * source.
 */
MeanChargeCurrent currentAtVoltage(const FittedModel& model, const Series& series,
                                   const std::vector<double>& driving = {});

}  // namespace battery_sof
