#pragma once

#include <optional>

#include "battery_sof/series.hpp"

namespace battery_sof {

/// Share of the capacity whose charge moves the open-circuit voltage by more than a circuit without
/// it may miss.
inline constexpr double kDeepShare = 0.1;

/**
 * @brief How far a battery's charge went, and over what distance.
 *
 *     q(t) = int i dt,   span = max q - min q,   throughput = int |i| dt,   i linear between samples
 *
 * Gaps count as rests. An offset of the current sensor goes into all of them.
 */
struct MovedCharge {
  double span = 0.0;        ///< [Ah]
  double throughput = 0.0;  ///< [Ah], charged and discharged; of an interval |charge|
  double drawn = 0.0;       ///< [Ah], largest fall of q
  double charged = 0.0;     ///< [Ah], largest rise of q

  /// Whether the open-circuit voltage must have moved: by a tenth of the capacity, which is some
  /// 0.1 V of a 12 V block (docs/physics.md#ocv_soc). @param capacity [Ah], nominal.
  bool isDeep(double capacity) const { return span >= kDeepShare * capacity; }
  /// Whether it went one way, or there and back once: a tenth more is left to the loads in between.
  /// Nothing that was just discharged is then charged again and again.
  bool isOneCycle() const { return throughput <= 2.2 * span; }
  /// Whether discharges, or charges, moved as much. @param capacity [Ah], nominal.
  bool isDrawnDeep(double capacity) const { return drawn >= kDeepShare * capacity; }
  bool isChargedDeep(double capacity) const { return charged >= kDeepShare * capacity; }
};

/// @return [Ah], that flows into the battery between a sample and the one before; none over a gap.
double chargeOfStep(const Series& series, std::size_t n, double max_gap);

/// @param range of the series.  @param max_gap [s], longest interval that is joined; none:
/// gapThreshold().
MovedCharge movedCharge(const Series& series, IndexRange range,
                        std::optional<double> max_gap = std::nullopt);

}  // namespace battery_sof
