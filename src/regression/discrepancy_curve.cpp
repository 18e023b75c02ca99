#include "regression/discrepancy_curve.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "util/constants.hpp"

namespace battery_sof {
namespace {

constexpr double kLate = 60.0;  // [s], of a held current: beyond a stop's transients
// [s]; a recording with a gap of years would need years
constexpr double kLongestAnswer = 43200.0;
constexpr double kLargestAnswer = 20.0;            // [A], a vehicle's loads in a stop
constexpr double kDrivenShare = 0.05;              // of the other direction's size
constexpr double kCurveShare = 0.01;               // of the largest current
constexpr int kFirstDecade = -3, kLastDecade = 2;  // [A], 1 mA to 500 A

/// The discrepancy's sum over regressors as they stand.
double summed(const DiscrepancyModel& discrepancy, const Eigen::VectorXd& values) {
  double sum = 0.0;
  for (Eigen::Index k = 0; k < discrepancy.weight.size(); ++k)
    sum += discrepancy.weight[k] * (discrepancy.used(k, values[k]) - discrepancy.centre[k]) /
           discrepancy.scale[k];
  return sum;
}

/// Standard deviation of a discrepancy's change from some regressors' values to others.
std::optional<double> changeStd(const DiscrepancyModel& discrepancy, const Eigen::VectorXd& from,
                                const Eigen::VectorXd& to) {
  if (discrepancy.covariance.rows() != discrepancy.weight.size()) return std::nullopt;
  Eigen::VectorXd change(to.size());
  for (Eigen::Index k = 0; k < change.size(); ++k)
    change[k] = (discrepancy.used(k, to[k]) - discrepancy.used(k, from[k])) / discrepancy.scale[k];
  return std::sqrt(std::max(change.dot(discrepancy.covariance * change), 0.0));
}

/// 1, 2 and 5 times powers of ten [A], ascending.
std::vector<double> roundSizes() {
  std::vector<double> sizes;
  for (int decade = kFirstDecade; decade <= kLastDecade; ++decade)
    for (const double digit : {1.0, 2.0, 5.0})
      sizes.push_back(decade < 0 ? digit / std::pow(10.0, -decade)
                                 : digit * std::pow(10.0, decade));
  return sizes;
}

/// The largest round size that was driven with a sign; 0 without.
double largestDriven(const DrivenTime& driven, double sign) {
  double largest = 0.0;
  for (const double size : roundSizes())
    if (driven(sign * size) > 0.0) largest = size;
  return largest;
}

}  // namespace

DrivenTime drivenTimeOf(const Series& series, IndexRange range) {
  return [&series, range, gap = gapThreshold(series),
          interval = medianInterval(series)](double current) {
    const double sign = current < 0.0 ? -1.0 : 1.0, size = std::abs(current);
    double longest = 0.0, duration = 0.0;
    bool is_reached = false;
    for (std::size_t n = range.first; n < range.last; ++n) {
      const double driven = sign * series.current[n];
      is_reached = is_reached || driven >= size;
      const bool is_last = n + 1 == series.size();
      const double step = is_last ? interval : series.time[n + 1] - series.time[n];
      duration = driven >= 0.5 * size ? duration + std::min(step, gap) : 0.0;
      longest = std::max(longest, duration);
      if (step > gap) duration = 0.0;
    }
    return is_reached ? longest : 0.0;
  };
}

std::optional<double> answerCurrentOf(const DrivenTime& driven) {
  const double charged = largestDriven(driven, 1.0), discharged = largestDriven(driven, -1.0),
               larger = std::max(charged, discharged), smaller = std::min(charged, discharged);
  if (!(larger > 0.0)) return std::nullopt;
  return std::min(smaller >= kDrivenShare * larger ? smaller : larger, kLargestAnswer);
}

std::vector<DiscrepancyAnswer> answersOf(const DiscrepancyModel& discrepancy, double current,
                                         const DrivenTime& driven) {
  const double step = std::max(0.1, discrepancy.context.interval);
  Eigen::VectorXd rest(discrepancy.regressors.size()), up = rest, down = rest;
  RegressorMemory rested(discrepancy.regressors, discrepancy.context);
  rested.advance({0.0, 0.0, 0.0, false, 0.0, discrepancy.context.span}, rest);
  RegressorMemory charged = rested, discharged = rested, resting = rested;
  std::vector<DiscrepancyAnswer> answers;
  double next = step;
  const double charged_for = driven(current), discharged_for = driven(-current);
  const double end = std::min(std::max(charged_for, discharged_for), kLongestAnswer);
  const auto steps = static_cast<long>(std::floor(end / step + 1e-9));
  for (long n = 1; n <= steps; ++n) {
    const double time = static_cast<double>(n) * step;
    // the settled double layer
    const double u = 2.0 / discrepancy.context.beta * std::asinh(0.5 * current);
    resting.advance({step, 0.0, 0.0, false, 0.0, discrepancy.context.span}, rest);
    charged.advance({step, current, current, false, u, discrepancy.context.span}, up);
    discharged.advance({step, -current, -current, false, -u, discrepancy.context.span}, down);
    if (time + 1e-9 < next) continue;
    const double unmoved = summed(discrepancy, rest);
    DiscrepancyAnswer answer{time, kNan, kNan};
    if (time <= charged_for + 1e-9) {
      answer.charging = summed(discrepancy, up) - unmoved;
      answer.charging_std = changeStd(discrepancy, rest, up);
    }
    if (time <= discharged_for + 1e-9) {
      answer.discharging = summed(discrepancy, down) - unmoved;
      answer.discharging_std = changeStd(discrepancy, rest, down);
    }
    answers.push_back(answer);
    next *= 1.5;
  }
  return answers;
}

std::vector<DiscrepancyAtCurrent> curveOf(const DiscrepancyModel& discrepancy,
                                          const DrivenTime& driven) {
  const double largest = std::max(largestDriven(driven, 1.0), largestDriven(driven, -1.0));
  std::vector<DiscrepancyAtCurrent> curve;
  for (const double size : roundSizes())
    for (const double sign : {1.0, -1.0}) {
      const double current = sign * size, time = driven(current);
      if (!(time > 0.0) || size < kCurveShare * largest) continue;
      const std::vector<DiscrepancyAnswer> answers =
          answersOf(discrepancy, size,
                    [&](double asked) { return asked == current ? std::min(time, kLate) : 0.0; });
      if (answers.empty()) continue;
      const DiscrepancyAnswer &early = answers.front(), &late = answers.back();
      DiscrepancyAtCurrent at{current, early.discharging, kNan, early.discharging_std};
      if (sign > 0.0) at.early = early.charging, at.early_std = early.charging_std;
      if (time >= kLate) {
        at.late = sign > 0.0 ? late.charging : late.discharging;
        at.late_std = sign > 0.0 ? late.charging_std : late.discharging_std;
      }
      curve.push_back(at);
    }
  std::sort(curve.begin(), curve.end(),
            [](const DiscrepancyAtCurrent& a, const DiscrepancyAtCurrent& b) {
              return a.current < b.current;
            });
  return curve;
}

}  // namespace battery_sof
