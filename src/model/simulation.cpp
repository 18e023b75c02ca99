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
  requireSound(model, start, seeds);
  const Eigen::Index tangents = seeds.cols();
  if (tangents == 0) return engineOf<0>(model, start, seeds);
  if (tangents <= 8) return engineOf<8>(model, start, seeds);
  if (tangents <= 16) return engineOf<16>(model, start, seeds);
  if (tangents <= 24) return engineOf<24>(model, start, seeds);
  return engineOf<48>(model, start, seeds);
}

}  // namespace

Simulation::Simulation(const BatteryModel& model, const ModelPoint& start,
                       const Eigen::Ref<const Eigen::MatrixXd>& seeds)
    : engine_(engineFor(model, start, seeds)) {}

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

}  // namespace battery_sof
