#pragma once

#include <Eigen/Core>

#include "battery_sof/identify/composition_fit.hpp"
#include "battery_sof/learn/force_fit.hpp"

namespace battery_sof {

/**
 * @brief Variance of rows' errors by what a slow sampling cannot know of a current that is shifted in time.
 *
 *     var i(t - d) = theta (1 - theta) (i_k - i_k-1)^2,    times (r + B)^2 or r^2
 *
 * with theta the place of t - d between the samples k - 1 and k: a current that steps at an unknown instant has the one's value or
 * the other's, and the straight line between them has neither. Rows of several samples are fast enough to see the step: 0.
 *
 * @return [V^2], one a row; empty where the model shifts nothing (time_skew) or no row is a single sample.
 */
Eigen::VectorXd unseenVariance(const Drive& drive, const BaseResponse& response, const BatteryModel& model, const CompositionPoint& point);

/// @return a drive whose samples count as much less as their errors are wider by that than a noise [V]. Averaged ones stay as they are.
Drive withUnseen(Drive drive, const BatteryModel& model, const CompositionPoint& point, double noise);

}  // namespace battery_sof
