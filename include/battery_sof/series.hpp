#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace battery_sof {

/// Half-open range of sample indices [first, last).
struct IndexRange {
  std::size_t first = 0;
  std::size_t last = 0;
  std::size_t size() const { return last - first; }
  bool empty() const { return first == last; }
};

/// Current and voltage at one instant.
struct Sample {
  double time = 0.0;     ///< [s]
  double current = 0.0;  ///< [A], positive into the battery
  double voltage = 0.0;  ///< [V]
};

/**
 * @brief Current and voltage of one battery over time, as accepted by Intake.
 *
 * Intake establishes three invariants, and every function of recording/ keeps them: the three
 * vectors have the same length, every value is finite, and time increases strictly. Sampling may be
 * uneven and may have gaps; nothing is interpolated.
 */
struct Series {
  std::vector<double> time;     ///< [s], the recording's own clock, strictly increasing
  std::vector<double> current;  ///< [A], positive into the battery
  std::vector<double> voltage;  ///< [V], at the terminals
  /// Temperature has its own, often slower, time base; empty if it was not measured.
  std::vector<double> temperature_time;  ///< [s], increasing
  std::vector<double> temperature;       ///< [K]

  std::size_t size() const { return time.size(); }
  bool empty() const { return time.empty(); }
  Sample operator[](std::size_t n) const { return {time[n], current[n], voltage[n]}; }
  void append(const Sample& sample) {
    time.push_back(sample.time);
    current.push_back(sample.current);
    voltage.push_back(sample.voltage);
  }
  /// Removes the first samples; the temperatures stay.
  void dropFirst(std::size_t count) {
    for (auto* values : {&time, &current, &voltage})
      values->erase(values->begin(), values->begin() + static_cast<std::ptrdiff_t>(count));
  }
};

/// Why samples offered to Intake were refused, by reason.
struct RejectedCounts {
  std::size_t missing_value = 0;    ///< current or voltage absent (empty cell, NaN)
  std::size_t not_finite = 0;       ///< infinite time, current or voltage
  std::size_t duplicate_stamp = 0;  ///< same time as the previous sample
  std::size_t clock_step_back = 0;  ///< earlier than an accepted sample
  /// |current| or |voltage| beyond what a battery sensor can show
  std::size_t out_of_range = 0;
  std::size_t total() const {
    return missing_value + not_finite + duplicate_stamp + clock_step_back + out_of_range;
  }
};

/// A series, with the name of its source and the samples that were refused.
struct Recording {
  std::string name;  ///< file name without folders
  Series series;
  RejectedCounts rejected;
  std::size_t offered = 0;         ///< rows or messages, except those with a temperature alone
  double largest_step_back = 0.0;  ///< [s], of the clock; 0 if it never stepped back
  std::size_t rejected_temperatures = 0;  ///< that no battery has; their samples are kept
};

/// @throws std::invalid_argument unless a series keeps its three invariants; the message names the
/// first sample that does not, and what it is.
void requireInvariants(const Series& series);

/// @return median of the sampling intervals [s]; 0 for fewer than two samples.
double medianInterval(const Series& series);
/// The same for the samples of a range.
double medianInterval(const std::vector<double>& time, IndexRange range);

/**
 * @brief The interval above which two neighbouring samples are not joined: max(10 * median
 * interval, 5 s).
 *
 * A pause of ten intervals is more than a lost message. Below 5 s, which is a tenth of its time
 * constant at rest (50 s, docs/physics.md, Base circuit), the battery's slow state hardly moves.
 */
double gapThreshold(const Series& series);
/// The same if the median interval [s] is known.
double gapThreshold(double median_interval);

/// @return the ranges of samples without an interval above max_gap [s], in order; none for an empty
/// series.
std::vector<IndexRange> contiguousRanges(const Series& series, double max_gap);

/// @return the indices of the samples with from <= time <= to; an empty range if there are none.
IndexRange indexRange(const Series& series, double from, double to);

/// @return the index of the first sample after a time [s]; size() if there is none.
std::size_t firstAfter(const Series& series, double time);

/// @return a copy of the samples in range, and of the temperatures between its two ends.
Series slice(const Series& series, IndexRange range);

/// @return the temperature [K] by linear interpolation, constant beyond both ends; none if it was
/// not measured.
std::optional<double> temperatureAt(const Series& series, double time);

}  // namespace battery_sof
