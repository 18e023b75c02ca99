#include "model/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "stepper.hpp"
#include "util/text.hpp"
#include "voltage_source.hpp"

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

using BoundModel = std::shared_ptr<const BoundComposition>;

/// A simulation in one arithmetic.
template <typename S>
class EngineOf final : public Simulation::Engine {
  using Derivatives = Simulation::Derivatives;

 public:
  EngineOf(const BoundModel& bound, const ModelPoint& start,
           const Eigen::Ref<const Eigen::MatrixXd>& seeds)
      : order_(bound->tangentOrder(seeds)), battery_(bound, start, seeds(Eigen::all, order_)) {}
  std::unique_ptr<Engine> clone() const override { return std::make_unique<EngineOf>(*this); }

  void advance(const InputStep& step) override {
    S held(step.held), end(step.current);
    battery_.effects().sense(step, held, end);
    SteadyCurrent& steady = battery_.now.steady;
    steady.begin(step.held);
    battery_.pass(held, end, step.duration, step.slope, step.time,
                  {S(step.held), S(step.current), step.gap}, step.rampPieces());
    steady.duration += step.duration;
    source_.forgetTrend();
  }

  double advanceAtVoltage(double voltage, double duration, double max_current) override {
    battery_.now.steady = {};
    return advanceTo(S(voltage), duration, max_current);
  }

  void followVoltage(const InputStep& step, double voltage) override {
    S held(step.held), shown(step.current);
    battery_.effects().sense(step, held, shown);
    battery_.now.steady = {};
    if (step.duration <= 0.0) {
      battery_.pass(held, shown, 0.0, 0.0, step.time);
      source_.current = shown;
      current_error_ = S(0.0);
      return;
    }
    if (step.missed > 0.0) battery_.discharge(step.missed);
    const double ramp = step.gap ? std::min(step.duration, kRampAfterGap) : step.duration;
    if (ramp < step.duration) {
      battery_.pass(S(0.0), S(0.0), step.duration - ramp, 0.0, step.time - ramp);
      source_.current = S(0.0);
      source_.forgetTrend();
    }
    // Before its first step a simulation has shown no voltage to ramp from.
    const S& shown_last = battery_.now.terminal;
    const S from = valueOf(shown_last) != 0.0 ? shown_last : S(voltage);
    const int parts =
        static_cast<int>(std::clamp(std::ceil(ramp / kLongestHold - 1e-9), 1.0, kMaxHolds));
    const double count = parts;
    for (int k = 1; k <= parts; ++k)
      advanceTo(S(from + (voltage - from) * (k / count)), ramp / count, kMaxCurrent);
    battery_.now.time = step.time;
    current_error_ = S(shown - source_.current);
  }

  double resistanceOver(double current, double duration) override {
    return VoltageSource<S>(battery_, source_).resistanceOver(current, duration);
  }
  double currentError() const override { return valueOf(current_error_); }
  Derivatives currentErrorDerivatives() const override { return derivatives(current_error_); }

  double voltage() const override { return valueOf(battery_.now.voltage); }
  Derivatives voltageDerivatives() const override { return derivatives(battery_.now.voltage); }
  Derivatives currentDerivatives() const override { return derivatives(source_.current); }
  double time() const override { return battery_.now.time; }
  Eigen::Index tangents() const override { return battery_.tangents(); }
  Eigen::VectorXd state() const override { return valuesOf(battery_.now.x); }
  Eigen::MatrixXd stateDerivatives() const override {
    const std::vector<S>& x = battery_.now.x;
    Eigen::MatrixXd slopes(x.size(), tangents());
    for (std::size_t j = 0; j < x.size(); ++j) slopes.row(j) = derivatives(x[j]).transpose();
    return slopes;
  }
  std::vector<double> regressorMemory() const override { return battery_.regressorMemory(); }
  double beyondIdentified() const override {
    return battery_.discrepancy() ? battery_.discrepancy()->beyond() : 0.0;
  }

 private:
  // A voltage between two samples is a ramp of currents held this long [s], at slow rates at most
  // so many.
  static constexpr double kLongestHold = 0.5, kMaxHolds = 8.0;
  // [s], the end of a gap in which the source comes back
  static constexpr double kRampAfterGap = 1.0;
  static constexpr double kMaxCurrent = 1e4;  // [A], beyond anything a source gives

  Derivatives derivatives(double) const { return Derivatives(0); }
  Derivatives derivatives(const Dual& x) const {
    Derivatives along(tangents());
    for (Eigen::Index k = 0; k < tangents(); ++k)
      along[order_[k]] = x.derivative(static_cast<int>(k));
    return along;
  }

  double advanceTo(const S& voltage, double duration, double max_current) {
    return VoltageSource<S>(battery_, source_).advanceTo(voltage, duration, max_current);
  }

  std::vector<int> order_;  // of the seeds' columns in the battery's numbers
  Stepper<S> battery_;
  SourceMemory<S> source_;
  S current_error_ = S(0.0);  // [A], measured less what followed
};

std::unique_ptr<Simulation::Engine> engineFor(const BatteryModel& model, const ModelPoint& start,
                                              const Eigen::Ref<const Eigen::MatrixXd>& seeds) {
  requireSound(model, start, seeds);
  const auto bound = std::make_shared<const BoundComposition>(model);
  if (seeds.cols() == 0) return std::make_unique<EngineOf<double>>(bound, start, seeds);
  return std::make_unique<EngineOf<Dual>>(bound, start, seeds);
}

}  // namespace

Simulation::Simulation(const BatteryModel& model, const ModelPoint& start,
                       const Eigen::Ref<const Eigen::MatrixXd>& seeds)
    : engine_(engineFor(model, start, seeds)),
      seeds_(std::make_shared<const Eigen::MatrixXd>(seeds)) {}

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
