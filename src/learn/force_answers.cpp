#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "battery_sof/learn/force_fit.hpp"

namespace battery_sof {
namespace {

constexpr double kLongestAnswer = 43200.0;  // [s]; a recording with a gap of years would ask for years

/// The force's sum over columns as they stand.
double summed(const LearnedForce& force, const Eigen::VectorXd& values) {
  double sum = 0.0;
  for (Eigen::Index k = 0; k < force.weight.size(); ++k) {
    const bool free = isUnbounded(force.columns[static_cast<std::size_t>(k)].kind);
    const double x = free ? values[k] : std::clamp(values[k], force.lower[k], force.upper[k]);
    sum += force.weight[k] * (x - force.centre[k]) / force.scale[k];
  }
  return sum;
}

/// Standard deviation of a force's change from some columns' values to others.
std::optional<double> changeStd(const LearnedForce& force, const Eigen::VectorXd& from, const Eigen::VectorXd& to) {
  if (force.covariance.rows() != force.weight.size()) return std::nullopt;
  Eigen::VectorXd change = to - from;
  for (Eigen::Index k = 0; k < change.size(); ++k)
    if (!isUnbounded(force.columns[static_cast<std::size_t>(k)].kind))
      change[k] = std::clamp(to[k], force.lower[k], force.upper[k]) - std::clamp(from[k], force.lower[k], force.upper[k]);
  change.array() /= force.scale.array();
  return std::sqrt(std::max(change.dot(force.covariance * change), 0.0));
}

}  // namespace

std::vector<ForceAnswer> answersOf(const LearnedForce& force, double current, double longest) {
  const double step = std::max(0.1, force.context.interval);
  Eigen::VectorXd rest(static_cast<Eigen::Index>(force.columns.size())), up = rest, down = rest;
  ForceMemory rested(force.columns, force.context);
  rested.advance({0.0, 0.0, 0.0, false, 0.0, force.context.span}, rest);
  ForceMemory charged = rested, discharged = rested, resting = rested;
  std::vector<ForceAnswer> answers;
  double next = step;
  const double end = std::min({longest, kLongestAnswer, force.context.span / 3.0});
  const auto steps = static_cast<long>(std::floor(end / step + 1e-9));
  for (long n = 1; n <= steps; ++n) {
    const double time = static_cast<double>(n) * step;
    const double u = 2.0 / force.context.beta * std::asinh(0.5 * current);  // the settled double layer
    resting.advance({step, 0.0, 0.0, false, 0.0, force.context.span}, rest);
    charged.advance({step, current, current, false, u, force.context.span}, up);
    discharged.advance({step, -current, -current, false, -u, force.context.span}, down);
    if (time + 1e-9 < next) continue;
    const double unmoved = summed(force, rest);
    answers.push_back(
        {time, summed(force, up) - unmoved, summed(force, down) - unmoved, changeStd(force, rest, up), changeStd(force, rest, down)});
    next *= 1.5;
  }
  return answers;
}

}  // namespace battery_sof
