#include "estimation/composition_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

namespace battery_sof {
namespace {

/// A problem with its linear coordinates solved for the others in every pass (Golub and Pereyra
/// 1973; Kaufman 1975).
class Elimination {
 public:
  /// @param start all coordinates.
  Elimination(const LeastSquaresProblem& problem, const Eigen::VectorXd& start)
      : problem_(problem), full_(start) {
    for (Eigen::Index k = 0; k < problem.size(); ++k)
      (problem[k].linear ? linear_ : others_).push_back(k);
  }

  /// @return the coordinates that are searched for.
  Eigen::VectorXd reduced(const Eigen::VectorXd& x) const { return x(others_); }
  /// All coordinates at the last pass' y.
  const Eigen::VectorXd& full() const { return full_; }
  int passes() const { return passes_; }

  /// As LeastSquaresProblem::evaluate(), over the coordinates that are searched for.
  bool evaluate(const Eigen::VectorXd& y, NormalEquations& equations) {
    ++passes_;
    // The linear coordinates go along as the last pass sees them: the others' columns depend on
    // them.
    Eigen::VectorXd x = last_.size() > 0 ? predicted(y - last_).x : full_;
    x(others_) = y;
    last_.resize(0);
    NormalEquations& all = all_;
    if (!problem_.evaluate(x, all)) return false;
    last_ = y;
    passed_ = x;
    const Eigen::VectorXd step = solveLinear(x, all);
    const Eigen::VectorXd gradient = all.gradient + all.hessian * step;
    equations.cost = all.cost + (2.0 * all.gradient + all.hessian * step).dot(step);
    equations.gradient = gradient(others_);
    equations.hessian = all.hessian(others_, others_);
    if (!moved_.empty()) {
      const Eigen::MatrixXd across = all.hessian(moved_, others_);
      const Eigen::MatrixXd own = all.hessian(moved_, moved_);
      equations.hessian -= across.transpose() * own.ldlt().solve(across);
    }
    full_ = inside(x + step);
    return std::isfinite(equations.cost);
  }

  /// Whether the last pass succeeded and was at y, but for rounding.
  bool wasAt(const Eigen::VectorXd& y) const {
    return last_.size() == y.size() &&
           (last_ - y).cwiseAbs().maxCoeff() <= 1e-13 * (1.0 + y.cwiseAbs().maxCoeff());
  }

  /// Moves on from the last pass by `step` and on to the linear coordinates' optimum, without
  /// another pass: exact but for the curvature of the others. @return nothing when that promises
  /// more than a share `most` of the cost.
  std::optional<NormalEquations> movedOn(const Eigen::VectorXd& step, double most) {
    const Predicted there = predicted(step);
    if (!(all_.cost - there.at.cost <= most * all_.cost)) return std::nullopt;
    full_ = there.x;
    return there.at;
  }

 private:
  struct Predicted {
    Eigen::VectorXd x;
    NormalEquations at;
  };
  /// What the last pass promises `step` away, the linear coordinates at their optimum.
  Predicted predicted(const Eigen::VectorXd& step) {
    Eigen::VectorXd whole = Eigen::VectorXd::Zero(full_.size());
    whole(others_) = step;
    const NormalEquations moved = shifted(all_, whole);
    const Eigen::VectorXd linear = solveLinear(passed_ + whole, moved);
    return {inside(passed_ + whole + linear), shifted(moved, linear)};
  }

  /// Against rounding: steps end on bounds.
  Eigen::VectorXd inside(const Eigen::VectorXd& x) const {
    return x.cwiseMax(problem_.lower()).cwiseMin(problem_.upper());
  }

  /// Step to the optimum over the linear coordinates inside their bounds, by the primal active-set
  /// method: along the unbounded solution to the first bound in the way, which then holds; a bound
  /// is left when the cost falls inwards. The cost never rises on the way. moved_ are then the
  /// coordinates that no bound holds.
  Eigen::VectorXd solveLinear(const Eigen::VectorXd& x, const NormalEquations& all) {
    Eigen::VectorXd step = Eigen::VectorXd::Zero(x.size());
    moved_ = linear_;
    std::vector<Eigen::Index> held;
    for (std::size_t k = 0; k < 4 * linear_.size() + 4; ++k) {
      const Eigen::Index stopped = moveFree(x, all, step);
      if (stopped >= 0) {
        moved_.erase(std::find(moved_.begin(), moved_.end(), stopped));
        held.push_back(stopped);
        continue;
      }
      const auto released = mostInward(x, all, step, held);
      if (released == held.end()) break;
      moved_.push_back(*released);
      held.erase(released);
    }
    return step;
  }

  /// Moves the free coordinates towards their optimum. @return the one that a bound stopped; -1
  /// when none did.
  Eigen::Index moveFree(const Eigen::VectorXd& x, const NormalEquations& all,
                        Eigen::VectorXd& step) const {
    if (moved_.empty()) return -1;
    Eigen::MatrixXd own = all.hessian(moved_, moved_);
    own.diagonal() *= 1.0 + 1e-12;
    own.diagonal().array() += 1e-30;
    const Eigen::VectorXd slope = all.gradient + all.hessian * step;
    const Eigen::VectorXd wanted = -own.ldlt().solve(slope(moved_));
    Eigen::Index stopped = -1;
    double share = 1.0, bound = 0.0;
    for (std::size_t k = 0; k < moved_.size(); ++k) {
      const Eigen::Index j = moved_[k];
      const double by = wanted[k];
      if (!std::isfinite(by)) return j;
      const double edge = (by < 0.0 ? problem_.lower()[j] : problem_.upper()[j]) - x[j];
      if (std::abs(by) <= std::abs(edge - step[j])) continue;
      const double reach = std::max(0.0, (edge - step[j]) / by);
      if (reach >= share) continue;
      share = reach;
      stopped = j;
      bound = edge;
    }
    step(moved_) += share * wanted;
    if (stopped >= 0) step[stopped] = bound;
    return stopped;
  }

  /// @return the held coordinate from whose bound the cost falls most steeply; end when there is
  /// none.
  std::vector<Eigen::Index>::iterator mostInward(const Eigen::VectorXd& x,
                                                 const NormalEquations& all,
                                                 const Eigen::VectorXd& step,
                                                 std::vector<Eigen::Index>& held) const {
    const Eigen::VectorXd slope = all.gradient + all.hessian * step;
    auto steepest = held.end();
    double most = 1e-9 * std::sqrt(std::max(all.cost, 0.0));
    for (auto at = held.begin(); at != held.end(); ++at) {
      const double here = x[*at] + step[*at];
      const bool at_lower = here - problem_.lower()[*at] < problem_.upper()[*at] - here;
      const double norm = std::sqrt(all.hessian(*at, *at));
      const double inward = (at_lower ? -slope[*at] : slope[*at]) / norm;
      if (!(norm > 0.0) || !(inward > most)) continue;
      most = inward;
      steepest = at;
    }
    return steepest;
  }

  const LeastSquaresProblem& problem_;
  Eigen::VectorXd full_;
  NormalEquations all_;            // of the last pass
  Eigen::VectorXd last_, passed_;  // its y, and all coordinates
  std::vector<Eigen::Index> linear_, others_, moved_;
  int passes_ = 0;
};

/// Fall of the cost that a full step inside the bounds promises.
double promisedGain(const LeastSquaresProblem& problem, const Eigen::VectorXd& x,
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

/// @return nothing where the cost has no finite value at x.
std::optional<CompositionFit> searchFrom(const LeastSquaresProblem& problem,
                                         const Eigen::VectorXd& x,
                                         const CompositionSearch& search) {
  Elimination elimination(problem, x);
  MinimizeOptions options;
  options.max_iterations = search.max_iterations;
  options.lower = elimination.reduced(problem.lower());
  options.upper = elimination.reduced(problem.upper());
  options.gain_tolerance = search.tolerance;
  options.trusted_gain = std::max(search.trusted_gain, search.tolerance);
  const Eigen::VectorXd start =
      elimination.reduced(x).cwiseMax(options.lower).cwiseMin(options.upper);
  const auto pass = [&](const Eigen::VectorXd& y, NormalEquations& equations) {
    if (search.pulse) search.pulse();
    return elimination.evaluate(y, equations);
  };
  std::optional<NormalEquations> first(std::in_place);
  if (!pass(start, *first)) return std::nullopt;
  const auto evaluate = [&](const Eigen::VectorXd& y, NormalEquations& equations) {
    if (!first) return pass(y, equations);
    equations = *std::exchange(first, std::nullopt);
    return true;
  };
  const MinimizeResult result = minimize(evaluate, start, options);
  CompositionFit fit;
  fit.status = result.status;
  fit.iterations = result.iterations + (result.last_step.isZero(0.0) ? 0 : 1);
  fit.passes = 0;
  // A refused trial may have come last, or the last step promised much: once more at the optimum
  // then.
  std::optional<NormalEquations> at;
  if (elimination.wasAt(result.x - result.last_step))
    at = elimination.movedOn(result.last_step, LeastSquaresProblem::kNegligibleShare);
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
  // parameter is known to. The limit may stop a search that is as good as there: within a standard
  // error, whose square is four times that of half of one.
  if (fit.status == FitStatus::kStalled || fit.status == FitStatus::kIterationLimit) {
    const double errors = fit.status == FitStatus::kStalled ? 1.0 : 4.0;
    if (promisedGain(problem, fit.x, fit.at) < errors * problem.negligibleShare() * fit.at.cost)
      fit.status = FitStatus::kConverged;
  }
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

Eigen::VectorXd spreadStart(const LeastSquaresProblem& problem, const Eigen::VectorXd& first,
                            int start) {
  Eigen::VectorXd x = first;
  for (Eigen::Index k = 0; k < problem.size(); ++k) {
    // Where the voltage is linear any start is as good as another.
    if (problem[k].linear) continue;
    const double low = problem.lower()[k], high = problem.upper()[k];
    const double span = high - low;
    // The middle half: at the very bounds a composition may be blind.
    x[k] = low + span * (0.25 + 0.5 * spread(start, k, problem.size()));
  }
  return x;
}

}  // namespace

std::optional<CompositionFit> fitFromStarts(const LeastSquaresProblem& problem,
                                            const std::vector<CompositionPoint>& starts,
                                            const CompositionSearch& search) {
  std::vector<Eigen::VectorXd> from;
  for (const CompositionPoint& start : starts) from.push_back(problem.coordinatesOf(start));
  for (int k = 1; k <= search.more_starts; ++k)
    from.push_back(spreadStart(problem, from.front(), k));
  std::vector<std::optional<CompositionFit>> fits(from.size());
  parallelFor(from.size(), search.threads,
              [&](std::size_t k) { fits[k] = searchFrom(problem, from[k], search); });
  std::optional<CompositionFit> best;
  for (std::size_t k = 0; k < fits.size(); ++k)
    if (fits[k] && (!best || fits[k]->at.cost < best->at.cost * (1.0 - 1e-9))) {
      best = std::move(fits[k]);
      best->best_start = static_cast<int>(k);
    }
  return best;
}

CompositionFit fitComposition(const LeastSquaresProblem& problem,
                              const std::vector<CompositionPoint>& starts,
                              const CompositionSearch& search) {
  std::optional<CompositionFit> fit = fitFromStarts(problem, starts, search);
  if (!fit) throw std::invalid_argument("fitComposition: the cost has no finite value at a start");
  return *std::move(fit);
}

CompositionPoint embedded(const BatteryModel& nested, const CompositionPoint& point,
                          const BatteryModel& larger) {
  CompositionPoint out{larger.typicalParameters(), larger.restState()};
  for (Eigen::Index j = 0; j < larger.parameterCount(); ++j) {
    const ParameterInfo& info = larger.parameters()[j];
    if (info.vanishes_at && !info.held) out.parameters[j] = *info.vanishes_at;
  }
  takeShared(nested, point, larger, out);
  return out;
}

void takeShared(const BatteryModel& from, const CompositionPoint& there, const BatteryModel& model,
                CompositionPoint& point) {
  for (Eigen::Index j = 0; j < model.parameterCount(); ++j)
    if (const auto row = from.parameterRow(model.parameters()[j].name))
      point.parameters[j] = there.parameters[*row];
  for (Eigen::Index k = 0; k < model.stateCount(); ++k)
    for (Eigen::Index m = 0; m < from.stateCount(); ++m)
      if (model.states()[k].name == from.states()[m].name) point.state[k] = there.state[m];
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

Course courseOf(const BatteryModel& model, const ModelPoint& start, const InputSequence& inputs) {
  Simulation simulation(model, start);
  Course course;
  for (const InputSample& sample : inputs.samples) {
    const double error = simulation.follow(sample);
    const bool is_controlled = sample.voltage_controlled;
    course.voltage.push_back(is_controlled ? sample.voltage : simulation.voltage());
    course.current.push_back(sample.step.current - (is_controlled ? error : 0.0));
    course.columns.push_back(course.memory.advance(
        {sample.step.duration, is_controlled, course.voltage.back(), course.current.back()}));
    course.error.push_back(error);
    course.voltage_controlled.push_back(is_controlled);
  }
  return course;
}

void parallelFor(std::size_t count, int threads, const std::function<void(std::size_t)>& work) {
  const std::size_t wanted = threads > 0 ? static_cast<std::size_t>(threads)
                                         : std::max(1U, std::thread::hardware_concurrency());
  std::vector<std::exception_ptr> failures(count);
  std::atomic<std::size_t> next{0};
  const auto loop = [&] {
    for (std::size_t k = next++; k < count; k = next++) {
      try {
        work(k);
      } catch (...) {
        failures[k] = std::current_exception();
      }
    }
  };
  std::vector<std::thread> others;
  for (std::size_t k = 1; k < std::min(wanted, count); ++k) others.emplace_back(loop);
  loop();
  for (std::thread& other : others) other.join();
  for (const auto& failure : failures)
    if (failure) std::rethrow_exception(failure);
}

}  // namespace battery_sof
