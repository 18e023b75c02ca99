#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>

#include "reference/case_draft.hpp"

namespace battery_sof_reference {
namespace {

constexpr double kLeastCapacitance = 300.0;  // [F] (PHYSICS S5)
constexpr double kDistinct = 4.0;            // ratio of time constants

/// Draws values, sets them in a scenario, and writes them down.
class Strength {
 public:
  Strength(CaseDraft& draft, Dice& dice) : draft_(draft), dice_(dice) {}

  Scenario& scenario() { return draft_.scenario; }
  double share() { return dice_.share(); }
  double sign() { return dice_.share() < 0.5 ? -1.0 : 1.0; }

  void set(const std::string& key, double& place, double value) {
    place = draft_.strength[key] = value;
  }
  void draw(const std::string& key, double& place, const Range& range) {
    set(key, place, dice_.between(range));
  }
  void drawLog(const std::string& key, double& place, const Range& range) {
    set(key, place, range.low * std::pow(range.high / range.low, dice_.share()));
  }
  double between(const Range& range) { return dice_.between(range); }
  void alsoTrue(const std::string& id) { draft_.effects.push_back(id); }

 private:
  CaseDraft& draft_;
  Dice& dice_;
};

void addCpe2(Strength& s) {
  s.scenario().effects.cpe2_fractional = true;
  s.draw("cpe2_exponent", s.scenario().battery.cpe2_exponent, {0.75, 0.88});
}

void addFastArc(Strength& s) {
  Additions& a = s.scenario().additions;
  a.fast_arc = true;
  s.draw("fast_arc_ohm", a.fast_arc_ohm, {1e-3, 2e-3});
  s.drawLog("fast_arc_time_s", a.fast_arc_time_s, {0.05, 0.4});
}

/// r_1 of both directions falls with current; at small current it is r_x more than at large.
void addCurrentDependence(Strength& s) {
  BatteryParameters& b = s.scenario().battery;
  s.scenario().effects.r1_current_dependence = true;
  double extra = 0.0;
  s.draw("r_x_ohm", extra, {3e-3, 6e-3});
  s.drawLog("r1_knee_current_a", b.r1_knee_current_a, {8.0, 40.0});
  const double smallest = std::min(b.r1_discharge_ohm, b.r1_charge_ohm);
  b.r_ohmic_ohm += smallest - std::min(smallest, 0.3 * extra);
  b.r1_discharge_ohm += extra - smallest;
  b.r1_charge_ohm += extra - smallest;
}

void addChargeTransfer(Strength& s) {
  BatteryParameters& b = s.scenario().battery;
  if (s.share() < 0.5)
    s.set("i0_a", b.i0_a, s.share() < 0.5 ? s.between({0.2, 0.4}) : s.between({2.5, 5.0}));
  else
    s.set("alpha", b.alpha, 0.5 + s.sign() * s.between({0.1, 0.2}));
}

/// With C_3 beta_3 far from C_2 beta: two electrodes of one time constant are one.
void addSecondElectrode(Strength& s) {
  const BatteryParameters& b = s.scenario().battery;
  Additions& a = s.scenario().additions;
  a.second_electrode = true;
  s.set("electrode3_beta_per_v", a.electrode3_beta_per_v, 1.0 / s.between({0.02, 0.04}));
  const double alike = b.beta_per_v * b.cpe2_capacitance_f / a.electrode3_beta_per_v;
  const bool faster = kDistinct * kLeastCapacitance < alike;
  s.drawLog(
      "electrode3_capacitance_f", a.electrode3_capacitance_f,
      faster ? Range{kLeastCapacitance, alike / kDistinct} : Range{kDistinct * alike, 6000.0});
  s.set("electrode3_exponent", a.electrode3_exponent,
        s.share() < 0.5 ? 1.0 : s.between({0.85, 1.0}));
}

void addInductance(Strength& s) {
  s.scenario().effects.inductance = true;
  s.draw("inductance_h", s.scenario().battery.inductance_h, {1.5e-6, 3e-6});
}

void addChargeAcceptance(Strength& s) {
  s.scenario().effects.charge_acceptance = true;
  s.drawLog("lead_ion_limit_a", s.scenario().battery.lead_ion_limit_a, {20.0, 70.0});
  s.drawLog("lead_ion_time_s", s.scenario().battery.lead_ion_time_s, {3.0, 40.0});
}

/// With a limited main reaction: only where that no longer takes the current does a side reaction
/// show.
void addGassing(Strength& s) {
  BatteryParameters& b = s.scenario().battery;
  s.scenario().effects.charge_acceptance = true;
  s.draw("lead_ion_limit_a", b.lead_ion_limit_a, {12.0, 25.0});
  s.draw("lead_ion_time_s", b.lead_ion_time_s, {3.0, 15.0});
  s.alsoTrue("charge_acceptance");
  s.scenario().effects.gassing = GassingLaw::kTafel;
  s.draw("gas_current_a", b.gas_current_a, {1.5, 3.0});
  s.draw("gas_slope_per_v", b.gas_slope_per_v, {1.4, 3.0});
}

void addSulphateHistory(Strength& s) {
  addChargeAcceptance(s);
  s.alsoTrue("charge_acceptance");
  Additions& a = s.scenario().additions;
  a.sulphate_history = true;
  s.drawLog("sulphate_ah", a.sulphate_ah, {0.2, 0.8});
  s.drawLog("sulphate_time_s", a.sulphate_time_s, {300.0, 1800.0});
  s.draw("sulphate_charge_share", a.sulphate_charge_share, {0.6, 1.0});
}

void addAcidTransport(Strength& s) {
  Additions& a = s.scenario().additions;
  a.acid_transport = true;
  s.draw("acid_1_ohm", a.acid_1_ohm, {1.75e-3, 3e-3});
  s.drawLog("acid_1_time_s", a.acid_1_time_s, {20.0, 100.0});
  s.draw("acid_2_ohm", a.acid_2_ohm, {3.5e-3, 6e-3});
  s.drawLog("acid_2_time_s", a.acid_2_time_s, {150.0, 1500.0});
}

/// u_0 at the start stays as drawn.
void addOcvSlope(Strength& s) {
  BatteryParameters& b = s.scenario().battery;
  const double below = s.scenario().start.soc - 0.8;
  const double u0 = b.u0_v + b.u0_slope_v * below;
  s.scenario().effects.ocv_slope = true;
  s.draw("u0_slope_v", b.u0_slope_v, {1.5, 1.8});
  b.u0_v = u0 - b.u0_slope_v * below;
}

void addOcvHysteresis(Strength& s) {
  Additions& a = s.scenario().additions;
  a.ocv_hysteresis = true;
  s.draw("hysteresis_v", a.hysteresis_v, {0.02, 0.04});
  s.drawLog("hysteresis_ah", a.hysteresis_ah, {0.05, 0.4});
}

void addHighRateDepletion(Strength& s) {
  Additions& a = s.scenario().additions;
  a.high_rate_depletion = true;
  s.draw("depletion_v", a.depletion_v, {0.17, 0.25});
  s.drawLog("depletion_limit_a", a.depletion_limit_a, {300.0, 600.0});
  s.draw("depletion_time_s", a.depletion_time_s, {10.0, 60.0});
}

void addCoupDeFouet(Strength& s) {
  Additions& a = s.scenario().additions;
  a.coup_de_fouet = true;
  s.draw("coup_v", a.coup_v, {0.1, 0.3});
  s.drawLog("coup_nuclei_ah", a.coup_nuclei_ah, {0.1, 0.4});
  s.drawLog("coup_erasing_ah", a.coup_erasing_ah, {0.6, 1.6});
  s.draw("coup_nuclei_at_start", a.coup_nuclei_at_start, {0.0, 0.15});
}

void addSelfHeating(Strength& s) {
  BatteryParameters& b = s.scenario().battery;
  s.scenario().effects.self_heating = true;
  s.draw("heat_capacity_j_per_k", b.heat_capacity_j_per_k, {12e3, 13.5e3});
  s.draw("thermal_resistance_k_per_w", b.thermal_resistance_k_per_w, {1.25, 2.0});
  s.draw("activation_j_per_mol", b.activation_j_per_mol, {50e3, 60e3});
}

void addParameterDrift(Strength& s) {
  struct Drifting {
    DriftingParameter parameter;
    Range per_h;
  };
  const std::array<Drifting, 4> all{{{DriftingParameter::kROhmic, {0.6, 1.2}},
                                     {DriftingParameter::kR1, {0.5, 1.0}},
                                     {DriftingParameter::kCpe2Capacitance, {0.6, 1.2}},
                                     {DriftingParameter::kU0, {0.005, 0.015}}}};
  Additions& a = s.scenario().additions;
  const auto which = static_cast<std::size_t>(s.share() * 4.0);
  a.parameter_drift = true;
  a.drifting = all[which].parameter;
  s.set("drift_per_h", a.drift_per_h, s.sign() * s.between(all[which].per_h));
}

void addParasiticLoad(Strength& s) {
  s.draw("parasitic_load_a", s.scenario().additions.parasitic_load_a, {0.2, 0.3});
}

void addCurrentOffset(Strength& s) {
  s.set("current_offset_a", s.scenario().acquisition.current_offset_a,
        s.sign() * s.between({0.7, 2.0}));
}

void addCurrentGain(Strength& s) {
  AcquisitionOptions& a = s.scenario().acquisition;
  const double error = s.sign() * s.between({0.025, 0.05});
  if (s.share() < 0.5)
    s.set("current_gain_charge", a.current_gain_charge, 1.0 + error);
  else
    s.set("current_gain_discharge", a.current_gain_discharge, 1.0 + error);
}

void addTimeSkew(Strength& s) {
  s.set("current_delay_s", s.scenario().acquisition.current_delay_s,
        s.sign() * s.between({0.02, 0.05}));
}

void addSensorLag(Strength& s) {
  AcquisitionOptions& a = s.scenario().acquisition;
  if (s.share() < 0.5)
    s.draw("current_lag_s", a.current_lag_s, {0.04, 0.1});
  else
    s.draw("voltage_lag_s", a.voltage_lag_s, {0.04, 0.1});
}

void addQuantisation(Strength& s) {
  s.draw("voltage_step_v", s.scenario().acquisition.voltage_step_v, {0.01, 0.02});
  s.draw("current_step_a", s.scenario().acquisition.current_step_a, {0.5, 1.0});
}

void addContactStep(Strength& s) {
  Additions& a = s.scenario().additions;
  a.contact_step = true;
  s.draw("contact_ohm", a.contact_ohm, {1e-3, 3e-3});
  s.set("contact_from_s", a.contact_from_s, s.between({0.3, 0.7}) * s.scenario().duration);
}

/// Within what every crank reaches.
void addClipping(Strength& s) {
  AcquisitionOptions& a = s.scenario().acquisition;
  const BatteryParameters& b = s.scenario().battery;
  const double u0 = openCircuitVoltage(b, s.scenario().start.soc).value;
  const double which = s.share();
  if (which < 0.67) s.draw("current_limit_a", a.current_limit_a, {80.0, 130.0});
  if (which > 0.33)
    s.set("voltage_floor_v", a.voltage_floor_v,
          u0 - 0.2 - s.between({90.0, 130.0}) * (b.r_ohmic_ohm + b.r1_discharge_ohm));
}

void addDropouts(Strength& s) {
  AcquisitionOptions& a = s.scenario().acquisition;
  s.draw("lost_share", a.lost_share, {0.02, 0.1});
  s.draw("frozen_per_min", a.frozen_per_min, {2.0, 5.0});
  a.frozen_s = {0.1, 1.5};
}

void addVoltageDrift(Strength& s) {
  s.set("voltage_drift_v_per_h", s.scenario().acquisition.voltage_drift_v_per_h,
        s.sign() * s.between({0.02, 0.06}));
}

/// Not near a multiple of the sample rate, where the tone would be a constant.
void addAliasing(Strength& s) {
  AcquisitionOptions& a = s.scenario().acquisition;
  s.draw("tone_v", a.tone_v, {0.005, 0.02});
  const double turns = std::floor(s.between({1.0, 6.0}));
  s.set("tone_hz", a.tone_hz, (turns + s.between({0.05, 0.95})) * a.sample_rate_hz);
}

void addMemoryResistance(Strength& s) {
  Additions& a = s.scenario().additions;
  a.memory_resistance = true;
  s.draw("memory_ohm_per_a", a.memory_ohm_per_a, {0.6e-4, 1.5e-4});
  s.draw("memory_time_s", a.memory_time_s, {15.0, 60.0});
}

void addStepForce(Strength& s) {
  Additions& a = s.scenario().additions;
  a.step_force = true;
  s.draw("step_force_v", a.step_force_v, {0.05, 0.15});
}

void addGatedTone(Strength& s) {
  Additions& a = s.scenario().additions;
  a.gated_tone = true;
  s.set("gated_tone_v", a.gated_tone_v, 0.02);
  s.draw("gated_tone_period_s", a.gated_tone_period_s, {20.0, 60.0});
}

void addCapacitanceFall(Strength& s) {
  s.scenario().additions.capacitance_fall = true;
  s.set("capacitance_fall_share", s.scenario().additions.capacitance_fall_share, 0.6);
}

void addDeadZone(Strength& s) {
  s.scenario().additions.dead_zone = true;
  s.draw("dead_zone_v", s.scenario().additions.dead_zone_v, {0.02, 0.05});
}

void addHystereticR(Strength& s) {
  Additions& a = s.scenario().additions;
  a.hysteretic_r = true;
  s.draw("hysteretic_ohm", a.hysteretic_ohm, {0.5e-3, 1.2e-3});
  s.draw("hysteretic_from_a", a.hysteretic_from_a, {20.0, 35.0});
}

const std::map<std::string, void (*)(Strength&)>& additionsById() {
  static const std::map<std::string, void (*)(Strength&)> all{
      {"cpe2", addCpe2},
      {"fast_arc", addFastArc},
      {"current_dependent_resistance", addCurrentDependence},
      {"charge_transfer", addChargeTransfer},
      {"second_electrode", addSecondElectrode},
      {"inductance", addInductance},
      {"gassing", addGassing},
      {"charge_acceptance", addChargeAcceptance},
      {"sulphate_history", addSulphateHistory},
      {"acid_transport", addAcidTransport},
      {"ocv_soc", addOcvSlope},
      {"ocv_hysteresis", addOcvHysteresis},
      {"high_rate_depletion", addHighRateDepletion},
      {"coup_de_fouet", addCoupDeFouet},
      {"self_heating", addSelfHeating},
      {"parameter_drift", addParameterDrift},
      {"parasitic_load", addParasiticLoad},
      {"current_offset", addCurrentOffset},
      {"current_gain", addCurrentGain},
      {"time_skew", addTimeSkew},
      {"sensor_lag", addSensorLag},
      {"quantisation", addQuantisation},
      {"contact_resistance", addContactStep},
      {"clipping", addClipping},
      {"dropouts", addDropouts},
      {"voltage_drift", addVoltageDrift},
      {"aliasing", addAliasing},
      {"memory_resistance", addMemoryResistance},
      {"step_force", addStepForce},
      {"gated_tone", addGatedTone},
      {"capacitance_fall", addCapacitanceFall},
      {"dead_zone", addDeadZone},
      {"hysteretic_r", addHystereticR}};
  return all;
}

bool isUnlisted(const std::string& id) {
  const auto& kinds = caseKinds();
  return std::any_of(kinds.begin(), kinds.end(), [&](const CaseKind& kind) {
    return kind.family == "unknown" && kind.id == id;
  });
}

}  // namespace

void addEffect(CaseDraft& draft, const std::string& id, Dice& dice) {
  const auto found = additionsById().find(id);
  if (found == additionsById().end())
    throw std::invalid_argument("no effect is called \"" + id + "\"");
  if (!isUnlisted(id)) draft.effects.push_back(id);
  Strength strength(draft, dice);
  found->second(strength);
}

void addPorousEffect(CaseDraft& draft, const std::string& id, Dice& dice) {
  if (!draft.porous) throw std::invalid_argument("the case has no porous block");
  PorousParameters& p = *draft.porous;
  Strength s(draft, dice);
  if (id == "acid_transport") {
    s.draw("diffusion_factor", p.diffusion_factor, {0.3, 0.5});
    return;
  }
  if (id != "charge_acceptance" && id != "gassing")
    throw std::invalid_argument("a porous block has no effect \"" + id + "\"");
  s.alsoTrue("charge_acceptance");
  p.lead_ion = true;
  if (id == "charge_acceptance") {
    s.drawLog("lead_ion_limit_a", p.lead_ion_limit_a, {20.0, 70.0});
    s.drawLog("lead_ion_time_s", p.lead_ion_time_s, {3.0, 40.0});
    return;
  }
  s.alsoTrue("gassing");
  p.gassing = true;
  s.draw("lead_ion_limit_a", p.lead_ion_limit_a, {12.0, 25.0});
  s.draw("lead_ion_time_s", p.lead_ion_time_s, {3.0, 15.0});
  s.draw("gas_current_a", p.gas_current_a, {0.3, 1.0});
  s.draw("gas_slope_per_v", p.gas_slope_per_v, {15.0, 22.0});
}

}  // namespace battery_sof_reference
