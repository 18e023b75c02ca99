#include "model/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "engine_choice.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

void requireFinite(const Eigen::VectorXd& values, const char* what) {
  for (Eigen::Index j = 0; j < values.size(); ++j)
    requireThat(true, what + std::to_string(j), values[j], "a finite number");
}

void requireSize(Eigen::Index size, Eigen::Index expected, const char* what) {
  if (size == expected) return;
  throw std::invalid_argument(
      format("%s: %td given, the composition has %td", what, size, expected));
}

void requireSound(const BatteryModel& model, const ModelPoint& start,
                  const Eigen::Ref<const Eigen::MatrixXd>& seeds) {
  requireSize(start.parameters.size(), model.parameterCount(), "parameters");
  requireSize(start.state.size(), model.stateCount(), "states");
  requireFinite(start.parameters, "parameter ");
  requireFinite(start.state, "state ");
  requireValid(baseParameters(start.parameters));
  if (seeds.cols() == 0) return;
  requireSize(seeds.rows(), model.parameterCount() + model.stateCount(), "rows of seeds");
  if (seeds.cols() > Simulation::kMaxTangents)
    throw std::invalid_argument("seeds have " + std::to_string(seeds.cols()) +
                                " columns, expected at most " +
                                std::to_string(Simulation::kMaxTangents));
}

std::unique_ptr<Simulation::Engine> engineFor(const BatteryModel& model, const ModelPoint& start,
                                              const Eigen::Ref<const Eigen::MatrixXd>& seeds) {
  const Eigen::Index tangents = seeds.cols();
  if (tangents == 0) return engineOf<0>(model, start, seeds);
  if (tangents <= 8) return engineOf<8>(model, start, seeds);
  if (tangents <= 16) return engineOf<16>(model, start, seeds);
  if (tangents <= 24) return engineOf<24>(model, start, seeds);
  return engineOf<48>(model, start, seeds);
}

}  // namespace

Simulation::Simulation(const BatteryModel& model, const ModelPoint& start,
                       const Eigen::Ref<const Eigen::MatrixXd>& seeds) {
  requireSound(model, start, seeds);
  engine_ = engineFor(model, start, seeds);
}

Simulation::Simulation(const Simulation& other) : engine_(other.engine_->clone()) {}

Simulation& Simulation::operator=(const Simulation& other) {
  if (this != &other) engine_ = other.engine_->clone();
  return *this;
}

Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;
Simulation::~Simulation() = default;

void Simulation::advance(const InputStep& step) { engine_->advance(step); }

void Simulation::hold(double current, double duration) {
  InputStep step;
  step.duration = duration;
  step.time = time() + duration;
  step.held = step.current = current;
  advance(step);
}

double Simulation::advanceAtVoltage(double voltage, double duration, double max_current) {
  if (!std::isfinite(voltage) || !std::isfinite(max_current) || !(duration > 0.0))
    throw std::invalid_argument(
        format("advanceAtVoltage(%g V, %g s, %g A): expected finite values and a duration above 0",
               voltage, duration, max_current));
  return engine_->advanceAtVoltage(voltage, duration, max_current);
}

void Simulation::followVoltage(const InputStep& step, double voltage) {
  if (!std::isfinite(voltage))
    throw std::invalid_argument("followVoltage: the voltage is not finite");
  engine_->followVoltage(step, voltage);
}
double Simulation::follow(const InputSample& sample) {
  if (sample.voltage_controlled) {
    followVoltage(sample.step, sample.voltage);
    return currentError();
  }
  advance(sample.step);
  return sample.voltage - voltage();
}
double Simulation::resistanceOver(double current, double duration) {
  return engine_->resistanceOver(current, duration);
}
double Simulation::currentError() const { return engine_->currentError(); }
Eigen::Map<const Eigen::VectorXd> Simulation::currentErrorDerivatives() const {
  return {engine_->currentErrorDerivatives(), engine_->tangents()};
}

double Simulation::voltage() const { return engine_->voltage(); }
Eigen::Map<const Eigen::VectorXd> Simulation::voltageDerivatives() const {
  return {engine_->voltageDerivatives(), engine_->tangents()};
}
Eigen::Map<const Eigen::VectorXd> Simulation::currentDerivatives() const {
  return {engine_->currentDerivatives(), engine_->tangents()};
}
double Simulation::time() const { return engine_->time(); }
Eigen::VectorXd Simulation::state() const { return engine_->state(); }
Eigen::MatrixXd Simulation::stateDerivatives() const { return engine_->stateDerivatives(); }
std::vector<double> Simulation::regressorMemory() const { return engine_->regressorMemory(); }
double Simulation::beyondIdentified() const { return engine_->beyondIdentified(); }
Eigen::Index Simulation::tangents() const { return engine_->tangents(); }

}  // namespace battery_sof
