#pragma once

#include <Eigen/Core>

#include "battery_sof/identify/products_kernel.hpp"
#include "battery_sof/model/overpotential_sweep.hpp"
#include "battery_sof/recording/series.hpp"

namespace battery_sof {

/// Columns of the base model's Jacobian beside the residual without ohmic drop and u_dc.
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

/// Everything a search needs of one pass over the window.
struct BaseSums {
  Eigen::Matrix<double, kBaseColumns, kBaseColumns> weighted;  ///< sum_n W(n)^2 column_j column_k
};

/**
 * @brief Simulation, derivatives and normal equations of the base model in one pass, without storing the Jacobian.
 *
 * r_discharge, r_charge and u_dc enter linearly, so their columns do not depend on the search's point; the caller
 * eliminates them (variable projection) or combines them (paper's start).
 */
class BaseNormalEquations {
 public:
  using Columns = Eigen::Matrix<double, Eigen::Dynamic, kBaseColumns>;

  /// One sample as the pass sees it; coarse passes average several into one.
  struct Sample {
    HeldCurrent held;
    double discharge, charge;  ///< [A], one of them zero unless averaged
    double voltage;            ///< [V]
    double weight;             ///< W^2; 0 leaves the sample out
  };

  /// @param samples not empty.
  explicit BaseNormalEquations(const std::vector<Sample>& samples, double i0);

  /// @param set at most widestInstructionSet(); results differ between the sets by rounding alone.
  BaseSums sums(const OverpotentialSweep::Point& point,
                InstructionSet set = widestInstructionSet()) const;

  /// @return mean of every column over the samples with a weight, unweighted (paper, eq. 4).
  Eigen::Matrix<double, kBaseColumns, 1> means(const OverpotentialSweep::Point& point) const;

  /// @return all columns, one row a sample; for covariances and scores after a search.
  Columns columns(const OverpotentialSweep::Point& point) const;

  double offset() const { return offset_; }  ///< [V], taken off the voltage to keep sums well scaled
  Eigen::Index size() const { return size_; }

 private:
  Eigen::Index size_;
  double offset_ = 0.0;
  OverpotentialSweep sweep_;
  std::vector<MeasuredBlock> measured_;
  Eigen::Matrix3d linear_ = Eigen::Matrix3d::Zero();  ///< sums of discharge, charge and 1, which no point of the search changes
};

/// @return the samples of a range with weight^2 where current < weight_current, 1 elsewhere (paper, eq. 3).
std::vector<BaseNormalEquations::Sample> fitSamples(const Series& series, IndexRange range,
                                                    double weight, double weight_current);

/// @return every `factor` neighbouring samples averaged into one, as a cheap first approach to the optimum.
std::vector<BaseNormalEquations::Sample> coarsened(
    const std::vector<BaseNormalEquations::Sample>& samples, std::size_t factor);

}  // namespace battery_sof
