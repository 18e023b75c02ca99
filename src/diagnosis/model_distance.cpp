#include "diagnosis/model_distance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "prediction/scores.hpp"
#include "recording/channel_statistics.hpp"

namespace battery_sof {
namespace {

// docs/decisions/0021-changes-against-a-reference.md
constexpr double kDistanceTime = 6000.0;  // [s], of sound recordings that may be 1 apart
constexpr double kLeastDistance = 0.7;    // twice the error
constexpr double kLeastBesideChange = 1.0;
constexpr std::size_t kDistanceBlocks = 8;

/// Mean squared error of a model in each block of a recording, in units of the variance of the
/// quantity that responds there [1].
std::vector<double> blockErrors(const FittedModel& model, const Series& series) {
  const std::size_t n = series.size();
  const FollowedPrediction course = predictRange(model, series, {0, n}).course;
  const auto isCurrent = [&](std::size_t k) {
    return !course.current.empty() && static_cast<bool>(course.voltage_controlled[k]);
  };
  std::array<RunningVariance, 2> measured;  // [V], [A]
  for (std::size_t k = 0; k < n; ++k)
    measured[isCurrent(k)].add(isCurrent(k) ? series.current[k] : series.voltage[k]);
  std::vector<double> errors;
  for (std::size_t block = 0; block < kDistanceBlocks; ++block) {
    double sum = 0.0, rows = 0.0;
    for (std::size_t k = n * block / kDistanceBlocks; k < n * (block + 1) / kDistanceBlocks; ++k) {
      const double variance = measured[isCurrent(k)].variance();
      if (!(variance > 0.0)) continue;
      const double error = isCurrent(k) ? course.current[k] - series.current[k]
                                        : course.voltage[k] - series.voltage[k];
      sum += error * error / variance;
      rows += 1.0;
    }
    errors.push_back(rows > 0.0 ? sum / rows : 0.0);
  }
  return errors;
}

/// An error as it can be compared: one that no sensor shows, or one that is not finite, is at an end.
double bounded(double error) {
  constexpr double kLeast = 1e-6, kMost = 1e6;  // [1]
  return error < kMost ? std::max(error, kLeast) : kMost;
}

/// Adds ln(error of another model / error of the own one), one a block.
void addLosses(std::vector<double>& losses, const FittedModel& other, const Modelled& own) {
  const std::vector<double> theirs = blockErrors(other, own.series);
  const std::vector<double> ours = blockErrors(own.model, own.series);
  for (std::size_t k = 0; k < ours.size(); ++k)
    losses.push_back(0.5 * std::log(bounded(theirs[k]) / bounded(ours[k])));
}

}  // namespace

double modelDistance(const Modelled& one, const Modelled& other) {
  std::vector<double> losses;
  addLosses(losses, other.model, one);
  addLosses(losses, one.model, other);
  return medianOf(std::move(losses));
}

double largestDistance(const Series& one, const Series& other, bool has_clear_change) {
  const auto duration = [](const Series& of) { return of.time.back() - of.time.front(); };
  return std::max(has_clear_change ? kLeastBesideChange : kLeastDistance,
                  std::sqrt(kDistanceTime / std::min(duration(one), duration(other))));
}

}  // namespace battery_sof
