#pragma once

#include <memory>
#include <vector>

#include "model/simulation.hpp"

namespace battery_sof {

/// What a Simulation is in one of its arithmetics.
class Simulation::Engine {
 public:
  virtual ~Engine() = default;
  virtual std::unique_ptr<Engine> clone() const = 0;
  virtual void advance(const InputStep& step) = 0;
  virtual double advanceAtVoltage(double voltage, double duration, double max_current) = 0;
  virtual void followVoltage(const InputStep& step, double voltage) = 0;
  virtual double resistanceOver(double current, double duration) = 0;
  virtual double currentError() const = 0;
  virtual const double* currentErrorDerivatives() const = 0;
  virtual double voltage() const = 0;
  virtual const double* voltageDerivatives() const = 0;
  virtual const double* currentDerivatives() const = 0;
  virtual double time() const = 0;
  virtual Eigen::VectorXd state() const = 0;
  virtual Eigen::MatrixXd stateDerivatives() const = 0;
  virtual std::vector<double> regressorMemory() const = 0;
  virtual double beyondIdentified() const = 0;
  virtual Eigen::Index tangents() const = 0;
};

/**
 * @brief A simulation in one arithmetic: N tangents, 0 for values alone.
 *
 * One file each (engine_of_*.cpp): a compiler inlines less where a file grows too large, and these
 * steps are where the time goes.
 *
 * @param seeds at most as many columns.
 */
template <int N>
std::unique_ptr<Simulation::Engine> engineOf(const BatteryModel& model, const ModelPoint& start,
                                             const Eigen::Ref<const Eigen::MatrixXd>& seeds);

}  // namespace battery_sof
