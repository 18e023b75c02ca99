#include "model/overpotential_sweep.hpp"

#include <algorithm>
#include <cmath>
#include <new>

namespace battery_sof {

OverpotentialSweep::OverpotentialSweep(const std::vector<HeldCurrent>& held, double i0)
    : OverpotentialSweep(held.size()) {
  for (Eigen::Index b = 0; b < blocks(); ++b) {
    HeldBlock block = {};
    const std::size_t first = static_cast<std::size_t>(b) * kBlock;
    for (std::size_t n = first; n < std::min(first + kBlock, held.size()); ++n) {
      const int place = lanePosition(static_cast<int>(n - first));
      block.current[place] = held[n].current;
      block.duration[place] = held[n].duration;
    }
    drive(b, block, i0);
  }
}

OverpotentialScale OverpotentialSweep::scaleOf(const Point& point) {
  return {point.beta, point.beta / point.c2, 0.5 * point.beta * point.u_c2_first};
}

OverpotentialCarried OverpotentialSweep::begin(const Point& point) {
  // Beyond |ln E| = 300 the branch empties the capacitor faster than any sampling can see
  // (OverpotentialStep).
  const double log_first = std::clamp(0.5 * point.beta * point.u_c2_first, -300.0, 300.0);
  return {std::exp(log_first), 1.0, 0.0, 1.0};
}

void OverpotentialSweep::keepDerivatives(const OverpotentialStates& states, SweptBlock& block) {
  new (&block.derivatives) DerivativeBlock;
  std::copy_n(states.d_log_c2, kBlockSize, block.derivatives.d_log_c2);
  std::copy_n(states.d_log_beta, kBlockSize, block.derivatives.d_log_beta);
  std::copy_n(states.d_initial, kBlockSize, block.derivatives.d_initial);
}

void OverpotentialSweep::inSampleOrder(const OverpotentialStates& in_lanes, States& states) {
  for (int k = 0; k < kBlock; ++k) {
    const int place = lanePosition(k);
    states.u_c2[k] = in_lanes.u_c2[place];
    states.d_log_c2[k] = in_lanes.d_log_c2[place];
    states.d_log_beta[k] = in_lanes.d_log_beta[place];
    states.d_initial[k] = in_lanes.d_initial[place];
  }
}

}  // namespace battery_sof
