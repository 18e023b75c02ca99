#pragma once

#include <memory>

#include "model/simulation.hpp"

namespace battery_sof {

/**
 * @brief A simulation in one arithmetic: N tangents, 0 for values alone.
 *
 * One file each (engine_of_*.cpp): a compiler inlines less where a file grows too large, and these
 * steps are where the time goes.
 *
 * @param seeds at most as many columns.
 */
template <int N>
std::unique_ptr<Simulation::Engine> engineOf(const BatteryModel& model, const ModelPoint& start,
                                             const Eigen::Ref<const Eigen::MatrixXd>& seeds);

}  // namespace battery_sof
