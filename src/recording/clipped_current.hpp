#pragma once

#include "battery_sof/series.hpp"
#include "recording/fit_mask.hpp"

namespace battery_sof {

/**
 * @brief What the current may have been where it is cut off, from what the voltage did.
 *
 *     i(t) = i_line(t) + (u(t) - u_line(t)) / r,   never nearer to zero than the limit
 *
 * i_line and u_line are straight from the last sample before to the first behind the clipped
 * stretch: what polarisation adds in it is taken for linear in time. r is the regression of the
 * changes of voltage on those of current over 30 ms that reach 70 % of the limit. On drives of the
 * reference simulator it finds 96 to 103 % of the charge that was cut off; a fast polarisation (0.2
 * s) of two fifths of the ohmic resistance, taken for current, makes it up to 28 % more; without it
 * a model driven by the current lacks that charge for as long as the battery remembers it.
 *
 * @return the series with that current; as it is for fewer than five samples a second, where r
 * cannot be reported, and where the
 *   stretch has no neighbour on one side. Where the voltage is cut off too the estimate is a lower bound.
 */
Series withEstimatedCurrent(const Series& series, const InstrumentLimits& limits);

/**
 * @brief Masks half a minute behind each stretch in which both channels are cut off: nothing
 * reports the charge that flowed, and the battery remembers it (docs/physics.md#base-circuit: 50 s
 * at rest, less under load).
 */
void maskBehindUnknownCharge(const Series& series, InstrumentLimits& limits);

}  // namespace battery_sof
