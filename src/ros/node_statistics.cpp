#include "ros/node_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace battery_sof {

double ResponseClock::Ring::quantile(double share) const {
  if (values.empty()) return 0.0;
  std::vector<double> sorted(values.begin(), values.end());
  const auto index =
      static_cast<std::ptrdiff_t>(std::ceil(share * static_cast<double>(sorted.size() - 1)));
  std::nth_element(sorted.begin(), sorted.begin() + index, sorted.end());
  return sorted[static_cast<std::size_t>(index)];
}

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
  times.query_p99_ms = queries.quantile(0.99);
  times.query_longest_ms = queries.quantile(1.0);
  times.sample_p99_ms = samples.quantile(0.99);
  return times;
}

}  // namespace battery_sof
