#pragma once

#include <Eigen/Core>
#include <vector>

#include "battery_sof/model/closed_form_step.hpp"
#include "battery_sof/model/driving_current.hpp"

namespace battery_sof {

/**
 * @brief The base model's state and its derivatives over a whole window, in blocks that stay in the first-level cache.
 *
 * The same step as OverpotentialStep for alpha = 0.5 (ClosedFormStep). What depends on the current alone is computed
 * once at construction; searches call it many times with other values of C_2 and beta.
 */
class OverpotentialSweep {
 public:
  static constexpr int kBlock = 128;
  using Block = Eigen::Array<double, kBlock, 1>;

  /// State and derivatives at the samples of one block; samples past the window's end repeat its last state.
  struct States {
    Block u_c2;       ///< [V]
    Block d_log_c2;   ///< d u_c2 / d ln C_2 [V]
    Block d_log_beta; ///< d u_c2 / d ln beta [V]
    Block d_initial;  ///< d u_c2 / d u_c2(first sample) [1]
  };

  /// Position of the search.
  struct Point {
    double c2 = 1000.0;       ///< [F], > 0
    double beta = 20.0;       ///< [1/V], > 0
    double u_c2_first = 0.0;  ///< [V], state at the first sample
  };

  /// @param held see heldCurrents().  @param i0 exchange current [A], > 0.
  OverpotentialSweep(const std::vector<HeldCurrent>& held, double i0);

  /// @param held_at function of the sample's index that returns its HeldCurrent.
  template <typename HeldAt>
  OverpotentialSweep(std::size_t size, double i0, HeldAt&& held_at);

  Eigen::Index blocks() const { return half_rate_dt_.cols(); }

  /// Calls visit(block index, const States&) for every block in order.
  template <typename Visitor>
  void run(const Point& point, Visitor&& visit) const;

 private:
  /// What is carried from block to block: x, y with E = x / y, and x y times the derivatives of ln E to ln(beta / C_2)
  /// and to the first ln E.
  struct Carried {
    double x, y, log_rate, initial;
  };
  void sweepBlock(Eigen::Index block, const Point& point, double log_first, Carried& carried,
                  States& states) const;
  static Carried begin(const Point& point);

  Eigen::Array<double, kBlock, Eigen::Dynamic> charging_, mixed_, half_rate_dt_;
};

template <typename HeldAt>
OverpotentialSweep::OverpotentialSweep(std::size_t size, double i0, HeldAt&& held_at) {
  const Eigen::Index blocks = (static_cast<Eigen::Index>(size) + kBlock - 1) / kBlock;
  charging_.setConstant(kBlock, blocks, 0.5);
  mixed_.setConstant(kBlock, blocks, 0.5);
  half_rate_dt_.setZero(kBlock, blocks);
  for (std::size_t n = 0; n < size; ++n) {
    const HeldCurrent held = held_at(n);
    const CurrentShares shares = sharesOf(held.current, i0);
    charging_.data()[n] = shares.charging;
    mixed_.data()[n] = shares.mixed;
    half_rate_dt_.data()[n] = 0.5 * shares.R * held.duration;
  }
}

template <typename Visitor>
void OverpotentialSweep::run(const Point& point, Visitor&& visit) const {
  Carried carried = begin(point);
  const double log_first = 0.5 * point.beta * point.u_c2_first;
  States states;
  for (Eigen::Index block = 0; block < blocks(); ++block) {
    sweepBlock(block, point, log_first, carried, states);
    visit(block, states);
  }
}

}  // namespace battery_sof
