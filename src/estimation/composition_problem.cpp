#include "estimation/composition_fit.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "estimation/depth_physics.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

// What a prior weighs without a noise model: 10 mV of error, correlated over 5 s (as
// windowExcitation()).
constexpr double kPriorError = 0.01;       // [V]
constexpr double kPriorCorrelation = 5.0;  // [s]
constexpr double kErrorsOfACurve = 40.0;   // that count as independent
// [s], over which a current is held for its conditioning: a sample's interval, within what the
// double layer makes of it.
constexpr double kShortestReach = 0.1, kLongestReach = 60.0;
constexpr Eigen::Index kRows = 64;  // of the Jacobian held at a time

/// @throws std::invalid_argument for a sequence without a sample.
double lengthOf(const InputSequence& inputs) {
  if (inputs.samples.empty()) throw std::invalid_argument("the input sequence has no sample");
  return inputs.samples.back().step.time - inputs.first_time;
}

double meanInterval(const InputSequence& inputs) {
  double count = 0.0;
  for (const InputSample& sample : inputs.samples) count += sample.count;
  const double span = inputs.samples.back().step.time - inputs.samples.front().step.time;
  return count > 1.0 ? span / (count - 1.0) : 0.0;
}

/// 2 k^2 (sqrt(1 + z^2 / k^2) - 1) (ChannelErrors). @param square z^2.
double robustCost(double square, double k) {
  return 2.0 * k * k * (std::sqrt(1.0 + square / (k * k)) - 1.0);
}

/// Weighs a row (Jacobian, residual last, in sigmas) by rho. @return rho(z) less the square
/// that is then summed.
template <typename Row>
double makeRobust(Row& row, double k) {
  const double square = row[row.size() - 1] * row[row.size() - 1];
  const double root = std::sqrt(1.0 + square / (k * k));
  row *= 1.0 / std::sqrt(root);
  return robustCost(square, k) - square / root;
}

/// d error / d tangent of Simulation::follow().
Eigen::Array<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, Simulation::kMaxTangents>
errorDerivatives(const Simulation& simulation, const InputSample& sample) {
  if (sample.voltage_controlled) return simulation.currentErrorDerivatives().transpose().array();
  return -simulation.voltageDerivatives().transpose().array();
}

/// [s], for which errors last: seconds, but in a curve over a whole discharge, where the physics
/// that it lacks is as slow as the curve.
double errorCorrelation(const BatteryModel& model, const InputSequence& inputs) {
  if (inputs.samples.empty() || !contains(model.effects(), kUsedUp)) return kPriorCorrelation;
  const double duration = inputs.samples.back().step.time - inputs.first_time;
  return std::max(kPriorCorrelation, duration / kErrorsOfACurve);
}

}  // namespace

CompositionProblem::CompositionProblem(const BatteryModel& model, const InputSequence& inputs,
                                       const FitCost& cost, const CompositionPoint& start,
                                       const std::vector<std::string>& fixed,
                                       std::vector<double> precision)
    : LeastSquaresProblem(model, start, lengthOf(inputs), cost.known, fixed),
      model_(model),
      inputs_(inputs),
      cost_(cost),
      precision_(std::move(precision)) {
  if (cost.noise) {
    whitening_.emplace(*cost.noise, inputs.samples);
  } else if (cost.channels) {
    prior_weight_ = 1.0 / cost.channels->independent;
    for (FitCoordinate& c : coordinates_) {
      c.linear = false;  // a current that answers to a voltage is linear in nothing
      // What is known of a first state does not weigh more because errors last for long.
      if (c.row >= model.parameterCount()) c.std = 1.0 / std::sqrt(cost.channels->independent);
    }
    if (precision_.empty()) reweigh(start);
  } else {
    const double interval = meanInterval(inputs), correlation = errorCorrelation(model, inputs);
    prior_weight_ =
        kPriorError * kPriorError * (interval > 0.0 ? std::max(1.0, correlation / interval) : 1.0);
  }
  if (cost.capacity) of_capacity_ = CapacityPrior::of(model, *cost.capacity);
}

void CompositionProblem::reweigh(const CompositionPoint& point) {
  const ChannelErrors& errors = *cost_.channels;
  Simulation simulation(model_, point.at(inputs_.first_time));
  precision_.clear();
  for (const InputSample& sample : inputs_.samples) {
    const double over = std::clamp(sample.step.duration, kShortestReach, kLongestReach);
    const double error = simulation.follow(sample);
    const double current = sample.step.current - (sample.voltage_controlled ? error : 0.0);
    const double G = 1.0 / simulation.resistanceOver(current, over);
    const double variance = std::pow(errors.current_std, 2) + std::pow(G * errors.voltage_std, 2) +
                            std::pow(errors.current_share * sample.step.current, 2);
    precision_.push_back(
        std::isfinite(variance) ? (sample.voltage_controlled ? 1.0 : G * G) / variance : 0.0);
  }
}

double CompositionProblem::negligibleShare() const {
  return cost_.channels ? kNegligibleShare / cost_.channels->independent : kNegligibleShare;
}

double CompositionProblem::weightOf(std::size_t k) const {
  const InputSample& sample = inputs_.samples[k];
  if (cost_.channels) return precision_[k] * sample.count;
  const double W = sample.step.current < cost_.crank_weight_current ? cost_.crank_weight : 1.0;
  return W * W * sample.count;
}

bool CompositionProblem::evaluateParts(const Eigen::VectorXd& x,
                                       const std::vector<IndexRange>& parts,
                                       std::vector<NormalEquations>& equations) const {
  const Eigen::Index n = size();
  Simulation simulation(model_, pointAt(x).at(inputs_.first_time), seedsAt(x));
  using Row =
      Eigen::Array<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, Simulation::kMaxTangents + 1>;
  Whitening::Memory<Row> memory{Row::Zero(n + 1), Row::Zero(n + 1)};
  Eigen::MatrixXd rows(n + 1, kRows);
  Row row(n + 1);
  equations.clear();
  for (const IndexRange& part : parts) {
    Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(n + 1, n + 1);
    Eigen::Index filled = 0;
    double robust_excess = 0.0;
    const auto flush = [&] {
      sums.selfadjointView<Eigen::Lower>().rankUpdate(rows.leftCols(filled));
      filled = 0;
    };
    for (std::size_t k = part.first; k < part.last; ++k) {
      const InputSample& sample = inputs_.samples[k];
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
    equations.push_back(
        {sums(n, n) + robust_excess, sums.col(n).head(n), sums.topLeftCorner(n, n)});
  }
  return true;
}

bool CompositionProblem::evaluate(const Eigen::VectorXd& x, NormalEquations& equations) const {
  std::vector<NormalEquations> whole;
  if (!evaluateParts(x, {{0, inputs_.samples.size()}}, whole)) return false;
  equations = std::move(whole.front());
  if (cost_.priors) addPriors(x, equations);
  return std::isfinite(equations.cost) && equations.hessian.allFinite();
}

double CompositionProblem::costOf(std::size_t k, double residual) const {
  const double square = weightOf(k) * residual * residual;
  return cost_.channels ? robustCost(square, cost_.channels->robust) : square;
}

void CompositionProblem::addPriors(const Eigen::VectorXd& x, NormalEquations& equations) const {
  for (Eigen::Index k = 0; k < size(); ++k) {
    const double std = (*this)[k].std, away = (x[k] - (*this)[k].centre) / std;
    equations.cost += prior_weight_ * away * away;
    equations.gradient[k] += prior_weight_ * away / std;
    equations.hessian(k, k) += prior_weight_ / (std * std);
  }
  if (!of_capacity_) return;
  const auto [z, slopes] = of_capacity_->at(*this, x);
  equations.cost += prior_weight_ * z * z;
  equations.gradient += prior_weight_ * z * slopes;
  equations.hessian += prior_weight_ * slopes * slopes.transpose();
}

Eigen::MatrixXd CompositionProblem::priorInformation(const Eigen::VectorXd& x) const {
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(size(), size());
  if (!cost_.priors) return information;
  for (Eigen::Index k = 0; k < size(); ++k)
    information(k, k) = 1.0 / ((*this)[k].std * (*this)[k].std);
  if (!of_capacity_) return information;
  const Eigen::VectorXd slopes = of_capacity_->at(*this, x).slopes;
  return information + slopes * slopes.transpose();
}

Eigen::VectorXd CompositionProblem::residual(const Eigen::VectorXd& x) const {
  Simulation simulation(model_, pointAt(x).at(inputs_.first_time));
  Eigen::VectorXd e(inputs_.samples.size());
  for (std::size_t k = 0; k < inputs_.samples.size(); ++k)
    e[k] = simulation.follow(inputs_.samples[k]);
  return e;
}

ModelPass passOver(const BatteryModel& model, const InputSequence& inputs,
                   const CompositionPoint& point, const Eigen::MatrixXd& seeds) {
  Simulation simulation(model, point.at(inputs.first_time), seeds);
  const Eigen::Index count = inputs.samples.size();
  ModelPass pass{Eigen::MatrixXd(count, seeds.cols()), Eigen::VectorXd(count), seeds};
  for (Eigen::Index n = 0; n < count; ++n) {
    const InputSample& sample = inputs.samples[n];
    pass.residual[n] = simulation.follow(sample);
    pass.jacobian.row(n) = -errorDerivatives(simulation, sample).matrix();
  }
  pass.at_end.bottomRows(model.stateCount()) = simulation.stateDerivatives();
  return pass;
}

}  // namespace battery_sof
