#pragma once

#include <cstdint>
#include <vector>

#include "simulator/acquisition.hpp"

namespace battery_sof_simulator {

struct CityDriveOptions {
  std::uint64_t seed = 1;
  double duration = 900.0;  ///< [s], > 0
};

/// A city drive of a start-stop car, as the paper's data set 3 describes it
/// (docs/physics.md#drives). Stops (-15 to -35 A, 8 to 40 s), cranks (-230 to -300 A for 0.12 s,
/// then -120 to -180 A for 0.3 to 0.7 s), and between them two to four rounds of acceleration,
/// cruising and regenerative braking. While charging, the current is reduced so that the voltage
/// stays at the alternator's limit. Integrated at 1 kHz with the classical Runge-Kutta method,
/// averaged to 100 Hz, then noise and quantisation are added. The same seed gives the same drive.
/// @throws std::invalid_argument for a duration that is not positive and finite.
std::vector<RecordedSample> simulateCityDrive(const CityDriveOptions& options);

}  // namespace battery_sof_simulator
