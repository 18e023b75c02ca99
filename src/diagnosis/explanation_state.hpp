#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "diagnosis/row_simulation.hpp"
#include "estimation/parameter_space.hpp"
#include "model/battery_model.hpp"
#include "model/effect.hpp"
#include "model/mechanism.hpp"
#include "regression/evidence.hpp"

namespace battery_sof {

constexpr double kWideStrength = 2.0;  // standard deviation of a strength, in magnitudes

/// Coordinate of a parameter of an effect, of the base circuit, and of a first state. @param span
/// of the recording [s].
/// @param start value that the base circuit's fit has there [V].
FitCoordinate effectCoordinate(const ParameterInfo& info, Eigen::Index row, double span);
FitCoordinate baseCoordinate(const ParameterInfo& info, Eigen::Index row, double start);
FitCoordinate stateCoordinate(const StateInfo& info, Eigen::Index row, double start);

/// A composition somewhere, with what it leaves of the counted rows, and the mechanisms whose
/// regressors are added to it.
struct ExplanationState {
  BatteryModel model = BatteryModel();
  CompositionPoint point;
  std::vector<FitCoordinate> coordinates;
  Eigen::VectorXd error;
  Eigen::MatrixXd sensitivity;
  std::set<Mechanism> estimated;
  std::vector<std::string> members;  // named ones, without what they need
  LinearFit fit;
  double evidence = -std::numeric_limits<double>::infinity();
  double structure_gain = 0.0;            // of ln evidence, by the structure taken in
  std::map<Mechanism, double> explained;  // [V], by the mechanisms taken in
};

/// What an effect adds to the base circuit at one point of its grid.
struct EffectGridPoint {
  std::string id;
  CompositionPoint point;  // of the base circuit with it
  bool one_sided;
  Eigen::VectorXd added;  // counted rows [V]
};

/// @return a composition with one effect more, and what that one needs.
BatteryModel enlarged(const BatteryModel& model, const std::string& id);

/// @return ids that a diagnosis weighs: those asked for, else all of the catalogue; what is weighed
/// on request alone takes part where a source controls the voltage, which is what it is for.
std::vector<std::string> hypothesesOf(const std::vector<std::string>& asked,
                                      bool voltage_controlled);

}  // namespace battery_sof
