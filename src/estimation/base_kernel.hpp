#pragma once

#include "model/overpotential_kernel.hpp"

// Plain structs and out-of-line functions only, as in overpotential_kernel.hpp.

namespace battery_sof {

/// A block's samples as the base model's cost sees them, in lane order.
struct alignas(64) MeasuredBlock {
  double discharge[kBlockSize];  ///< [A]
  double charge[kBlockSize];     ///< [A]
  double voltage[kBlockSize];    ///< [V], less an offset
  double weight[kBlockSize];     ///< W^2; 0 leaves the sample out
};

constexpr int kLinearColumns = 3;  ///< discharge, charge, 1
constexpr int kStateColumns = 4;   ///< d_log_c2, d_log_beta, d_initial, voltage - u_c2

/// Sums over the samples of each SIMD lane.
struct alignas(64) LaneProducts {
  double with_linear[kStateColumns][kLinearColumns][kLanes];
  double with_states[kStateColumns][kStateColumns][kLanes];  ///< upper triangle
};

/// Adds weight * column_j * column_k of one block, j a column of the states, k any. @param set as
/// of sweepOverpotential().
void addProducts(const MeasuredBlock& measured, const OverpotentialStates& states,
                 LaneProducts& products, InstructionSet set);

/// Sums over the samples of each SIMD lane.
struct alignas(64) ResidualSums {
  double residual[kLanes], squares[kLanes];
  double lagged[kLanes];  ///< residual times the one before; a lane's first sample has none
};

/// discharge, charge, 1, d_log_c2, d_log_beta, d_initial
constexpr int kScoreColumns = 6;
/// neighbouring samples that addUpScores() adds up
constexpr int kScoreSteps = 4;
constexpr int kScoreSums = kLaneSteps / kScoreSteps;  ///< sums of one lane

/// Sums of scores, g = weight * residual * column_j, over kScoreSteps samples of each lane.
struct alignas(64) ScoreSums {
  double scores[kScoreSums][kScoreColumns][kLanes];
};

/// Scores of a block and of the kLaneSteps samples before each of its lanes. Zero before the first
/// block.
struct alignas(64) MovingScores {
  double before[kLaneSteps][kScoreColumns][kLanes];
  double here[kLaneSteps][kScoreColumns][kLanes];
};

/// Sums over the samples of each lane; lower triangle.
struct alignas(64) ScoreProducts {
  double sums[kScoreColumns][kScoreColumns][kLanes];
};

/// Puts voltage - u_c2 - r_discharge discharge - r_charge charge - u_dc, the residual, in the place
/// of every sample's voltage, and adds it up.
/// @param linear r_discharge, r_charge [Ohm], u_dc less the voltages' offset [V].  @param set as of
/// sweepOverpotential().
void leaveResidual(const OverpotentialStates& states, const double (&linear)[kLinearColumns],
                   MeasuredBlock& measured, ResidualSums& sums, InstructionSet set);

/// The scores of a block, kScoreSteps samples added up. @param left leaveResidual()'s.
void addUpScores(const MeasuredBlock& left, const DerivativeBlock& derivatives, ScoreSums& sums,
                 InstructionSet set);

/**
 * @brief Adds the outer products of the moving sums of `width` scores that end at the block's
 * samples.
 *
 * @param left leaveResidual()'s.  @param moving the scores of the block before; those of this one
 * afterwards.
 * @param width 1 to kLaneSteps.
 */
void addMovingProducts(const MeasuredBlock& left, const DerivativeBlock& derivatives, int width,
                       MovingScores& moving, ScoreProducts& products, InstructionSet set);

}  // namespace battery_sof
