#pragma once

#include <Eigen/Core>
#include <vector>

#include "battery_sof/model/driving_current.hpp"

namespace battery_sof {

/**
 * @brief The base model's state and its derivatives over a whole window, in blocks that stay in the first-level cache.
 *
 * The same step as OverpotentialStep for alpha = 0.5 (ClosedFormStep); what depends on the current alone is computed once
 * at construction. Searches call it many times with other values of C_2 and beta.
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

  Eigen::Index blocks() const { return e_plus_.cols(); }

  /// Calls visit(block index, const States&) for every block in order.
  template <typename Visitor>
  void run(const Point& point, Visitor&& visit) const;

 private:
  /// What is carried from block to block: E and the derivatives of ln E to ln(beta / C_2) and to the first ln E.
  struct Carried {
    double E, d_log_rate, d_initial;
  };
  void sweepBlock(Eigen::Index block, const Point& point, double log_first, Carried& carried,
                  States& states) const;
  static Carried begin(const Point& point);

  Eigen::Array<double, kBlock, Eigen::Dynamic> e_plus_, m_, half_rate_dt_;
};

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
