#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "regression/discrepancy_fit.hpp"

namespace battery_sof {
namespace {

// [s]; a recording with a gap of years would need years
constexpr double kLongestAnswer = 43200.0;

/// The discrepancy's sum over regressors as they stand.
double summed(const DiscrepancyModel& discrepancy, const Eigen::VectorXd& values) {
  double sum = 0.0;
  for (Eigen::Index k = 0; k < discrepancy.weight.size(); ++k) {
    const bool free = isUnbounded(discrepancy.regressors[static_cast<std::size_t>(k)].kind);
    const double x =
        free ? values[k] : std::clamp(values[k], discrepancy.lower[k], discrepancy.upper[k]);
    sum += discrepancy.weight[k] * (x - discrepancy.centre[k]) / discrepancy.scale[k];
  }
  return sum;
}

/// Standard deviation of a discrepancy's change from some regressors' values to others.
std::optional<double> changeStd(const DiscrepancyModel& discrepancy, const Eigen::VectorXd& from,
                                const Eigen::VectorXd& to) {
  if (discrepancy.covariance.rows() != discrepancy.weight.size()) return std::nullopt;
  Eigen::VectorXd change = to - from;
  for (Eigen::Index k = 0; k < change.size(); ++k)
    if (!isUnbounded(discrepancy.regressors[static_cast<std::size_t>(k)].kind))
      change[k] = std::clamp(to[k], discrepancy.lower[k], discrepancy.upper[k]) -
                  std::clamp(from[k], discrepancy.lower[k], discrepancy.upper[k]);
  change.array() /= discrepancy.scale.array();
  return std::sqrt(std::max(change.dot(discrepancy.covariance * change), 0.0));
}

}  // namespace

std::vector<DiscrepancyAnswer> answersOf(const DiscrepancyModel& discrepancy, double current,
                                         double longest) {
  const double step = std::max(0.1, discrepancy.context.interval);
  Eigen::VectorXd rest(static_cast<Eigen::Index>(discrepancy.regressors.size())), up = rest,
                                                                                  down = rest;
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

}  // namespace battery_sof
