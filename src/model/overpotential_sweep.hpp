#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "model/driving_current.hpp"
#include "model/overpotential_kernel.hpp"

namespace battery_sof {

/**
 * @brief The base model's state and its derivatives over a whole window, in blocks that stay in the
 * first-level cache.
 *
 * The same step as OverpotentialStep for alpha = 0.5 (ClosedFormStep). What depends on the current
 * alone is computed once at construction; searches call it many times with other values of C_2 and
 * beta.
 */
class OverpotentialSweep {
 public:
  static constexpr int kBlock = kBlockSize;
  using Block = Eigen::Array<double, kBlock, 1>;

  /// State and derivatives at the samples of one block; samples past the window's end repeat its
  /// last state.
  struct States {
    Block u_c2;        ///< [V]
    Block d_log_c2;    ///< d u_c2 / d ln C_2 [V]
    Block d_log_beta;  ///< d u_c2 / d ln beta [V]
    Block d_initial;   ///< d u_c2 / d u_c2(first sample) [1]
  };

  /// Position of the search.
  struct Point {
    double c2 = 1000.0;       ///< [F], > 0
    double beta = 20.0;       ///< [1/V], > 0
    double u_c2_first = 0.0;  ///< [V], state at the first sample
  };

  /// @param held see heldCurrents().  @param i0 exchange current [A], > 0.
  OverpotentialSweep(const std::vector<HeldCurrent>& held, double i0);

  /// A window whose blocks are still to be driven. @param size samples.
  explicit OverpotentialSweep(std::size_t size) : blocks_((size + kBlock - 1) / kBlock) {}

  /// Sets what a block's samples are reached with. @param held in SIMD lane order, duration 0 past
  /// the window's end.
  void drive(Eigen::Index block, const HeldBlock& held, double i0) {
    shareCurrents(held, i0, blocks_[static_cast<std::size_t>(block)].driven,
                  widestInstructionSet());
  }

  Eigen::Index blocks() const { return static_cast<Eigen::Index>(blocks_.size()); }

  /// Calls visit(block index, const States&) for every block in order.
  template <typename Visitor>
  void run(const Point& point, Visitor&& visit) const;

  /// Calls visit(block index, const OverpotentialStates&), samples in SIMD lane order
  /// (lanePosition()): for sums, faster.
  /// @param set at most widestInstructionSet().
  template <typename Visitor>
  void runInLanes(const Point& point, InstructionSet set, Visitor&& visit) const;

  /// The last pass: runInLanes() that uses the sweep up. @return the blocks with the derivatives in
  /// the place of the currents.
  template <typename Visitor>
  std::vector<SweptBlock> runOut(const Point& point, InstructionSet set, Visitor&& visit) &&;

 private:
  static OverpotentialScale scaleOf(const Point& point);
  static OverpotentialCarried begin(const Point& point);
  static void keepDerivatives(const OverpotentialStates& states, SweptBlock& block);
  static void inSampleOrder(const OverpotentialStates& in_lanes, States& states);

  std::vector<SweptBlock> blocks_;
};

template <typename Visitor>
void OverpotentialSweep::runInLanes(const Point& point, InstructionSet set, Visitor&& visit) const {
  const OverpotentialScale scale = scaleOf(point);
  OverpotentialCarried carried = begin(point);
  OverpotentialStates states;
  for (Eigen::Index block = 0; block < blocks(); ++block) {
    sweepOverpotential(blocks_[static_cast<std::size_t>(block)].driven, scale, carried, states,
                       set);
    visit(block, states);
  }
}

template <typename Visitor>
std::vector<SweptBlock> OverpotentialSweep::runOut(const Point& point, InstructionSet set,
                                                   Visitor&& visit) && {
  runInLanes(point, set, [&](Eigen::Index block, const OverpotentialStates& states) {
    visit(block, states);
    keepDerivatives(states, blocks_[static_cast<std::size_t>(block)]);
  });
  return std::move(blocks_);
}

template <typename Visitor>
void OverpotentialSweep::run(const Point& point, Visitor&& visit) const {
  States states;
  runInLanes(point, widestInstructionSet(),
             [&](Eigen::Index block, const OverpotentialStates& in_lanes) {
               inSampleOrder(in_lanes, states);
               visit(block, states);
             });
}

}  // namespace battery_sof
