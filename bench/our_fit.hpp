#pragma once

#include "drive_window.hpp"
#include "fit.hpp"

namespace battery_sof_bench {

/**
 * @brief The part of identify() that finds the optimum: equations, coarse search, search on all
 * samples.
 *
 * It calls what identify() calls, in the same order; requireSameAsIdentify() holds the two
 * together.
 */
Fit searchOnly(const DriveWindow& window);

/// @throws std::runtime_error when identify() did not converge or ended in other parameters than
/// searchOnly().
void requireSameAsIdentify(const DriveWindow& window, const Fit& searched);

}  // namespace battery_sof_bench
