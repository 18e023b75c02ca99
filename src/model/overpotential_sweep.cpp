#include "battery_sof/model/overpotential_sweep.hpp"

#include <algorithm>
#include <cmath>

namespace battery_sof {

OverpotentialSweep::OverpotentialSweep(const std::vector<HeldCurrent>& held, double i0)
    : OverpotentialSweep(held.size(), i0, [&](std::size_t n) { return held[n]; }) {}

OverpotentialScale OverpotentialSweep::scaleOf(const Point& point) {
  return {point.beta, point.beta / point.c2, 0.5 * point.beta * point.u_c2_first};
}

OverpotentialCarried OverpotentialSweep::begin(const Point& point) {
  // Beyond |ln E| = 300 the branch empties the capacitor faster than any sampling can see
  // (OverpotentialStep).
  const double log_first = std::clamp(0.5 * point.beta * point.u_c2_first, -300.0, 300.0);
  return {std::exp(log_first), 1.0, 0.0, 1.0};
}

void OverpotentialSweep::inSampleOrder(const OverpotentialStates& lanes, States& states) {
  for (int k = 0; k < kBlock; ++k) {
    const int place = lanePosition(k);
    states.u_c2[k] = lanes.u_c2[place];
    states.d_log_c2[k] = lanes.d_log_c2[place];
    states.d_log_beta[k] = lanes.d_log_beta[place];
    states.d_initial[k] = lanes.d_initial[place];
  }
}

}  // namespace battery_sof
