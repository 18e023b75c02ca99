#pragma once

// Plain structs and out-of-line functions only: the source is compiled with flags of its own.

namespace battery_sof {

/// stretches of a block that are swept side by side
constexpr int kLanes = 8;
constexpr int kLaneSteps = 32;                   ///< samples of a stretch
constexpr int kBlockSize = kLanes * kLaneSteps;  ///< samples of a block

/// Place of a block's k-th sample in its arrays (lane order): a SIMD lane holds a stretch of
/// neighbouring samples.
constexpr int lanePosition(int k) { return k % kLaneSteps * kLanes + k / kLaneSteps; }

/// The currents that a block's samples are reached with, in lane order; see HeldCurrent.
struct alignas(64) HeldBlock {
  double current[kBlockSize];   ///< [A]
  double duration[kBlockSize];  ///< [s]; 0 repeats the state before
};

/// What of a block's samples depends on the current alone, in lane order; see CurrentShares.
struct alignas(64) DrivenBlock {
  double charging[kBlockSize];
  double mixed[kBlockSize];
  double half_rate_dt[kBlockSize];  ///< R dt / 2 [As]
};

/// State and derivatives at the samples of a block, in lane order.
struct alignas(64) OverpotentialStates {
  double u_c2[kBlockSize];        ///< [V]
  double d_log_c2[kBlockSize];    ///< d u_c2 / d ln C_2 [V]
  double d_log_beta[kBlockSize];  ///< d u_c2 / d ln beta [V]
  double d_initial[kBlockSize];   ///< d u_c2 / d u_c2(first sample) [1]
};

/// What is carried from block to block, with E = exp(beta u_c2 / 2) = x / y.
struct OverpotentialCarried {
  double x, y;        ///< > 0
  double d_log_rate;  ///< d ln E / d ln(beta / C_2)
  double d_initial;   ///< d ln E / d ln E(first sample)
};

/// What the kernels are compiled for, narrowest first; off x86-64 the first serves for all.
enum class InstructionSet {
  kPlain,   ///< the build's own
  kAvx2,    ///< with FMA
  kAvx512,  ///< F, DQ and VL
};

/// @return the widest one that this processor has.
InstructionSet widestInstructionSet();

/// Fills in sharesOf() every held current. @param i0 exchange current [A], > 0.  @param set at most
/// widestInstructionSet().
void shareCurrents(const HeldBlock& held, double i0, DrivenBlock& driven, InstructionSet set);

/// Where in its parameters a sweep stands.
struct OverpotentialScale {
  double beta;       ///< [1/V]
  double rate;       ///< beta / C_2 [1/As]
  double log_first;  ///< ln E at the first sample
};

/**
 * @brief One block of ClosedFormStep's recurrence with its derivatives.
 *
 * The step is linear in (x, y), so the lanes' stretches are first multiplied up as 2 x 2 matrices
 * side by side; a short sequential pass over the lanes gives each its start, and a second
 * side-by-side pass the states. The derivative to the rate is affine in its own start and is joined
 * in the same way.
 *
 * @param set at most widestInstructionSet(); results differ between the sets by rounding alone.
 */
void sweepOverpotential(const DrivenBlock& driven, const OverpotentialScale& scale,
                        OverpotentialCarried& carried, OverpotentialStates& states,
                        InstructionSet set);

}  // namespace battery_sof
