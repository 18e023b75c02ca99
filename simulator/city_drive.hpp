#pragma once

#include <cstdint>
#include <vector>

#include "simulator/acquisition.hpp"

namespace battery_sof_simulator {

/// The battery of a simulated drive: the paper's Fig. 3 circuit, written here a second time and on
/// purpose.
struct Circuit {
  double r_discharge = 0.006;     ///< [Ohm]
  double r_charge = 0.0085;       ///< [Ohm]
  double capacitance = 1100.0;    ///< C_2 [F]
  double exchange_current = 1.0;  ///< I_0 [A]
  double beta = 22.0;             ///< [1/V], alpha = 0.5
  double u_dc = 12.7;             ///< [V]
};

/// What to drive and how it is measured.
struct CityDriveOptions {
  std::uint64_t seed = 1;
  double duration = 900.0;       ///< [s], > 0
  double voltage_limit = 14.2;   ///< [V], set point of the alternator
  double voltage_noise = 0.002;  ///< [V], standard deviation
  double current_noise = 0.05;   ///< [A], standard deviation
  double voltage_step = 0.001;   ///< [V], quantisation; 0 for none
  double current_step = 0.01;    ///< [A], quantisation; 0 for none
  Circuit circuit;
};

/**
 * @brief A city drive of a start-stop car, as the paper's data set 3 describes it
 * (docs/physics.md#drives).
 *
 * Stops (-15 to -35 A, 8 to 40 s), cranks (-230 to -300 A for 0.12 s, then -120 to -180 A for 0.3
 * to 0.7 s), and between them two to four rounds of acceleration, cruising and regenerative
 * braking. While charging, the current is reduced so that the voltage stays at the alternator's
 * limit. Integrated at 1 kHz with the classical Runge-Kutta method, averaged to 100 Hz, then noise
 * and quantisation are added. The same seed gives the same drive.
 *
 * @throws std::invalid_argument for a duration that is not positive and finite, or a negative noise
 * or step.
 */
std::vector<RecordedSample> simulateCityDrive(const CityDriveOptions& options);

}  // namespace battery_sof_simulator
