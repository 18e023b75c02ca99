#pragma once

#include "battery_sof/series.hpp"
#include "estimation/composition_fit.hpp"

namespace battery_sof_bench {

/// base + charge_acceptance + acid_transport + current_dependent_resistance.
battery_sof::BatteryModel composedModel();

/// What the records' voltage is simulated with: away from every magnitude and inside all bounds.
battery_sof::CompositionPoint composedTruth(const battery_sof::BatteryModel& model);

/**
 * @brief City driving whose voltage is that of a composition, so that its effects are in the data.
 *
 * Current: drives of the independent reference at 100 Hz, 30 minutes of seed 1 one after the other;
 * cranks below -150 A are among them. Voltage: `model` at `truth`, plus seeded white noise of 2 mV.
 *
 * @param duration [s], > 0.
 */
battery_sof::Series composedRecord(const battery_sof::BatteryModel& model,
                                   const battery_sof::CompositionPoint& truth, double duration);

/// @return the whole of a record as a range.
battery_sof::IndexRange all(const battery_sof::Series& series);

}  // namespace battery_sof_bench
