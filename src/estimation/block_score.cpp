#include "estimation/block_score.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "estimation/composition_fit.hpp"
#include "estimation/controlled_window.hpp"
#include "regression/residual_regression.hpp"
#include "state/state_estimator.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr int kStepsFromOptimum = 2;   // of a fit to all blocks but one
constexpr double kLeastError = 1e-12;  // [1], of a block that is predicted exactly

CompositionSearch searchOf(int iterations) {
  CompositionSearch search;
  search.tolerance = 1e-4;
  search.max_iterations = iterations;
  return search;
}

/// Variances of the two quantities over the rows in which they are compared.
struct Variances {
  double current = 0.0, voltage = 0.0;  // [A^2], [V^2]
  double of(const InputSample& sample) const {
    return sample.voltage_controlled ? current : voltage;
  }
};

Variances variancesOf(const InputSequence& inputs) {
  const auto variance = [&](bool of_current) {
    double n = 0.0, sum = 0.0, squares = 0.0;
    for (const InputSample& sample : inputs.samples) {
      if (!(sample.count > 0.0) || sample.voltage_controlled != of_current) continue;
      const double x = of_current ? sample.step.current : sample.voltage;
      n += 1.0;
      sum += x;
      squares += x * x;
    }
    return n > 0.0 ? squares / n - std::pow(sum / n, 2) : 0.0;
  };
  return {variance(true), variance(false)};
}

/// The equations' course through the rows.
ResidualSamples followed(const BatteryModel& model, const CompositionPoint& point,
                         const InputSequence& inputs) {
  Simulation simulation(model, point.at(inputs.first_time));
  InputMemory memory;
  ResidualSamples course;
  for (const InputSample& sample : inputs.samples) {
    const double error = simulation.follow(sample);
    const double voltage = sample.voltage_controlled ? sample.voltage : simulation.voltage();
    const double current = sample.step.current - (sample.voltage_controlled ? error : 0.0);
    course.columns.push_back(
        memory.advance({sample.step.duration, sample.voltage_controlled, voltage, current}));
    course.error.push_back(error);
    course.voltage_controlled.push_back(sample.voltage_controlled);
  }
  return course;
}

/// A course without the rows of a block.
ResidualSamples without(const ResidualSamples& course, IndexRange block) {
  ResidualSamples others;
  for (std::size_t n = 0; n < course.error.size(); ++n) {
    if (n >= block.first && n < block.last) continue;
    others.columns.push_back(course.columns[n]);
    others.error.push_back(course.error[n]);
    others.voltage_controlled.push_back(course.voltage_controlled[n]);
  }
  return others;
}

/// Mean squared error of a block in units of the variances. @param missed double(std::size_t row).
template <typename Missed>
double relativeError(const InputSequence& inputs, IndexRange block, const Variances& variances,
                     Missed&& missed) {
  double sum = 0.0, rows = 0.0;
  for (std::size_t n = block.first; n < block.last; ++n) {
    const double variance = variances.of(inputs.samples[n]);
    if (!(inputs.samples[n].count > 0.0) || !(variance > 0.0)) continue;
    rows += 1.0;
    sum += std::pow(missed(n), 2) / variance;
  }
  return rows > 0.0 ? std::max(sum / rows, kLeastError) : kLeastError;
}

}  // namespace

double BlockErrors::share() const {
  double sum = 0.0;
  for (const double block : relative) sum += block;
  return 1.0 - std::sqrt(sum / static_cast<double>(relative.size()));
}

std::vector<double> blockGains(const BlockScore& more, const BlockScore& less) {
  std::vector<double> gains(more.equations.relative.size(), 0.0);
  for (const auto column : {&BlockScore::equations, &BlockScore::with_regression}) {
    const std::vector<double>&one = (more.*column).relative, &other = (less.*column).relative;
    if (one.size() != gains.size() || other.size() != gains.size())
      throw std::invalid_argument(
          format("blockGains: %zu and %zu blocks, expected as many", one.size(), other.size()));
    for (std::size_t b = 0; b < gains.size(); ++b) gains[b] += 0.5 * std::log(other[b] / one[b]);
  }
  return gains;
}

ScoreGain gainOf(const BlockScore& more, const BlockScore& less) {
  const std::vector<double> gains = blockGains(more, less);
  if (gains.size() < 2) throw std::invalid_argument("gainOf: fewer than two blocks");
  double sum = 0.0, squares = 0.0;
  for (const double gain : gains) {
    sum += gain;
    squares += gain * gain;
  }
  const double n = static_cast<double>(gains.size()), mean = sum / n;
  return {mean, std::sqrt(std::max(0.0, squares / n - mean * mean) / (n - 1.0))};
}

CompositionPoint optimumOf(const FittedModel& model) {
  const ModelPoint first = pointOf(atFirstState(model));
  return {first.parameters, first.state};
}

BlockScore scoreBlocks(const BatteryModel& composition, const CompositionPoint& optimum,
                       const Series& series, IndexRange range, const IdentifyOptions& options,
                       std::size_t blocks) {
  if (!options.source || blocks < 2)
    throw std::invalid_argument(
        format("scoreBlocks: %zu blocks%s, expected at least 2 and a source", blocks,
               options.source ? "" : " and no source"));
  const InputSequence inputs = controlledWindow(series, range, options).inputs;
  const FitCost cost = controlledCost(options);
  const Variances variances = variancesOf(inputs);
  const std::size_t rows = inputs.samples.size();
  const CompositionProblem whole(composition, inputs, cost, optimum);
  BlockScore score;
  for (std::size_t b = 0; b < blocks; ++b) {
    const IndexRange block{rows * b / blocks, rows * (b + 1) / blocks};
    CompositionProblem others = whole;
    others.leaveOut(block);
    const CompositionFit fit = fitComposition(others, {optimum}, searchOf(kStepsFromOptimum));
    const ResidualSamples course = followed(composition, fit.point, inputs);
    std::vector<double> unused;
    const ResidualRegression regression = fitResidualRegression(without(course, block), unused);
    score.equations.relative.push_back(
        relativeError(inputs, block, variances, [&](std::size_t n) { return course.error[n]; }));
    score.with_regression.relative.push_back(
        relativeError(inputs, block, variances, [&](std::size_t n) {
          const RidgeFit& part =
              course.voltage_controlled[n] ? regression.current : regression.voltage;
          return course.error[n] - part.at(course.columns[n]);
        }));
  }
  return score;
}

FittedCost fittedCost(const FittedModel& model, const Series& series, IndexRange range,
                      const IdentifyOptions& options) {
  const InputSequence inputs = controlledWindow(series, range, options).inputs;
  const BatteryModel composition = compositionOf(model.fit);
  const CompositionPoint optimum = optimumOf(model);
  const CompositionProblem problem(composition, inputs, controlledCost(options), optimum);
  NormalEquations at;
  if (!problem.evaluate(problem.coordinatesOf(optimum), at)) return {};
  return {at.cost, problem.precision()};
}

Promise promiseOf(const FittedModel& model, const FittedCost& nested,
                  const std::vector<std::string>& larger, const Series& series, IndexRange range,
                  const IdentifyOptions& options, int steps, const CompositionPoint* start) {
  const InputSequence inputs = controlledWindow(series, range, options).inputs;
  const FitCost cost = controlledCost(options);
  const BatteryModel composition(larger);
  const CompositionPoint from =
      start ? *start : withNewAtMagnitudes(compositionOf(model.fit), optimumOf(model), composition);
  const CompositionProblem problem(composition, inputs, cost, from, {}, nested.precision);
  NormalEquations at;
  if (!problem.evaluate(problem.coordinatesOf(from), at)) return {0.0, from};
  const CompositionFit fit = fitComposition(problem, {from}, searchOf(steps));
  return {std::max(0.0, 0.5 * cost.channels->independent * (nested.cost - fit.at.cost)), fit.point};
}

Eigen::VectorXd equationErrors(const FittedModel& model, const Series& series, IndexRange range,
                               const IdentifyOptions& options) {
  const InputSequence inputs = controlledWindow(series, range, options).inputs;
  const ResidualSamples course = followed(compositionOf(model.fit), optimumOf(model), inputs);
  Eigen::VectorXd errors(static_cast<Eigen::Index>(course.error.size()));
  for (std::size_t n = 0; n < course.error.size(); ++n)
    errors[static_cast<Eigen::Index>(n)] =
        course.error[n] * (course.voltage_controlled[n] ? kOhmsOfCurrentError : 1.0);
  return errors;
}

}  // namespace battery_sof
