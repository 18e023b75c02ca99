#include "estimation/event_history.hpp"

#include <algorithm>

#include "recording/events.hpp"

namespace battery_sof {
namespace {

// Of stops (docs/decisions/0018-stops.md): how far the level moves from one to the next, and how one
// differs from it [V].
constexpr double kStopWalk = 0.04, kStopNoise = 0.08;
// Stops that the first guess of the spread counts as, and how much of the past spread each keeps.
constexpr double kGuessedStops = 3.0, kKept = 0.9;
constexpr double kStopCurrent = -2.0;  // [A], more than an idle network's

template <typename T>
void keep(std::vector<T>& past, const T& event, std::size_t most) {
  past.push_back(event);
  if (past.size() > most) past.erase(past.begin());
}

}  // namespace

void EventHistory::add(const PastCrank& crank) { keep(cranks, crank, kMost); }
void EventHistory::add(const PastCharge& charge) { keep(charges, charge, 2 * kMost); }
void EventHistory::add(const PastStop& stop) { keep(stops, stop, kMost); }

bool isStopLoad(double current, double min_current) {
  return current < std::min(min_current, kStopCurrent) &&
         current > 0.5 * EventLimits{}.crank_current;
}

StopLevel EventHistory::nextStop(double usual_error) const {
  constexpr double kNoise = kStopNoise * kStopNoise;
  double mean = 0.0, variance = usual_error * usual_error;
  double count = kGuessedStops, squares = count * (variance + kNoise);
  for (const PastStop& stop : stops) {
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
  for (PastCrank& crank : cranks) crank.time += moved;
  for (PastCharge& charge : charges) charge.time += moved;
  for (PastStop& stop : stops) stop.time += moved;
}

}  // namespace battery_sof
