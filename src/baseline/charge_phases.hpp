#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "recording/events.hpp"

namespace battery_sof {

/**
 * @brief Where charges begin: the first sample above 0 A with a controlled voltage after the
 * current was below kDischargeCurrent.
 *
 * @param voltage_controlled one a sample of series (ControlModes::voltage_controlled).
 * @return indices into series, rising, all in range; what was before range is not looked at.
 * @throws std::invalid_argument when the mask's size differs from the series' or range lies outside
 * it.
 */
std::vector<std::size_t> chargeBeginnings(const Series& series, IndexRange range,
                                          const std::vector<char>& voltage_controlled);

/**
 * @brief The samples of the first duration [s] of a charge that begins at sample `first`.
 *
 * Sample k represents the time from time[k] on, so that at 1 Hz ten seconds are ten samples.
 * @return none when range ends earlier, when fewer than 90 % of the samples that belong there have
 * a controlled voltage, or when sampling is slower than three samples in duration.
 */
std::optional<IndexRange> beginningOfCharge(const Series& series, IndexRange range,
                                            std::size_t first, double duration,
                                            const std::vector<char>& voltage_controlled);

}  // namespace battery_sof
