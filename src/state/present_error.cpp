#include "state/present_error.hpp"

#include <algorithm>
#include <cmath>

namespace battery_sof {
namespace {

constexpr double kLevelMemory = 8.0;        // [s], as a stop's level (docs/decisions/0018-stops.md)
constexpr double kMissMemory = 300.0;       // [s], of the comparisons
constexpr double kSnapshotInterval = 10.0;  // [s]
constexpr double kSameLoad = 0.95;          // correlation above which a load is the same
constexpr double kSpans[] = {0.0, 30.0, 120.0};  // [s]; the first is the next sample

double largestCurrent(const FittedModel& model) {
  return std::max(-model.fit.excited.min_current, model.fit.excited.max_current);
}

}  // namespace

double correlationOfLoads(double one, double other, double largest) {
  const double span = std::max({largest, std::abs(one), std::abs(other), 1e-6});
  return std::max(0.0, 1.0 - std::abs(one - other) / span);
}

double missedAhead(const PresentError& error, double ahead) {
  const auto& squares = error.squares;
  const double first = squares[0], middle = std::max(first, squares[1]),
               last = std::max(middle, squares[2]);
  if (ahead <= kSpans[1]) return first + (middle - first) * std::max(0.0, ahead) / kSpans[1];
  if (ahead <= kSpans[2])
    return middle + (last - middle) * (ahead - kSpans[1]) / (kSpans[2] - kSpans[1]);
  const double power =
      middle > 0.0 ? std::clamp(std::log(last / middle) / std::log(kSpans[2] / kSpans[1]), 1.0, 2.0)
                   : 1.0;
  return last * std::pow(ahead / kSpans[2], power);
}

PresentForecast forecastOf(const FittedModel& model, double current, double ahead) {
  const PresentError& error = model.state.residual_state.present;
  if (!error.current) return {};
  return {correlationOfLoads(current, *error.current, error.largest), error.level,
          missedAhead(error, ahead)};
}

ErrorForecast expectedPresentError(const FittedModel& model) {
  const double usual = model.fit.scores.rmse;
  ErrorForecast expected{0.0, usual * usual};
  if (model.fit.source) expected = model.intervals.event_history.nextStop(usual);
  expected.variance += missedAhead(model.state.residual_state.present,
                                   std::max(0.0, model.state.time - model.fit.window.to));
  return expected;
}

PresentErrorFilter::PresentErrorFilter(const FittedModel& model)
    : now_(model.state.residual_state.present) {
  now_.largest = std::max(now_.largest, largestCurrent(model));
  const double usual = model.fit.scores.rmse * model.fit.scores.rmse;
  for (std::size_t k = 0; k < now_.squares.size(); ++k)
    if (!(now_.weights[k] > 0.0)) {
      now_.squares[k] = usual;
      now_.weights[k] = 1.0;
    }
}

void PresentErrorFilter::compare(std::size_t span, double duration, double miss, double length) {
  // A comparison over another length than the span's counts as a walk's.
  const double square = miss * miss * (span == 0 ? 1.0 : kSpans[span] / length);
  double& weight = now_.weights[span];
  weight *= std::exp(-duration / kMissMemory);
  weight += 1.0;
  now_.squares[span] += (square - now_.squares[span]) / weight;
}

void PresentErrorFilter::compareSnapshots(double duration, double error, double current) {
  for (Snapshot& then : snapshots_) {
    if (then.next_span == std::size(kSpans)) continue;
    const double since = clock_ - then.time;
    if (since < kSpans[then.next_span]) continue;
    const std::size_t span = then.next_span++;
    if (correlationOfLoads(current, then.current, now_.largest) >= kSameLoad &&
        since <= 2.0 * kSpans[span] + duration)
      compare(span, std::max(duration, kSnapshotInterval), error - then.level, since);
  }
  while (!snapshots_.empty() && snapshots_.front().next_span == std::size(kSpans))
    snapshots_.pop_front();
}

void PresentErrorFilter::follow(const InputSample& sample, double error) {
  const double duration = sample.step.duration, current = sample.step.current;
  clock_ += duration;
  if (sample.voltage_controlled || sample.step.gap) {
    now_.current.reset();
    now_.since = 0.0;
    snapshots_.clear();
  }
  if (sample.voltage_controlled) return;
  now_.largest = std::max(now_.largest, std::abs(current));
  if (!now_.current) {
    now_.level = error;
  } else {
    const double alike = correlationOfLoads(current, *now_.current, now_.largest);
    const double since = now_.since;
    now_.since = alike >= kSameLoad ? since + duration : 0.0;
    if (now_.since > 0.0 && since > 0.0) compare(0, duration, error - now_.level, duration);
    compareSnapshots(duration, error, current);
    const double share = now_.since > 0.0 ? duration / now_.since : 0.0;
    now_.level += std::max({1.0 - std::exp(-duration / kLevelMemory), 1.0 - alike, share}) *
                  (error - now_.level);
  }
  now_.current = current;
  const bool is_due = snapshots_.empty() || clock_ - snapshots_.back().time >= kSnapshotInterval;
  if (now_.since > 0.0 && is_due) snapshots_.push_back({clock_, now_.level, current, 1});
}

}  // namespace battery_sof
