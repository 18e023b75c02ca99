#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "model/mechanism.hpp"

namespace battery_sof {

/// What a regressor makes of the inputs. i: current [A], i+ = max(i, 0), i- = max(-i, 0), LP: low
/// pass of first order.
enum class RegressorKind {
  kChargeMemory,        ///< LP[i+] [A]
  kDischargeMemory,     ///< LP[i-] [A]
  kMemory,              ///< LP[i] [A]
  kLogChargeMemory,     ///< ln(1 + LP[i+] / scale) [1]
  kLogDischargeMemory,  ///< ln(1 + LP[i-] / scale) [1]
  kCompressedMemory,    ///< asinh(LP[i] / scale) [1]
  kMemoryOfCompressed,  ///< LP[asinh(i / scale)] [1]
  kMemoryOfCharging,    ///< LP[asinh(i+ / scale)] [1]
  kFresh,               ///< scale / (scale + s), s = time LP[i-] [1]; scale [As]
  kFreshCharging,       ///< i+ of it [A]
  /// -ln c, c emptied by i+ / scale, filled by (1 - c) (1/time + i- / scale); scale [As]
  kAcceptanceReserve,
  kDischargeReserve,  ///< ln c of the same with the currents' roles exchanged
  /// exp(-q / scale) while i < -1 A, q: charge drawn less charge given since, >= 0 [1]; scale [As]
  kSinceCharge,
  kCompressed,              ///< asinh(i / scale) [1]
  kSaturating,              ///< tanh(i / scale) [1]
  kLogMagnitude,            ///< ln(1 + |i| / scale) [1]
  kSmallCurrent,            ///< i exp(-|i| / scale) [A]
  kRest,                    ///< exp(-|i| / scale) [1]
  kCharge,                  ///< q: charge since the first sample [Ah]
  kChargeSquared,           ///< q^2 [Ah^2]
  kSlowCharge,              ///< LP[q] [Ah]
  kPath,                    ///< h: dh/dt = |i| / scale (sign(i) - h) [1]; scale [As]
  kEdge,                    ///< i - LP[i] [A]
  kChange,                  ///< i less the sample's before [A]
  kChangeBefore,            ///< the same, one sample late [A]
  kOverpotentialMagnitude,  ///< |u| [V], u: u_c2 of the base circuit
  kOverpotentialSquared,    ///< z^2, z = scale u, within +-3 [1]; scale [1/V]
  kOverpotentialCubed,      ///< z^3 [1]
  kOverpotentialLogCosh,    ///< ln cosh z [1]
  kHighOverpotential,       ///< p = ln(1 + exp((u - time) / scale)) [1]; time, scale [V]
  kHighMemory,              ///< LP of it [1]; charge [s]
  kHighSum,                 ///< its integral [s]
  /// i t / span [A], t: time since the training part began, held at its ends
  kTimeCurrent,
  kTimeMagnitude,       ///< |i| t / span [A]
  kTimeSquaredCurrent,  ///< i (t / span)^2 [A]
  kTimeOverpotential,   ///< u t / span [V]
  kWarmCurrent,         ///< i LP[i^2] [A^3]
  kTime,                ///< t / span [1]
  kStepCurrent,         ///< i from `time` on [A]
};

/// @return every kind, in the order above.
std::vector<RegressorKind> allRegressorKinds();

/// @return a kind's id in files: "charge_memory", "discharge_memory", ...
std::string kindId(RegressorKind kind);

/// Kinds whose regressors share one strength.
enum class RegressorGroup {
  kCharge,
  kDischarge,
  kCurrent,
  kStatic,
  kChargeCounted,
  kEdges,
  kKinetics,
  kHighVoltage,
  kTime
};
constexpr int kRegressorGroups = 9;
RegressorGroup groupOf(RegressorKind kind);

/// One regressor of a discrepancy model: a kind with its numbers. Their meaning stands at the
/// kinds.
struct Regressor {
  RegressorKind kind;
  Mechanism mechanism;
  double time = 0.0;  ///< [s] unless the kind says otherwise
  double scale = 0.0;
  double charge = 0.0;  ///< third number of kinds that have one
};

/// What a recording offers to regressors.
struct RegressorContext {
  double interval = 0.0;  ///< [s], median between samples
  double span = 0.0;      ///< [s], of the training part
  double beta = 20.0;     ///< [1/V], of the base circuit
  /// [V], nine tenths of the overpotentials of the training part lie below it
  double high = 0.0;
  double high_width = 0.02;  ///< [V], over which a side reaction sets in
};

/// @return the library: memories by decades of time from the sampling to a third of the span, no
/// equation of the catalogue.
std::vector<Regressor> regressorLibrary(const RegressorContext& context);

/// A sample as regressors see it, in arithmetic S.
template <typename S>
struct RegressorInputOf {
  double duration = 0.0;     ///< [s], since the sample before
  S current = S(0.0);        ///< [A]
  S held = S(0.0);           ///< [A], mean over the interval; 0 across a gap
  bool gap = false;          ///< the battery rested in between
  S overpotential = S(0.0);  ///< u_c2 of the base circuit [V]
  double time = 0.0;         ///< [s], since the first sample of the training part
};
using RegressorInput = RegressorInputOf<double>;

/// What low passes take of a step in an interval, kept while intervals are equally long.
struct LowPassShares {
  double duration = -1.0;     ///< [s]
  std::vector<double> share;  ///< 1 - exp(-duration / time), one a regressor

  void take(const std::vector<Regressor>& regressors, double of_duration);
};

/**
 * @brief Values of regressors along a sequence, sample by sample, from nothing that comes later.
 *
 * Memories begin at the first sample's value, reserves full, charges at zero.
 */
class RegressorMemory {
 public:
  RegressorMemory(std::vector<Regressor> regressors, RegressorContext context);

  /// Moves on to a sample. @param values one a regressor, overwritten.
  void advance(const RegressorInput& moment, Eigen::Ref<Eigen::VectorXd> values);

  const std::vector<Regressor>& regressors() const { return regressors_; }

 private:
  std::vector<Regressor> regressors_;
  RegressorContext context_;
  std::vector<double> state_;  // one a regressor, then those that regressors share
  LowPassShares shares_;
};

/// @return a regressor in words with its numbers, for pages and messages.
std::string toString(const Regressor& regressor);

}  // namespace battery_sof
