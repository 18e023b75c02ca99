#pragma once

#include <string>

#include "model/base_model.hpp"

namespace battery_sof_bench {

/// Where a contender's search ended.
struct Fit {
  battery_sof::BaseParameters parameters;
  double u_c2_first = 0.0;  ///< [V]
  double cost = 0.0;        ///< eq. 3 [V^2]
  /// passes over the window, with or without derivatives; 0 when not counted
  int evaluations = 0;
};

/// The demand: the four tunables agree to this share.
constexpr double kSameOptimum = 1e-4;
/// At the optimum the cost is flat: a share of 1e-4 of a parameter moves it by less than this
/// share.
constexpr double kSameCost = 1e-6;

/**
 * @brief Refuses a comparison of different answers.
 * @throws std::runtime_error naming the contender, the value that differs, both values and the
 * tolerance.
 */
void requireSameOptimum(const Fit& ours, const Fit& theirs, const std::string& contender);

}  // namespace battery_sof_bench
