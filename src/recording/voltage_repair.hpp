#pragma once

#include <cstddef>
#include <vector>

#include "battery_sof/series.hpp"

namespace battery_sof {

/// What must be put right in a slow voltage channel before it may be the input of a model.
struct VoltageRepair {
  std::vector<char> dropped;  ///< one a sample; 1 where the channel dropped out for a sample
  std::size_t lag = 0;        ///< [samples], by which the voltage is behind the current
};

/**
 * @brief A single sample that stands apart from both its neighbours while the current says nothing
 * of it.
 *
 * |u_k - u_(k-1)| and |u_k - u_(k+1)| above 0.25 V, to the same side, the neighbours within 0.4 of
 * the smaller of the two, the current above -60 A and within 25 A of its neighbours' mean. A
 * vehicle's battery sensor shows such samples (and a current of exactly zero) when it loses a
 * message.
 */
bool isDropOut(const Series& series, std::size_t k);

/**
 * @brief Drop-outs, and whole samples by which the voltage is behind the current, from -2 to 3.
 *
 *     c(l) = sum di_k du_(k+l) / sqrt(sum di_k^2 sum du_(k+l)^2),   2 A < |di_k| < 40 A
 *
 * The lag is the mean of the peak and its neighbours weighted by c^2, rounded; none below a
 * correlation of 0.3 or when it is negative.
 */
VoltageRepair findVoltageRepair(const Series& series);

/// @return the series with drop-outs replaced by their neighbours' mean and the voltage moved
/// forward by the lag; the last samples keep the last voltage there is.
/// @throws std::invalid_argument when `dropped` has another size.
Series repaired(const Series& series, const VoltageRepair& repair);

/// @return the voltage [V] that repaired() puts at a sample, drop-outs as isDropOut() says; reads
/// no further than a sample beyond the one `lag` later.
double repairedVoltage(const Series& series, std::size_t k, std::size_t lag);

}  // namespace battery_sof
