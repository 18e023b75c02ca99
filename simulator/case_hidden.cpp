#include <cmath>
#include <stdexcept>

#include "simulator/case_strength.hpp"

namespace battery_sof_reference {
namespace {

constexpr double kRoom = 0.2;  // of the state of charge

/// Whether a drive takes the charge up (1) or down (-1).
double trendOf(const Scenario& scenario) {
  const auto* city = std::get_if<CityOptions>(&scenario.profile);
  if (city == nullptr) throw std::invalid_argument("the drive's charge has no trend");
  return std::copysign(1.0, city->net_charge_ah);
}

void addChargeGain(Strength& s) {
  s.set("current_gain_charge", s.scenario().acquisition.current_gain_charge,
        1.0 + s.scale() * s.between({0.025, 0.05}));
}

void addOpposingDrift(Strength& s) {
  s.set("voltage_drift_v_per_h", s.scenario().acquisition.voltage_drift_v_per_h,
        -trendOf(s.scenario()) * s.scale() * s.between({0.02, 0.06}));
}

}  // namespace

void addMask(CaseDraft& draft, const std::string& id, Dice& dice, double scale) {
  if (id == "time_skew") return addEffect(draft, id, dice, scale);
  Strength s(draft, dice, scale);
  if (s.present()) s.alsoTrue(id);
  if (id == "gassing") return addSideReaction(s);
  if (id == "current_gain") return addChargeGain(s);
  if (id == "voltage_drift") return addOpposingDrift(s);
  throw std::invalid_argument("no mask is called \"" + id + "\"");
}

void addAbsent(CaseDraft& draft, const std::string& id, Dice& dice, double scale) {
  if (id != "gassing") return addEffect(draft, id, dice, scale);
  Strength s(draft, dice, scale);
  if (s.present()) s.alsoTrue(id);
  // Room for what two plateaus put in; u_0 at the start stays.
  s.scenario().start.soc -= kRoom;
  s.scenario().battery.u0_v += kRoom * s.scenario().battery.u0_slope_v;
  // Far above the first half's currents, below those of a plateau; slow against its turns.
  addCompanion(s, {40.0, 60.0}, {20.0, 40.0});
  addSideReaction(s);
}

}  // namespace battery_sof_reference
