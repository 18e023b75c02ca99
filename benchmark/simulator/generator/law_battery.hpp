#pragma once

#include <vector>

#include "simulator/generator/law.hpp"
#include "simulator/simulation.hpp"

namespace battery_sof_simulator {

/// Battery and law at one instant.
struct LawState {
  BatteryState base;
  Law::State law{};
  double current = 0.0;  ///< at the terminals [A]
  double charge = 0.0;   ///< through them since the start [As]
};

/// The base circuit with an out-of-catalogue law in addition.
///     u = u_base(i - s i_side) + [r(i) i - r(i - s i_side) (i - s i_side)] + s v
/// The side current passes the double layer by, not the resistance. With strength 0 or without a
/// law every voltage is that of FullBattery, bit for bit. A Battery as PowerSource takes it.
class LawBattery {
 public:
  using State = LawState;
  static constexpr double kStep = FullBattery::kStep;

  /// @param scenario its battery, effects and start; effects are plainCircuit().
  /// @param law not owned; null: none.  @param strength s, finite.
  LawBattery(const Scenario& scenario, const Law* law, double strength);

  LawState rested() const {
    return {battery_.rested(), law_ != nullptr ? law_->rested : Law::State{}};
  }
  LawState advance(const LawState& before, double current_end) const;
  double voltage(const LawState& state) const;  ///< [V]

 private:
  LawInstant instantOf(const LawState& state, double current) const;
  double ohmic(double current) const {
    return (current < 0.0 ? r_discharge_ : r_charge_) * current;
  }

  FullBattery battery_;
  const Law* law_;
  double strength_, r_discharge_, r_charge_, u0_;
};

/// The scenario's drive, its voltage limit acting on battery and law together.
Course drivenCourse(const Scenario& scenario, const Law* law, double strength);

/// The same battery under given currents, without a limit; it comes from rest within a step.
Course controlledCourse(const Scenario& scenario, const Law* law, double strength,
                        const std::vector<double>& current);

/// How the base circuit's voltage answers its parameters, along a course.
///     C ds_C/dt = -i' s_C - (i - i_r2),   C ds_beta/dt = -i' s_beta - i' u2,   C ds_0/dt = -i' s_0
///     i_r2 = 2 I_0 sinh(beta u2 / 2),  i' = d i_r2/du2,  s_0 = 1 at the start
/// What u2 gains with ln C, ln beta and u2 at the start. One row every `per_sample` entries.
struct BaseAnswer {
  std::vector<double> voltage;                 ///< of the base circuit [V]
  std::vector<double> u2;                      ///< [V]
  std::vector<std::array<double, 6>> columns;  ///< 1, (i)+, -(-i)+, s_C, s_beta, s_0
};
BaseAnswer baseAnswer(const Scenario& scenario, const std::vector<double>& current,
                      std::size_t per_sample);

}  // namespace battery_sof_simulator
