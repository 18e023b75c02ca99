#pragma once

#include <vector>

#include "simulator/full_battery.hpp"
#include "simulator/out_of_model_force.hpp"
#include "simulator/simulation.hpp"

namespace battery_sof_reference {

/// Battery and force at one instant.
struct OutOfModelState {
  BatteryState base;
  OutOfModelVoltage::State force{};
  double current = 0.0;  ///< at the terminals [A]
  double charge = 0.0;   ///< through them since the start [As]
};

/**
 * @brief The base circuit with an out-of-model case's force beside it.
 *
 *     u = u_base(i - s i_side) + [r(i) i - r(i - s i_side) (i - s i_side)] + s v
 *
 * The side current passes the double layer by, not the resistance. With strength 0 or without a
 * force every voltage is that of FullBattery, bit for bit. A Battery as PowerSource takes it.
 */
class OutOfModelBattery {
 public:
  using State = OutOfModelState;
  static constexpr double kStep = FullBattery::kStep;

  /// @param scenario its battery, effects and start; effects are plainCircuit().
  /// @param force not owned; null: none.  @param strength s, finite.
  OutOfModelBattery(const Scenario& scenario, const OutOfModelVoltage* force, double strength);

  OutOfModelState rested() const;
  OutOfModelState advance(const OutOfModelState& before, double current_end) const;
  double voltage(const OutOfModelState& state) const;  ///< [V]

 private:
  OutOfModelInstant instantOf(const OutOfModelState& state, double current) const;
  double ohmic(double current) const;

  FullBattery battery_;
  const OutOfModelVoltage* force_;
  double strength_, r_discharge_, r_charge_, u0_;
};

/// True current and voltage every OutOfModelBattery::kStep; entry 0 stands at the start.
struct Course {
  std::vector<double> current;  ///< [A]
  std::vector<double> voltage;  ///< [V]
};

/// The scenario's drive, its voltage limit acting on battery and force together, and `after` more
/// seconds of it.
Course drivenCourse(const Scenario& scenario, const OutOfModelVoltage* force, double strength,
                    double after = 0.0);

/// The same battery under given currents, which it comes to from rest within a step; the limit does
/// not act.
Course controlledCourse(const Scenario& scenario, const OutOfModelVoltage* force, double strength,
                        const std::vector<double>& current);

/**
 * @brief A current as a recording's samples know it: means around each sample, linear between.
 *
 * What a recording of these samples leaves unknown between them is then nothing.
 *
 * @param per_sample entries of `current` a sample, >= 1.
 */
std::vector<double> linearBetweenSamples(const std::vector<double>& current,
                                         std::size_t per_sample);

/**
 * @brief How the base circuit's voltage answers its parameters, along a course.
 *
 *     C ds_C/dt = -i' s_C - (i - i_r2),   C ds_beta/dt = -i' s_beta - i' u2,   C ds_0/dt = -i' s_0
 *     i_r2 = 2 I_0 sinh(beta u2 / 2),  i' = d i_r2/du2,  s_0 = 1 at the start
 *
 * s_C, s_beta, s_0: what u2 gains with ln C, ln beta and u2 at the start. One row every
 * `per_sample` entries.
 */
struct BaseAnswer {
  std::vector<double> voltage;                 ///< of the base circuit [V]
  std::vector<double> u2;                      ///< [V]
  std::vector<std::array<double, 6>> columns;  ///< 1, (i)+, -(-i)+, s_C, s_beta, s_0
};
BaseAnswer baseAnswer(const Scenario& scenario, const std::vector<double>& current,
                      std::size_t per_sample);

}  // namespace battery_sof_reference
