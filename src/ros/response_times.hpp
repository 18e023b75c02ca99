#pragma once

#include <cstddef>
#include <mutex>
#include <vector>

namespace battery_sof {

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
