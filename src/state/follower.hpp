#pragma once

#include <optional>

#include "regression/residual_regression.hpp"
#include "state/fitted_model.hpp"

namespace battery_sof {

/// One sample as a model followed it.
struct FollowedSample {
  bool voltage_controlled = false;
  double voltage = 0.0;                ///< [V], modelled; measured where it is the input
  double current = 0.0;                ///< [A], modelled; measured where it is the input
  double physics_error = 0.0;          ///< [A] or [V], measured less what the equations say
  double regression_correction = 0.0;  ///< [A] or [V], what ResidualRegression adds to them
  double variance = 0.0;    ///< [A^2] or [V^2], by the parameters and the state; 0 without tangents
  Eigen::VectorXd columns;  ///< of ResidualRegression
};

/**
 * @brief A model that follows an input sequence in its operating mode: equations, residual
 * regression and discrepancy, and their memories.
 */
class Follower {
 public:
  /// From the model's saved state. @param uncertain carries the covariance's directions along.
  explicit Follower(const FittedModel& model, bool uncertain = false);
  /// From any simulation, with nothing estimated yet.
  explicit Follower(Simulation simulation) : simulation_(std::move(simulation)) {}

  FollowedSample follow(const InputSample& sample);

  const Simulation& simulation() const { return simulation_; }
  const InputMemory& memory() const { return memory_; }

 private:
  Simulation simulation_;
  InputMemory memory_;
  ResidualRegression residual_regression_;
};

/// @return a stretch of a recording as a model is driven through it: by the voltage where its
/// source controls that.
InputSequence inputsOf(const Fit& fit, const Series& series, IndexRange range);

/// Puts a follower's state, its covariance and its memory into the model it was begun with.
void takeState(FittedModel& model, const Follower& follower, double current);

}  // namespace battery_sof
