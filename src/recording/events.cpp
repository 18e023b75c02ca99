#include "recording/events.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "recording/channel_statistics.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr double kLongCharge = 10.0;    // [s]
constexpr double kStopCurrent = -2.0;   // [A], more than an idle network's
constexpr double kChargeCurrent = 2.0;  // [A], docs/physics.md#regimes
constexpr double kFewestSamples = 3.0;  // of it

void requireValid(const EventLimits& limits) {
  requireThat(limits.crank_current < 0.0, "EventLimits: crank_current [A]", limits.crank_current,
              "below 0");
}

void requireMask(const Series& series, IndexRange range,
                 const std::vector<char>& voltage_controlled) {
  if (voltage_controlled.size() == series.size() && range.first <= range.last &&
      range.last <= series.size())
    return;
  throw std::invalid_argument("charge phases: range " + std::to_string(range.first) + " to " +
                              std::to_string(range.last) + " and a mask of " +
                              std::to_string(voltage_controlled.size()) + " for " +
                              std::to_string(series.size()) + " samples");
}

std::vector<IndexRange> crankRanges(const Series& series, IndexRange bounds,
                                    const EventLimits& limits, double max_gap) {
  std::vector<IndexRange> cranks;
  EventDetector detector(limits);
  std::size_t first = bounds.first;
  for (std::size_t n = bounds.first; n <= bounds.last; ++n) {
    const bool was_at_level = detector.isAtCrankLevel(), is_end = n == bounds.last;
    const bool is_gap =
        is_end || (n > bounds.first && series.time[n] - series.time[n - 1] > max_gap);
    detector.add(is_end ? HUGE_VAL : series.time[n], is_end ? 0.0 : series.current[n], is_gap);
    if (detector.crankEnded()) cranks.push_back({first, n});
    if (!was_at_level || is_gap) first = n;
  }
  return cranks;
}

std::vector<EventKind> kindOfEverySample(const Series& series, const EventLimits& limits,
                                         double max_gap) {
  std::vector<EventKind> kinds(series.size());
  std::transform(series.current.begin(), series.current.end(), kinds.begin(), [&](double current) {
    return std::abs(current) < limits.kRestCurrent ? EventKind::kRest
           : current > 0.0                         ? EventKind::kCharge
                                                   : EventKind::kDischarge;
  });
  for (const IndexRange& range : crankRanges(series, {0, series.size()}, limits, max_gap))
    std::fill(kinds.begin() + range.first, kinds.begin() + range.last, EventKind::kCrank);
  return kinds;
}

Event describeEvent(const Series& series, IndexRange range, EventKind kind) {
  const auto current = series.current.begin(), voltage = series.voltage.begin();
  const auto lower_magnitude = [](double a, double b) { return std::abs(a) < std::abs(b); };
  const auto extremes = std::minmax_element(voltage + range.first, voltage + range.last);
  Event event;
  event.kind = kind;
  event.range = range;
  event.from = series.time[range.first];
  event.to = series.time[range.last - 1];
  for (std::size_t k = range.first + 1; k < range.last; ++k)
    event.charge +=
        0.5 * (series.current[k] + series.current[k - 1]) * (series.time[k] - series.time[k - 1]);
  event.peak_current =
      *std::max_element(current + range.first, current + range.last, lower_magnitude);
  event.min_voltage = *extremes.first;
  event.max_voltage = *extremes.second;
  return event;
}

}  // namespace

std::string toString(EventKind kind) {
  constexpr std::array kNames = {"crank", "discharge", "charge", "rest"};
  return kNames.at(static_cast<std::size_t>(kind));
}

bool isStopLoad(double current, double min_current, const EventLimits& limits) {
  return current < std::min(min_current, kStopCurrent) && current > limits.crankLevel();
}

void EventDetector::add(double time, double current, bool is_gap,
                        std::optional<double> min_current) {
  const bool is_level = current <= limits_.crankLevel();
  crank_ended_ = (is_gap || !is_level) && mayBeCrank() && crank_lowest_ <= limits_.crank_current;
  if (is_gap || !is_level) crank_since_.reset();
  if (is_level) {
    crank_lowest_ = crank_since_ ? std::min(crank_lowest_, current) : current;
    crank_since_ = crank_since_.value_or(time);
    crank_until_ = time;
  }
  const bool was_charging = charging_;
  charging_ = current > kChargeCurrent && !is_gap;
  charge_begins_ =
      !is_gap && (min_current ? discharged_ && current > 0.0 : charging_ && !was_charging);
  discharged_ = current < kDischargeCurrent || (discharged_ && !(is_gap || current > 0.0));
  in_stop_ = !is_gap && min_current && isStopLoad(current, *min_current, limits_);
  stop_begins_ = in_stop_ && may_stop_;
  may_stop_ = !is_gap && !in_stop_;
}

void EventDetector::beginBehind(double current) {
  *this = EventDetector(limits_);
  charging_ = current > kChargeCurrent;
  discharged_ = current < kDischargeCurrent;
}

std::vector<Event> detectEvents(const Series& series, const EventLimits& limits) {
  requireValid(limits);
  const double max_gap = gapThreshold(series);
  const std::vector<EventKind> kinds = kindOfEverySample(series, limits, max_gap);
  std::vector<Event> events;
  const auto joined = [&](std::size_t k) {
    return kinds[k] == kinds[k - 1] && series.time[k] - series.time[k - 1] <= max_gap;
  };
  for (const IndexRange& range : cutWhere({0, series.size()}, joined))
    events.push_back(describeEvent(series, range, kinds[range.first]));
  return events;
}

std::vector<Event> detectCranks(const Series& series, IndexRange range, const EventLimits& limits) {
  requireValid(limits);
  const double max_gap = gapThreshold(medianInterval(series.time, range));
  std::vector<Event> cranks;
  for (const IndexRange& crank : crankRanges(series, range, limits, max_gap))
    cranks.push_back(describeEvent(series, crank, EventKind::kCrank));
  return cranks;
}

EventSummary summarise(const Series& series, const std::vector<Event>& events) {
  const double max_gap = gapThreshold(series);
  EventSummary summary;
  for (std::size_t k = 1; k < series.size(); ++k) {
    const double interval = series.time[k] - series.time[k - 1];
    if (interval > max_gap) continue;
    const double charge = 0.5 * (series.current[k] + series.current[k - 1]) * interval;
    (charge > 0.0 ? summary.charge_in : summary.charge_out) += charge;
  }
  for (std::size_t k = 0; k < events.size(); ++k) {
    const Event& event = events[k];
    const bool is_joined = k + 1 < events.size() && events[k + 1].from - event.to <= max_gap;
    const double duration = is_joined ? events[k + 1].from - event.from : event.duration();
    EventTotals& totals = summary.of(event.kind);
    ++totals.count;
    totals.duration += duration;
    if (event.kind != EventKind::kCharge) continue;
    summary.longest_charge = std::max(summary.longest_charge, duration);
    if (duration > kLongCharge) ++summary.long_charges;
    const double low = event.min_voltage, high = event.max_voltage;
    summary.min_charge_voltage = std::min(summary.min_charge_voltage.value_or(low), low);
    summary.max_charge_voltage = std::max(summary.max_charge_voltage.value_or(high), high);
  }
  return summary;
}

std::vector<std::size_t> chargeBeginnings(const Series& series, IndexRange range,
                                          const std::vector<char>& voltage_controlled) {
  requireMask(series, range, voltage_controlled);
  std::vector<std::size_t> beginnings;
  EventDetector detector;
  for (std::size_t k = range.first; k < range.last; ++k) {
    detector.add(series.time[k], series.current[k], false, 0.0);
    if (!voltage_controlled[k])
      detector.denyCharge();
    else if (detector.chargeBegins())
      beginnings.push_back(k);
  }
  return beginnings;
}

std::optional<IndexRange> beginningOfCharge(const Series& series, IndexRange range,
                                            std::size_t first, double duration,
                                            const std::vector<char>& voltage_controlled) {
  requireMask(series, range, voltage_controlled);
  const double interval = medianInterval(series);
  if (first >= range.last || interval * kFewestSamples > duration) return std::nullopt;
  const double end = series.time[first] + duration - 0.5 * interval;
  std::size_t last = first, controlled = 0;
  for (; last < range.last && series.time[last] < end; ++last)
    controlled += voltage_controlled[last] ? 1 : 0;
  const bool complete = series.time[last - 1] + interval >= end;
  if (!complete || static_cast<double>(controlled) < kMinControlled * duration / interval)
    return std::nullopt;
  return IndexRange{first, last};
}

}  // namespace battery_sof
