#pragma once

#include <chrono>
#include <ctime>

namespace battery_sof_bench {

/// Processor time of a call [ms]: other programs' turns do not count.
template <typename Work>
double processorMilliseconds(const Work& work) {
  const std::clock_t begin = std::clock();
  work();
  return 1e3 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

/// Time on the wall of a call [ms], for work on several threads.
template <typename Work>
double wallMilliseconds(const Work& work) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  work();
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

}  // namespace battery_sof_bench
