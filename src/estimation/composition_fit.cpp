#include "estimation/composition_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "elimination.hpp"
#include "estimation/parallel.hpp"

namespace battery_sof {
namespace {

// a last step promising less is taken unseen: 0.15 standard errors in 24,000 samples
constexpr double kTrustedGain = 1e-6;

/// Fall of the cost that a full step inside the bounds promises.
double promisedGain(const CompositionProblem& problem, const Eigen::VectorXd& x,
                    const NormalEquations& at) {
  std::vector<Eigen::Index> free;
  for (Eigen::Index k = 0; k < x.size(); ++k)
    if ((x[k] > problem.lower()[k] || at.gradient[k] < 0.0) &&
        (x[k] < problem.upper()[k] || at.gradient[k] > 0.0))
      free.push_back(k);
  if (free.empty()) return 0.0;
  Eigen::MatrixXd hessian = at.hessian(free, free);
  hessian.diagonal() *= 1.0 + 1e-9;
  const Eigen::VectorXd gradient = at.gradient(free);
  return gradient.dot(hessian.ldlt().solve(gradient));
}

CompositionFit searchFrom(const CompositionProblem& problem, const Eigen::VectorXd& x,
                          const CompositionSearch& search) {
  Elimination elimination(problem, search.eliminate, x);
  MinimizeOptions options;
  options.max_iterations = search.max_iterations;
  options.lower = elimination.reduced(problem.lower());
  options.upper = elimination.reduced(problem.upper());
  options.gain_tolerance = search.tolerance;
  options.trusted_gain = std::max(kTrustedGain, search.tolerance);
  const auto evaluate = [&](const Eigen::VectorXd& y, NormalEquations& equations) {
    if (search.pulse) search.pulse();
    return elimination.evaluate(y, equations);
  };
  const MinimizeResult result = minimize(evaluate, elimination.reduced(x), options);
  CompositionFit fit;
  fit.status = result.status;
  fit.iterations = result.iterations;
  fit.passes = 0;
  // A refused trial may have come last, or the last step promised much: once more at the optimum
  // then.
  std::optional<NormalEquations> at;
  if (elimination.wasAt(result.x - result.last_step))
    at = elimination.movedOn(result.last_step, CompositionProblem::kNegligibleShare);
  if (!at) {
    NormalEquations last;
    elimination.evaluate(result.x, last);
    at.emplace();
    problem.evaluate(elimination.full(), *at);
    ++fit.passes;
  }
  fit.x = elimination.full();
  fit.at = *at;
  // Where implicit steps change their number the cost has steps of its own, far below what a
  // parameter is known to.
  if (fit.status == FitStatus::kStalled &&
      promisedGain(problem, fit.x, fit.at) < problem.negligibleShare() * fit.at.cost)
    fit.status = FitStatus::kConverged;
  fit.passes += elimination.passes();
  fit.point = problem.pointAt(fit.x);
  return fit;
}

/// Fractional part of multiples of powers of 1/phi_d: evenly spread points of the unit cube, the
/// same every time (Roberts 2018, R_d sequence).
double spread(int start, std::size_t coordinate, std::size_t dimensions) {
  double phi = 2.0;
  for (int k = 0; k < 40; ++k)
    phi = std::pow(1.0 + phi, 1.0 / (static_cast<double>(dimensions) + 1.0));
  const double value = 0.5 + start * std::pow(1.0 / phi, static_cast<double>(coordinate) + 1.0);
  return value - std::floor(value);
}

Eigen::VectorXd spreadStart(const CompositionProblem& problem, const Eigen::VectorXd& first,
                            int start) {
  Eigen::VectorXd x = first;
  for (Eigen::Index k = 0; k < problem.size(); ++k) {
    // Where the voltage is linear any start is as good as another.
    if (problem[k].linear) continue;
    const double low = problem.lower()[k], high = problem.upper()[k];
    const double span = high - low;
    // The middle half: at the very bounds a composition may be blind.
    x[k] = low + span * (0.25 + 0.5 * spread(start, static_cast<std::size_t>(k),
                                             static_cast<std::size_t>(problem.size())));
  }
  return x;
}

Eigen::VectorXd leastOf(const CompositionProblem& problem,
                        const std::vector<Eigen::VectorXd>& points) {
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < points.size(); ++k) {
    NormalEquations at;
    if (!problem.evaluate(points[k], at) || at.cost >= least) continue;
    least = at.cost;
    best = k;
  }
  return points[best];
}

}  // namespace

CompositionFit fitComposition(const CompositionProblem& problem,
                              const std::vector<CompositionPoint>& starts,
                              const CompositionSearch& search) {
  std::vector<Eigen::VectorXd> from;
  for (const CompositionPoint& start : starts) from.push_back(problem.coordinatesOf(start));
  for (int k = 1; k <= search.more_starts; ++k)
    from.push_back(spreadStart(problem, from.front(), k));
  if (!search.every_start && from.size() > 1) from = {leastOf(problem, from)};
  std::vector<std::optional<CompositionFit>> fits(from.size());
  parallelFor(from.size(), search.threads, [&](std::size_t k) {
    NormalEquations probe;
    if (k == 0 || problem.evaluate(from[k], probe)) fits[k] = searchFrom(problem, from[k], search);
  });
  CompositionFit best = *fits.front();
  for (std::size_t k = 1; k < fits.size(); ++k)
    if (fits[k] && fits[k]->at.cost < best.at.cost * (1.0 - 1e-9)) {
      best = *fits[k];
      best.best_start = static_cast<int>(k);
    }
  return best;
}

CompositionPoint embedded(const BatteryModel& nested, const CompositionPoint& point,
                          const BatteryModel& larger) {
  CompositionPoint out{larger.typicalParameters(), larger.restState()};
  for (Eigen::Index j = 0; j < larger.parameterCount(); ++j) {
    const ParameterInfo& info = larger.parameters()[static_cast<std::size_t>(j)];
    if (const auto row = nested.parameterRow(info.name))
      out.parameters[j] = point.parameters[*row];
    else if (info.vanishes_at && !info.held)
      out.parameters[j] = *info.vanishes_at;
  }
  for (Eigen::Index j = 0; j < larger.stateCount(); ++j)
    for (Eigen::Index k = 0; k < nested.stateCount(); ++k)
      if (larger.states()[static_cast<std::size_t>(j)].name ==
          nested.states()[static_cast<std::size_t>(k)].name)
        out.state[j] = point.state[k];
  return out;
}

CompositionPoint typicalStart(const BatteryModel& model, const InputSequence& inputs) {
  CompositionPoint start{model.typicalParameters(), model.restState()};
  double sum = 0.0, count = 0.0;
  for (const InputSample& sample : inputs.samples) {
    sum += sample.count * sample.voltage;
    count += sample.count;
  }
  if (count > 0.0) start.parameters[kRowUDc] = sum / count;
  return start;
}

}  // namespace battery_sof
