#pragma once

#include <array>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "simulator/acquisition.hpp"
#include "simulator/additions.hpp"
#include "simulator/battery_elements.hpp"
#include "simulator/drive_plan.hpp"
#include "simulator/porous_block.hpp"

namespace battery_sof_simulator {

/// An option of a scenario: its key in files, its place, and the bounds of numbers. Said once for
/// the reader of scenario files, the check of values, labels, and what is drawn.
struct Field {
  std::string key;
  std::variant<double*, int*, bool*, Range*, GassingLaw*, DriftingParameter*> place;
  double lowest = 0.0, highest = 0.0;
};
using Fields = std::vector<Field>;

Fields fieldsOf(BatteryParameters& parameters);
Fields fieldsOf(BatteryEffects& effects);
Fields fieldsOf(Additions& additions);
Fields fieldsOf(PorousParameters& parameters);
Fields fieldsOf(AcquisitionOptions& options);
Fields fieldsOf(AlternatingOptions& options);
Fields fieldsOf(LongChargesOptions& options);
Fields fieldsOf(CityOptions& options);
Fields fieldsOf(Phase& phase);
Fields fieldsOf(ListedPhases& listed);  ///< keys "phases[0].duration_s" and so on

/// Names of an enumeration's values in files, in the values' order.
inline std::vector<std::string> namesOf(GassingLaw) { return {"none", "threshold", "tafel"}; }
inline std::vector<std::string> namesOf(DriftingParameter) {
  return {"r_ohmic", "r1", "cpe2_capacitance", "u0"};
}

/// Names of profiles in files, in the order of ProfileOptions.
constexpr std::array<const char*, 4> kProfileKinds{"alternating", "long_charges", "city_drive",
                                                   "phases"};

/// @return one sentence for every number outside its bounds.
std::vector<std::string> boundsFaults(const Fields& fields);
template <typename Options>
std::vector<std::string> fieldFaults(Options options) {
  return boundsFaults(fieldsOf(options));
}

/// "name is value, expected ..."
std::string faultOf(const std::string& name, double value, const std::string& expected);

/// @return "fault; fault".
std::string join(const std::vector<std::string>& faults);

/// @throws std::invalid_argument, "where: fault; fault", unless there are none.
void requireNone(const std::vector<std::string>& faults, const std::string& where);

}  // namespace battery_sof_simulator
