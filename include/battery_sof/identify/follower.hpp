#pragma once

#include <optional>

#include "battery_sof/identify/fitted_model.hpp"
#include "battery_sof/identify/learned_residual.hpp"

namespace battery_sof {

/// One sample as a model followed it.
struct FollowedSample {
  bool voltage_drives = false;
  double voltage = 0.0;        ///< [V], modelled; imposed where the voltage drives
  double current = 0.0;        ///< [A], modelled; measured where the current drives
  double physics_error = 0.0;  ///< [A] or [V], measured less what the equations say
  double learned = 0.0;        ///< [A] or [V], what LearnedResidual adds to them
  double variance = 0.0;       ///< [A^2] or [V^2], by the parameters and the state; 0 without lanes
  Eigen::VectorXd columns;     ///< of LearnedResidual
};

/**
 * @brief A model that goes along with a drive in the direction that is imposed: equations, what was learnt beside them, and
 * the memory that needs.
 */
class Follower {
 public:
  /// From the model's saved state. @param uncertain carries the covariance's directions along.
  explicit Follower(const FittedModel& model, bool uncertain = false);
  /// From any simulation, with nothing learnt yet.
  explicit Follower(Simulation simulation) : simulation_(std::move(simulation)) {}

  FollowedSample follow(const DriveSample& sample);

  const Simulation& simulation() const { return simulation_; }
  const DriveMemory& memory() const { return memory_; }

 private:
  Simulation simulation_;
  DriveMemory memory_;
  LearnedResidual learned_;
};

/// @return a stretch of a recording as a model is driven through it: by the voltage where its source imposes that.
Drive driveOf(const Fit& fit, const Series& series, IndexRange range);

/// Puts a follower's state, its covariance and its memory into the model it was begun with.
void takeState(FittedModel& model, const Follower& follower, double current);

}  // namespace battery_sof
