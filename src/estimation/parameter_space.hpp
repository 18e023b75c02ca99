#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "model/simulation.hpp"
#include "state/posterior.hpp"

namespace battery_sof {

/// A parameter or first state as it is searched: its logarithm, or the multiple of a unit from where
/// it vanishes.
struct FitCoordinate {
  Eigen::Index row = 0;  ///< of (parameters, states)
  bool logarithmic = false, strength = false, instant = false;
  bool linear = false;  ///< the voltage is linear in it while the others stay
  double zero = 0.0, unit = 1.0, lower = -1e300, upper = 1e300;  ///< in the parameter's unit
  /// of what is known beforehand, in coordinates; std infinite: nothing
  double centre = 0.0, std = 1.0;

  double of(double value) const { return logarithmic ? std::log(value) : (value - zero) / unit; }
  double value(double x) const {
    return std::clamp(logarithmic ? std::exp(x) : zero + unit * x, lower, upper);
  }
  double slope(double value) const { return logarithmic ? value : unit; }  ///< d value / d x
  /// In place of the catalogue's prior; a spread of logarithms is taken for that share of the value,
  /// and the other way round, where the search has other coordinates.
  void take(const KnownParameter& known);
};

/// @return a first state's, its rest expected.
FitCoordinate coordinateOf(const StateInfo& info, Eigen::Index row);

/// Parameters and first states of a composition.
struct CompositionPoint {
  Eigen::VectorXd parameters;  ///< in the order of BatteryModel::parameters()
  /// at the first sample, in the order of BatteryModel::states()
  Eigen::VectorXd state;

  /// @param row of the parameters, or of the states behind them.
  double& operator[](Eigen::Index row) {
    return row < parameters.size() ? parameters[row] : state[row - parameters.size()];
  }
  double operator[](Eigen::Index row) const {
    return row < parameters.size() ? parameters[row] : state[row - parameters.size()];
  }
  /// Where a simulation begins with it. @param time [s], of the first sample.
  ModelPoint at(double time) const { return {parameters, state, time, time}; }
};

/**
 * @brief The coordinates that a composition is fitted in: its free parameters (logarithms where
 * ParameterInfo says so, else in units of their magnitude), then the first states that are estimated.
 * What is not among them stays at the start.
 */
class ParameterSpace {
 public:
  /**
   * @param length of the recording [s], the upper bound of instants.
   * @param known priors in place of the catalogue's.
   * @param fixed names of parameters that stay at `start`.
   * @throws std::invalid_argument for unknown names, or more than Simulation::kMaxTangents
   * coordinates.
   */
  ParameterSpace(const BatteryModel& model, const CompositionPoint& start, double length,
                 const std::vector<KnownParameter>& known,
                 const std::vector<std::string>& fixed = {});

  Eigen::Index size() const { return static_cast<Eigen::Index>(coordinates_.size()); }
  const FitCoordinate& operator[](Eigen::Index k) const { return coordinates_[k]; }
  /// Row of the parameter vector, or of the state vector behind it, that a coordinate moves.
  Eigen::Index rowOf(Eigen::Index coordinate) const { return (*this)[coordinate].row; }
  const Eigen::VectorXd& lower() const { return lower_; }
  const Eigen::VectorXd& upper() const { return upper_; }

  Eigen::VectorXd coordinatesOf(const CompositionPoint& point) const;
  CompositionPoint pointAt(const Eigen::VectorXd& x) const;
  /// d(parameters, first state) / d(coordinates) at x.
  Eigen::MatrixXd seedsAt(const Eigen::VectorXd& x) const;

 protected:
  std::vector<FitCoordinate> coordinates_;

 private:
  CompositionPoint start_;
  std::vector<Eigen::Index> as_u_c2_;  // states that begin at u_c2's first value
  Eigen::VectorXd lower_, upper_;
};

}  // namespace battery_sof
