#include "battery_sof/model/overpotential_sweep.hpp"

#include <algorithm>
#include <cmath>

#include "battery_sof/model/closed_form_step.hpp"

namespace battery_sof {

OverpotentialSweep::OverpotentialSweep(const std::vector<HeldCurrent>& held, double i0) {
  const Eigen::Index blocks = (static_cast<Eigen::Index>(held.size()) + kBlock - 1) / kBlock;
  e_plus_.setOnes(kBlock, blocks);
  m_.setOnes(kBlock, blocks);
  half_rate_dt_.setZero(kBlock, blocks);
  for (std::size_t n = 0; n < held.size(); ++n) {
    const double i = held[n].current;
    const double R = std::sqrt(i * i + 4.0 * i0 * i0);
    // The larger root of |i|, then mirrored for discharges: nothing cancels.
    const double larger = (R + std::abs(i)) / (2.0 * i0);
    (i < 0.0 ? m_ : e_plus_).data()[n] = larger;
    (i < 0.0 ? e_plus_ : m_).data()[n] = 1.0 / larger;
    half_rate_dt_.data()[n] = 0.5 * R * held[n].duration;
  }
}

OverpotentialSweep::Carried OverpotentialSweep::begin(const Point& point) {
  // Beyond |ln E| = 300 the branch empties the capacitor faster than any sampling can see (OverpotentialStep).
  const double log_first = std::clamp(0.5 * point.beta * point.u_c2_first, -300.0, 300.0);
  return {std::exp(log_first), 0.0, 1.0};
}

void OverpotentialSweep::sweepBlock(Eigen::Index block, const Point& point, double log_first,
                                    Carried& carried, States& states) const {
  const Block decay = half_rate_dt_.col(block) * (point.beta / point.c2);
  const Block D = (-decay).exp();
  const ClosedFormStep<Block> step{e_plus_.col(block), m_.col(block), D, 1.0 - D};

  // E' = (E a + P) / (E P + b): the only part that cannot go element by element.
  const Block a = step.e_plus + step.m * step.D;
  const Block b = step.e_plus * step.D + step.m;
  Block before, after;
  double E = carried.E;
  for (int k = 0; k < kBlock; ++k) {
    before[k] = E;
    E = (E * a[k] + step.P[k]) / (E * step.P[k] + b[k]);
    after[k] = E;
  }
  carried.E = E;

  const Block num = before * a + step.P;
  const Block den = before * step.P + b;
  const Block survival = step.survival(before, num, den);
  const Block force = -decay * D * step.slopeToD(before, num, den);
  Block d_log_rate;
  for (int k = 0; k < kBlock; ++k) {
    carried.d_log_rate = survival[k] * carried.d_log_rate + force[k];
    carried.d_initial *= survival[k];
    d_log_rate[k] = carried.d_log_rate;
    states.d_initial[k] = carried.d_initial;
  }
  const double scale = 2.0 / point.beta;
  states.u_c2 = scale * after.log();
  states.d_log_c2 = -scale * d_log_rate;
  states.d_log_beta = scale * (d_log_rate + log_first * states.d_initial) - states.u_c2;
}

}  // namespace battery_sof
