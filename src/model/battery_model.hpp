#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "model/discrepancy_model.hpp"
#include "model/effect.hpp"

namespace battery_sof {

/// Rows of a parameter vector that every composition begins with.
enum BaseRow { kRowRDischarge, kRowRCharge, kRowC2, kRowBeta, kRowUDc, kBaseRows };

/**
 * @brief The base model composed with any set of effects: which parameters and states there are,
 * and in which order.
 *
 * Parameters: r_discharge, r_charge, c2, beta, u_dc, then those of every effect in catalogue order.
 * States: u_c2, then those of every effect in the same order. All in SI units but for charges,
 * which are in Ah.
 */
class BatteryModel {
 public:
  /// @param effects ids in any order; kDiscrepancyEffect with its discrepancy model.
  /// @throws std::invalid_argument for an unknown id, one given twice, one whose needs are not
  /// among them, kDiscrepancyEffect without a
  ///   discrepancy model or the other way round; the message says which and what is known.
  explicit BatteryModel(const std::vector<std::string>& effects = {},
                        std::shared_ptr<const DiscrepancyModel> discrepancy = nullptr);

  const std::vector<std::string>& effects() const { return effects_; }  ///< in catalogue order
  const std::vector<ParameterInfo>& parameters() const { return parameters_; }
  const std::vector<StateInfo>& states() const { return states_; }
  Eigen::Index parameterCount() const { return static_cast<Eigen::Index>(parameters_.size()); }
  Eigen::Index stateCount() const { return static_cast<Eigen::Index>(states_.size()); }

  /// @return row of a parameter; none when the composition does not have it.
  std::optional<Eigen::Index> parameterRow(const std::string& name) const;

  /// @return every parameter at its order of magnitude.
  Eigen::VectorXd typicalParameters() const;
  /// @return every state of a battery at rest.
  Eigen::VectorXd restState() const;

  /// The discrepancy model; none without kDiscrepancyEffect.
  const std::shared_ptr<const DiscrepancyModel>& discrepancy() const { return discrepancy_; }

  /// First row of an effect's parameters and of its states, by position in effects().
  Eigen::Index firstParameter(std::size_t effect) const { return first_parameter_[effect]; }
  Eigen::Index firstState(std::size_t effect) const { return first_state_[effect]; }

 private:
  std::vector<std::string> effects_;
  std::shared_ptr<const DiscrepancyModel> discrepancy_;
  std::vector<ParameterInfo> parameters_;
  std::vector<StateInfo> states_;
  std::vector<Eigen::Index> first_parameter_, first_state_;
};

/// @return the base part of a parameter vector; i0 = 1 A and alpha = 0.5.
BaseParameters baseParameters(const Eigen::VectorXd& parameters);

}  // namespace battery_sof
