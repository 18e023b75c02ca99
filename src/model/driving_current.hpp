#pragma once

#include <vector>

#include "battery_sof/series.hpp"
#include "model/base_model.hpp"

namespace battery_sof {

/// A current held over the interval that ends at a sample.
struct HeldCurrent {
  double current = 0.0;   ///< [A]
  double duration = 0.0;  ///< [s]
};

/**
 * @brief The current a model is driven with between two neighbouring samples.
 *
 *     i_held = (i(n-1) + i(n)) / 2      within a recording; second order for a current linear
 * between samples i_held = 0                        across a gap (duration > max_gap): the battery
 * is taken to rest
 *
 * @param max_gap [s], see gapThreshold().
 */
inline HeldCurrent heldCurrent(double time_before, double current_before, double time,
                               double current, double max_gap) {
  const double duration = time - time_before;
  return {duration > max_gap ? 0.0 : 0.5 * (current_before + current), duration};
}

/// @return the state at sample n, from that at sample n - 1. @param n at least 1.
Overpotential advanceToSample(const OverpotentialStep& step, const Overpotential& before,
                              const Series& series, std::size_t n, double max_gap);

/// @return one HeldCurrent a sample of the range; the first has duration 0.
std::vector<HeldCurrent> heldCurrents(const Series& series, IndexRange range, double max_gap);

}  // namespace battery_sof
