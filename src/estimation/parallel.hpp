#pragma once

#include <cstddef>
#include <functional>

namespace battery_sof {

/**
 * @brief Runs work(0) to work(count - 1) on up to `threads` threads.
 *
 * Every call writes to its own place, so results do not depend on the number of threads. The first
 * exception, by index, is thrown again once all have ended.
 *
 * @param threads at least 1; 0 for as many as the machine has.
 */
void parallelFor(std::size_t count, int threads, const std::function<void(std::size_t)>& work);

}  // namespace battery_sof
