#include "estimation/fit_quality.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

namespace battery_sof {
namespace {

using Values = Eigen::Map<const Eigen::ArrayXd>;

Values allOf(const std::vector<double>& values) {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}

Eigen::ArrayXd errorOf(const std::vector<double>& measured, const std::vector<double>& predicted) {
  if (measured.size() != predicted.size() || measured.empty())
    throw std::invalid_argument("measured has " + std::to_string(measured.size()) +
                                " samples, predicted " + std::to_string(predicted.size()) +
                                ": expected the same number, at least one");
  return allOf(measured) - allOf(predicted);
}

}  // namespace

std::optional<double> qDyn(const std::vector<double>& measured,
                           const std::vector<double>& predicted) {
  return qDyn(allOf(measured), errorOf(measured, predicted).square().sum());
}

std::optional<double> qDyn(const Eigen::Map<const Eigen::ArrayXd>& measured, double squares) {
  const double mean = measured.mean();
  const double variation = (measured - mean).square().sum();
  // Rounding of the mean alone leaves about (1e-15 u)^2 a sample.
  if (variation <= 1e-26 * static_cast<double>(measured.size()) * (1.0 + mean * mean))
    return std::nullopt;
  return 100.0 * (1.0 - std::sqrt(squares / variation));
}

double rootMeanSquareError(const std::vector<double>& measured,
                           const std::vector<double>& predicted) {
  return std::sqrt(errorOf(measured, predicted).square().mean());
}

}  // namespace battery_sof
