#include "prediction/history.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace battery_sof {

std::string toString(AnswerBasis basis) {
  constexpr std::array kNames = {"population", "previous_trip", "this_trip"};
  return kNames.at(static_cast<std::size_t>(basis));
}

History::History(Standing beginning) : now_(std::move(beginning)) { mark(Mark::kBeginning); }

void History::mark(Mark mark) {
  remove(mark);
  marks_.push_back({mark, std::make_shared<const Standing>(now_)});
}

bool History::has(Mark mark) const {
  return std::any_of(marks_.begin(), marks_.end(),
                     [mark](const Marked& marked) { return marked.mark == mark; });
}

const Standing& History::at(Mark mark) const {
  return *std::find_if(marks_.begin(), marks_.end(), [mark](const Marked& marked) {
            return marked.mark == mark;
          })->standing;
}

bool History::continuesFrom(Mark mark) const {
  return at(mark).stream.counts().clock_restarts == now_.stream.counts().clock_restarts;
}

void History::remove(Mark mark) {
  marks_.erase(std::remove_if(marks_.begin(), marks_.end(),
                              [mark](const Marked& marked) { return marked.mark == mark; }),
               marks_.end());
}

void History::rewindTo(Mark mark) {
  auto marked = marks_.begin();
  while (marked->mark != mark) ++marked;
  const std::shared_ptr<const Standing> then = marked->standing;
  for (; marked != marks_.end(); ++marked) marked->standing = then;
  remove(Mark::kBeforeClockJump);
  const SampleStream stream = std::exchange(now_, *then).stream;
  now_.stream.resumeAfter(stream);
}

bool History::replay(ModelMonitor monitor) {
  now_.monitor = std::move(monitor);
  const Series& series = now_.stream.series();
  for (std::size_t n = firstAfter(series, now_.monitor.tracker().state().time); n < series.size();
       ++n) {
    now_.monitor.follow(series[n], now_.stream.maxGap());
    if (!now_.monitor.isFinite()) return false;
  }
  return true;
}

}  // namespace battery_sof
