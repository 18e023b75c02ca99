#include "estimation/parameter_space.hpp"

#include <limits>
#include <stdexcept>

#include "util/text.hpp"

namespace battery_sof {
namespace {

FitCoordinate coordinateOf(const ParameterInfo& info, Eigen::Index row, double length) {
  FitCoordinate c;
  c.row = row;
  c.logarithmic = info.logarithmic;
  c.linear = info.linear;
  c.lower = info.lower;
  c.upper = info.instant ? std::clamp(length, info.lower, info.upper) : info.upper;
  if (!info.logarithmic)
    c.unit = info.magnitude != 0.0 ? std::abs(info.magnitude) : std::abs(info.upper);
  c.centre = c.of(info.magnitude);
  c.std = info.prior_std ? *info.prior_std / c.unit : std::numeric_limits<double>::infinity();
  return c;
}

}  // namespace

FitCoordinate coordinateOf(const StateInfo& info, Eigen::Index row) {
  FitCoordinate c;
  c.row = row;
  c.unit = *info.initial_std;
  c.lower = info.lower;
  c.upper = info.upper;
  c.centre = c.of(info.rest);
  return c;
}

void FitCoordinate::take(const KnownParameter& known) {
  const double at = std::clamp(known.value, lower, upper);
  centre = of(at);
  if (logarithmic)
    std = known.logarithmic ? known.std : known.std / std::abs(at);
  else
    std = (known.logarithmic ? known.std * std::abs(at) : known.std) / unit;
}

ParameterSpace::ParameterSpace(const BatteryModel& model, const CompositionPoint& start,
                               double length, const std::vector<KnownParameter>& known,
                               const std::vector<std::string>& fixed)
    : start_(start) {
  for (const std::string& name : fixed)
    if (!model.parameterRow(name))
      throw std::invalid_argument("parameter \"" + name + "\" is not one of the composition's");
  for (Eigen::Index j = 0; j < model.parameterCount(); ++j) {
    const ParameterInfo& info = model.parameters()[j];
    if (info.held || contains(fixed, info.name)) continue;
    coordinates_.push_back(coordinateOf(info, j, length));
    if (const KnownParameter* one = find(known, info.name)) coordinates_.back().take(*one);
  }
  for (Eigen::Index j = 0; j < model.stateCount(); ++j) {
    const StateInfo& info = model.states()[j];
    if (info.initial_std) coordinates_.push_back(coordinateOf(info, model.parameterCount() + j));
    if (info.begins_as_u_c2) as_u_c2_.push_back(j);
  }
  if (size() > Simulation::kMaxTangents)
    throw std::invalid_argument(
        format("the composition has %td unknowns, at most %td can be fitted at once", size(),
               Simulation::kMaxTangents));
  lower_.resize(size());
  upper_.resize(size());
  for (Eigen::Index k = 0; k < size(); ++k) {
    lower_[k] = (*this)[k].of((*this)[k].lower);
    upper_[k] = (*this)[k].of((*this)[k].upper);
  }
}

Eigen::VectorXd ParameterSpace::coordinatesOf(const CompositionPoint& point) const {
  Eigen::VectorXd x(size());
  for (Eigen::Index k = 0; k < size(); ++k) x[k] = (*this)[k].of(point[rowOf(k)]);
  return x.cwiseMax(lower_).cwiseMin(upper_);
}

CompositionPoint ParameterSpace::pointAt(const Eigen::VectorXd& x) const {
  CompositionPoint point = start_;
  for (Eigen::Index k = 0; k < size(); ++k) point[rowOf(k)] = (*this)[k].value(x[k]);
  for (const Eigen::Index j : as_u_c2_) point.state[j] = point.state[0];
  return point;
}

Eigen::MatrixXd ParameterSpace::seedsAt(const Eigen::VectorXd& x) const {
  const Eigen::Index parameters = start_.parameters.size();
  Eigen::MatrixXd seeds = Eigen::MatrixXd::Zero(parameters + start_.state.size(), size());
  for (Eigen::Index k = 0; k < size(); ++k)
    seeds(rowOf(k), k) = (*this)[k].slope((*this)[k].value(x[k]));
  for (const Eigen::Index j : as_u_c2_) seeds.row(parameters + j) = seeds.row(parameters);
  return seeds;
}

}  // namespace battery_sof
