#pragma once

#include <optional>

#include "battery_sof/queries.hpp"
#include "state/fitted_model.hpp"

namespace battery_sof {

/**
 * @brief The capacity that a discharge shows: the charge between full and exhausted under its load.
 *
 *     Q = (U_full - U_E) / k_s - theta I,   U_full = 12.9 +- 0.1 V of a block
 *
 * with k_s of ocv_slope, U_E and theta of end_of_discharge and I, the window's largest discharge
 * current (docs/physics.md#end_of_discharge). That a full battery rests at 12.8 to 13 V is assumed,
 * not measured.
 * @return 90 % [Ah]; none without end_of_discharge, where the window did not determine k_s or U_E is at
 * a bound, or where 0 is not excluded: the load may exhaust the pores of a full battery.
 */
std::optional<Interval> estimatedCapacity(const Fit& fit);

}  // namespace battery_sof
