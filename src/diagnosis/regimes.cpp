#include "diagnosis/regimes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "recording/events.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

// docs/physics.md#regimes
constexpr double kEdgeStep = 30.0;           // [A]
constexpr double kEdgeReach = 0.15;          // [s]
constexpr double kLongChargeTime = 10.0;     // [s]
constexpr double kLongChargeCurrent = 2.0;   // [A]
constexpr double kHighVoltage = 13.8;        // [V]
constexpr double kLongDischargeTime = 20.0;  // [s]
constexpr double kMoved = 1.0;               // [As], a load that rest remembers: 1 mV on 1 kF
constexpr double kRestShare = 0.02;          // of the largest current, where that is small

enum class Load { kRest, kCharge, kDischarge, kCrank };

/// Below which a current is rest [A]: that of a vehicle, or of a small battery's range.
double restLimit(const InputSequence& inputs) {
  double largest = 0.0;
  for (const InputSample& sample : inputs.samples)
    largest = std::max(largest, std::abs(sample.step.current));
  return std::min(EventLimits::kRestCurrent, kRestShare * largest);
}

Load loadOf(double current, Load before, double rest, const EventLimits& limits) {
  if (current < limits.crank_current) return Load::kCrank;
  if (current > rest) return Load::kCharge;
  if (current < -rest) return Load::kDischarge;
  const double half = 0.5 * rest;
  if (before == Load::kCharge && current > half) return Load::kCharge;
  if (before == Load::kDischarge && current < -half) return Load::kDischarge;
  return Load::kRest;
}

/// Samples of one load with what they add up to.
struct Run {
  Load load;
  IndexRange range;
  double duration = 0.0;  // [s], until the next run begins
  double charge = 0.0;    // [As]
  double volts = 0.0, count = 0.0;
};

std::vector<Run> runsOf(const InputSequence& inputs, const EventLimits& limits) {
  std::vector<Run> runs;
  const double rest = restLimit(inputs);
  for (std::size_t n = 0; n < inputs.samples.size(); ++n) {
    const InputSample& sample = inputs.samples[n];
    const Load load =
        loadOf(sample.step.current, runs.empty() ? Load::kRest : runs.back().load, rest, limits);
    if (!runs.empty() && !sample.step.gap) {
      runs.back().duration += sample.step.duration;
      runs.back().charge += sample.step.duration * sample.step.held;
    }
    if (runs.empty() || sample.step.gap || runs.back().load != load) runs.push_back({load, {n, n}});
    Run& run = runs.back();
    run.range.last = n + 1;
    run.volts += sample.count * sample.voltage;
    run.count += sample.count;
  }
  return runs;
}

Regime regimeOf(const Run& run, Load before) {
  switch (run.load) {
    case Load::kCrank: return Regime::kCrank;
    case Load::kCharge:
      if (run.duration > kLongChargeTime && run.charge > kLongChargeCurrent * run.duration)
        return Regime::kLongCharge;
      return run.volts > kHighVoltage * run.count ? Regime::kHighVoltageCharge
                                                  : Regime::kShortCharge;
    case Load::kDischarge:
      return run.duration > kLongDischargeTime ? Regime::kLongDischarge : Regime::kDischarge;
    case Load::kRest: break;
  }
  if (before == Load::kRest) return Regime::kFirstRest;
  return before == Load::kCharge ? Regime::kPostChargeRest : Regime::kPostDischargeRest;
}

/// Whether the current changes by more than kEdgeStep around a sample. The sample before belongs to
/// its surroundings at any rate: at slow rates the jump shows in nothing else.
bool isEdge(const InputSequence& inputs, std::size_t n) {
  const std::vector<InputSample>& samples = inputs.samples;
  const auto isNear = [&](std::size_t k) {
    return std::abs(samples[n].step.time - samples[k].step.time) <= kEdgeReach * (1.0 + 1e-9);
  };
  double low = samples[n].step.current, high = low;
  const auto take = [&](std::size_t k) {
    low = std::min(low, samples[k].step.current);
    high = std::max(high, samples[k].step.current);
  };
  for (std::size_t k = n; k > 0 && isNear(k - 1); --k) take(k - 1);
  for (std::size_t k = n + 1; k < samples.size() && isNear(k); ++k) take(k);
  if (n > 0 && !samples[n].step.gap) take(n - 1);
  return high - low > kEdgeStep;
}

}  // namespace

std::string regimeName(Regime regime) {
  static constexpr std::array<const char*, kRegimes> kNames = {"edge",
                                                               "crank",
                                                               "long charge",
                                                               "high-voltage charge",
                                                               "short charge",
                                                               "long discharge",
                                                               "discharge",
                                                               "post-charge rest",
                                                               "post-discharge rest",
                                                               "rest before any load"};
  return kNames.at(static_cast<std::size_t>(regime));
}

std::vector<Regime> regimesOf(const InputSequence& inputs, const EventLimits& limits) {
  std::vector<Regime> regimes(inputs.samples.size());
  Load before = Load::kRest;
  for (const Run& run : runsOf(inputs, limits)) {
    const Regime regime = regimeOf(run, before);
    for (std::size_t n = run.range.first; n < run.range.last; ++n) {
      const bool is_slow = inputs.samples[n].step.duration > kEdgeReach;
      regimes[n] =
          isEdge(inputs, n) && !(regime == Regime::kCrank && is_slow) ? Regime::kEdge : regime;
    }
    if (run.load != Load::kRest && std::abs(run.charge) > kMoved)
      before = run.charge > 0.0 ? Load::kCharge : Load::kDischarge;
  }
  return regimes;
}

std::vector<Regime> regimesOf(const Series& series, IndexRange range, const EventLimits& limits) {
  const InputSequence inputs = compressedInputs(series, range);
  const std::vector<Regime> regimes = regimesOf(inputs, limits);
  std::vector<Regime> all;
  all.reserve(range.size());
  for (std::size_t n = 0; n < regimes.size(); ++n)
    all.insert(all.end(), static_cast<std::size_t>(std::lround(inputs.samples[n].count)),
               regimes[n]);
  return all;
}

void requireOneSize(const char* function, const InputSequence& inputs,
                    const std::vector<Regime>& regimes, std::size_t fitted) {
  if (regimes.size() == inputs.samples.size() && fitted == inputs.samples.size()) return;
  throw std::invalid_argument(format("%s: fit, inputs and regimes have %zu, %zu and %zu samples",
                                     function, fitted, inputs.samples.size(), regimes.size()));
}

std::vector<Episode> episodesOf(const InputSequence& inputs, const std::vector<Regime>& regimes) {
  requireOneSize("episodesOf", inputs, regimes, inputs.samples.size());
  std::vector<Episode> episodes;
  for (std::size_t n = 0; n < regimes.size(); ++n) {
    if (episodes.empty() || inputs.samples[n].step.gap || episodes.back().regime != regimes[n])
      episodes.push_back({regimes[n], {n, n}});
    episodes.back().range.last = n + 1;
  }
  return episodes;
}

}  // namespace battery_sof
