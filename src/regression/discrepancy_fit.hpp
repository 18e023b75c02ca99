#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "model/battery_model.hpp"
#include "model/discrepancy_model.hpp"
#include "model/input_sequence.hpp"
#include "model/simulation.hpp"
#include "regression/evidence.hpp"

namespace battery_sof {

/// @return what a direction may move by beforehand: Table I's orders of magnitude, half a volt,
/// what a double layer holds.
double baseDirectionStd(Eigen::Index direction);

/**
 * @brief The residual of a base circuit, and what it could still take up of it, on a grid of rows.
 *
 *     e = u_b - u_m  where the current is the input,    e = (r + B) (i_m - i_b)  elsewhere    [V]
 *
 * with B = d u_c2 / d i of a current held over the interval: an error of the current counts as the
 * voltage that it represents. Samples less than 60 ms apart are averaged to a tenth of a second,
 * others are rows of their own.
 */
struct Linearization {
  Eigen::VectorXd time;         ///< [s], of every row
  Eigen::VectorXd error;        ///< e [V]
  Eigen::MatrixXd sensitivity;  ///< d u_m / d (the six directions), rows x kBaseDirections
  Eigen::VectorXd weight;       ///< 1: counts, 0: no measurement in it
  Eigen::VectorXd persistence;  ///< A = d u_c2 / d u_c2 of the row before [1]
  Eigen::VectorXd resistance;   ///< r + B where the voltage is the input [Ohm], 0 elsewhere
  Eigen::VectorXd yielding;     ///< B / (r + B) where the voltage is the input, else 0 [1]
  std::vector<char> voltage_controlled;
  /// where Table I expects the six directions, from where the circuit stands
  Eigen::VectorXd expected;
  /// sample with which a row begins; one more entry: the number of samples
  std::vector<std::size_t> first;
  std::vector<double> overpotential;  ///< u_c2 of every sample [V]
  /// rows that belong to the training part; later ones are only predicted
  Eigen::Index training = 0;
};

/**
 * @param model the base circuit, or a composition: its effects stay as they are, the circuit's
 * directions are free.
 * @param start its parameters and first state.  @param training samples of the inputs that may be
 * estimated from.
 */
Linearization linearizationOf(const BatteryModel& model, const ModelPoint& start,
                              const InputSequence& inputs, std::size_t training);

/// linearizationOf() with the directions of the double layer as a DiscrepancyModel carries them
/// along, so that what is estimated is what is used. The current is the input throughout.
Linearization discrepancyLinearizationOf(const BatteryModel& model, const ModelPoint& start,
                                         const InputSequence& inputs, std::size_t training);

/// @return the composition with a discrepancy, and the point with every factor as estimated.
/// @param at in the order of `model`.
BatteryModel withDiscrepancy(const BatteryModel& model,
                             std::shared_ptr<const DiscrepancyModel> discrepancy);
Eigen::VectorXd withFactors(const BatteryModel& with_discrepancy,
                            const Eigen::VectorXd& parameters);

/**
 * @brief What a discrepancy p added to the terminal voltage would do to the rows' errors.
 *
 *     e = p + A d,   d <- (1 - c) A d - c p,   c = yielding: 0 where the current is the input
 *
 * Where the voltage is controlled a discrepancy moves the current, and that the double
 * layer (d: change of u_c2).
 */
Eigen::VectorXd answered(const Linearization& response, const Eigen::VectorXd& discrepancy);

/// Regressors of a discrepancy model over the rows.
struct DesignMatrix {
  std::vector<Regressor> regressors;
  RegressorContext context;
  /// of the training part, in the regressors' units; a regressor is held inside
  Eigen::VectorXd lower, upper;
  Eigen::VectorXd centre, scale;  ///< mean and RMS about it over the training part
  /// (x - centre) / scale as the rows' errors see it, rows x regressors
  Eigen::MatrixXd values;
};

/// @return the library's regressors that move over the training part. Charge counted is not held
/// inside its range.
DesignMatrix designMatrix(const InputSequence& inputs, const Linearization& response, double beta);

/// What is held against a mechanism's regressors.
struct MechanismWeight {
  Mechanism mechanism;
  double gain = 0.0;  ///< of ln evidence along the sparse path [1]
  /// of its part of the discrepancy over the training part, the base circuit's share taken out [V]
  double rms = 0.0;
};

using RegressorFilter = std::function<bool(const Regressor&)>;

/// A fit of a discrepancy, its values in every row and how much the data support it.
struct DiscrepancyFit {
  DiscrepancyModel discrepancy;
  std::vector<MechanismWeight> mechanisms;  ///< strongest first
  double noise = 0.0;                       ///< [V], RMS of the residual over the training part
  /// of ln evidence, scaled by the fraction of the base circuit's own residual [1]: what speaks for
  /// there being any discrepancy
  double gain = 0.0;
  /// of the discrepancy over the training part, the base circuit's share taken out [V]
  double rms = 0.0;
  Eigen::VectorXd predicted;  ///< J d + X w of every row, also beyond the training part [V]
  Eigen::VectorXd base;       ///< J d' of every row, d' fitted without a discrepancy [V]
};

/**
 * @brief Estimates a discrepancy with a circuit: e = J d + X w.
 *
 * Mean of a fit with one strength a group and of a sparse one, both of greatest evidence, scaled
 * by the share of rows that count as independent (docs/diagnosis.md). The circuit stays linear in
 * its six directions. A mechanism's factor is as uncertain as the grouped fit's posterior says of
 * its part along itself.
 *
 * @param wanted regressors of the table that take part; none given: all.
 */
DiscrepancyFit fitDiscrepancy(const Linearization& response, const DesignMatrix& table,
                              const RegressorFilter& wanted = nullptr);

/// Errors on blocks of the training part, each left out of what is estimated [V, RMS over the
/// rows].
struct LeftOutErrors {
  double base = 0.0;         ///< of the composition with its circuit's directions fitted
  double discrepancy = 0.0;  ///< with a discrepancy
  double in_sample = 0.0;    ///< of the composition as it was fitted, no block left out
};

/// @param blocks consecutive ones, at least 2.
LeftOutErrors leftOutErrors(const Linearization& response, const DesignMatrix& table, int blocks,
                            const RegressorFilter& wanted = nullptr);

/// Whether a regressor has no clock of its own.
bool isTimeless(const Regressor& regressor);

}  // namespace battery_sof
