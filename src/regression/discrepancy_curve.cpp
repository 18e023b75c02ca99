#include "regression/discrepancy_curve.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace battery_sof {
namespace {

constexpr double kLate = 60.0;  // [s], of a held current: beyond a stop's transients
// [s]; a recording with a gap of years would need years
constexpr double kLongestAnswer = 43200.0;

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

}  // namespace

std::vector<DiscrepancyAnswer> answersOf(const DiscrepancyModel& discrepancy, double current,
                                         double longest) {
  const double step = std::max(0.1, discrepancy.context.interval);
  Eigen::VectorXd rest(discrepancy.regressors.size()), up = rest, down = rest;
  RegressorMemory rested(discrepancy.regressors, discrepancy.context);
  rested.advance({0.0, 0.0, 0.0, false, 0.0, discrepancy.context.span}, rest);
  RegressorMemory charged = rested, discharged = rested, resting = rested;
  std::vector<DiscrepancyAnswer> answers;
  double next = step;
  const double end = std::min({longest, kLongestAnswer, discrepancy.context.span / 3.0});
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
    answers.push_back({time, summed(discrepancy, up) - unmoved, summed(discrepancy, down) - unmoved,
                       changeStd(discrepancy, rest, up), changeStd(discrepancy, rest, down)});
    next *= 1.5;
  }
  return answers;
}

std::vector<DiscrepancyAtCurrent> curveOf(const DiscrepancyModel& discrepancy, double least,
                                          double most) {
  std::vector<DiscrepancyAtCurrent> curve;
  for (const double decade : {1.0, 10.0, 100.0})
    for (const double size : {decade, 2.0 * decade, 5.0 * decade}) {
      if (size > std::max(most, -least)) continue;
      const std::vector<DiscrepancyAnswer> answers = answersOf(discrepancy, size, kLate);
      if (answers.empty()) continue;
      const DiscrepancyAnswer &early = answers.front(), &late = answers.back();
      if (size <= most)
        curve.push_back(
            {size, early.charging, late.charging, early.charging_std, late.charging_std});
      if (size <= -least)
        curve.push_back({-size, early.discharging, late.discharging, early.discharging_std,
                         late.discharging_std});
    }
  std::sort(curve.begin(), curve.end(),
            [](const DiscrepancyAtCurrent& a, const DiscrepancyAtCurrent& b) {
              return a.current < b.current;
            });
  return curve;
}

}  // namespace battery_sof
