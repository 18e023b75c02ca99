#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "simulator/simulation.hpp"

namespace battery_sof_simulator {

constexpr double kInrush = 0.12;  // [s] (docs/physics.md#drives)

/// A charge [Ah] taken up, or given out when negative, at a current counted positive [A].
inline Phase swing(double charge_ah, double current) {
  return steady(std::abs(charge_ah) * kSecondsPerHour / current, std::copysign(current, charge_ah));
}

/// What a crank is drawn from: inrush for kInrush, then a plateau; currents counted positive.
struct CrankRanges {
  Range inrush_a, plateau_s, plateau_a;
};
inline void appendCrank(std::vector<Phase>& phases, const CrankRanges& ranges, Dice& dice) {
  phases.push_back(steady(kInrush, -dice.between(ranges.inrush_a)));
  phases.push_back(steady(dice.between(ranges.plateau_s), -dice.between(ranges.plateau_a)));
}

/// Has a drive play phases from an instant on [s], among those that are there.
inline void insertAt(Scenario& s, double at, std::vector<Phase> phases) {
  const auto after = std::upper_bound(s.inserts.begin(), s.inserts.end(), at,
                                      [](double time, const Insert& one) { return time < one.at; });
  s.inserts.insert(after, {at, std::move(phases)});
}

}  // namespace battery_sof_simulator
