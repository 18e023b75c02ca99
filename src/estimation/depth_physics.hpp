#pragma once

#include <optional>
#include <string>
#include <vector>

#include "battery_sof/series.hpp"
#include "recording/moved_charge.hpp"

namespace battery_sof {

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

/// @return the effects that a charge calls for where it is deep; empty elsewhere.
/// @param capacity [Ah], nominal.  @param is_controlled a source held the voltage somewhere.
std::vector<std::string> physicsOfDepth(const MovedCharge& moved, double capacity,
                                        bool is_controlled);

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
