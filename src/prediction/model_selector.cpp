#include "prediction/model_selector.hpp"

#include <cmath>

namespace battery_sof {
namespace {

constexpr double kBlock = 10.0;              // [s]
constexpr double kClearlyBetter = 0.95;      // of the RMSE
constexpr double kToleratedWorsening = 1.1;  // as OnlineSession tolerates of a new model
constexpr int kMinEvents = 3;
// Half a step of the coarsest battery sensor known (25 mV), and what it moves through r_charge's
// magnitude of 10 mOhm.
constexpr double kNegligibleVoltage = 0.0125;  // [V]
constexpr double kNegligibleCurrent = 1.25;    // [A]

double meanOf(double sum, int count) { return count > 0 ? sum / count : 0.0; }

double errorOf(const EventComparison& event) {
  return std::abs(event.measured - event.expected.value);
}

}  // namespace

void ModelSelector::Errors::add(double base_error, double extended_error) {
  ++count;
  base += base_error;
  extended += extended_error;
}

void ModelSelector::Errors::add(const Errors& other) {
  count += other.count;
  base += other.base;
  extended += other.extended;
}

bool ModelSelector::Errors::isExtendedWorse(double negligible) const {
  if (count < kMinEvents) return false;
  return extended > kToleratedWorsening * base && extended - base > negligible * count;
}

double ModelSelector::blockOf(double time) { return std::floor(time / kBlock); }

void ModelSelector::add(const StreamSample& sample, const ModelMonitor& base,
                        const SessionEvents& base_events, const ModelMonitor& extended,
                        const SessionEvents& extended_events) {
  const double interval = blocks_.empty() ? 0.0 : sample.time - blocks_.back().to;
  if (blocks_.empty() || blockOf(sample.time) != blockOf(blocks_.back().from)) {
    if (score().duration >= kMinDuration) extended_answers_ = isExtendedBetter();
    blocks_.push_back({sample.time, sample.time, 0.0, {}, {}, {}});
    while (blocks_.front().to < sample.time - ModelMonitor::kBacktestSpan) blocks_.pop_front();
  }
  Block& block = blocks_.back();
  block.to = sample.time;
  if (interval <= kBlock) block.duration += interval;
  if (base.isCompared() && extended.isCompared())
    block.squares.add(std::pow(base.error(), 2), std::pow(extended.error(), 2));
  if (!base_events.cranks.empty() && !extended_events.cranks.empty())
    block.cranks.add(errorOf(base_events.cranks[0]), errorOf(extended_events.cranks[0]));
  if (!base_events.charges.empty() && !extended_events.charges.empty())
    block.charges.add(errorOf(base_events.charges[0]), errorOf(extended_events.charges[0]));
}

ModelSelector::Block ModelSelector::total() const {
  Block sum;
  for (const Block& block : blocks_) {
    sum.duration += block.duration;
    sum.squares.add(block.squares);
    sum.cranks.add(block.cranks);
    sum.charges.add(block.charges);
  }
  return sum;
}

ModelSelectorScore ModelSelector::score() const {
  const Block sum = total();
  ModelSelectorScore score;
  score.duration = sum.duration;
  score.base_rmse = std::sqrt(meanOf(sum.squares.base, sum.squares.count));
  score.extended_rmse = std::sqrt(meanOf(sum.squares.extended, sum.squares.count));
  score.cranks = sum.cranks.count;
  score.base_crank_error = meanOf(sum.cranks.base, sum.cranks.count);
  score.extended_crank_error = meanOf(sum.cranks.extended, sum.cranks.count);
  score.charges = sum.charges.count;
  score.base_charge_error = meanOf(sum.charges.base, sum.charges.count);
  score.extended_charge_error = meanOf(sum.charges.extended, sum.charges.count);
  return score;
}

bool ModelSelector::isExtendedBetter() const {
  const Block sum = total();
  const double margin = extended_answers_ ? 1.0 : kClearlyBetter;
  return std::sqrt(sum.squares.extended) < margin * std::sqrt(sum.squares.base) &&
         !sum.cranks.isExtendedWorse(kNegligibleVoltage) &&
         !sum.charges.isExtendedWorse(kNegligibleCurrent);
}

}  // namespace battery_sof
