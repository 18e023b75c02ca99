#include "diagnosis/regimes.hpp"

#include <cmath>
#include <deque>
#include <stdexcept>

#include "recording/events.hpp"

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

enum class Load { kRest, kCharge, kDischarge, kCrank };

Load loadOf(double current, Load before) {
  const EventLimits limits;
  if (current < limits.crank_current) return Load::kCrank;
  if (current > limits.kRestCurrent) return Load::kCharge;
  if (current < -limits.kRestCurrent) return Load::kDischarge;
  const double half = 0.5 * limits.kRestCurrent;
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

std::vector<Run> runsOf(const InputSequence& inputs) {
  std::vector<Run> runs;
  for (std::size_t n = 0; n < inputs.samples.size(); ++n) {
    const InputSample& sample = inputs.samples[n];
    const Load load = loadOf(sample.step.current, runs.empty() ? Load::kRest : runs.back().load);
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
  return before == Load::kCharge ? Regime::kPostChargeRest : Regime::kPostDischargeRest;
}

/// Whether the current changes by more than kEdgeStep around each sample; one pass with the
/// extremes of a moving window.
class EdgeFinder {
 public:
  explicit EdgeFinder(const InputSequence& inputs) : inputs_(inputs) {}

  /// Samples in order.
  bool isEdge(std::size_t n) {
    while (next_ < inputs_.samples.size() && (next_ <= n || isNear(n, next_))) take(next_++);
    while (first_ < n && !isNear(n, first_)) ++first_;
    // The sample before belongs to it at any rate: at slow rates the jump shows in nothing else.
    const bool alone = first_ == n && n > 0 && !inputs_.samples[n].step.gap;
    const std::size_t from = alone ? n - 1 : first_;
    drop(high_, from);
    drop(low_, from);
    return current(high_.front()) - current(low_.front()) > kEdgeStep;
  }

  bool isSlow(std::size_t n) const { return inputs_.samples[n].step.duration > kEdgeReach; }

 private:
  double current(std::size_t n) const { return inputs_.samples[n].step.current; }
  bool isNear(std::size_t a, std::size_t b) const {
    return std::abs(inputs_.samples[a].step.time - inputs_.samples[b].step.time) <=
           kEdgeReach * (1.0 + 1e-9);
  }
  void take(std::size_t n) {
    while (!high_.empty() && current(high_.back()) <= current(n)) high_.pop_back();
    while (!low_.empty() && current(low_.back()) >= current(n)) low_.pop_back();
    high_.push_back(n);
    low_.push_back(n);
  }
  static void drop(std::deque<std::size_t>& window, std::size_t from) {
    while (window.front() < from) window.pop_front();
  }

  const InputSequence& inputs_;
  std::size_t first_ = 0, next_ = 0;
  std::deque<std::size_t> high_, low_;
};

}  // namespace

std::string regimeName(Regime regime) {
  switch (regime) {
    case Regime::kEdge: return "edge";
    case Regime::kCrank: return "crank";
    case Regime::kLongCharge: return "long charge";
    case Regime::kHighVoltageCharge: return "high-voltage charge";
    case Regime::kShortCharge: return "short charge";
    case Regime::kLongDischarge: return "long discharge";
    case Regime::kDischarge: return "discharge";
    case Regime::kPostChargeRest: return "post-charge rest";
    case Regime::kPostDischargeRest: return "post-discharge rest";
  }
  throw std::invalid_argument("regimeName: not a regime");
}

std::vector<Regime> regimesOf(const InputSequence& inputs) {
  std::vector<Regime> regimes(inputs.samples.size());
  EdgeFinder edges(inputs);
  Load before = Load::kRest;
  for (const Run& run : runsOf(inputs)) {
    const Regime regime = regimeOf(run, before);
    for (std::size_t n = run.range.first; n < run.range.last; ++n) {
      const bool edge = edges.isEdge(n) && !(regime == Regime::kCrank && edges.isSlow(n));
      regimes[n] = edge ? Regime::kEdge : regime;
    }
    if (run.load != Load::kRest && std::abs(run.charge) > kMoved)
      before = run.charge > 0.0 ? Load::kCharge : Load::kDischarge;
  }
  return regimes;
}

std::vector<Regime> regimesOf(const Series& series, IndexRange range) {
  const InputSequence inputs = compressedInputs(series, range);
  const std::vector<Regime> regimes = regimesOf(inputs);
  std::vector<Regime> all;
  all.reserve(range.size());
  for (std::size_t n = 0; n < regimes.size(); ++n)
    all.insert(all.end(), static_cast<std::size_t>(std::lround(inputs.samples[n].count)),
               regimes[n]);
  return all;
}

std::vector<Episode> episodesOf(const InputSequence& inputs, const std::vector<Regime>& regimes) {
  if (regimes.size() != inputs.samples.size())
    throw std::invalid_argument("episodesOf: " + std::to_string(regimes.size()) + " regimes for " +
                                std::to_string(inputs.samples.size()) + " samples");
  std::vector<Episode> episodes;
  for (std::size_t n = 0; n < regimes.size(); ++n) {
    if (episodes.empty() || inputs.samples[n].step.gap || episodes.back().regime != regimes[n])
      episodes.push_back({regimes[n], {n, n}});
    episodes.back().range.last = n + 1;
  }
  return episodes;
}

}  // namespace battery_sof
