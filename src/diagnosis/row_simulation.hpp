#pragma once

#include <Eigen/Core>
#include <vector>

#include "estimation/composition_fit.hpp"
#include "model/battery_model.hpp"
#include "model/input_sequence.hpp"
#include "regression/discrepancy_fit.hpp"

namespace battery_sof {

/// What a composition leaves of the rows, in volts as in Linearization.
struct RowErrors {
  /// measured less modelled, one a row [V]; empty where the model has no finite voltage
  Eigen::VectorXd error;
  Eigen::MatrixXd sensitivity;  ///< - d error / d tangent, rows x tangents
};

/**
 * @brief Compositions simulated over the rows of a base response.
 *
 * Simulated under the rows' mean currents; what acts at edges at full rate in rows whose current
 * moves. What that leaves of the full rate is taken from the base circuit once and added: an effect
 * is not worth more for being simulated more finely. Where the voltage is the input, an error of
 * the current counts as the voltage that it represents in the base circuit.
 */
class RowSimulation {
 public:
  /// Both must outlive this. @param response of the whole sequence.
  RowSimulation(const InputSequence& inputs, const Linearization& response,
                const CompositionPoint& base);

  /// @param seeds d(parameters, first state) / d(tangent), as Simulation takes them; no columns
  /// for errors alone.
  RowErrors errors(const BatteryModel& model, const CompositionPoint& point,
                   const Eigen::MatrixXd& seeds = {}) const;

  /// mean [A]
  double currentOf(Eigen::Index row) const { return rows_.inputs.samples[row].step.current; }

 private:
  struct Grid {
    InputSequence inputs;
    std::vector<Eigen::Index> row;  // of every sample
    // the base circuit's error at full rate less that on this grid [V]
    Eigen::VectorXd coarseness;
  };
  Grid gridOf(const InputSequence& inputs, bool fine_at_edges) const;
  RowErrors simulated(const Grid& grid, const BatteryModel& model, const CompositionPoint& point,
                      const Eigen::MatrixXd& seeds) const;

  const Linearization& response_;
  Grid rows_, edges_;
};

}  // namespace battery_sof
