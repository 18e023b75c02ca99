#pragma once

#include "battery_sof/series.hpp"

namespace battery_sof {

/// The effect that a charge which moved a tenth of the capacity calls for.
inline constexpr const char* kMovedByCharge = "ocv_soc";

/**
 * @brief How far a battery's charge went in a window, and over what distance.
 *
 *     q(t) = int i dt,   span = max q - min q,   throughput = int |i| dt
 *
 * Gaps count as rests. An offset of the current sensor goes into both.
 */
struct MovedCharge {
  double span = 0.0;        ///< [Ah]
  double throughput = 0.0;  ///< [Ah], charged and discharged

  /// Whether the open-circuit voltage must have moved: by a tenth of the capacity, which is some
  /// 0.1 V of a 12 V block (docs/physics.md#ocv_soc). @param capacity [Ah], nominal.
  bool isDeep(double capacity) const { return span >= 0.1 * capacity; }
  /// Whether it went one way, or there and back once: a tenth more is left to the loads in between.
  /// Nothing that was just discharged is then charged again and again.
  bool isOneCycle() const { return throughput <= 2.2 * span; }
};

/// @param range window of the series.
MovedCharge movedCharge(const Series& series, IndexRange range);

}  // namespace battery_sof
