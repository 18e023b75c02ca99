#pragma once

#include <cmath>
#include <cstddef>
#include <mutex>
#include <optional>
#include <vector>

#include "prediction/online_session.hpp"

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

/// The cranks and charges of the running back-test.
struct EventTallies {
  EventTally cranks, charges;  ///< of the model
  /// of its window's baseline predictors, where they expected something
  EventTally baseline_cranks, baseline_charges;
  std::optional<EventComparison> last_crank, last_charge;
  IntervalCalibration crank_calibration, charge_calibration;

  void add(const SessionEvents& events) {
    for (const EventComparison& crank : events.cranks)
      add(last_crank.emplace(crank), cranks, baseline_cranks);
    for (const EventComparison& charge : events.charges)
      add(last_charge.emplace(charge), charges, baseline_charges);
  }

 private:
  static void add(const EventComparison& event, EventTally& model, EventTally& baseline) {
    model.add(event.measured, event.expected);
    if (event.baseline) baseline.add(event.measured, *event.baseline);
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

  void addQuery(double milliseconds);
  void addSample(double milliseconds);
  /// The report, from which the next one's sample_longest_ms begins again.
  ResponseTimes report();

 private:
  /// The last kKept durations.
  struct Ring {
    std::vector<double> values;
    std::size_t next = 0, count = 0;
    void add(double value);
    double quantile(double share) const;
  };

  std::mutex mutex_;
  Ring queries_, samples_;
  double sample_longest_ = 0.0;
};

}  // namespace battery_sof
