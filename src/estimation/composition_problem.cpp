#include "estimation/composition_fit.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "util/text.hpp"

namespace battery_sof {
namespace {

// What a prior weighs without a noise model: 10 mV of error, correlated over 5 s (as
// windowExcitation()).
constexpr double kPriorError = 0.01;       // [V]
constexpr double kPriorCorrelation = 5.0;  // [s]
// [s], over which a current is held for its conditioning: a sample's interval, within what the
// double layer makes of it.
constexpr double kShortestReach = 0.1, kLongestReach = 60.0;
constexpr Eigen::Index kRows = 64;  // of the Jacobian held at a time

void requireKnown(const BatteryModel& model, const std::vector<std::string>& names) {
  for (const std::string& name : names)
    if (!model.parameterRow(name))
      throw std::invalid_argument("parameter \"" + name + "\" is not one of the composition's");
}

double meanInterval(const InputSequence& inputs) {
  double count = 0.0;
  for (const InputSample& sample : inputs.samples) count += sample.count;
  const double span = inputs.samples.back().step.time - inputs.samples.front().step.time;
  return count > 1.0 ? span / (count - 1.0) : 0.0;
}

/// Weighs a row (Jacobian, residual last, in sigmas) by rho. @return rho(z) less the square
/// that is then summed.
template <typename Row>
double makeRobust(Row& row, double k) {
  const double z = row[row.size() - 1] / k;
  const double root = std::sqrt(1.0 + z * z);
  row *= 1.0 / std::sqrt(root);
  return 2.0 * k * k * (root - 1.0) - k * k * z * z / root;
}

/// d error / d tangent of Simulation::follow().
Eigen::Array<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, Simulation::kMaxTangents>
errorDerivatives(const Simulation& simulation, const InputSample& sample) {
  if (sample.voltage_controlled) return simulation.currentErrorDerivatives().transpose().array();
  return -simulation.voltageDerivatives().transpose().array();
}

}  // namespace

CompositionProblem::CompositionProblem(const BatteryModel& model, const InputSequence& inputs,
                                       const FitCost& cost, const CompositionPoint& start,
                                       const std::vector<std::string>& free,
                                       const std::vector<std::string>& fixed)
    : model_(model), inputs_(inputs), cost_(cost), start_(start) {
  requireKnown(model, free);
  requireKnown(model, fixed);
  if (inputs.samples.empty()) throw std::invalid_argument("the input sequence has no sample");
  for (Eigen::Index j = 0; j < model.parameterCount(); ++j) {
    const ParameterInfo& info = model.parameters()[static_cast<std::size_t>(j)];
    if ((!info.held || contains(free, info.name)) && !contains(fixed, info.name))
      addParameter(j, info);
  }
  for (Eigen::Index j = 0; j < model.stateCount(); ++j)
    if (model.states()[static_cast<std::size_t>(j)].initial_std)
      addState(model.parameterCount() + j, model.states()[static_cast<std::size_t>(j)]);
  if (size() > Simulation::kMaxTangents)
    throw std::invalid_argument("the composition has " + std::to_string(size()) +
                                " unknowns, at most " + std::to_string(Simulation::kMaxTangents) +
                                " can be fitted at once");
  if (cost.noise) {
    whitening_.emplace(*cost.noise, inputs.samples);
  } else if (cost.channels) {
    prior_weight_ = 1.0 / cost.channels->independent;
    reweigh(start);
  } else {
    const double interval = meanInterval(inputs);
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
  takeKnown(info, coordinate);
  coordinates_.push_back(coordinate);
  // A current that answers to a voltage is linear in nothing.
  linear_.push_back(info.linear && !cost_.channels);
  lower_.conservativeResize(size());
  upper_.conservativeResize(size());
  const double length = inputs_.samples.back().step.time - inputs_.first_time;
  lower_[size() - 1] = in(info.lower);
  upper_[size() - 1] = in(info.instant ? std::clamp(length, info.lower, info.upper) : info.upper);
}

/// A spread of logarithms is taken for that share of the value, and the other way round, where the
/// search has other coordinates.
void CompositionProblem::takeKnown(const ParameterInfo& info, Coordinate& coordinate) const {
  const KnownParameter* known = find(cost_.known, info.name);
  if (!known) return;
  const double value = std::clamp(known->value, info.lower, info.upper);
  if (info.logarithmic) {
    coordinate.prior_mean = std::log(value);
    coordinate.prior_std = known->logarithmic ? known->std : known->std / std::abs(value);
  } else {
    coordinate.prior_mean = value / coordinate.scale;
    coordinate.prior_std =
        (known->logarithmic ? known->std * std::abs(value) : known->std) / coordinate.scale;
  }
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
    if (model_.states()[static_cast<std::size_t>(j)].begins_as_u_c2)
      point.state[j] = point.state[0];
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
  Simulation simulation(model_,
                        {point.parameters, point.state, inputs_.first_time, inputs_.first_time});
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

bool CompositionProblem::evaluate(const Eigen::VectorXd& x, NormalEquations& equations) const {
  const CompositionPoint point = pointAt(x);
  const Eigen::Index n = size();
  Simulation simulation(
      model_, {point.parameters, point.state, inputs_.first_time, inputs_.first_time}, seedsAt(x));
  using Row =
      Eigen::Array<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, Simulation::kMaxTangents + 1>;
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
  for (std::size_t k = 0; k < inputs_.samples.size(); ++k) {
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
  Simulation simulation(model_,
                        {point.parameters, point.state, inputs_.first_time, inputs_.first_time});
  Eigen::VectorXd e(static_cast<Eigen::Index>(inputs_.samples.size()));
  for (std::size_t k = 0; k < inputs_.samples.size(); ++k) {
    e[static_cast<Eigen::Index>(k)] = simulation.follow(inputs_.samples[k]);
  }
  return e;
}

}  // namespace battery_sof
