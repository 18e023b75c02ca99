#pragma once

#include <cmath>

namespace battery_sof_simulator {

/// tau dy/dt = x - y over steps of one length, exact for an x that is linear over a step.
struct LowPass {
  /// @param tau [s]; 0: y is x.  @param step [s], > 0.
  LowPass(double tau, double step)
      : decay(tau > 0.0 ? std::exp(-step / tau) : 0.0), delay(tau / step) {}
  /// @return y at a step's end. @param before y at its begin.  @param begin, end x there.
  double advance(double before, double begin, double end) const {
    const double lag = delay * (end - begin);
    return end - lag + (before - (begin - lag)) * decay;
  }
  double decay, delay;  ///< delay: tau / step
};

}  // namespace battery_sof_simulator
