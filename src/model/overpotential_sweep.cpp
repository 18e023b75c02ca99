#include "battery_sof/model/overpotential_sweep.hpp"

#include <algorithm>
#include <cmath>

#include "battery_sof/model/closed_form_step.hpp"

namespace battery_sof {

OverpotentialSweep::OverpotentialSweep(const std::vector<HeldCurrent>& held, double i0)
    : OverpotentialSweep(held.size(), i0, [&](std::size_t n) { return held[n]; }) {}

OverpotentialSweep::Carried OverpotentialSweep::begin(const Point& point) {
  // Beyond |ln E| = 300 the branch empties the capacitor faster than any sampling can see
  // (OverpotentialStep).
  const double log_first = std::clamp(0.5 * point.beta * point.u_c2_first, -300.0, 300.0);
  const double E = std::exp(log_first);
  return {E, 1.0, 0.0, E};
}

void OverpotentialSweep::sweepBlock(Eigen::Index block, const Point& point, double log_first,
                                    Carried& carried, States& states) const {
  const Block decay = half_rate_dt_.col(block) * (point.beta / point.c2);
  const Block decayed = (-decay).exp();
  const ClosedFormStep<Block> step{charging_.col(block), 1.0 - charging_.col(block),
                                   mixed_.col(block), decayed, 1.0 - decayed};
  const Block a = step.xFromX();
  const Block b = step.yFromY();
  const Block p = step.across();

  // The only parts that cannot go element by element; in locals, which stay in registers.
  Block x_before, y_before, x_after, y_after, force, d_log_rate;
  const double norm = 1.0 / (carried.x + carried.y);
  double x = carried.x * norm;
  double y = carried.y * norm;
  double initial = carried.initial * norm * norm;
  for (int k = 0; k < kBlock; ++k) {
    x_before[k] = x;
    y_before[k] = y;
    const double next = a[k] * x + p[k] * y;
    y = p[k] * x + b[k] * y;
    x = next;
    x_after[k] = x;
    y_after[k] = y;
    initial *= step.D[k];
    states.d_initial[k] = initial;
  }
  force = -decay * step.D * step.slopeToD(x_before, y_before);
  double rate = carried.log_rate * norm * norm;
  for (int k = 0; k < kBlock; ++k) {
    rate = step.D[k] * rate + force[k];
    d_log_rate[k] = rate;
  }
  carried = {x, y, rate, initial};

  const double scale = 2.0 / point.beta;
  const Block over_xy = 1.0 / (x_after * y_after);
  states.u_c2 = scale * (x_after.square() * over_xy).log();
  states.d_initial *= over_xy;
  d_log_rate *= over_xy;
  states.d_log_c2 = -scale * d_log_rate;
  states.d_log_beta = scale * (d_log_rate + log_first * states.d_initial) - states.u_c2;
}

}  // namespace battery_sof
