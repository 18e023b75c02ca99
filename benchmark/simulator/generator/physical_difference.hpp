#pragma once

#include <string>
#include <vector>

#include "simulator/acquisition.hpp"
#include "simulator/porous_block.hpp"

namespace battery_sof_simulator {

/// A change of a porous block, and when it acts.
struct PhysicalCause {
  enum class Course { kAlways, kFromInstant, kGrowing };
  std::string id, mechanism;  ///< mechanism: as `sof effects` names it
  Course course;
  void (*change)(PorousParameters& block, double amount);  ///< amount 0: none
};

/// All causes that a difference can have.
const std::vector<PhysicalCause>& physicalCauses();

/// Causes to put into a recording that was measured, and the block that stands for its battery.
struct DifferenceOrder {
  struct Part {
    std::string id;         ///< of physicalCauses()
    double strength = 1.0;  ///< s, >= 0
  };
  std::vector<Part> parts;
  double capacity_ah = 50.0;  ///< of the recorded battery; area and grids follow
};

/// Part of the recording's duration after which a cause of Course::kFromInstant acts [1].
constexpr double kInstantShare = 0.35;

/// A measured recording with the difference that causes make of a porous block.
///     current-controlled: u + u_s(i) - u_0(i)
///     voltage-controlled: i + i_s(u_0) - i_0
/// u_0: a sound block along the recorded current; u_s, i_s: the same block with the causes, under
/// the same current, or at u_0 while a charger regulates the voltage. The charger gives 0 A to the
/// largest recorded current; at that limit both differ. The amount of a cause is s, from
/// kInstantShare on or in proportion to the time where its course says so. Currents are linear
/// between samples, 0 in gaps (longer than three times the median interval). The blocks start at
/// rest with kReferenceSoc, and move by a quarter of the interval, 1 to 250 ms.
/// @throws std::invalid_argument for fewer than three samples, a cause that does not exist or that
/// the block cannot have at that strength; NoSolution where the block cannot follow the current.
std::vector<RecordedSample> withDifference(const std::vector<RecordedSample>& measured,
                                           const DifferenceOrder& order);

/// Whether a charger regulates the voltage: more than 0.5 A flows in at 13 V or more. Vehicles have
/// no other charger, and its set point moves, so that a plateau of the voltage is not asked for.
bool isRegulated(const RecordedSample& sample);

}  // namespace battery_sof_simulator
