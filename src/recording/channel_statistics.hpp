#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "battery_sof/series.hpp"

namespace battery_sof {

/**
 * @brief Step of a quantised channel: the greatest step of which nearly all sample-to-sample
 * changes are multiples.
 *
 * "Nearly all" is 95 % within 8 % of a multiple (printed digits round a step of 0.0625 to 0.062 and
 * 0.063); chance puts 16 % there. Candidates are the channel's own most frequent small changes.
 *
 * @param values any unit.
 * @return the step in the unit of values; none with fewer than 30 changes, with fewer than 8 levels
 * in use (a programmed current that steps between a few set points is not a quantised one), or when
 * no step fits.
 */
std::optional<double> findStep(const std::vector<double>& values);

/**
 * @brief The same of the voltage: of its values, or of its changes while the current repeats, which
 * an ohmic part that was added to a quantised voltage, u + r i, leaves as they are.
 *
 * @return the greater [V].
 */
std::optional<double> findVoltageStep(const Series& series);

/**
 * @brief Standard deviation of the white noise on a channel, from the lower quartile of the
 * sample-to-sample changes.
 *
 * The lower quartile is untouched by edges and transients in up to three quarters of the samples.
 * @param step the channel's quantisation; the result is never below step / sqrt(12).
 * @return in the unit of values; 0 for fewer than two samples and for exact data.
 */
double noiseLevel(const std::vector<double>& values, std::optional<double> step);

/// @return bounds cut before every sample k that does not belong with the one before it. @param
/// joined bool(k), of every sample but the first.
template <typename Joined>
std::vector<IndexRange> cutWhere(IndexRange bounds, Joined&& joined) {
  std::vector<IndexRange> ranges;
  for (std::size_t k = bounds.first; k < bounds.last; ++k) {
    if (ranges.empty() || !joined(k)) ranges.push_back({k, k});
    ranges.back().last = k + 1;
  }
  return ranges;
}

/// @return ranges within bounds of samples that follow each other and hold. @param holds bool(k).
template <typename Holds>
std::vector<IndexRange> rangesWhere(IndexRange bounds, Holds&& holds) {
  std::vector<IndexRange> ranges;
  for (std::size_t k = bounds.first; k < bounds.last; ++k) {
    if (!holds(k)) continue;
    if (ranges.empty() || ranges.back().last != k) ranges.push_back({k, k});
    ranges.back().last = k + 1;
  }
  return ranges;
}

/// @return those of the ranges that hold, in order. @param holds bool(IndexRange).
template <typename Holds>
std::vector<IndexRange> thoseWhere(std::vector<IndexRange> ranges, Holds&& holds) {
  ranges.erase(std::remove_if(ranges.begin(), ranges.end(), std::not_fn(holds)), ranges.end());
  return ranges;
}

/// @return parts of the ranges in which one exact value repeats at least min_samples times, in
/// order.
std::vector<IndexRange> constantRuns(const std::vector<double>& values,
                                     const std::vector<IndexRange>& ranges,
                                     std::size_t min_samples);

/**
 * @brief How often a channel moves up and down by at least threshold.
 *
 * @param stride samples between the two values that are compared; shortened for ranges of less than
 * three strides.
 * @return changes of direction between such moves; 0 for a channel that only falls, only rises or
 * stays.
 */
std::size_t countReversals(const std::vector<double>& values, IndexRange range, std::size_t stride,
                           double threshold);

/// @return the value below which the given share [0, 1] of values lies; 0 for no values.
double quantile(std::vector<double> values, double share);

/// @return the middle of some values, of an even number the mean of both; 0 of none.
double medianOf(std::vector<double> values);

/// Mean and variance of values that come one by one (Welford 1962).
class RunningVariance {
 public:
  void add(double value) {
    const double before = value - mean_;
    mean_ += before / static_cast<double>(++count_);
    squares_ += before * (value - mean_);
  }
  std::size_t count() const { return count_; }
  /// Mean squared distance from the mean; 0 of none.
  double variance() const { return count_ > 0 ? squares_ / static_cast<double>(count_) : 0.0; }

 private:
  std::size_t count_ = 0;
  double mean_ = 0.0, squares_ = 0.0;
};

/// Two ends of a range.
struct Bounds {
  double lower = 0.0, upper = 0.0;
};

/// Sums of a regression through the origin of changes of voltage on changes of current.
struct ChangeSums {
  std::size_t count = 0;
  double current = 0.0, product = 0.0, voltage = 0.0;                       ///< [A^2], [AV], [V^2]
  double slope() const { return current > 0.0 ? product / current : 0.0; }  ///< [Ohm]
};

/// @param stride samples that a change is over.
/// @param taken bool(k, change of the current [A]), of the change that ends with sample k.
/// @param lag samples by which the voltage's change is later, within the series where `taken`.
template <typename Taken>
ChangeSums changeSums(const Series& series, std::size_t stride, Taken&& taken,
                      std::ptrdiff_t lag = 0) {
  ChangeSums sums;
  for (std::size_t k = stride; k < series.size(); ++k) {
    const double di = series.current[k] - series.current[k - stride];
    if (!taken(k, di)) continue;
    const std::size_t later = k + static_cast<std::size_t>(lag);  // earlier for a lag below 0
    const double dv = series.voltage[later] - series.voltage[later - stride];
    ++sums.count;
    sums.current += di * di;
    sums.product += di * dv;
    sums.voltage += dv * dv;
  }
  return sums;
}

}  // namespace battery_sof
