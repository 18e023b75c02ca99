#pragma once

#include <optional>

#include "battery_sof/queries.hpp"
#include "state/fitted_model.hpp"

namespace battery_sof {

/**
 * @brief The capacity that a discharge shows: the charge between full and exhausted.
 *
 *     Q = (U_full - U_E) / k_s,   U_full = 12.9 +- 0.1 V of a block
 *
 * with U_E and k_s of end_of_discharge and ocv_slope (docs/physics.md#end_of_discharge). That a full
 * battery rests at 12.8 to 13 V is assumed, not measured.
 * @return 90 % [Ah]; none without end_of_discharge, or where the window did not determine k_s.
 */
std::optional<Interval> estimatedCapacity(const Fit& fit);

}  // namespace battery_sof
