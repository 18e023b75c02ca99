#pragma once

#include "battery_sof/series.hpp"

namespace battery_sof {

/**
 * @brief A series with its current moved in time against its voltage.
 *
 *     i(t) = i_measured(t - shift)
 *
 * Times and voltages stay as they are. Between samples the current is interpolated linearly; samples
 * whose current would come from before the first one, from behind the last one or from within a gap
 * are left out. The sign is that of EdgeResponse::lag and of the effect time_skew: to move the
 * current by what they read undoes the shift.
 *
 * @param shift [s], > 0: the current is moved to later times, to meet a voltage that comes late;
 * < 0: to earlier times, because the current comes late.
 * @throws std::invalid_argument for a shift that is not finite.
 */
Series withShiftedCurrent(const Series& series, double shift);

}  // namespace battery_sof
