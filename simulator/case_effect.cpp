#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>

#include "simulator/case_strength.hpp"

namespace battery_sof_reference {
namespace {

constexpr double kMinCapacitance = 300.0;   // [F] (docs/physics.md#second_electrode)
constexpr double kDistinct = 4.0;           // ratio of time constants
constexpr Range kLeadIonLimit{20.0, 70.0};  // [A]
constexpr Range kLeadIonTime{3.0, 40.0};    // [s]

void addCpe2(Strength& s) {
  s.scenario().effects.cpe2_fractional = true;
  s.set("cpe2_exponent", s.scenario().battery.cpe2_exponent,
        1.0 - s.scale() * (1.0 - s.between({0.75, 0.88})));
}

void addFastArc(Strength& s) {
  Additions& a = s.scenario().additions;
  a.fast_arc = s.present();
  s.drawAmplitude("fast_arc_ohm", a.fast_arc_ohm, {1e-3, 2e-3});
  s.drawLog("fast_arc_time_s", a.fast_arc_time_s, {0.05, 0.4});
}

/// r_1 of both directions falls with current; at small current it is r_x more than at large. A
/// scale below 1 takes back the share of r_1 that falls, one above 1 makes r_x larger.
void addCurrentDependence(Strength& s) {
  BatteryParameters& b = s.scenario().battery;
  s.scenario().effects.r1_current_dependence = s.present();
  const double as_drawn = s.between({3e-3, 6e-3}), extra = std::max(1.0, s.scale()) * as_drawn;
  double r_x = 0.0;
  s.set("r_x_ohm", r_x, s.scale() * as_drawn);
  b.r1_knee_share = std::min(1.0, s.scale());
  s.drawLog("r1_knee_current_a", b.r1_knee_current_a, {8.0, 40.0});
  const double smallest = std::min(b.r1_discharge_ohm, b.r1_charge_ohm);
  b.r_ohmic_ohm += smallest - std::min(smallest, 0.3 * extra);
  b.r1_discharge_ohm += extra - smallest;
  b.r1_charge_ohm += extra - smallest;
}

void addChargeTransfer(Strength& s) {
  BatteryParameters& b = s.scenario().battery;
  if (s.share() < 0.5)
    s.set("i0_a", b.i0_a,
          std::pow(s.share() < 0.5 ? s.between({0.2, 0.4}) : s.between({2.5, 5.0}), s.scale()));
  else
    s.set("alpha", b.alpha, 0.5 + s.scale() * (s.sign() * s.between({0.1, 0.2})));
}

/// With C_3 beta_3 far from C_2 beta: two electrodes of one time constant are one. The scale acts
/// on 1/beta_3 and on C_3, so that C_3 / (I_03 beta_3) stays, and u_3 is the scale times what it
/// was.
void addSecondElectrode(Strength& s) {
  const BatteryParameters& b = s.scenario().battery;
  Additions& a = s.scenario().additions;
  a.second_electrode = s.present();
  const double beta = 1.0 / s.between({0.02, 0.04});
  s.setLimit("electrode3_beta_per_v", a.electrode3_beta_per_v, beta);
  const double alike = b.beta_per_v * b.cpe2_capacitance_f / beta;
  const bool faster = kDistinct * kMinCapacitance < alike;
  s.drawLogLimit(
      "electrode3_capacitance_f", a.electrode3_capacitance_f,
      faster ? Range{kMinCapacitance, alike / kDistinct} : Range{kDistinct * alike, 6000.0});
  s.set("electrode3_exponent", a.electrode3_exponent,
        s.share() < 0.5 ? 1.0 : s.between({0.85, 1.0}));
}

void addInductance(Strength& s) {
  s.scenario().effects.inductance = s.present();
  s.drawAmplitude("inductance_h", s.scenario().battery.inductance_h, {1.5e-6, 3e-6});
}

void addChargeAcceptance(Strength& s) {
  s.scenario().effects.charge_acceptance = s.present();
  s.drawLogLimit("lead_ion_limit_a", s.scenario().battery.lead_ion_limit_a, kLeadIonLimit);
  s.drawLog("lead_ion_time_s", s.scenario().battery.lead_ion_time_s, kLeadIonTime);
}

/// With a limited main reaction: only where that no longer takes the current does a side reaction
/// show.
void addGassing(Strength& s) {
  addCompanion(s, {12.0, 25.0}, {3.0, 15.0});
  addSideReaction(s);
}

void addSulphateHistory(Strength& s) {
  BatteryParameters& b = s.scenario().battery;
  s.scenario().effects.charge_acceptance = true;
  s.drawLog("lead_ion_limit_a", b.lead_ion_limit_a, kLeadIonLimit);
  s.drawLog("lead_ion_time_s", b.lead_ion_time_s, kLeadIonTime);
  s.alsoTrue("charge_acceptance");
  Additions& a = s.scenario().additions;
  a.sulphate_history = s.present();
  s.drawLogLimit("sulphate_ah", a.sulphate_ah, {0.2, 0.8});
  s.drawLog("sulphate_time_s", a.sulphate_time_s, {300.0, 1800.0});
  s.draw("sulphate_charge_share", a.sulphate_charge_share, {0.6, 1.0});
}

void addAcidTransport(Strength& s) {
  Additions& a = s.scenario().additions;
  a.acid_transport = s.present();
  s.drawAmplitude("acid_1_ohm", a.acid_1_ohm, {1.75e-3, 3e-3});
  s.drawLog("acid_1_time_s", a.acid_1_time_s, {20.0, 100.0});
  s.drawAmplitude("acid_2_ohm", a.acid_2_ohm, {3.5e-3, 6e-3});
  s.drawLog("acid_2_time_s", a.acid_2_time_s, {150.0, 1500.0});
}

/// u_0 at the start stays as drawn.
void addOcvSlope(Strength& s) {
  BatteryParameters& b = s.scenario().battery;
  const double below = s.scenario().start.soc - 0.8;
  const double u0 = b.u0_v + b.u0_slope_v * below;
  s.scenario().effects.ocv_slope = s.present();
  s.drawAmplitude("u0_slope_v", b.u0_slope_v, {1.5, 1.8});
  b.u0_v = u0 - b.u0_slope_v * below;
}

void addOcvHysteresis(Strength& s) {
  Additions& a = s.scenario().additions;
  a.ocv_hysteresis = s.present();
  s.drawAmplitude("hysteresis_v", a.hysteresis_v, {0.02, 0.04});
  s.drawLog("hysteresis_ah", a.hysteresis_ah, {0.05, 0.4});
}

void addHighRateDepletion(Strength& s) {
  Additions& a = s.scenario().additions;
  a.high_rate_depletion = s.present();
  s.draw("depletion_v", a.depletion_v, {0.17, 0.25});
  s.drawLogLimit("depletion_limit_a", a.depletion_limit_a, {300.0, 600.0});
  s.draw("depletion_time_s", a.depletion_time_s, {10.0, 60.0});
}

void addCoupDeFouet(Strength& s) {
  Additions& a = s.scenario().additions;
  a.coup_de_fouet = s.present();
  s.drawAmplitude("coup_v", a.coup_v, {0.1, 0.3});
  s.drawLog("coup_nuclei_ah", a.coup_nuclei_ah, {0.1, 0.4});
  s.drawLog("coup_erasing_ah", a.coup_erasing_ah, {0.6, 1.6});
  s.draw("coup_nuclei_at_start", a.coup_nuclei_at_start, {0.0, 0.15});
}

/// The scale acts on 1/C_th and on R_th: the time constant stays, the warming is in proportion.
void addSelfHeating(Strength& s) {
  BatteryParameters& b = s.scenario().battery;
  s.scenario().effects.self_heating = s.present();
  s.drawLimit("heat_capacity_j_per_k", b.heat_capacity_j_per_k, {12e3, 13.5e3});
  s.drawAmplitude("thermal_resistance_k_per_w", b.thermal_resistance_k_per_w, {1.25, 2.0});
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
  a.parameter_drift = s.present();
  a.drifting = all[which].parameter;
  s.set("drift_per_h", a.drift_per_h, s.scale() * (s.sign() * s.between(all[which].per_h)));
}

void addParasiticLoad(Strength& s) {
  s.drawAmplitude("parasitic_load_a", s.scenario().additions.parasitic_load_a, {0.2, 0.3});
}

const std::map<std::string, void (*)(Strength&)>& effectsById() {
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
      {"parasitic_load", addParasiticLoad}};
  return all;
}

}  // namespace

void addCompanion(Strength& s, const Range& limit_a, const Range& time_s) {
  s.scenario().effects.charge_acceptance = true;
  s.draw("lead_ion_limit_a", s.scenario().battery.lead_ion_limit_a, limit_a);
  s.draw("lead_ion_time_s", s.scenario().battery.lead_ion_time_s, time_s);
  s.alsoTrue("charge_acceptance");
}

void addSideReaction(Strength& s) {
  BatteryParameters& b = s.scenario().battery;
  s.scenario().effects.gassing = s.present() ? GassingLaw::kTafel : GassingLaw::kNone;
  s.drawAmplitude("gas_current_a", b.gas_current_a, {1.5, 3.0});
  s.draw("gas_slope_per_v", b.gas_slope_per_v, {1.4, 3.0});
}

void addEffect(CaseDraft& draft, const std::string& id, Dice& dice, double scale) {
  Strength strength(draft, dice, scale);
  if (isFault(id)) return addFault(strength, id);
  const auto found = effectsById().find(id);
  if (found == effectsById().end())
    throw std::invalid_argument("no effect is called \"" + id + "\"");
  if (strength.present()) strength.alsoTrue(id);
  found->second(strength);
}

void addPorousEffect(CaseDraft& draft, const std::string& id, Dice& dice, double scale) {
  if (!draft.porous) throw std::invalid_argument("the case has no porous block");
  PorousParameters& p = *draft.porous;
  Strength s(draft, dice, scale);
  if (id == "acid_transport") {
    // gamma: what 1 / diffusion_factor is more than the block's own.
    const double own = p.diffusion_factor, slow = s.between({0.3, 0.5});
    s.set("diffusion_factor", p.diffusion_factor, own / (1.0 + scale * (own / slow - 1.0)));
    return;
  }
  if (id != "charge_acceptance" && id != "gassing")
    throw std::invalid_argument("a porous block has no effect \"" + id + "\"");
  if (s.present() || id == "gassing") s.alsoTrue("charge_acceptance");
  p.lead_ion = s.present() || id == "gassing";
  if (id == "charge_acceptance") {
    s.drawLogLimit("lead_ion_limit_a", p.lead_ion_limit_a, kLeadIonLimit);
    s.drawLog("lead_ion_time_s", p.lead_ion_time_s, kLeadIonTime);
    return;
  }
  if (s.present()) s.alsoTrue("gassing");
  p.gassing = s.present();
  s.draw("lead_ion_limit_a", p.lead_ion_limit_a, {12.0, 25.0});
  s.draw("lead_ion_time_s", p.lead_ion_time_s, {3.0, 15.0});
  s.drawAmplitude("gas_current_a", p.gas_current_a, {0.3, 1.0});
  s.draw("gas_slope_per_v", p.gas_slope_per_v, {15.0, 22.0});
}

}  // namespace battery_sof_reference
