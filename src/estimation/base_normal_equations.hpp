#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "battery_sof/series.hpp"
#include "estimation/base_kernel.hpp"
#include "model/base_model.hpp"
#include "model/input_sequence.hpp"
#include "model/overpotential_sweep.hpp"
#include "recording/events.hpp"

namespace battery_sof {

/// Columns of the base model's Jacobian with the residual without ohmic drop and u_dc.
enum BaseColumn {
  kColumnDischarge,  ///< i where i < 0: d u / d r_discharge [A]
  kColumnCharge,     ///< i where i >= 0: d u / d r_charge [A]
  kColumnOne,        ///< 1: d u / d u_dc
  kColumnLogC2,      ///< d u_c2 / d ln C_2 [V]
  kColumnLogBeta,    ///< d u_c2 / d ln beta [V]
  kColumnInitial,    ///< d u_c2 / d u_c2(first) [1]
  kColumnTarget,     ///< u_b - offset - u_c2 [V]
  kBaseColumns,
};

/// A window with the base model at one point, kept whole.
struct BaseJacobian {
  Eigen::MatrixXd columns;   ///< of BaseColumn but for the target, one row a sample
  Eigen::VectorXd residual;  ///< u_b - u_m [V]
  Eigen::VectorXd weight;    ///< W^2
  Overpotential last;        ///< at the window's last sample
};

/// sum_n W(n)^2 column_j column_k: everything a search needs of one pass over the window.
using BaseSums = Eigen::Matrix<double, kBaseColumns, kBaseColumns>;

/**
 * @brief Simulation, derivatives and normal equations of the base model in one pass, without
 * storing the Jacobian.
 *
 * r_discharge, r_charge and u_dc enter linearly, so their columns do not depend on the search's
 * point; the caller eliminates them (variable projection) or combines them (paper's start).
 */
class BaseNormalEquations {
 public:
  /// One sample as the pass sees it; coarse passes average several into one.
  struct Sample {
    HeldCurrent held;
    double discharge, charge;  ///< [A], one of them zero unless averaged
    double voltage;            ///< [V]
    double weight;             ///< W^2; 0 leaves the sample out
  };

  /// @param samples not empty: a vector of Sample, or WindowSamples.
  template <typename Samples>
  BaseNormalEquations(const Samples& samples, double i0);

  /// @param set at most widestInstructionSet(); results differ between the sets by rounding alone.
  BaseSums sums(const OverpotentialSweep::Point& point,
                InstructionSet set = widestInstructionSet()) const;

  /// @param linear r_discharge, r_charge [Ohm], u_dc [V] at the point.
  BaseJacobian jacobian(const OverpotentialSweep::Point& point,
                        const Eigen::Vector3d& linear) const;

  /// [V], one of the voltages, taken off all of them to keep sums well scaled
  double offset() const { return offset_; }

 private:
  Eigen::Index size_;
  double offset_ = 0.0;
  OverpotentialSweep sweep_;
  std::vector<MeasuredBlock> measured_;
  /// sums of discharge, charge and 1, which no point of the search changes
  Eigen::Matrix3d linear_ = Eigen::Matrix3d::Zero();
};

/// Weights of eq. 3.
struct CrankWeight {
  double factor = 10.0;            ///< W [1]
  double current = kCrankCurrent;  ///< [A], W applies below
};

/**
 * @brief The samples of a range with weight^2 where current < weight_current, 1 elsewhere (paper,
 * eq. 3), each made from the recording where it is needed: passes over a window need no copy of it.
 */
struct WindowSamples {
  const Series& series;
  IndexRange range;
  CrankWeight weight;
  double max_gap;  ///< [s], gapThreshold(series)
  /// one a sample of the series, those that weigh nothing; empty for none
  const std::vector<char>& masked;

  std::size_t size() const { return range.size(); }
  /// [s], first sample to last
  double duration() const { return series.time[range.last - 1] - series.time[range.first]; }

  std::vector<BaseNormalEquations::Sample> copied() const;  ///< all of them, side by side

  BaseNormalEquations::Sample operator[](std::size_t n) const {
    const std::size_t at = range.first + n, before = at - (n > 0);
    const double i = series.current[at];
    const bool is_masked = !masked.empty() && masked[at];
    const double weighed = i < weight.current ? weight.factor * weight.factor : 1.0;
    return {heldCurrent(series.time[before], series.current[before], series.time[at], i, max_gap),
            std::min(i, 0.0), std::max(i, 0.0), series.voltage[at], is_masked ? 0.0 : weighed};
  }
};

/// @return every `factor` neighbouring samples averaged into one, as a cheap first approach to the
/// optimum.
/// @param samples as of BaseNormalEquations.
template <typename Samples>
std::vector<BaseNormalEquations::Sample> coarsened(const Samples& samples, std::size_t factor);

}  // namespace battery_sof
