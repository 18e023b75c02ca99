#include "ros/node_statistics.hpp"

#include <algorithm>

#include "recording/channel_statistics.hpp"

namespace battery_sof {

void ResponseClock::addQuery(double milliseconds) {
  const std::lock_guard<std::mutex> lock(mutex_);
  queries_.add(milliseconds);
}

void ResponseClock::addSample(double milliseconds) {
  const std::lock_guard<std::mutex> lock(mutex_);
  samples_.add(milliseconds);
  sample_longest_ = std::max(sample_longest_, milliseconds);
}

ResponseTimes ResponseClock::report() {
  Ring queries, samples;
  ResponseTimes times;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    queries = queries_;
    samples = samples_;
    times.sample_longest_ms = sample_longest_;
    sample_longest_ = 0.0;
  }
  times.queries = queries.count;
  times.query_p99_ms = quantile(queries.kept(), 0.99);
  times.query_longest_ms = quantile(queries.kept(), 1.0);
  times.sample_p99_ms = quantile(samples.kept(), 0.99);
  return times;
}

}  // namespace battery_sof
