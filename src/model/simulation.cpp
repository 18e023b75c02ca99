#include "battery_sof/model/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "battery_sof/recording/number_text.hpp"
#include "engine_choice.hpp"

namespace battery_sof {
namespace {

void requireFinite(const Eigen::VectorXd& values, const char* what) {
  for (Eigen::Index j = 0; j < values.size(); ++j)
    if (!std::isfinite(values[j])) {
      ClassicStream text;
      text << what << " " << j << " is " << values[j] << ", expected a finite number";
      throw std::invalid_argument(text.str());
    }
}

void requireSize(Eigen::Index size, Eigen::Index expected, const char* what) {
  if (size == expected) return;
  ClassicStream text;
  text << what << ": " << size << " given, the composition has " << expected;
  throw std::invalid_argument(text.str());
}

void requireSound(const BatteryModel& model, const ModelPoint& start, const Eigen::Ref<const Eigen::MatrixXd>& seeds) {
  requireSize(start.parameters.size(), model.parameterCount(), "parameters");
  requireSize(start.state.size(), model.stateCount(), "states");
  requireFinite(start.parameters, "parameter");
  requireFinite(start.state, "state");
  requireValid(baseParameters(start.parameters));
  if (seeds.cols() == 0) return;
  requireSize(seeds.rows(), model.parameterCount() + model.stateCount(), "rows of seeds");
  if (seeds.cols() > Simulation::kMaxLanes)
    throw std::invalid_argument("seeds have " + std::to_string(seeds.cols()) + " columns, expected at most " +
                                std::to_string(Simulation::kMaxLanes));
}

std::unique_ptr<Simulation::Engine> engineFor(const BatteryModel& model, const ModelPoint& start,
                                              const Eigen::Ref<const Eigen::MatrixXd>& seeds) {
  const Eigen::Index lanes = seeds.cols();
  if (lanes == 0) return engineOfValues(model, start, seeds);
  if (lanes <= 8) return engineOf8(model, start, seeds);
  if (lanes <= 16) return engineOf16(model, start, seeds);
  if (lanes <= 24) return engineOf24(model, start, seeds);
  return engineOf48(model, start, seeds);
}

}  // namespace

Simulation::Simulation(const BatteryModel& model, const ModelPoint& start, const Eigen::Ref<const Eigen::MatrixXd>& seeds) {
  requireSound(model, start, seeds);
  engine_ = engineFor(model, start, seeds);
}

Simulation::Simulation(const BatteryModel& model, const ModelPoint& start) : Simulation(model, start, Eigen::MatrixXd()) {}

Simulation::Simulation(const Simulation& other) : engine_(other.engine_->clone()) {}

Simulation& Simulation::operator=(const Simulation& other) {
  if (this != &other) engine_ = other.engine_->clone();
  return *this;
}

Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;
Simulation::~Simulation() = default;

void Simulation::advance(const DriveStep& step) { engine_->advance(step); }

double Simulation::advanceAtVoltage(double voltage, double duration, double most_current) {
  if (!std::isfinite(voltage) || !std::isfinite(most_current) || !(duration > 0.0)) {
    ClassicStream text;
    text << "advanceAtVoltage(" << voltage << " V, " << duration << " s, " << most_current
         << " A): expected finite values and a duration above 0";
    throw std::invalid_argument(text.str());
  }
  return engine_->advanceAtVoltage(voltage, duration, most_current);
}

void Simulation::followVoltage(const DriveStep& step, double voltage) {
  if (!std::isfinite(voltage)) throw std::invalid_argument("followVoltage: the voltage is not finite");
  engine_->followVoltage(step, voltage);
}
double Simulation::follow(const DriveSample& sample) {
  if (sample.voltage_drives) {
    followVoltage(sample.step, sample.voltage);
    return currentError();
  }
  advance(sample.step);
  return sample.voltage - voltage();
}
double Simulation::resistanceOver(double current, double duration) { return engine_->resistanceOver(current, duration); }
double Simulation::currentError() const { return engine_->currentError(); }
Eigen::Map<const Eigen::VectorXd> Simulation::currentErrorDerivatives() const {
  return {engine_->currentErrorDerivatives(), engine_->lanes()};
}

double Simulation::voltage() const { return engine_->voltage(); }
Eigen::Map<const Eigen::VectorXd> Simulation::voltageDerivatives() const { return {engine_->voltageDerivatives(), engine_->lanes()}; }
Eigen::Map<const Eigen::VectorXd> Simulation::currentDerivatives() const { return {engine_->currentDerivatives(), engine_->lanes()}; }
double Simulation::time() const { return engine_->time(); }
Eigen::VectorXd Simulation::state() const { return engine_->state(); }
Eigen::MatrixXd Simulation::stateDerivatives() const { return engine_->stateDerivatives(); }
std::vector<double> Simulation::forceMemory() const { return engine_->forceMemory(); }
double Simulation::beyondLearned() const { return engine_->beyondLearned(); }
Eigen::Index Simulation::lanes() const { return engine_->lanes(); }

}  // namespace battery_sof
