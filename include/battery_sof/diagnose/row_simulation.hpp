#pragma once

#include <Eigen/Core>
#include <vector>

#include "battery_sof/identify/composition_fit.hpp"
#include "battery_sof/learn/learned_force.hpp"
#include "battery_sof/model/battery_model.hpp"
#include "battery_sof/model/drive.hpp"

namespace battery_sof {

/// What a composition leaves of the rows, in volts as in BaseResponse.
struct RowErrors {
  Eigen::VectorXd error;        ///< measured less modelled, one a row [V]; empty where the model has no finite voltage
  Eigen::MatrixXd sensitivity;  ///< - d error / d lane, rows x lanes
};

/**
 * @brief Compositions simulated over the rows of a base response.
 *
 * What acts at edges is simulated at full rate and averaged; everything else under the rows' mean currents. Where the voltage
 * drives, an error of the current counts as the voltage that it stands for beside the base circuit.
 */
class RowSimulation {
 public:
  /// Both must outlive this.
  RowSimulation(const Drive& drive, const BaseResponse& response);

  /// @param seeds d(parameters, first state) / d(lane), as Simulation takes them; no columns for errors alone.
  RowErrors errors(const BatteryModel& model, const CompositionPoint& point, const Eigen::MatrixXd& seeds = {}) const;

 private:
  const Drive& drive_;
  const BaseResponse& response_;
  Drive rows_;  // the rows' mean currents and voltages
};

}  // namespace battery_sof
