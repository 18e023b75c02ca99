#include "model/overpotential_kernel.hpp"

#include <math.h>

#include "model/closed_form_step.hpp"
#include "model/instruction_sets.hpp"

// glibc's libmvec has exp and log for several values at once, but its header says so under
// -ffast-math alone.
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__)
#if __GLIBC_PREREQ(2, 22)
extern "C" {
__attribute__((simd("notinbranch"))) double exp(double) noexcept;
__attribute__((simd("notinbranch"))) double log(double) noexcept;
}
#endif
#endif

namespace battery_sof {
namespace {

/// x after = xx x + xy y, y after = yx x + yy y over each lane's stretch, scaled by a common
/// factor.
struct alignas(64) LaneMaps {
  double xx[kLanes], xy[kLanes], yx[kLanes], yy[kLanes];
};

struct alignas(64) LaneValues {
  double x[kLanes], y[kLanes];
  double d_log_rate[kLanes], d_initial[kLanes];  ///< x y times the derivatives of ln E
};

/// What the forward pass leaves of a block. A lane starts with d ln E / d ln rate = 0 and, for
/// survival, with x y d ln E = 1.
struct alignas(64) Trajectory {
  double E[kBlockSize];
  double forced[kBlockSize];    ///< d ln E / d ln rate
  double survival[kBlockSize];  ///< d ln E
  double x[kLanes], y[kLanes];  ///< at each lane's end
};

template <int>
BATTERY_SOF_INLINE void share(const HeldBlock& held, double i0, DrivenBlock& driven) {
  for (int n = 0; n < kBlockSize; ++n) {
    const CurrentShares shares = sharesOf(held.current[n], i0);
    driven.charging[n] = shares.charging;
    driven.mixed[n] = shares.mixed;
    driven.half_rate_dt[n] = 0.5 * shares.R * held.duration[n];
  }
}

BATTERY_SOF_INLINE void decaysOf(const DrivenBlock& driven, double rate, double* decayed) {
  for (int n = 0; n < kBlockSize; ++n) decayed[n] = exp(-driven.half_rate_dt[n] * rate);
}

template <int kWidth>
BATTERY_SOF_INLINE ClosedFormStep<typename Register<kWidth>::Type> stepAt(const DrivenBlock& driven,
                                                                          const double* decayed,
                                                                          int n) {
  const typename Register<kWidth>::Type charging = at<kWidth>(driven.charging + n);
  const typename Register<kWidth>::Type D = at<kWidth>(decayed + n);
  return {charging, 1.0 - charging, at<kWidth>(driven.mixed + n), D, 1.0 - D};
}

template <int kWidth>
BATTERY_SOF_INLINE void multiplyUp(const DrivenBlock& driven, const double* decayed, int lane,
                                   LaneMaps& maps) {
  using Value = typename Register<kWidth>::Type;
  const Value zero = {};
  Value xx = zero + 1.0, xy = zero, yx = zero, yy = zero + 1.0;
  for (int n = lane; n < kBlockSize; n += kLanes) {
    const auto step = stepAt<kWidth>(driven, decayed, n);
    const Value next_xx = step.nextX(xx, yx);
    const Value next_xy = step.nextX(xy, yy);
    yx = step.nextY(xx, yx);
    yy = step.nextY(xy, yy);
    xx = next_xx;
    xy = next_xy;
  }
  const Value norm = 1.0 / (xx + xy + yx + yy);
  at<kWidth>(maps.xx + lane) = xx * norm;
  at<kWidth>(maps.xy + lane) = xy * norm;
  at<kWidth>(maps.yx + lane) = yx * norm;
  at<kWidth>(maps.yy + lane) = yy * norm;
}

/// Every lane's first x and y, x + y = 1.
BATTERY_SOF_INLINE void startLanes(const LaneMaps& maps, const OverpotentialCarried& carried,
                                   LaneValues& start) {
  double x = carried.x, y = carried.y;
  for (int lane = 0; lane < kLanes; ++lane) {
    start.x[lane] = x;
    start.y[lane] = y;
    const double next = maps.xx[lane] * x + maps.xy[lane] * y;
    y = maps.yx[lane] * x + maps.yy[lane] * y;
    x = next;
  }
  for (int lane = 0; lane < kLanes; ++lane) {
    const double norm = 1.0 / (start.x[lane] + start.y[lane]);
    start.x[lane] *= norm;
    start.y[lane] *= norm;
  }
}

template <int kWidth>
BATTERY_SOF_INLINE void forward(const DrivenBlock& driven, const double* decayed, double rate,
                                int lane, const LaneValues& start, Trajectory& along) {
  using Value = typename Register<kWidth>::Type;
  Value x = at<kWidth>(start.x + lane), y = at<kWidth>(start.y + lane);
  Value forced = {};
  Value survival = forced + 1.0;
  for (int n = lane; n < kBlockSize; n += kLanes) {
    const auto step = stepAt<kWidth>(driven, decayed, n);
    const Value decay = at<kWidth>(driven.half_rate_dt + n) * rate;
    forced = step.D * forced - decay * step.D * step.slopeToD(x, y);
    survival *= step.D;
    const Value next = step.nextX(x, y);
    y = step.nextY(x, y);
    x = next;
    const Value over_xy = 1.0 / (x * y);
    at<kWidth>(along.E + n) = x * (x * over_xy);
    at<kWidth>(along.forced + n) = forced * over_xy;
    at<kWidth>(along.survival + n) = survival * over_xy;
  }
  at<kWidth>(along.x + lane) = x;
  at<kWidth>(along.y + lane) = y;
}

/// Every lane's first derivatives, and what the block hands on.
BATTERY_SOF_INLINE void startDerivatives(const Trajectory& along, OverpotentialCarried& carried,
                                         LaneValues& start) {
  const int last = kBlockSize - kLanes;
  double d_log_rate = carried.d_log_rate, d_initial = carried.d_initial;
  for (int lane = 0; lane < kLanes; ++lane) {
    const double xy = start.x[lane] * start.y[lane];
    start.d_log_rate[lane] = d_log_rate * xy;
    start.d_initial[lane] = d_initial * xy;
    const double survival = along.survival[last + lane] * xy;
    d_log_rate = survival * d_log_rate + along.forced[last + lane];
    d_initial *= survival;
  }
  carried = {along.x[kLanes - 1], along.y[kLanes - 1], d_log_rate, d_initial};
}

template <int kWidth>
BATTERY_SOF_INLINE void finish(const OverpotentialScale& scale, int lane, const LaneValues& start,
                               const Trajectory& along, OverpotentialStates& states) {
  using Value = typename Register<kWidth>::Type;
  const double two_over_beta = 2.0 / scale.beta;
  const Value first_log_rate = at<kWidth>(start.d_log_rate + lane);
  const Value first_initial = at<kWidth>(start.d_initial + lane);
  for (int n = lane; n < kBlockSize; n += kLanes) {
    const Value survival = at<kWidth>(along.survival + n);
    const Value d_log_rate = survival * first_log_rate + at<kWidth>(along.forced + n);
    const Value d_initial = survival * first_initial;
    at<kWidth>(states.d_initial + n) = d_initial;
    at<kWidth>(states.d_log_c2 + n) = -two_over_beta * d_log_rate;
    at<kWidth>(states.d_log_beta + n) =
        two_over_beta * (d_log_rate + scale.log_first * d_initial) - at<kWidth>(states.u_c2 + n);
  }
}

BATTERY_SOF_INLINE void logarithms(const OverpotentialScale& scale, const Trajectory& along,
                                   double* u_c2) {
  const double two_over_beta = 2.0 / scale.beta;
  for (int n = 0; n < kBlockSize; ++n) u_c2[n] = two_over_beta * log(along.E[n]);
}

template <int kWidth>
BATTERY_SOF_INLINE void sweep(const DrivenBlock& driven, const OverpotentialScale& scale,
                              OverpotentialCarried& carried, OverpotentialStates& states) {
  alignas(64) double decayed[kBlockSize];
  LaneMaps maps;
  LaneValues start;
  Trajectory along;
  decaysOf(driven, scale.rate, decayed);
  for (int lane = 0; lane < kLanes; lane += kWidth) multiplyUp<kWidth>(driven, decayed, lane, maps);
  startLanes(maps, carried, start);
  for (int lane = 0; lane < kLanes; lane += kWidth)
    forward<kWidth>(driven, decayed, scale.rate, lane, start, along);
  startDerivatives(along, carried, start);
  logarithms(scale, along, states.u_c2);
  for (int lane = 0; lane < kLanes; lane += kWidth)
    finish<kWidth>(scale, lane, start, along, states);
}

}  // namespace

InstructionSet widestInstructionSet() {
#if BATTERY_SOF_X86_DISPATCH
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl"))
    return InstructionSet::kAvx512;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return InstructionSet::kAvx2;
#endif
  return InstructionSet::kPlain;
}

BATTERY_SOF_DISPATCH(shareCurrents, share, (const HeldBlock& held, double i0, DrivenBlock& driven),
                     (held, i0, driven))
BATTERY_SOF_DISPATCH(sweepOverpotential, sweep,
                     (const DrivenBlock& driven, const OverpotentialScale& scale,
                      OverpotentialCarried& carried, OverpotentialStates& states),
                     (driven, scale, carried, states))

}  // namespace battery_sof
