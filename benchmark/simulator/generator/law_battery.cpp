#include "simulator/generator/law_battery.hpp"

#include <stdexcept>

#include "simulator/fields.hpp"

namespace battery_sof_simulator {
namespace {

/// Sensitivities of u2 along a course, by implicit Euler steps.
struct Sensitivities {
  double by_capacitance = 0.0, by_beta = 0.0, by_start = 1.0;

  void advance(const BatteryParameters& b, double u2, double current, double step) {
    const double half = 0.5 * b.beta_per_v * u2;
    const double slope = b.i0_a * b.beta_per_v * std::cosh(half);
    const double reaction = 2.0 * b.i0_a * std::sinh(half);
    const double kept = b.cpe2_capacitance_f / step, all = kept + slope;
    by_capacitance = (kept * by_capacitance - (current - reaction)) / all;
    by_beta = (kept * by_beta - slope * u2) / all;
    by_start = kept * by_start / all;
  }
};

/// Shows every state of a battery under given currents, which it comes to from rest within a step.
template <typename Look>
void impose(const LawBattery& battery, const std::vector<double>& current, const Look& look) {
  if (current.empty()) throw std::invalid_argument("controlledCourse: no current");
  LawState state = battery.rested();
  for (std::size_t n = 0; n < current.size(); ++n) {
    if (n > 0 || current[0] != 0.0) state = battery.advance(state, current[n]);
    look(n, state);
  }
}

}  // namespace

LawBattery::LawBattery(const Scenario& scenario, const Law* law, double strength)
    : battery_(scenario.battery, scenario.effects, scenario.start),
      law_(law),
      strength_(strength),
      r_discharge_(scenario.battery.r_ohmic_ohm + scenario.battery.r1_discharge_ohm),
      r_charge_(scenario.battery.r_ohmic_ohm + scenario.battery.r1_charge_ohm),
      u0_(battery_.voltage(battery_.rested())) {
  requireNone(faultsOf(scenario), "scenario");
  if (!std::isfinite(strength))
    throw std::invalid_argument(faultOf("strength", strength, "finite"));
}

LawInstant LawBattery::instantOf(const LawState& state, double current) const {
  const double u2 = state.base.cpe2.voltage;
  return {
      static_cast<double>(state.base.steps) * kStep, kStep, current, u2, u0_ + u2, state.charge};
}

LawState LawBattery::advance(const LawState& before, double current_end) const {
  LawState next = before;
  next.current = current_end;
  const double mean = 0.5 * (before.current + current_end);
  next.charge += mean * kStep;
  double side = 0.0;
  if (law_ != nullptr) {
    const LawInstant now = instantOf(before, mean);
    side = strength_ * law_->sideCurrent(before.law, now);
    next.law = law_->advance(before.law, now);
  }
  next.base = battery_.advance(before.base, current_end - side);
  return next;
}

double LawBattery::voltage(const LawState& state) const {
  const double base = battery_.voltage(state.base);
  if (law_ == nullptr || strength_ == 0.0) return base;
  const double added = law_->voltage(state.law, instantOf(state, state.current));
  return base + ohmic(state.current) - ohmic(state.base.current) + strength_ * added;
}

Course drivenCourse(const Scenario& scenario, const Law* law, double strength) {
  const LawBattery battery(scenario, law, strength);
  Course course;
  driveThrough(battery, scenario, scenario.duration, std::lround(scenario.duration / battery.kStep),
               [&](const LawState& state, long) {
                 course.current.push_back(state.current);
                 course.voltage.push_back(battery.voltage(state));
                 return state.charge / kSecondsPerHour;
               });
  return course;
}

Course controlledCourse(const Scenario& scenario, const Law* law, double strength,
                        const std::vector<double>& current) {
  const LawBattery battery(scenario, law, strength);
  Course course{current, {}};
  course.voltage.reserve(current.size());
  impose(battery, current, [&](std::size_t, const LawState& state) {
    course.voltage.push_back(battery.voltage(state));
  });
  return course;
}

BaseAnswer baseAnswer(const Scenario& scenario, const std::vector<double>& current,
                      std::size_t per_sample) {
  const LawBattery battery(scenario, nullptr, 0.0);
  Sensitivities s;
  BaseAnswer answer;
  impose(battery, current, [&](std::size_t n, const LawState& state) {
    if (n > 0)
      s.advance(scenario.battery, state.base.cpe2.voltage, 0.5 * (current[n] + current[n - 1]),
                battery.kStep);
    if (n % per_sample != 0) return;
    answer.voltage.push_back(battery.voltage(state));
    answer.u2.push_back(state.base.cpe2.voltage);
    answer.columns.push_back({1.0, std::max(current[n], 0.0), std::min(current[n], 0.0),
                              s.by_capacitance, s.by_beta, s.by_start});
  });
  return answer;
}

}  // namespace battery_sof_simulator
