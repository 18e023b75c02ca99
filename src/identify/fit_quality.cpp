#include "battery_sof/identify/fit_quality.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

namespace battery_sof {
namespace {

double squaredError(const std::vector<double>& measured, const std::vector<double>& predicted) {
  if (measured.size() != predicted.size() || measured.empty())
    throw std::invalid_argument("measured has " + std::to_string(measured.size()) +
                                " samples, predicted " + std::to_string(predicted.size()) +
                                ": expected the same number, at least one");
  double sum = 0.0;
  for (std::size_t n = 0; n < measured.size(); ++n)
    sum += (measured[n] - predicted[n]) * (measured[n] - predicted[n]);
  return sum;
}

}  // namespace

std::optional<double> qDyn(const std::vector<double>& measured,
                           const std::vector<double>& predicted) {
  const double error = squaredError(measured, predicted);
  double mean = 0.0;
  for (double u : measured) mean += u / static_cast<double>(measured.size());
  const double variation = squaredError(measured, std::vector<double>(measured.size(), mean));
  // Rounding of the mean alone leaves about (1e-15 u)^2 a sample.
  if (variation <= 1e-26 * static_cast<double>(measured.size()) * (1.0 + mean * mean))
    return std::nullopt;
  return 100.0 * (1.0 - std::sqrt(error / variation));
}

double rootMeanSquareError(const std::vector<double>& measured,
                           const std::vector<double>& predicted) {
  return std::sqrt(squaredError(measured, predicted) / static_cast<double>(measured.size()));
}

}  // namespace battery_sof
