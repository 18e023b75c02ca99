#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "model/overpotential_kernel.hpp"

namespace battery_sof {

/**
 * @brief The base model's state and its derivatives over a whole window, in blocks that stay in the
 * first-level cache.
 *
 * The step is ClosedFormStep. What depends on the current alone is computed once by drive(); searches
 * pass over it many times with other values of C_2 and beta. Samples past the window's end repeat its
 * last state.
 */
class OverpotentialSweep {
 public:
  /// Position of the search.
  struct Point {
    double c2 = 1000.0;       ///< [F], > 0
    double beta = 20.0;       ///< [1/V], > 0
    double u_c2_first = 0.0;  ///< [V], state at the first sample
  };

  /// A window whose blocks are still to be driven. @param size samples.
  explicit OverpotentialSweep(std::size_t size) : blocks_((size + kBlockSize - 1) / kBlockSize) {}

  /// Sets what a block's samples are reached with. @param held in SIMD lane order, duration 0 past
  /// the window's end.  @param i0 exchange current [A], > 0.
  void drive(Eigen::Index block, const HeldBlock& held, double i0) {
    shareCurrents(held, i0, blocks_[block], widestInstructionSet());
  }

  Eigen::Index blocks() const { return static_cast<Eigen::Index>(blocks_.size()); }

  /// Calls visit(block index, const OverpotentialStates&) for every block in order, samples in the
  /// order of lanePosition(). @param set at most widestInstructionSet().
  template <typename Visitor>
  void run(const Point& point, InstructionSet set, Visitor&& visit) const {
    const OverpotentialScale scale{point.beta, point.beta / point.c2,
                                   0.5 * point.beta * point.u_c2_first};
    // Beyond |ln E| = 300 the branch empties the capacitor faster than any sampling can see.
    OverpotentialCarried carried{std::exp(std::clamp(scale.log_first, -300.0, 300.0)), 1.0, 0.0,
                                 1.0};
    OverpotentialStates states;
    for (Eigen::Index block = 0; block < blocks(); ++block) {
      sweepOverpotential(blocks_[block], scale, carried, states, set);
      visit(block, states);
    }
  }

 private:
  std::vector<DrivenBlock> blocks_;
};

}  // namespace battery_sof
