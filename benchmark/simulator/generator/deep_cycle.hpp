#pragma once

#include <string>
#include <vector>

#include "simulator/acquisition.hpp"
#include "simulator/generator/scenario_kind.hpp"
#include "simulator/porous_block.hpp"

namespace battery_sof_simulator {

/// A battery that is run down and charged on a bench: a porous block of 5 to 100 Ah, a row every 1 to
/// 60 s. Its open-circuit voltage over the charge, its acid and the end of its discharge follow from
/// the block's equations, none of which the catalogue has.
struct DeepCycle {
  Order order;
  PorousParameters block;
  std::vector<RecordedSample> samples;
  std::string plan;            ///< of kDeepPlans
  double soc_at_start = 1.0;   ///< [1]
  double soc_at_end = 1.0;     ///< [1]
  double discharge_a = 0.0;    ///< held while discharging, counted positive [A]
  double charge_a = 0.0;       ///< at most, while charging [A]
  double charge_v = 0.0;       ///< held once it is reached [V]
  double row_s = 1.0;          ///< between samples [s]
  double usable_ah = 0.0;      ///< from full to kEmpty at the discharge's current [Ah]
  double voltage_noise = 0.0;  ///< white [V]
};

/// discharge: from full. charge_first: charged, then discharged. full_cycle: run down to kEmpty,
/// charged, discharged again.
constexpr const char* kDeepPlans[] = {"discharge", "charge_first", "full_cycle"};
constexpr double kEmpty = 10.5;  ///< [V], under the discharge's current

/// A scenario of deep_cycle. @param order its seed alone counts.
/// @throws std::invalid_argument for a duration, a rate, a drive or a scale: the seed chooses them.
DeepCycle drawDeepCycle(const Order& order);

/// The label of a deep cycle:
///     {"schema","kind","id":null,"seed","plan","mechanisms":[..],"usable_ah","nominal_ah",
///      "discharge_a","charge_a","charge_v","row_s","soc_at_start","soc_at_end"}
/// mechanisms: those that are true, each of which is a right answer.
std::string labelOf(const DeepCycle& one);

}  // namespace battery_sof_simulator
