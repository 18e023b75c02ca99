#pragma once

#include <optional>
#include <string>
#include <vector>

#include "battery_sof/series.hpp"

namespace battery_sof {

/// Share of the capacity whose charge moves the open-circuit voltage by more than a circuit without
/// it may miss.
inline constexpr double kDeepShare = 0.1;
/// The effect that a charge which moved a tenth of the capacity calls for.
inline constexpr const char* kMovedByCharge = "ocv_soc";
/// The effect that ends a discharge: the acid is used up.
inline constexpr const char* kUsedUp = "end_of_discharge";
/// The effect of what is drawn on the resistance: the acid conducts worse.
inline constexpr const char* kLessConducting = "resistance_soc";
/// The effect that ends a charge: the sulphate is used up.
inline constexpr const char* kFilledUp = "acceptance_soc";
/// The effect between the two: what a charge leaves at the plates.
inline constexpr const char* kLeftByCharge = "surface_charge";

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
  /// The effects that it calls for where it is deep; empty elsewhere.
  /// @param capacity [Ah], nominal.  @param is_controlled a source held the voltage somewhere.
  std::vector<std::string> physicsOfDepth(double capacity, bool is_controlled) const;
};

/// @param range window of the series.
MovedCharge movedCharge(const Series& series, IndexRange range);

/**
 * @brief The deep discharge that a recording ends in, without its beginning.
 *
 * The samples since the last charge, of which the last one draws. The first tenth of what they draw
 * is left out, since what a charge left at the plates, and the dip at the beginning of a discharge,
 * are no part of the open-circuit voltage's curve; the rest must be a tenth of the capacity.
 * @param searched samples that it lies in.  @param capacity [Ah], nominal.  @return none where the
 * recording ends otherwise.
 */
std::optional<IndexRange> dischargeUnderWay(const Series& series, IndexRange searched,
                                            double capacity);

/// Whether currents are one load, to a tenth. @param least, most [A], largest discharge and least.
inline bool isOneLoad(double least, double most) {
  return least < 0.0 && most - least <= -0.1 * least;
}

}  // namespace battery_sof
