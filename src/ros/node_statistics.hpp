#pragma once

#include <algorithm>
#include <boost/circular_buffer.hpp>
#include <cmath>
#include <cstddef>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "prediction/online_session.hpp"
#include "recording/channel_statistics.hpp"

namespace battery_sof {

/// How events since the start compare with what the model expected.
struct EventTally {
  std::size_t count = 0;
  std::size_t inside = 0;      ///< inside their 90 % interval
  double sum_abs_error = 0.0;  ///< [V] or [A]

  void add(double measured, const Interval& expected) {
    ++count;
    sum_abs_error += std::abs(measured - expected.value);
    if (expected.lower <= measured && measured <= expected.upper) ++inside;
  }
  /// None before the first.
  std::optional<double> coverageOf() const { return perEvent(static_cast<double>(inside)); }
  std::optional<double> meanAbsError() const { return perEvent(sum_abs_error); }

 private:
  std::optional<double> perEvent(double sum) const {
    return count == 0 ? std::nullopt : std::optional<double>(sum / static_cast<double>(count));
  }
};

/// One kind of event in the running back-test.
struct KindTally {
  EventTally model;
  EventTally baseline;  ///< of its window's baseline predictors, where they expected something
  std::optional<EventComparison> last;

  void add(const EventComparison& event) {
    last = event;
    model.add(event.measured, event.expected);
    if (event.baseline) baseline.add(event.measured, *event.baseline);
  }
};

struct EventTallies {
  KindTally cranks, charges;
  IntervalCalibrations calibrations;

  void add(const SessionEvents& events) {
    for (const EventComparison& crank : events.cranks) cranks.add(crank);
    for (const EventComparison& charge : events.charges) charges.add(charge);
  }
};

/// What a report says of response times.
struct ResponseTimes {
  std::size_t queries = 0;        ///< since the start
  double query_p99_ms = 0.0;      ///< 99th percentile of the last kKept queries' work
  double query_longest_ms = 0.0;  ///< of the same
  /// of the last kKept samples, from arrival (simulated time: from callback) to done
  double sample_p99_ms = 0.0;
  double sample_longest_ms = 0.0;  ///< since the report before
};

/// How long queries and samples take. Any thread may add.
class ResponseClock {
 public:
  static constexpr std::size_t kKept = 12000;  ///< a minute of 200 queries a second

  void addQuery(double milliseconds) {
    const std::lock_guard<std::mutex> lock(mutex_);
    queries_.add(milliseconds);
  }
  void addSample(double milliseconds) {
    const std::lock_guard<std::mutex> lock(mutex_);
    samples_.add(milliseconds);
    sample_longest_ = std::max(sample_longest_, milliseconds);
  }
  /// The report, from which the next one's sample_longest_ms begins again.
  ResponseTimes report() {
    Ring queries, samples;
    ResponseTimes times;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      queries = queries_;
      samples = samples_;
      times.sample_longest_ms = std::exchange(sample_longest_, 0.0);
    }
    times.queries = queries.count;
    times.query_p99_ms = quantile(queries.kept(), 0.99);
    times.query_longest_ms = quantile(queries.kept(), 1.0);
    times.sample_p99_ms = quantile(samples.kept(), 0.99);
    return times;
  }

 private:
  /// The last kKept durations.
  struct Ring {
    boost::circular_buffer<double> values{kKept};
    std::size_t count = 0;
    void add(double value) {
      values.push_back(value);
      ++count;
    }
    std::vector<double> kept() const { return {values.begin(), values.end()}; }
  };

  std::mutex mutex_;
  Ring queries_, samples_;
  double sample_longest_ = 0.0;
};

}  // namespace battery_sof
