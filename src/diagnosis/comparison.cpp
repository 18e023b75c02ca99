#include "diagnosis/comparison.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <stdexcept>

#include "battery_sof/intake.hpp"
#include "diagnosis/regimes.hpp"
#include "estimation/fit_quality.hpp"
#include "recording/events.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr int kDraws = 999;
constexpr double kBlocks = 30.0, kShortestBlock = 10.0, kLongestBlock = 60.0;  // [1], [s], [s]
constexpr double kWindow = 10.0, kShortestWindow = 1.0;                        // [s]
// [s], as currentAtVoltage()
constexpr double kStep = 0.1;

void requireOneSize(const char* function, const Series& series, IndexRange range,
                    const std::vector<double>& modelled, const std::vector<char>& masked) {
  if (modelled.size() == series.size() && (masked.empty() || masked.size() == series.size()) &&
      range.first <= range.last && range.last <= series.size())
    return;
  throw std::invalid_argument(
      format("%s: %zu voltages and %zu masks for %zu samples, range %zu to %zu", function,
             modelled.size(), masked.size(), series.size(), range.first, range.last));
}

bool counts(const std::vector<char>& masked, std::size_t n) {
  return masked.empty() || masked[n] == 0;
}

/// Events of the range, their samples counted from the series' first.
std::vector<Event> eventsOf(const Series& series, IndexRange range,
                            const EventLimits& limits = {}) {
  std::vector<Event> events = detectEvents(slice(series, range), limits);
  for (Event& event : events) {
    event.range.first += range.first;
    event.range.last += range.first;
  }
  return events;
}

/// Sums of one regime over one block of time.
struct BlockSums {
  double base = 0.0, extended = 0.0;  // [V^2]
  double samples = 0.0;
  void add(const BlockSums& other) {
    base += other.base;
    extended += other.extended;
    samples += other.samples;
  }
  double change() const { return std::sqrt(extended / samples) - std::sqrt(base / samples); }
};

void takeInterval(const std::vector<BlockSums>& blocks, RegimeComparison& comparison) {
  std::mt19937_64 random;  // its sequence is the standard's, the same on every machine
  std::vector<double> changes;
  for (int draw = 0; draw < kDraws; ++draw) {
    BlockSums sums;
    for (std::size_t k = 0; k < blocks.size(); ++k) sums.add(blocks[random() % blocks.size()]);
    changes.push_back(sums.change());
  }
  std::sort(changes.begin(), changes.end());
  const auto tail = static_cast<std::size_t>(0.025 * (kDraws + 1));
  comparison.change_lower = changes[tail - 1];
  comparison.change_upper = changes[changes.size() - tail];
}

std::optional<Simulation> simulationBefore(const FittedModel& model, double time) {
  if (model.state.time <= time) return simulationOf(model);
  if (model.fit.first_state.size() == 0 || model.fit.window.from > time) return std::nullopt;
  return simulationOf(atFirstState(model));
}

/// Errors of the mean current over windows of a charge, as they come to an end.
class CurrentErrors {
 public:
  void begin() { duration_ = charge_ = 0.0; }
  void add(double duration, double error) {
    duration_ += duration;
    charge_ += duration * error;
    if (duration_ >= kWindow) end();
  }
  void end() {
    if (duration_ >= kShortestWindow) {
      total_ += std::abs(charge_);
      time_ += duration_;
    }
    begin();
  }
  std::optional<double> mean() const {
    return time_ > 0.0 ? std::optional<double>(total_ / time_) : std::nullopt;
  }

 private:
  double duration_ = 0.0, charge_ = 0.0;  // [s], [As] of the window
  double total_ = 0.0, time_ = 0.0;       // [As], [s] of all
};

/// @param simulation at the charge's first sample.
void addCharge(Simulation simulation, const Series& series, IndexRange charge,
               const std::vector<char>& masked, CurrentErrors& errors) {
  errors.begin();
  double duration = 0.0, measured = 0.0, volts = 0.0, weight = 0.0;
  for (std::size_t n = charge.first + 1; n < charge.last; ++n) {
    const double dt = series.time[n] - series.time[n - 1];
    duration += dt;
    measured += 0.5 * (series.current[n - 1] + series.current[n]) * dt;
    if (counts(masked, n)) {
      volts += series.voltage[n] * dt;
      weight += dt;
    }
    if ((duration < kStep && n + 1 < charge.last) || weight <= 0.0) continue;
    const double current = simulation.advanceAtVoltage(volts / weight, duration, kMaxCurrent);
    errors.add(duration, current - measured / duration);
    duration = measured = volts = weight = 0.0;
  }
  errors.end();
}

}  // namespace

ErrorMetrics errorMetrics(const Series& series, IndexRange range,
                          const std::vector<double>& modelled, const std::vector<char>& masked,
                          const EventLimits& limits) {
  requireOneSize("errorMetrics", series, range, modelled, masked);
  std::vector<double> measured, predicted;
  ErrorMetrics metrics;
  metrics.max_abs = 0.0;
  for (std::size_t n = range.first; n < range.last; ++n) {
    if (!counts(masked, n)) continue;
    measured.push_back(series.voltage[n]);
    predicted.push_back(modelled[n]);
    metrics.max_abs = std::max(metrics.max_abs, std::abs(series.voltage[n] - modelled[n]));
  }
  if (measured.empty())
    throw std::invalid_argument("errorMetrics: no measured sample in the range");
  metrics.q_dyn_percent = qDyn(measured, predicted).value_or(0.0);
  metrics.rmse = rootMeanSquareError(measured, predicted);
  double crank_error = 0.0, charge_error = 0.0;
  std::size_t charging = 0;
  for (const Event& event : eventsOf(series, range, limits)) {
    double lowest = HUGE_VAL, lowest_modelled = HUGE_VAL;  // [V]
    for (std::size_t n = event.range.first; n < event.range.last; ++n) {
      if (!counts(masked, n)) continue;
      lowest = std::min(lowest, series.voltage[n]);
      lowest_modelled = std::min(lowest_modelled, modelled[n]);
      if (event.kind != EventKind::kCharge) continue;
      charge_error += series.voltage[n] - modelled[n];
      ++charging;
    }
    if (event.kind != EventKind::kCrank || !std::isfinite(lowest)) continue;
    crank_error += std::abs(lowest - lowest_modelled);
    ++metrics.cranks;
  }
  if (metrics.cranks > 0) metrics.crank_mae = crank_error / static_cast<double>(metrics.cranks);
  if (charging > 0) metrics.charge_bias = charge_error / static_cast<double>(charging);
  return metrics;
}

std::vector<RegimeComparison> compareRegimes(const Series& series, IndexRange range,
                                             const std::vector<double>& base,
                                             const std::vector<double>& extended,
                                             const std::vector<char>& masked,
                                             const EventLimits& limits) {
  requireOneSize("compareRegimes", series, range, base, masked);
  requireOneSize("compareRegimes", series, range, extended, masked);
  if (range.empty()) return {};
  const std::vector<Regime> regimes = regimesOf(series, range, limits);
  const double first = series.time[range.first], span = series.time[range.last - 1] - first;
  const double length = std::clamp(span / kBlocks, kShortestBlock, kLongestBlock);
  std::array<std::map<std::size_t, BlockSums>, kRegimes> sums;  // by block; gaps have none
  for (std::size_t n = range.first; n < range.last; ++n) {
    if (!counts(masked, n)) continue;
    const auto block = static_cast<std::size_t>((series.time[n] - first) / length);
    const double before = series.voltage[n] - base[n], after = series.voltage[n] - extended[n];
    sums[static_cast<std::size_t>(regimes[n - range.first])][block].add(
        {before * before, after * after, 1.0});
  }
  std::vector<RegimeComparison> comparisons;
  for (std::size_t g = 0; g < kRegimes; ++g) {
    std::vector<BlockSums> blocks;
    for (const auto& [block, sum] : sums[g]) blocks.push_back(sum);
    if (blocks.empty()) continue;
    BlockSums all;
    for (const BlockSums& block : blocks) all.add(block);
    RegimeComparison comparison;
    comparison.regime = regimeName(static_cast<Regime>(g));
    comparison.samples = static_cast<std::size_t>(std::lround(all.samples));
    comparison.base_rmse = std::sqrt(all.base / all.samples);
    comparison.extended_rmse = std::sqrt(all.extended / all.samples);
    comparison.change = all.change();
    takeInterval(blocks, comparison);
    comparisons.push_back(comparison);
  }
  return comparisons;
}

std::optional<double> chargeCurrentError(const FittedModel& model, const Series& series,
                                         IndexRange range, const std::vector<char>& masked) {
  if (range.empty()) return std::nullopt;
  std::optional<Simulation> simulation = simulationBefore(model, series.time[range.first]);
  if (!simulation) return std::nullopt;
  const IndexRange whole{indexRange(series, simulation->time(), series.time[range.last - 1]).first,
                         range.last};
  const InputSequence inputs = inputSequence(series, whole);
  const double max_gap = gapThreshold(series);
  std::size_t next = whole.first;
  // Its first step leads from the model's time to the first sample.
  const auto carryTo = [&](std::size_t sample) {
    for (; next <= sample; ++next) {
      InputStep step = inputs.samples[next - whole.first].step;
      if (next == whole.first) {
        step.duration = step.time - simulation->time();
        step.gap = step.duration > max_gap;
        if (step.gap) step.held = 0.0;
      }
      simulation->advance(step);
    }
  };
  CurrentErrors errors;
  for (const Event& event : eventsOf(series, range)) {
    if (event.kind != EventKind::kCharge) continue;
    carryTo(event.range.first);
    addCharge(*simulation, series, event.range, masked, errors);
  }
  return errors.mean();
}

}  // namespace battery_sof
