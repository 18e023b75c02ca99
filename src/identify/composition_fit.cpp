#include "battery_sof/identify/composition_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "battery_sof/identify/fit_description.hpp"
#include "battery_sof/identify/parallel.hpp"

namespace battery_sof {
namespace {

// What a prior weighs without a noise model: 10 mV of error, correlated over 5 s (as windowExcitation()).
constexpr double kPriorError = 0.01;       // [V]
constexpr double kPriorCorrelation = 5.0;  // [s]
constexpr double kNoise = 1e-5;            // share of the cost: half a standard error in 24,000 samples
constexpr double kTrustedGain = 1e-6;      // a last step promising less is taken unseen: 0.15 standard errors in 24,000 samples
// [s], over which a current is held for its conditioning: a sample's interval, within what the double layer makes of it.
constexpr double kShortestReach = 0.1, kLongestReach = 60.0;
constexpr Eigen::Index kRows = 64;         // of the Jacobian held at a time

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

void requireKnown(const BatteryModel& model, const std::vector<std::string>& names) {
  for (const std::string& name : names)
    if (!model.parameterRow(name))
      throw std::invalid_argument("parameter \"" + name + "\" is not one of the composition's");
}

double meanInterval(const Drive& drive) {
  double count = 0.0;
  for (const DriveSample& sample : drive.samples) count += sample.count;
  const double span = drive.samples.back().step.time - drive.samples.front().step.time;
  return count > 1.0 ? span / (count - 1.0) : 0.0;
}

/// Weighs a row (Jacobian, residual last, in sigmas) as rho asks for. @return rho(z) less the square that is then summed.
template <typename Row>
double makeRobust(Row& row, double k) {
  const double z = row[row.size() - 1] / k;
  const double root = std::sqrt(1.0 + z * z);
  row *= 1.0 / std::sqrt(root);
  return 2.0 * k * k * (root - 1.0) - k * k * z * z / root;
}

/// d error / d lane of Simulation::follow().
Eigen::Array<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, Simulation::kMaxLanes> errorDerivatives(
    const Simulation& simulation, const DriveSample& sample) {
  if (sample.voltage_drives) return simulation.currentErrorDerivatives().transpose().array();
  return -simulation.voltageDerivatives().transpose().array();
}

}  // namespace

CompositionProblem::CompositionProblem(const BatteryModel& model, const Drive& drive,
                                       const FitCost& cost, const CompositionPoint& start,
                                       const std::vector<std::string>& free,
                                       const std::vector<std::string>& fixed)
    : model_(model), drive_(drive), cost_(cost), start_(start) {
  requireKnown(model, free);
  requireKnown(model, fixed);
  if (drive.samples.empty()) throw std::invalid_argument("the drive has no sample");
  for (Eigen::Index j = 0; j < model.parameterCount(); ++j) {
    const ParameterInfo& info = model.parameters()[static_cast<std::size_t>(j)];
    if ((!info.held || contains(free, info.name)) && !contains(fixed, info.name)) addParameter(j, info);
  }
  for (Eigen::Index j = 0; j < model.stateCount(); ++j)
    if (model.states()[static_cast<std::size_t>(j)].initial_std)
      addState(model.parameterCount() + j, model.states()[static_cast<std::size_t>(j)]);
  if (size() > Simulation::kMaxLanes)
    throw std::invalid_argument("the composition has " + std::to_string(size()) +
                                " unknowns, at most " + std::to_string(Simulation::kMaxLanes) +
                                " can be fitted at once");
  if (cost.noise) {
    whitening_.emplace(*cost.noise, drive.samples);
  } else if (cost.channels) {
    prior_weight_ = 1.0 / cost.channels->independent;
    reweigh(start);
  } else {
    const double interval = meanInterval(drive);
    prior_weight_ = kPriorError * kPriorError *
                    (interval > 0.0 ? std::max(1.0, kPriorCorrelation / interval) : 1.0);
  }
}

void CompositionProblem::addParameter(Eigen::Index row, const ParameterInfo& info) {
  Coordinate coordinate{row, info.logarithmic, 1.0, std::nullopt, std::nullopt};
  if (!info.logarithmic)
    coordinate.scale = info.magnitude != 0.0 ? std::abs(info.magnitude) : std::abs(info.upper);
  const auto in = [&](double value) {
    return info.logarithmic ? std::log(value) : value / coordinate.scale;
  };
  if (info.prior_std) {
    coordinate.prior_mean = in(info.magnitude);
    coordinate.prior_std = info.logarithmic ? *info.prior_std : *info.prior_std / coordinate.scale;
  }
  coordinates_.push_back(coordinate);
  // A current that answers to a voltage is linear in nothing.
  linear_.push_back(info.linear && !cost_.channels);
  lower_.conservativeResize(size());
  upper_.conservativeResize(size());
  const double length = drive_.samples.back().step.time - drive_.first_time;
  lower_[size() - 1] = in(info.lower);
  upper_[size() - 1] = in(info.instant ? std::clamp(length, info.lower, info.upper) : info.upper);
}

void CompositionProblem::addState(Eigen::Index row, const StateInfo& info) {
  const double scale = *info.initial_std;
  // What is known of a first state does not weigh more because errors last for long.
  const double std = cost_.channels ? 1.0 / std::sqrt(cost_.channels->independent) : 1.0;
  coordinates_.push_back({row, false, scale, info.rest / scale, std});
  linear_.push_back(false);
  lower_.conservativeResize(size());
  upper_.conservativeResize(size());
  lower_[size() - 1] = info.lower / scale;
  upper_[size() - 1] = info.upper / scale;
}

Eigen::VectorXd CompositionProblem::coordinatesOf(const CompositionPoint& point) const {
  Eigen::VectorXd x(size());
  for (Eigen::Index k = 0; k < size(); ++k) {
    const Coordinate& c = coordinates_[static_cast<std::size_t>(k)];
    const Eigen::Index state = c.row - model_.parameterCount();
    const double value = state < 0 ? point.parameters[c.row] : point.state[state];
    x[k] = c.logarithmic ? std::log(value) : value / c.scale;
  }
  return x.cwiseMax(lower_).cwiseMin(upper_);
}

CompositionPoint CompositionProblem::pointAt(const Eigen::VectorXd& x) const {
  CompositionPoint point = start_;
  for (Eigen::Index k = 0; k < size(); ++k) {
    const Coordinate& c = coordinates_[static_cast<std::size_t>(k)];
    const Eigen::Index state = c.row - model_.parameterCount();
    const double value = c.logarithmic ? std::exp(x[k]) : x[k] * c.scale;
    (state < 0 ? point.parameters[c.row] : point.state[state]) = value;
  }
  for (Eigen::Index j = 0; j < model_.stateCount(); ++j)
    if (model_.states()[static_cast<std::size_t>(j)].begins_as_u_c2) point.state[j] = point.state[0];
  return point;
}

Eigen::MatrixXd CompositionProblem::seedsAt(const Eigen::VectorXd& x) const {
  const Eigen::Index parameters = model_.parameterCount();
  Eigen::MatrixXd seeds = Eigen::MatrixXd::Zero(parameters + model_.stateCount(), size());
  for (Eigen::Index k = 0; k < size(); ++k) {
    const Coordinate& c = coordinates_[static_cast<std::size_t>(k)];
    seeds(c.row, k) = c.logarithmic ? std::exp(x[k]) : c.scale;
  }
  for (Eigen::Index j = 0; j < model_.stateCount(); ++j)
    if (model_.states()[static_cast<std::size_t>(j)].begins_as_u_c2)
      seeds.row(parameters + j) = seeds.row(parameters);
  return seeds;
}

void CompositionProblem::reweigh(const CompositionPoint& point) {
  const ChannelErrors& errors = *cost_.channels;
  Simulation simulation(model_, {point.parameters, point.state, drive_.first_time, drive_.first_time});
  precision_.clear();
  for (const DriveSample& sample : drive_.samples) {
    const double over = std::clamp(sample.step.duration, kShortestReach, kLongestReach);
    const double error = simulation.follow(sample);
    const double current = sample.step.current - (sample.voltage_drives ? error : 0.0);
    const double G = 1.0 / simulation.resistanceOver(current, over);
    const double variance = std::pow(errors.current_std, 2) + std::pow(G * errors.voltage_std, 2) +
                            std::pow(errors.current_share * sample.step.current, 2);
    precision_.push_back(std::isfinite(variance) ? (sample.voltage_drives ? 1.0 : G * G) / variance : 0.0);
  }
}

double CompositionProblem::negligibleShare() const {
  return cost_.channels ? kNoise / cost_.channels->independent : kNoise;
}

double CompositionProblem::weightOf(std::size_t k) const {
  const DriveSample& sample = drive_.samples[k];
  if (cost_.channels) return precision_[k] * sample.count;
  const double W = sample.step.current < cost_.crank_weight_current ? cost_.crank_weight : 1.0;
  return W * W * sample.count;
}

bool CompositionProblem::evaluate(const Eigen::VectorXd& x, NormalEquations& equations) const {
  const CompositionPoint point = pointAt(x);
  const Eigen::Index n = size();
  Simulation simulation(model_, {point.parameters, point.state, drive_.first_time, drive_.first_time},
                        seedsAt(x));
  using Row = Eigen::Array<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, Simulation::kMaxLanes + 1>;
  Whitening::Memory<Row> memory{Row::Zero(n + 1), Row::Zero(n + 1)};
  Eigen::MatrixXd rows(n + 1, kRows);
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(n + 1, n + 1);
  Eigen::Index filled = 0;
  double robust_excess = 0.0;
  const auto flush = [&] {
    sums.selfadjointView<Eigen::Lower>().rankUpdate(rows.leftCols(filled));
    filled = 0;
  };
  Row row(n + 1);
  for (std::size_t k = 0; k < drive_.samples.size(); ++k) {
    const DriveSample& sample = drive_.samples[k];
    const double residual = simulation.follow(sample);
    if (!std::isfinite(residual)) return false;
    row.head(n) = errorDerivatives(simulation, sample);
    row[n] = residual;
    if (whitening_)
      whitening_->apply(k, row, memory);
    else
      row *= std::sqrt(weightOf(k));
    if (cost_.channels) robust_excess += makeRobust(row, cost_.channels->robust);
    if (sample.count > 0.0) rows.col(filled++) = row.matrix().transpose();
    if (filled == kRows) flush();
  }
  flush();
  sums.triangularView<Eigen::StrictlyUpper>() = sums.transpose();
  equations.cost = sums(n, n) + robust_excess;
  equations.gradient = sums.col(n).head(n);
  equations.hessian = sums.topLeftCorner(n, n);
  if (cost_.priors) addPriors(x, equations);
  return std::isfinite(equations.cost) && equations.hessian.allFinite();
}

void CompositionProblem::addPriors(const Eigen::VectorXd& x, NormalEquations& equations) const {
  for (Eigen::Index k = 0; k < size(); ++k) {
    const Coordinate& c = coordinates_[static_cast<std::size_t>(k)];
    if (!c.prior_std) continue;
    const double away = (x[k] - *c.prior_mean) / *c.prior_std;
    equations.cost += prior_weight_ * away * away;
    equations.gradient[k] += prior_weight_ * away / *c.prior_std;
    equations.hessian(k, k) += prior_weight_ / (*c.prior_std * *c.prior_std);
  }
}

Eigen::VectorXd CompositionProblem::priorPrecision() const {
  Eigen::VectorXd precision = Eigen::VectorXd::Zero(size());
  if (!cost_.priors) return precision;
  for (Eigen::Index k = 0; k < size(); ++k)
    if (const auto std = coordinates_[static_cast<std::size_t>(k)].prior_std)
      precision[k] = 1.0 / (*std * *std);
  return precision;
}

Eigen::VectorXd CompositionProblem::residual(const Eigen::VectorXd& x) const {
  const CompositionPoint point = pointAt(x);
  Simulation simulation(model_, {point.parameters, point.state, drive_.first_time, drive_.first_time});
  Eigen::VectorXd e(static_cast<Eigen::Index>(drive_.samples.size()));
  for (std::size_t k = 0; k < drive_.samples.size(); ++k) {
    e[static_cast<Eigen::Index>(k)] = simulation.follow(drive_.samples[k]);
  }
  return e;
}

namespace {

/// The problem with its linear coordinates solved for the others in every pass (Golub and Pereyra 1973; Kaufman 1975).
class Elimination {
 public:
  Elimination(const CompositionProblem& problem, bool eliminate, const Eigen::VectorXd& start)
      : problem_(problem), full_(start) {
    for (Eigen::Index k = 0; k < problem.size(); ++k)
      (eliminate && problem.isLinear()[static_cast<std::size_t>(k)] ? linear_ : others_).push_back(k);
  }

  Eigen::VectorXd reduced(const Eigen::VectorXd& x) const { return x(others_); }

  bool evaluate(const Eigen::VectorXd& y, NormalEquations& equations) {
    ++passes_;
    // The linear coordinates go along as the last pass sees them: the others' columns depend on them.
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
    return last_.size() == y.size() && (last_ - y).cwiseAbs().maxCoeff() <= 1e-13 * (1.0 + y.cwiseAbs().maxCoeff());
  }

  /// Moves on from the last pass by `step` and on to the linear coordinates' optimum, without another pass: exact but
  /// for the curvature of the others. @return nothing when that promises more than a share `most` of the cost.
  std::optional<NormalEquations> movedOn(const Eigen::VectorXd& step, double most) {
    const Predicted there = predicted(step);
    if (!(all_.cost - there.at.cost <= most * all_.cost)) return std::nullopt;
    full_ = there.x;
    return there.at;
  }

  /// All coordinates at the last pass' y.
  const Eigen::VectorXd& full() const { return full_; }
  void setFull(const Eigen::VectorXd& x) { full_ = x; }
  int passes() const { return passes_; }
  const std::vector<Eigen::Index>& others() const { return others_; }

 private:
  struct Predicted {
    Eigen::VectorXd x;
    NormalEquations at;
  };
  /// What the last pass promises `step` away, the linear coordinates at their optimum.
  Predicted predicted(const Eigen::VectorXd& step) {
    Eigen::VectorXd whole = Eigen::VectorXd::Zero(full_.size());
    whole(others_) = step;
    const NormalEquations beside = shifted(all_, whole);
    const Eigen::VectorXd linear = solveLinear(passed_ + whole, beside);
    return {inside(passed_ + whole + linear), shifted(beside, linear)};
  }

  /// Against rounding: steps end on bounds.
  Eigen::VectorXd inside(const Eigen::VectorXd& x) const {
    return x.cwiseMax(problem_.lower()).cwiseMin(problem_.upper());
  }

  static NormalEquations shifted(NormalEquations at, const Eigen::VectorXd& step) {
    const Eigen::VectorXd curved = at.hessian * step;
    at.cost += (2.0 * at.gradient + curved).dot(step);
    at.gradient += curved;
    return at;
  }

  /// Step to the optimum over the linear coordinates inside their bounds, by the primal active-set method: along the
  /// unbounded solution to the first bound in the way, which then holds; a bound is left when the cost falls inwards.
  /// The cost never rises on the way. moved_ are then the coordinates that no bound holds.
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

  /// Moves the free coordinates towards their optimum. @return the one that a bound stopped; -1 when none did.
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
      const double by = wanted[static_cast<Eigen::Index>(k)];
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

  /// @return the held coordinate from whose bound the cost falls most steeply; end when there is none.
  std::vector<Eigen::Index>::iterator mostInward(const Eigen::VectorXd& x, const NormalEquations& all,
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

  const CompositionProblem& problem_;
  Eigen::VectorXd full_;
  NormalEquations all_;          // of the last pass
  Eigen::VectorXd last_, passed_;  // its y, and all coordinates
  std::vector<Eigen::Index> linear_, others_, moved_;
  int passes_ = 0;
};

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
  const MinimizeResult result = minimize(
      [&](const Eigen::VectorXd& y, NormalEquations& equations) {
        return elimination.evaluate(y, equations);
      },
      elimination.reduced(x), options);
  CompositionFit fit;
  fit.status = fitStatusOf(result.status);
  fit.iterations = result.iterations;
  fit.passes = 0;
  // A refused trial may have come last, or the last step promised much: once more at the optimum then.
  std::optional<NormalEquations> at;
  if (elimination.wasAt(result.x - result.last_step)) at = elimination.movedOn(result.last_step, kNoise);
  if (!at) {
    NormalEquations last;
    elimination.evaluate(result.x, last);
    at.emplace();
    problem.evaluate(elimination.full(), *at);
    ++fit.passes;
  }
  fit.x = elimination.full();
  fit.at = *at;
  // Where implicit steps change their number the cost has steps of its own, far below what a parameter is known to.
  if (fit.status == FitStatus::kStalled &&
      promisedGain(problem, fit.x, fit.at) < problem.negligibleShare() * fit.at.cost)
    fit.status = FitStatus::kConverged;
  fit.passes += elimination.passes();
  fit.point = problem.pointAt(fit.x);
  return fit;
}

/// Fractional part of multiples of powers of 1/phi_d: evenly spread points of the unit cube, the same every time
/// (Roberts 2018, R_d sequence).
double spread(int start, std::size_t coordinate, std::size_t dimensions) {
  double phi = 2.0;
  for (int k = 0; k < 40; ++k) phi = std::pow(1.0 + phi, 1.0 / (static_cast<double>(dimensions) + 1.0));
  const double value = 0.5 + start * std::pow(1.0 / phi, static_cast<double>(coordinate) + 1.0);
  return value - std::floor(value);
}

Eigen::VectorXd spreadStart(const CompositionProblem& problem, const Eigen::VectorXd& first,
                            int start) {
  Eigen::VectorXd x = first;
  for (Eigen::Index k = 0; k < problem.size(); ++k) {
    // Where the voltage is linear any start is as good as another.
    if (problem.isLinear()[static_cast<std::size_t>(k)]) continue;
    const double low = problem.lower()[k], high = problem.upper()[k];
    const double span = high - low;
    // The middle half: at the very bounds a composition may be blind.
    x[k] = low + span * (0.25 + 0.5 * spread(start, static_cast<std::size_t>(k), static_cast<std::size_t>(problem.size())));
  }
  return x;
}

}  // namespace

namespace {

Eigen::VectorXd leastOf(const CompositionProblem& problem, const std::vector<Eigen::VectorXd>& points) {
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
  for (int k = 1; k <= search.more_starts; ++k) from.push_back(spreadStart(problem, from.front(), k));
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
      if (larger.states()[static_cast<std::size_t>(j)].name == nested.states()[static_cast<std::size_t>(k)].name)
        out.state[j] = point.state[k];
  return out;
}

CompositionPoint typicalStart(const BatteryModel& model, const Drive& drive) {
  CompositionPoint start{model.typicalParameters(), model.restState()};
  double sum = 0.0, count = 0.0;
  for (const DriveSample& sample : drive.samples) {
    sum += sample.count * sample.voltage;
    count += sample.count;
  }
  if (count > 0.0) start.parameters[kRowUDc] = sum / count;
  return start;
}

}  // namespace battery_sof
