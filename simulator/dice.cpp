#include "simulator/dice.hpp"

#include <algorithm>
#include <cmath>

namespace battery_sof_simulator {
namespace {

constexpr double kMaxLean = 4.0;

std::mt19937_64 engineOf(std::uint64_t seed, std::uint32_t stream) {
  std::seed_seq sequence{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32),
                         stream};
  return std::mt19937_64(sequence);
}

}  // namespace

Dice::Dice(std::uint64_t seed, std::uint32_t stream) : engine_(engineOf(seed, stream)) {}

double Dice::share() { return std::generate_canonical<double, 53>(engine_); }

double Dice::between(const Range& range) { return range.low + (range.high - range.low) * share(); }

double Dice::logBetween(const Range& range) {
  return range.low * std::pow(range.high / range.low, share());
}

double Dice::sign() { return share() < 0.5 ? -1.0 : 1.0; }

double Dice::normal() { return normal_(engine_); }

double Dice::leaning(const Range& range, double lean) {
  const double exponent = std::exp2(std::clamp(lean, -kMaxLean, kMaxLean));
  return range.low + (range.high - range.low) * std::pow(share(), exponent);
}

}  // namespace battery_sof_simulator
