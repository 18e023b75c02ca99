#include "simulator/out_of_model_battery.hpp"

#include <cmath>
#include <stdexcept>

#include "simulator/drive_follower.hpp"

namespace battery_sof_reference {
namespace {

constexpr double kSecondsPerHour = 3600.0;

void requireValid(const Scenario& scenario) {
  std::string text;
  for (const auto& fault : faultsOf(scenario)) text += (text.empty() ? "" : "; ") + fault;
  if (!text.empty()) throw std::invalid_argument("scenario: " + text);
}

/// Sensitivities of u2 along a course, by implicit Euler steps.
class Sensitivities {
 public:
  explicit Sensitivities(const BatteryParameters& battery) : b_(battery) {}

  void advance(double u2, double current, double step) {
    const double half = 0.5 * b_.beta_per_v * u2;
    const double slope = b_.i0_a * b_.beta_per_v * std::cosh(half);
    const double reaction = 2.0 * b_.i0_a * std::sinh(half);
    const double kept = b_.cpe2_capacitance_f / step, all = kept + slope;
    by_capacitance_ = (kept * by_capacitance_ - (current - reaction)) / all;
    by_beta_ = (kept * by_beta_ - slope * u2) / all;
    by_start_ = kept * by_start_ / all;
  }
  std::array<double, 6> row(double current) const {
    return {1.0,      std::max(current, 0.0), std::min(current, 0.0), by_capacitance_, by_beta_,
            by_start_};
  }

 private:
  BatteryParameters b_;
  double by_capacitance_ = 0.0, by_beta_ = 0.0, by_start_ = 1.0;
};

}  // namespace

OutOfModelBattery::OutOfModelBattery(const Scenario& scenario, const OutOfModelVoltage* force,
                                     double strength)
    : battery_(scenario.battery, scenario.effects, scenario.start),
      force_(force),
      strength_(strength),
      r_discharge_(scenario.battery.r_ohmic_ohm + scenario.battery.r1_discharge_ohm),
      r_charge_(scenario.battery.r_ohmic_ohm + scenario.battery.r1_charge_ohm),
      u0_(battery_.voltage(battery_.rested())) {
  requireValid(scenario);
  if (!std::isfinite(strength))
    throw std::invalid_argument("strength is " + std::to_string(strength) + ", expected finite");
}

OutOfModelState OutOfModelBattery::rested() const {
  OutOfModelState state;
  state.base = battery_.rested();
  if (force_ != nullptr) state.force = force_->rested();
  return state;
}

OutOfModelInstant OutOfModelBattery::instantOf(const OutOfModelState& state, double current) const {
  OutOfModelInstant now;
  now.time = static_cast<double>(state.base.steps) * kStep;
  now.step = kStep;
  now.current = current;
  now.u2 = state.base.cpe2.voltage;
  now.u_x = u0_ + now.u2;
  now.charge = state.charge;
  return now;
}

OutOfModelState OutOfModelBattery::advance(const OutOfModelState& before,
                                           double current_end) const {
  OutOfModelState next = before;
  next.current = current_end;
  const double mean = 0.5 * (before.current + current_end);
  next.charge += mean * kStep;
  double side = 0.0;
  if (force_ != nullptr) {
    const OutOfModelInstant now = instantOf(before, mean);
    side = strength_ * force_->sideCurrent(before.force, now);
    next.force = force_->advance(before.force, now);
  }
  next.base = battery_.advance(before.base, current_end - side);
  return next;
}

double OutOfModelBattery::voltage(const OutOfModelState& state) const {
  const double base = battery_.voltage(state.base);
  if (force_ == nullptr || strength_ == 0.0) return base;
  const double added = force_->voltage(state.force, instantOf(state, state.current));
  return base + ohmic(state.current) - ohmic(state.base.current) + strength_ * added;
}

double OutOfModelBattery::ohmic(double current) const {
  return (current < 0.0 ? r_discharge_ : r_charge_) * current;
}

Course drivenCourse(const Scenario& scenario, const OutOfModelVoltage* force, double strength,
                    double after) {
  const OutOfModelBattery battery(scenario, force, strength);
  DriveFollower driver(scenario, scenario.duration);
  const PowerSource source(scenario.slew);
  OutOfModelState state = battery.rested();
  const auto steps =
      static_cast<std::size_t>(std::lround((scenario.duration + after) / battery.kStep));
  Course course{{state.current}, {battery.voltage(state)}};
  course.current.reserve(steps + 1);
  course.voltage.reserve(steps + 1);
  for (std::size_t n = 1; n <= steps; ++n) {
    state = source.step(battery, state, driver.next(state.charge / kSecondsPerHour));
    course.current.push_back(state.current);
    course.voltage.push_back(battery.voltage(state));
  }
  return course;
}

Course controlledCourse(const Scenario& scenario, const OutOfModelVoltage* force, double strength,
                        const std::vector<double>& current) {
  if (current.empty()) throw std::invalid_argument("controlledCourse: no current");
  const OutOfModelBattery battery(scenario, force, strength);
  OutOfModelState state = battery.rested();
  Course course{current, {}};
  course.voltage.reserve(current.size());
  for (std::size_t n = 0; n < current.size(); ++n) {
    if (n > 0 || current[0] != 0.0) state = battery.advance(state, current[n]);
    course.voltage.push_back(battery.voltage(state));
  }
  return course;
}

std::vector<double> linearBetweenSamples(const std::vector<double>& current,
                                         std::size_t per_sample) {
  if (per_sample < 1) throw std::invalid_argument("per_sample is 0, expected 1 or more");
  const std::size_t samples = (current.size() - 1) / per_sample + 1, reach = per_sample / 2;
  std::vector<double> knots(samples, 0.0);
  for (std::size_t k = 0; k < samples; ++k) {
    const std::size_t middle = k * per_sample;
    const std::size_t from = middle > reach ? middle - reach : 0;
    const std::size_t to = std::min(middle + reach, current.size() - 1);
    for (std::size_t n = from; n <= to; ++n) knots[k] += current[n];
    knots[k] /= static_cast<double>(to - from + 1);
  }
  knots[0] = current[0];  // a battery begins at rest
  std::vector<double> linear((samples - 1) * per_sample + 1);
  for (std::size_t n = 0; n < linear.size(); ++n) {
    const std::size_t k = n / per_sample, next = std::min(k + 1, samples - 1);
    const double share = static_cast<double>(n % per_sample) / static_cast<double>(per_sample);
    linear[n] = knots[k] + share * (knots[next] - knots[k]);
  }
  return linear;
}

BaseAnswer baseAnswer(const Scenario& scenario, const std::vector<double>& current,
                      std::size_t per_sample) {
  const OutOfModelBattery battery(scenario, nullptr, 0.0);
  OutOfModelState state = battery.rested();
  if (current.at(0) != 0.0) state = battery.advance(state, current[0]);
  Sensitivities sensitivities(scenario.battery);
  BaseAnswer answer;
  for (std::size_t n = 0; n < current.size(); ++n) {
    if (n > 0) {
      state = battery.advance(state, current[n]);
      sensitivities.advance(state.base.cpe2.voltage, 0.5 * (current[n] + current[n - 1]),
                            battery.kStep);
    }
    if (n % per_sample != 0) continue;
    answer.voltage.push_back(battery.voltage(state));
    answer.u2.push_back(state.base.cpe2.voltage);
    answer.columns.push_back(sensitivities.row(current[n]));
  }
  return answer;
}

}  // namespace battery_sof_reference
