#include "model/driving_current.hpp"

namespace battery_sof {

Overpotential advanceToSample(const OverpotentialStep& step, const Overpotential& before,
                              const Series& series, std::size_t n, double max_gap) {
  const HeldCurrent held = heldCurrent(series.time[n - 1], series.current[n - 1], series.time[n],
                                       series.current[n], max_gap);
  return step.advance(before, held.current, held.duration);
}

std::vector<HeldCurrent> heldCurrents(const Series& series, IndexRange range, double max_gap) {
  std::vector<HeldCurrent> held;
  held.reserve(range.size());
  for (std::size_t n = range.first; n < range.last; ++n)
    held.push_back(n == range.first ? HeldCurrent{series.current[n], 0.0}
                                    : heldCurrent(series.time[n - 1], series.current[n - 1],
                                                  series.time[n], series.current[n], max_gap));
  return held;
}

}  // namespace battery_sof
