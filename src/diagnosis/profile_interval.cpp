#include "diagnosis/profile_interval.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace battery_sof {
namespace {

constexpr double kRise = 3.84;  // 95 % of chi-squared with one degree of freedom
constexpr double kClose = 0.1;  // of kRise
constexpr int kLooks = 6;
constexpr int kIterations = 8;

/// Least deviance of the others with one parameter held at a value.
std::optional<double> heldDeviance(const WhitenedFit& fit, const InputSequence& inputs,
                                   const std::string& parameter, CompositionPoint& point) {
  FitCost cost;
  cost.noise = fit.noise;
  cost.known = fit.known;
  const CompositionProblem problem(fit.model, inputs, cost, point, {parameter});
  CompositionSearch search;
  search.max_iterations = kIterations;
  const CompositionFit found = fitComposition(problem, {point}, search);
  point = found.point;
  return std::isfinite(found.at.cost) ? std::optional<double>(found.at.cost) : std::nullopt;
}

/// @return a free parameter as a coordinate of the fit; std::nullopt for any other name.
std::optional<FitCoordinate> coordinateOf(const WhitenedFit& fit, const InputSequence& inputs,
                                          const std::string& parameter) {
  const double length = inputs.samples.back().step.time - inputs.first_time;
  const ParameterSpace space(fit.model, fit.point, length, fit.known);
  const std::optional<Eigen::Index> row = fit.model.parameterRow(parameter);
  for (Eigen::Index k = 0; k < space.size(); ++k)
    if (row == space.rowOf(k)) return space[k];
  return std::nullopt;
}

double priorOf(const FitCoordinate& coordinate, double value) {
  const double away = (coordinate.of(value) - coordinate.centre) / coordinate.std;
  return away * away;
}

}  // namespace

ProfileInterval profileInterval(const WhitenedFit& fit, const InputSequence& inputs,
                                const std::string& parameter, double first_step) {
  const std::optional<FitCoordinate> coordinate = coordinateOf(fit, inputs, parameter);
  if (!coordinate)
    throw std::invalid_argument("parameter \"" + parameter +
                                "\" is not one that the composition fits");
  if (!(first_step > 0.0))
    throw std::invalid_argument("first_step is " + std::to_string(first_step) +
                                ", expected above 0");
  const double optimum = fit.point.parameters[coordinate->row];
  CompositionPoint there = fit.point;
  const std::optional<double> least = heldDeviance(fit, inputs, parameter, there);
  ProfileInterval interval;
  if (!least) return interval;
  const CompositionPoint at_optimum = there;
  for (const double side : {-1.0, 1.0}) {
    const double reach = side < 0.0 ? optimum - coordinate->lower : coordinate->upper - optimum;
    double step = std::min(first_step, reach);
    CompositionPoint point = at_optimum;
    for (int look = 0; look < kLooks && step > 0.0; ++look) {
      point.parameters[coordinate->row] = optimum + side * step;
      const std::optional<double> held = heldDeviance(fit, inputs, parameter, point);
      if (!held) break;
      const double rise = *held - *least + priorOf(*coordinate, optimum + side * step) -
                          priorOf(*coordinate, optimum);
      if (rise < kRise && step >= reach) break;
      if (std::abs(rise - kRise) < kClose * kRise || look + 1 == kLooks) {
        (side < 0.0 ? interval.lower : interval.upper) = optimum + side * step;
        break;
      }
      step = std::min(reach, step * std::clamp(std::sqrt(kRise / std::max(rise, 1e-3)), 0.2, 4.0));
    }
  }
  return interval;
}

}  // namespace battery_sof
