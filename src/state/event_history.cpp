#include "state/event_history.hpp"

namespace battery_sof {
namespace {

// Of stops (docs/decisions/0018-stops.md): how far the level moves from one to the next, and how one
// differs from it [V].
constexpr double kStopWalk = 0.04, kStopNoise = 0.08;
// Stops that the first guess of the spread counts as, and how much of the past spread each keeps.
constexpr double kGuessedStops = 3.0, kKept = 0.9;

}  // namespace

void EventHistory::add(const PastEvent& event) {
  const bool is_charge = event.kind == PastEvent::Kind::kCharge;
  auto& past = is_charge ? charges : event.kind == PastEvent::Kind::kCrank ? cranks : stops;
  past.push_back(event);
  // Charges are compared over two durations.
  if (past.size() > (is_charge ? 2 : 1) * kMost) past.erase(past.begin());
}

StopLevel EventHistory::nextStop(double usual_error) const {
  constexpr double kNoise = kStopNoise * kStopNoise;
  double mean = 0.0, variance = usual_error * usual_error;
  double count = kGuessedStops, squares = count * (variance + kNoise);
  for (const PastEvent& stop : stops) {
    const double gain = variance / (variance + kNoise);
    const double innovation = stop.measured - stop.modelled - mean;
    mean += gain * innovation;
    variance = (1.0 - gain) * variance + kStopWalk * kStopWalk;
    squares = kKept * squares + innovation * innovation;
    count = kKept * count + 1.0;
  }
  return {mean, stops.empty() ? variance : squares / count};
}

void EventHistory::moveBy(double moved) {
  for (auto* past : {&cranks, &charges, &stops})
    for (PastEvent& event : *past) event.time += moved;
}

}  // namespace battery_sof
