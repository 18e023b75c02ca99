#pragma once

// The regressors of a discrepancy model in arithmetic S: one definition for values, derivatives and
// the solver for a current.

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "effects/effect_definition.hpp"
#include "model/regressors.hpp"

namespace battery_sof {

/// States behind those of the regressors: charge [Ah], charge drawn since a charge [As], last
/// change
/// [A], last current [A], 0 before the first sample.
enum SharedRegressorState {
  kChargeState,
  kDrawnState,
  kChangeState,
  kLastCurrent,
  kBegunState,
  kSharedStates
};

/// f(x) where value and slope of f at x are known.
inline double mapped(double, double value, double) { return value; }
template <typename S>
S mapped(const S& x, double value, double slope) {
  return S::mapped(x, value, slope);
}

/// States before the first sample: reserves full, nothing moved.
inline std::vector<double> freshRegressorStates(const std::vector<Regressor>& regressors) {
  std::vector<double> state(regressors.size() + kSharedStates, 0.0);
  for (std::size_t k = 0; k < regressors.size(); ++k)
    if (regressors[k].kind == RegressorKind::kAcceptanceReserve ||
        regressors[k].kind == RegressorKind::kDischargeReserve)
      state[k] = 1.0;
  return state;
}

/// Moves regressors over a sample.
template <typename S>
struct RegressorKernel {
  const std::vector<Regressor>& regressors;
  const RegressorContext& context;
  LowPassShares& shares;
  S* state;  // one a regressor, then the shared ones

  /// @param values one a regressor, overwritten.
  void advance(const RegressorInputOf<S>& moment, S* values) const {
    shares.take(regressors, moment.duration);
    S* shared = state + regressors.size();
    if (!hasBegun()) shared[kLastCurrent] = moment.current;
    if (!moment.gap)
      shared[kChargeState] =
          S(shared[kChargeState] + moment.held * (moment.duration / kSecondsPerHour));
    const S flowed = moment.gap ? S(0.0) : moment.current;
    shared[kDrawnState] = positivePart(S(shared[kDrawnState] - flowed * moment.duration));
    for (std::size_t k = 0; k < regressors.size(); ++k)
      values[k] = valueOfRegressor(k, moment, flowed);
    shared[kChangeState] = moment.gap ? S(0.0) : S(moment.current - shared[kLastCurrent]);
    shared[kLastCurrent] = moment.current;
    shared[kBegunState] = S(1.0);
  }

 private:
  static constexpr double kMinReserve = 1e-3;  // [1], of a reserve that is spent
  // [1], overpotentials beyond it say nothing more of kinetics
  static constexpr double kMaxBend = 3.0;

  bool hasBegun() const { return valueOf(state[regressors.size() + kBegunState]) != 0.0; }

  static S limited(const S& x, double most) {
    return std::abs(valueOf(x)) > most ? S(std::copysign(most, valueOf(x))) : x;
  }
  static S bentAt(const S& x, double scale) {
    const double z = valueOf(x) / scale;
    return mapped(x, std::asinh(z), 1.0 / (scale * std::sqrt(1.0 + z * z)));
  }
  static S logOf(const S& x, double scale) {  // ln(1 + x / scale), x >= 0
    return mapped(x, std::log1p(valueOf(x) / scale), 1.0 / (scale + valueOf(x)));
  }
  static S fading(const S& magnitude, double scale) {
    const double value = std::exp(-valueOf(magnitude) / scale);
    return mapped(magnitude, value, -value / scale);
  }
  /// ln(1 + exp(z)) of how far an overpotential is beyond what is high.
  static S highPart(const Regressor& regressor, const S& overpotential) {
    const double z = (valueOf(overpotential) - regressor.time) / regressor.scale;
    const double value = z > 30.0 ? z : std::log1p(std::exp(std::max(z, -30.0)));
    return mapped(overpotential, value,
                  1.0 / ((1.0 + std::exp(std::clamp(-z, -700.0, 700.0))) * regressor.scale));
  }
  static S logCosh(const S& z) {
    const S bounded = limited(z, 30.0);
    return mapped(bounded, std::log(std::cosh(valueOf(bounded))), std::tanh(valueOf(bounded)));
  }

  S lowPass(std::size_t k, const S& input) const {
    state[k] = hasBegun() ? S(state[k] + (input - state[k]) * shares.share[k]) : input;
    return state[k];
  }

  /// c of a reserve that `out` empties and time and `in` fill [1].
  S reserve(std::size_t k, const S& out, const S& in, double duration) const {
    const Regressor& regressor = regressors[k];
    const S filling = S(in * (1.0 / regressor.scale) + 1.0 / regressor.time),
            rate = S(filling + out * (1.0 / regressor.scale));
    const S end = S(filling / rate);
    const double kept = std::exp(-duration * valueOf(rate));
    state[k] = S(end + (state[k] - end) * mapped(rate, kept, -duration * kept));
    return valueOf(state[k]) > kMinReserve ? state[k] : S(kMinReserve);
  }
  static S logReserve(const S& c) { return mapped(c, std::log(valueOf(c)), 1.0 / valueOf(c)); }

  S path(std::size_t k, const S& flowed, double duration) const {
    const double towards = valueOf(flowed) > 0.0 ? 1.0 : -1.0;
    const S magnitude = magnitudeOf(flowed);
    const double rate = duration / regressors[k].scale, kept = std::exp(-valueOf(magnitude) * rate);
    state[k] = S(towards + (state[k] - towards) * mapped(magnitude, kept, -rate * kept));
    return state[k];
  }

  /// Share of a store of fresh discharge products that is used up: scale / (scale + s).
  S fresh(std::size_t k, const S& discharging) const {
    const Regressor& regressor = regressors[k];
    return S(regressor.scale / (lowPass(k, discharging) * regressor.time + regressor.scale));
  }

  /// What has a memory of its own moves.
  S valueOfRegressor(std::size_t k, const RegressorInputOf<S>& moment, const S& flowed) const {
    const Regressor& regressor = regressors[k];
    const S* shared = state + regressors.size();
    const S &i = moment.current, &u = moment.overpotential;
    const S charging = positivePart(flowed), discharging = positivePart(S(-flowed));
    const double t = std::clamp(moment.time / context.span, 0.0, 1.0);
    const auto bent = [&] { return limited(S(u * regressor.scale), kMaxBend); };
    switch (regressor.kind) {
      case RegressorKind::kChargeMemory: return lowPass(k, charging);
      case RegressorKind::kDischargeMemory: return lowPass(k, discharging);
      case RegressorKind::kMemory: return lowPass(k, flowed);
      case RegressorKind::kLogChargeMemory: return logOf(lowPass(k, charging), regressor.scale);
      case RegressorKind::kLogDischargeMemory:
        return logOf(lowPass(k, discharging), regressor.scale);
      case RegressorKind::kCompressedMemory: return bentAt(lowPass(k, flowed), regressor.scale);
      case RegressorKind::kMemoryOfCompressed: return lowPass(k, bentAt(flowed, regressor.scale));
      case RegressorKind::kMemoryOfCharging: return lowPass(k, bentAt(charging, regressor.scale));
      case RegressorKind::kFresh: return fresh(k, discharging);
      case RegressorKind::kFreshCharging: return S(positivePart(i) * fresh(k, discharging));
      case RegressorKind::kAcceptanceReserve:
        return S(-logReserve(reserve(k, charging, discharging, moment.duration)));
      case RegressorKind::kDischargeReserve:
        return logReserve(reserve(k, discharging, charging, moment.duration));
      case RegressorKind::kSlowCharge: return lowPass(k, shared[kChargeState]);
      case RegressorKind::kPath: return path(k, flowed, moment.duration);
      case RegressorKind::kEdge: return S(i - lowPass(k, i));
      case RegressorKind::kHighMemory: return lowPass(k, highPart(regressor, u));
      case RegressorKind::kHighSum:
        return state[k] = S(state[k] + highPart(regressor, u) * moment.duration);
      case RegressorKind::kWarmCurrent: return S(i * lowPass(k, S(flowed * flowed)));
      case RegressorKind::kSinceCharge:
        return valueOf(i) < -1.0 ? fading(shared[kDrawnState], regressor.scale) : S(0.0);
      case RegressorKind::kCompressed: return bentAt(i, regressor.scale);
      case RegressorKind::kSaturating: {
        const double value = std::tanh(valueOf(i) / regressor.scale);
        return mapped(i, value, (1.0 - value * value) / regressor.scale);
      }
      case RegressorKind::kLogMagnitude: return logOf(magnitudeOf(i), regressor.scale);
      case RegressorKind::kSmallCurrent: return S(i * fading(magnitudeOf(i), regressor.scale));
      case RegressorKind::kRest: return fading(magnitudeOf(i), regressor.scale);
      case RegressorKind::kCharge: return shared[kChargeState];
      case RegressorKind::kChargeSquared: return S(shared[kChargeState] * shared[kChargeState]);
      case RegressorKind::kChange: return moment.gap ? S(0.0) : S(i - shared[kLastCurrent]);
      case RegressorKind::kChangeBefore: return shared[kChangeState];
      case RegressorKind::kOverpotentialMagnitude: return magnitudeOf(u);
      case RegressorKind::kOverpotentialSquared: return S(bent() * bent());
      case RegressorKind::kOverpotentialCubed: return S(bent() * S(bent() * bent()));
      case RegressorKind::kOverpotentialLogCosh: return logCosh(S(u * regressor.scale));
      case RegressorKind::kHighOverpotential: return highPart(regressor, u);
      case RegressorKind::kTimeCurrent: return S(i * t);
      case RegressorKind::kTimeMagnitude: return S(magnitudeOf(i) * t);
      case RegressorKind::kTimeSquaredCurrent: return S(i * (t * t));
      case RegressorKind::kTimeOverpotential: return S(u * t);
      case RegressorKind::kTime: return S(t);
      case RegressorKind::kStepCurrent: return moment.time >= regressor.time ? i : S(0.0);
      default: throw std::logic_error("a regressor of an unknown kind");
    }
  }
};

}  // namespace battery_sof
