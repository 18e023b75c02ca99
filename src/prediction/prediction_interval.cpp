#include "prediction/prediction_interval.hpp"

#include <cmath>

namespace battery_sof {

Interval voltageInterval(const Simulation& simulation, double model_error) {
  const double variance = simulation.voltageDerivatives().squaredNorm();
  const double half = kNinetyPercent * std::sqrt(variance + model_error * model_error);
  const double u = simulation.voltage();
  return {u, u - half, u + half};
}

}  // namespace battery_sof
