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

}  // namespace battery_sof
