#include "prediction/history.hpp"

#include <array>

namespace battery_sof {

std::string toString(AnswerBasis basis) {
  constexpr std::array kNames = {"population", "previous_trip", "this_trip"};
  return kNames.at(static_cast<std::size_t>(basis));
}

bool History::continuesFrom(const Standing& then) const {
  return then.stream.counts().clock_restarts == now_.stream.counts().clock_restarts;
}

void History::rewindTo(Mark mark) {
  const std::shared_ptr<const Standing> then = marks_.at(mark);
  for (auto& [other, standing] : marks_)
    if (standing->driving > then->driving) standing = then;
  remove(Mark::kBeforeClockJump);
  const SampleStream since = std::exchange(now_, *then).stream;
  now_.stream.resumeAfter(since);
}

bool History::replay(ModelMonitor monitor) {
  now_.monitor = std::move(monitor);
  const Series& series = now_.stream.series();
  const double reached = now_.monitor.tracker().state().time;
  for (std::size_t n = firstAfter(series, reached); n < series.size(); ++n) {
    now_.monitor.follow(series[n], now_.stream.maxGap());
    if (!now_.monitor.isFinite()) return false;
  }
  return true;
}

}  // namespace battery_sof
