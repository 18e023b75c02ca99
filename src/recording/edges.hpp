#pragma once

#include <cstddef>
#include <optional>

#include "battery_sof/series.hpp"

namespace battery_sof {

/// How voltage answers to the steep changes of current in a series.
struct EdgeResponse {
  std::size_t edges = 0;     ///< steep changes of current that were looked at
  double correlation = 0.0;  ///< of the changes of voltage and current at the lag below; -1 to 1
  /// [Ohm], change of voltage per change of current at that lag
  double resistance = 0.0;
  double lag = 0.0;         ///< [s], by which voltage follows current; negative: voltage is first
  double lag_first = 0.0;   ///< [s], the same from the first half of the edges
  double lag_second = 0.0;  ///< [s], and from the second half
  double correlation_unshifted = 0.0;  ///< as correlation, at lag 0
};

/**
 * @brief Shift, sign and resistance between voltage and current at the edges of the current.
 *
 * Changes over w = 0.1 s (over one sample when sampling is slower than 20 Hz) are compared:
 *
 *     c(L) = sum over edges of (i(t+w) - i(t)) (u(t+w+L) - u(t+L))
 *
 * The lag is the L with the greatest |c|. It is refined with w = 20 ms, which the fast polarisation
 * barely enters, and by a parabola through the greatest value and its neighbours; where the short
 * changes are not alike (a sensor that holds its value), w = 0.1 s stands. An edge is a change of
 * at least a tenth of the range of current; at most 400, evenly spread, are used. Lags up to 0.5 s
 * are searched, up to one sample below 20 Hz, where no fraction of a sample is claimed. Of samples
 * less than 0.2 ms apart every n-th is used.
 *
 * @return none without a change of current.
 * @note At 100 Hz a fast polarisation of two fifths of the ohmic resistance moves the lag by less
 * than 1.5 ms, one of 0.2 s by 0.3 ms. A filter on one channel alone reads as a lag.
 */
std::optional<EdgeResponse> edgeResponse(const Series& series);

}  // namespace battery_sof
