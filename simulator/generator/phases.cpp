#include "simulator/generator/phases.hpp"

#include <algorithm>
#include <cmath>

#include "simulator/units.hpp"

namespace battery_sof_simulator {
namespace {

constexpr double kInrush = 0.12;  // [s] (docs/physics.md#drives)

}  // namespace

Phase swing(double charge_ah, double current) {
  return steady(std::abs(charge_ah) * kSecondsPerHour / current, std::copysign(current, charge_ah));
}

void appendCrank(std::vector<Phase>& phases, const CrankRanges& ranges, Dice& dice) {
  phases.push_back(steady(kInrush, -dice.between(ranges.inrush_a)));
  phases.push_back(steady(dice.between(ranges.plateau_s), -dice.between(ranges.plateau_a)));
}

void insertAt(Scenario& s, double at, std::vector<Phase> phases) {
  const auto after = std::upper_bound(s.inserts.begin(), s.inserts.end(), at,
                                      [](double time, const Insert& one) { return time < one.at; });
  s.inserts.insert(after, {at, std::move(phases)});
}

}  // namespace battery_sof_simulator
