#include "estimation/block_score.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "estimation/composition_fit.hpp"
#include "estimation/fit_window.hpp"
#include "recording/channel_statistics.hpp"
#include "regression/residual_regression.hpp"
#include "state/state_estimator.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr int kQuadraticSteps = 20;  // of a fit to all blocks but one, on its quadratic form
constexpr int kHalvings = 3;         // of the step that it asks for, until its rows are missed less
constexpr double kLeastError = 1e-12;  // [1], of a block that is predicted exactly

CompositionSearch searchOf(int iterations) {
  CompositionSearch search;
  search.tolerance = 1e-4;
  search.max_iterations = iterations;
  return search;
}

/// Of voltage and current, over the rows in which each responds [V^2], [A^2].
using ResponseVariances = std::array<RunningVariance, 2>;

ResponseVariances variancesOf(const InputSequence& inputs) {
  ResponseVariances variances;
  for (const InputSample& sample : inputs.samples)
    if (sample.count > 0.0)
      variances[sample.voltage_controlled].add(sample.voltage_controlled ? sample.step.current
                                                                         : sample.voltage);
  return variances;
}

/// Fits to all blocks but one, from one pass with derivatives over all of them.
class BlockFits {
 public:
  /// @throws std::invalid_argument where the optimum has no finite cost.
  BlockFits(const CompositionProblem& problem, const CompositionPoint& optimum,
            const std::vector<IndexRange>& blocks)
      : problem_(problem), blocks_(blocks), x_(problem.coordinatesOf(optimum)) {
    if (!problem.evaluateParts(x_, blocks, parts_))
      throw std::invalid_argument("scoreBlocks: the model has no finite voltage at its optimum");
    whole_ = {0.0, Eigen::VectorXd::Zero(x_.size()), Eigen::MatrixXd::Zero(x_.size(), x_.size())};
    problem.addPriors(x_, whole_);
    for (const NormalEquations& part : parts_) {
      whole_.cost += part.cost;
      whole_.gradient += part.gradient;
      whole_.hessian += part.hessian;
    }
  }

  /// The equations' course with what fits all blocks but one: the Gauss-Newton step to there, or a
  /// part of it where the whole misses the others' rows by more than the optimum does.
  ResidualSamples courseWithout(std::size_t block, const BatteryModel& model,
                                const InputSequence& inputs) const {
    const NormalEquations at{whole_.cost - parts_[block].cost,
                             whole_.gradient - parts_[block].gradient,
                             whole_.hessian - parts_[block].hessian};
    MinimizeOptions options;
    options.max_iterations = kQuadraticSteps;
    options.lower = problem_.lower();
    options.upper = problem_.upper();
    const auto quadratic = [&](const Eigen::VectorXd& x, NormalEquations& there) {
      there = shifted(at, x - x_);
      return true;
    };
    Eigen::VectorXd step = minimize(quadratic, x_, options).x - x_;
    for (int halving = 0; halving < kHalvings; ++halving, step *= 0.5) {
      const Eigen::VectorXd x = x_ + step;
      ResidualSamples course = courseAt(x, model, inputs);
      if (costWithout(block, x, course.error) <= at.cost) return course;
    }
    return courseAt(x_, model, inputs);
  }

 private:
  ResidualSamples courseAt(const Eigen::VectorXd& x, const BatteryModel& model,
                           const InputSequence& inputs) const {
    return courseOf(model, problem_.pointAt(x).at(inputs.first_time), inputs);
  }
  double costWithout(std::size_t block, const Eigen::VectorXd& x,
                     const std::vector<double>& errors) const {
    NormalEquations priors{0.0, Eigen::VectorXd::Zero(x.size()),
                           Eigen::MatrixXd::Zero(x.size(), x.size())};
    problem_.addPriors(x, priors);
    double cost = priors.cost;
    for (std::size_t k = 0; k < errors.size(); ++k)
      if (k < blocks_[block].first || k >= blocks_[block].last)
        cost += problem_.costOf(k, errors[k]);
    return std::isfinite(cost) ? cost : HUGE_VAL;
  }

  const CompositionProblem& problem_;
  const std::vector<IndexRange>& blocks_;
  const Eigen::VectorXd x_;
  std::vector<NormalEquations> parts_;
  NormalEquations whole_;
};

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
double relativeError(const InputSequence& inputs, IndexRange block,
                     const ResponseVariances& variances, Missed&& missed) {
  double sum = 0.0, rows = 0.0;
  for (std::size_t n = block.first; n < block.last; ++n) {
    const double variance = variances[inputs.samples[n].voltage_controlled].variance();
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

std::vector<double> blockGains(const BlockScore& more, const BlockScore& less, double most_apart) {
  std::vector<double> gains(more.equations.relative.size(), 0.0);
  for (const auto column : {&BlockScore::equations, &BlockScore::with_regression}) {
    const std::vector<double>&one = (more.*column).relative, &other = (less.*column).relative;
    if (one.size() != gains.size() || other.size() != gains.size())
      throw std::invalid_argument(
          format("blockGains: %zu and %zu blocks, expected as many", one.size(), other.size()));
    for (std::size_t b = 0; b < gains.size(); ++b) gains[b] += 0.5 * std::log(other[b] / one[b]);
  }
  const double middle = medianOf(gains);
  for (double& gain : gains) gain = std::clamp(gain, middle - most_apart, middle + most_apart);
  return gains;
}

ScoreGain gainOf(const BlockScore& more, const BlockScore& less, double most_apart) {
  const std::vector<double> gains = blockGains(more, less, most_apart);
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
  if (blocks < 2)
    throw std::invalid_argument(format("scoreBlocks: %zu blocks, expected at least 2", blocks));
  const InputSequence inputs = fitWindow(series, range, options).inputs;
  const ResponseVariances variances = variancesOf(inputs);
  const std::size_t rows = inputs.samples.size();
  std::vector<IndexRange> ranges;
  for (std::size_t b = 0; b < blocks; ++b)
    ranges.push_back({rows * b / blocks, rows * (b + 1) / blocks});
  const CompositionProblem problem(composition, inputs, fitCost(options), optimum);
  const BlockFits fits(problem, optimum, ranges);
  BlockScore score;
  for (std::size_t b = 0; b < blocks; ++b) {
    const IndexRange block = ranges[b];
    const ResidualSamples course = fits.courseWithout(b, composition, inputs);
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
  const InputSequence inputs = fitWindow(series, range, options).inputs;
  const BatteryModel composition = compositionOf(model.fit);
  const CompositionPoint optimum = optimumOf(model);
  const CompositionProblem problem(composition, inputs, fitCost(options), optimum);
  NormalEquations at;
  if (!problem.evaluate(problem.coordinatesOf(optimum), at)) return {};
  return {at.cost, problem.precision()};
}

Promise promiseOf(const FittedModel& model, const FittedCost& nested,
                  const std::vector<std::string>& larger, const Series& series, IndexRange range,
                  const IdentifyOptions& options, int steps, const CompositionPoint* start) {
  const InputSequence inputs = fitWindow(series, range, options).inputs;
  const FitCost cost = fitCost(options);
  const BatteryModel composition(larger);
  const std::vector<CompositionPoint> starts =
      start ? std::vector<CompositionPoint>{*start}
            : startsInLarger(compositionOf(model.fit), optimumOf(model), composition);
  const CompositionProblem problem(composition, inputs, cost, starts.front(), {}, nested.precision);
  const std::optional<CompositionFit> fit = fitFromStarts(problem, starts, searchOf(steps));
  if (!fit) return {0.0, starts.front()};
  // Where the weights are those of eq. 3 the errors' own size is the noise.
  const double rows = static_cast<double>(inputs.samples.size());
  const double fall =
      cost.channels ? nested.cost - fit->at.cost : rows * std::log(nested.cost / fit->at.cost);
  return {std::max(0.0, 0.5 * kIndependentShare * fall), fit->point};
}

Eigen::VectorXd equationErrors(const FittedModel& model, const Series& series, IndexRange range,
                               const IdentifyOptions& options) {
  const InputSequence inputs = fitWindow(series, range, options).inputs;
  const Course course =
      courseOf(compositionOf(model.fit), optimumOf(model).at(inputs.first_time), inputs);
  Eigen::VectorXd errors(static_cast<Eigen::Index>(course.error.size()));
  for (std::size_t n = 0; n < course.error.size(); ++n)
    errors[static_cast<Eigen::Index>(n)] =
        course.error[n] * (course.voltage_controlled[n] ? kOhmsOfCurrentError : 1.0);
  return errors;
}

}  // namespace battery_sof
