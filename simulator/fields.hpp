#pragma once

#include <array>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "simulator/acquisition.hpp"
#include "simulator/additions.hpp"
#include "simulator/battery_parameters.hpp"
#include "simulator/drive_plan.hpp"
#include "simulator/porous_block.hpp"

namespace battery_sof_simulator {

/// A value of an enumeration and its name in files.
template <typename Enum>
struct Choice {
  const char* name;
  Enum value;
};
constexpr std::array<Choice<GassingLaw>, 3> kGassingLaws{{{"none", GassingLaw::kNone},
                                                          {"threshold", GassingLaw::kThreshold},
                                                          {"tafel", GassingLaw::kTafel}}};
constexpr std::array<Choice<DriftingParameter>, 4> kDriftingParameters{
    {{"r_ohmic", DriftingParameter::kROhmic},
     {"r1", DriftingParameter::kR1},
     {"cpe2_capacitance", DriftingParameter::kCpe2Capacitance},
     {"u0", DriftingParameter::kU0}}};

/**
 * Every option of a scenario with its key and its bounds, said once: the reader of scenario files
 * and the check of values both visit them. A visitor has number(), count(), range() (key, value,
 * lowest, highest), flag() and choice().
 */
template <typename Visitor>
void visitFields(Visitor& visitor, BatteryParameters& p) {
  visitor.number("capacity_ah", p.capacity_ah, 1.0, 1000.0);
  visitor.number("inductance_h", p.inductance_h, 0.0, 1e-4);
  visitor.number("r_ohmic_ohm", p.r_ohmic_ohm, 1e-5, 1.0);
  visitor.number("r1_charge_ohm", p.r1_charge_ohm, 1e-5, 1.0);
  visitor.number("r1_discharge_ohm", p.r1_discharge_ohm, 1e-5, 1.0);
  visitor.number("r1_knee_current_a", p.r1_knee_current_a, 0.1, 1e6);
  visitor.number("r1_knee_share", p.r1_knee_share, 0.0, 1.0);
  visitor.number("r1_transition_a", p.r1_transition_a, 0.01, 1000.0);
  visitor.number("r1_transition_at_a", p.r1_transition_at_a, -100.0, 100.0);
  visitor.number("cpe1_exponent", p.cpe1_exponent, 0.1, 1.0);
  visitor.number("cpe1_corner_hz", p.cpe1_corner_hz, 0.01, 1e4);
  visitor.number("i0_a", p.i0_a, 1e-3, 1000.0);
  visitor.number("alpha", p.alpha, 0.05, 0.95);
  visitor.number("beta_per_v", p.beta_per_v, 1.0, 200.0);
  visitor.number("cpe2_exponent", p.cpe2_exponent, 0.1, 1.0);
  visitor.number("cpe2_capacitance_f", p.cpe2_capacitance_f, 1.0, 1e6);
  visitor.number("cpe2_reference_rad_per_s", p.cpe2_reference_rad_per_s, 1e-4, 1e3);
  visitor.number("u0_v", p.u0_v, 1.0, 100.0);
  visitor.number("u0_slope_v", p.u0_slope_v, 0.0, 100.0);
  visitor.number("u_gas_v", p.u_gas_v, 1.0, 100.0);
  visitor.number("r_gas_ohm", p.r_gas_ohm, 1e-3, 1e6);
  visitor.number("gas_current_a", p.gas_current_a, 0.0, 100.0);
  visitor.number("gas_slope_per_v", p.gas_slope_per_v, 0.0, 20.0);
  visitor.number("gas_slope_per_k", p.gas_slope_per_k, 0.0, 1.0);
  visitor.number("lead_ion_limit_a", p.lead_ion_limit_a, 0.1, 1e9);
  visitor.number("lead_ion_time_s", p.lead_ion_time_s, 0.1, 1e4);
  visitor.number("lead_ion_halving_k", p.lead_ion_halving_k, 1.0, 1e3);
  visitor.number("r_per_k", p.r_per_k, -0.015, 0.015);
  visitor.number("activation_j_per_mol", p.activation_j_per_mol, 0.0, 2e5);
  visitor.number("heat_capacity_j_per_k", p.heat_capacity_j_per_k, 10.0, 1e9);
  visitor.number("thermal_resistance_k_per_w", p.thermal_resistance_k_per_w, 1e-6, 1e3);
}

template <typename Visitor>
void visitFields(Visitor& visitor, BatteryEffects& e) {
  visitor.flag("inductance", e.inductance);
  visitor.flag("r1_asymmetry", e.r1_asymmetry);
  visitor.flag("r1_smooth", e.r1_smooth);
  visitor.flag("r1_current_dependence", e.r1_current_dependence);
  visitor.flag("cpe1", e.cpe1);
  visitor.flag("cpe1_fractional", e.cpe1_fractional);
  visitor.flag("cpe2_fractional", e.cpe2_fractional);
  visitor.flag("ocv_slope", e.ocv_slope);
  visitor.choice("gassing", e.gassing, kGassingLaws);
  visitor.flag("charge_acceptance", e.charge_acceptance);
  visitor.flag("self_heating", e.self_heating);
}

/// Physics that the battery may have beyond Fig. 4.
template <typename Visitor>
void visitPhysics(Visitor& visitor, Additions& a) {
  visitor.flag("second_electrode", a.second_electrode);
  visitor.number("electrode3_capacitance_f", a.electrode3_capacitance_f, 1.0, 1e9);
  visitor.number("electrode3_exponent", a.electrode3_exponent, 0.1, 1.0);
  visitor.number("electrode3_i0_a", a.electrode3_i0_a, 1e-3, 1000.0);
  visitor.number("electrode3_beta_per_v", a.electrode3_beta_per_v, 1.0, 1e6);
  visitor.flag("fast_arc", a.fast_arc);
  visitor.number("fast_arc_ohm", a.fast_arc_ohm, 0.0, 1.0);
  visitor.number("fast_arc_time_s", a.fast_arc_time_s, 1e-4, 100.0);
  visitor.flag("acid_transport", a.acid_transport);
  visitor.number("acid_1_ohm", a.acid_1_ohm, 0.0, 1.0);
  visitor.number("acid_1_time_s", a.acid_1_time_s, 0.1, 1e6);
  visitor.number("acid_2_ohm", a.acid_2_ohm, 0.0, 1.0);
  visitor.number("acid_2_time_s", a.acid_2_time_s, 0.1, 1e6);
  visitor.flag("ocv_hysteresis", a.ocv_hysteresis);
  visitor.number("hysteresis_v", a.hysteresis_v, 0.0, 10.0);
  visitor.number("hysteresis_ah", a.hysteresis_ah, 1e-3, 1000.0);
  visitor.flag("high_rate_depletion", a.high_rate_depletion);
  visitor.number("depletion_v", a.depletion_v, 0.0, 10.0);
  visitor.number("depletion_limit_a", a.depletion_limit_a, 1.0, 1e9);
  visitor.number("depletion_time_s", a.depletion_time_s, 0.01, 1e5);
  visitor.flag("coup_de_fouet", a.coup_de_fouet);
  visitor.number("coup_v", a.coup_v, 0.0, 10.0);
  visitor.number("coup_onset_ah", a.coup_onset_ah, 1e-4, 100.0);
  visitor.number("coup_nuclei_ah", a.coup_nuclei_ah, 1e-3, 1000.0);
  visitor.number("coup_erasing_ah", a.coup_erasing_ah, 1e-3, 1000.0);
  visitor.number("coup_nuclei_at_start", a.coup_nuclei_at_start, 0.0, 1.0);
  visitor.flag("sulphate_history", a.sulphate_history);
  visitor.number("sulphate_ah", a.sulphate_ah, 1e-3, 1e6);
  visitor.number("sulphate_time_s", a.sulphate_time_s, 0.1, 1e6);
  visitor.number("sulphate_charge_share", a.sulphate_charge_share, 0.0, 10.0);
  visitor.number("sulphate_least", a.sulphate_least, 1e-3, 1.0);
}

/// Faults around the battery, drifts, and laws that are in no catalogue.
template <typename Visitor>
void visitFaultsAndUnlistedLaws(Visitor& visitor, Additions& a) {
  visitor.flag("parameter_drift", a.parameter_drift);
  visitor.choice("drifting", a.drifting, kDriftingParameters);
  visitor.number("drift_per_h", a.drift_per_h, -10.0, 10.0);
  visitor.number("parasitic_load_a", a.parasitic_load_a, 0.0, 100.0);
  visitor.flag("contact_step", a.contact_step);
  visitor.number("contact_ohm", a.contact_ohm, 0.0, 1.0);
  visitor.number("contact_from_s", a.contact_from_s, 0.0, 1e6);
  visitor.flag("memory_resistance", a.memory_resistance);
  visitor.number("memory_ohm_per_a", a.memory_ohm_per_a, 0.0, 1.0);
  visitor.number("memory_time_s", a.memory_time_s, 0.01, 1e5);
  visitor.flag("step_force", a.step_force);
  visitor.number("step_force_v", a.step_force_v, 0.0, 10.0);
  visitor.number("step_force_above_a", a.step_force_above_a, 0.0, 2000.0);
  visitor.flag("gated_tone", a.gated_tone);
  visitor.number("gated_tone_v", a.gated_tone_v, 0.0, 10.0);
  visitor.number("gated_tone_period_s", a.gated_tone_period_s, 0.1, 1e5);
  visitor.flag("capacitance_fall", a.capacitance_fall);
  visitor.number("capacitance_fall_share", a.capacitance_fall_share, 0.0, 0.99);
  visitor.flag("dead_zone", a.dead_zone);
  visitor.number("dead_zone_v", a.dead_zone_v, 0.0, 1.0);
  visitor.flag("hysteretic_r", a.hysteretic_r);
  visitor.number("hysteretic_ohm", a.hysteretic_ohm, 0.0, 1.0);
  visitor.number("hysteretic_from_a", a.hysteretic_from_a, 0.0, 2000.0);
}

template <typename Visitor>
void visitFields(Visitor& visitor, Additions& a) {
  visitPhysics(visitor, a);
  visitFaultsAndUnlistedLaws(visitor, a);
}

template <typename Visitor>
void visitFields(Visitor& visitor, PorousParameters& p) {
  visitor.number("capacity_ah", p.capacity_ah, 1.0, 1000.0);
  visitor.number("area_m2", p.area_m2, 1e-3, 10.0);
  visitor.number("negative_m", p.negative_m, 1e-4, 1e-2);
  visitor.number("separator_m", p.separator_m, 1e-4, 1e-2);
  visitor.number("positive_m", p.positive_m, 1e-4, 1e-2);
  visitor.number("negative_porosity", p.negative_porosity, 0.3, 0.95);
  visitor.number("separator_porosity", p.separator_porosity, 0.3, 1.0);
  visitor.number("positive_porosity", p.positive_porosity, 0.3, 0.95);
  visitor.number("grid_ohm", p.grid_ohm, 0.0, 1.0);
  visitor.number("full_acid_mol_per_m3", p.full_acid_mol_per_m3, 1000.0, 8000.0);
  visitor.number("negative_surface_per_m", p.negative_surface_per_m, 1e4, 1e9);
  visitor.number("positive_surface_per_m", p.positive_surface_per_m, 1e4, 1e9);
  visitor.number("negative_exchange_a_per_m2", p.negative_exchange_a_per_m2, 1e-6, 100.0);
  visitor.number("positive_exchange_a_per_m2", p.positive_exchange_a_per_m2, 1e-6, 100.0);
  visitor.number("negative_layer_f_per_m2", p.negative_layer_f_per_m2, 1e-3, 100.0);
  visitor.number("positive_layer_f_per_m2", p.positive_layer_f_per_m2, 1e-3, 100.0);
  visitor.number("diffusion_factor", p.diffusion_factor, 0.01, 100.0);
  visitor.flag("gassing", p.gassing);
  visitor.number("gas_current_a", p.gas_current_a, 0.0, 100.0);
  visitor.number("oxygen_potential_v", p.oxygen_potential_v, 1.0, 3.0);
  visitor.number("hydrogen_potential_v", p.hydrogen_potential_v, -2.0, 0.0);
  visitor.number("gas_slope_per_v", p.gas_slope_per_v, 0.0, 60.0);
  visitor.flag("lead_ion", p.lead_ion);
  visitor.number("lead_ion_limit_a", p.lead_ion_limit_a, 0.1, 1e9);
  visitor.number("lead_ion_time_s", p.lead_ion_time_s, 0.1, 1e4);
  visitor.count("cells_per_region", p.cells_per_region, 3, 30);
}

template <typename Visitor>
void visitFields(Visitor& visitor, AcquisitionOptions& a) {
  visitor.number("sample_rate_hz", a.sample_rate_hz, 1.0, 1000.0);
  visitor.number("cutoff_hz", a.cutoff_hz, 0.0, 490.0);
  visitor.number("voltage_white_v", a.voltage_noise.white, 0.0, 10.0);
  visitor.number("voltage_correlated_v", a.voltage_noise.correlated, 0.0, 10.0);
  visitor.number("voltage_correlation_time_s", a.voltage_noise.correlation_time, 1e-3, 1e6);
  visitor.number("voltage_walk_v_per_sqrt_min", a.voltage_noise.walk_per_sqrt_min, 0.0, 10.0);
  visitor.number("current_white_a", a.current_noise.white, 0.0, 100.0);
  visitor.number("current_correlated_a", a.current_noise.correlated, 0.0, 100.0);
  visitor.number("current_correlation_time_s", a.current_noise.correlation_time, 1e-3, 1e6);
  visitor.number("current_walk_a_per_sqrt_min", a.current_noise.walk_per_sqrt_min, 0.0, 100.0);
  visitor.number("voltage_step_v", a.voltage_step_v, 0.0, 10.0);
  visitor.number("current_step_a", a.current_step_a, 0.0, 100.0);
  visitor.number("current_offset_a", a.current_offset_a, -100.0, 100.0);
  visitor.number("current_gain", a.current_gain, -10.0, 10.0);
  visitor.number("current_delay_s", a.current_delay_s, -1.0, 1.0);
  visitor.number("current_gain_charge", a.current_gain_charge, 0.01, 10.0);
  visitor.number("current_gain_discharge", a.current_gain_discharge, 0.01, 10.0);
  visitor.number("current_lag_s", a.current_lag_s, 0.0, 10.0);
  visitor.number("voltage_lag_s", a.voltage_lag_s, 0.0, 10.0);
  visitor.number("voltage_drift_v_per_h", a.voltage_drift_v_per_h, -10.0, 10.0);
  visitor.number("current_limit_a", a.current_limit_a, 0.1, kNoLimit);
  visitor.number("voltage_floor_v", a.voltage_floor_v, -kNoLimit, kNoLimit);
  visitor.number("voltage_ceiling_v", a.voltage_ceiling_v, -kNoLimit, kNoLimit);
  visitor.number("lost_share", a.lost_share, 0.0, 0.9);
  visitor.number("frozen_per_min", a.frozen_per_min, 0.0, 60.0);
  visitor.range("frozen_s", a.frozen_s, 0.0, 1e4);
  visitor.number("tone_v", a.tone_v, 0.0, 10.0);
  visitor.number("tone_hz", a.tone_hz, 0.0, 1e6);
}

template <typename Visitor>
void visitFields(Visitor& visitor, AlternatingOptions& o) {
  visitor.range("charge_a", o.charge_a, 0.0, 2000.0);
  visitor.range("discharge_a", o.discharge_a, 0.0, 2000.0);
  visitor.range("turn_s", o.turn_s, 0.001, 1e5);
  visitor.number("rest_share", o.rest_share, 0.0, 1.0);
  visitor.range("rest_s", o.rest_s, 0.001, 1e5);
  visitor.number("charge_target_ah", o.charge_target_ah, -1000.0, 1000.0);
  visitor.count("pulse_count", o.pulses.count, 0, 100000);
  visitor.range("pulse_a", o.pulses.current_a, 0.0, 2000.0);
  visitor.number("pulse_s", o.pulses.duration_s, 0.001, 1e5);
}

template <typename Visitor>
void visitFields(Visitor& visitor, LongChargesOptions& o) {
  visitFields(visitor, o.turns);
  visitor.number("long_charges_from_s", o.from_s, 0.0, 1e6);
  visitor.range("long_charge_a", o.long_charge_a, 0.1, 2000.0);
  visitor.range("long_charge_s", o.long_charge_s, 0.001, 1e5);
  visitor.range("after_a", o.after_a, 0.0, 2000.0);
  visitor.range("after_s", o.after_s, 0.001, 1e5);
  visitor.number("highest_charge_ah", o.highest_charge_ah, -1000.0, 1000.0);
  visitor.number("final_hold_a", o.final_hold_a, 0.0, 2000.0);
  visitor.number("final_hold_s", o.final_hold_s, 0.001, 1e5);
  visitor.number("final_peak_a", o.final_peak_a, 0.0, 2000.0);
  visitor.number("final_s", o.final_s, 0.002, 1e5);
  visitor.number("final_rest_s", o.final_rest_s, 0.0, 1e5);
}

template <typename Visitor>
void visitFields(Visitor& visitor, CityOptions& o) {
  visitor.range("stop_a", o.stop_a, 0.0, 2000.0);
  visitor.range("stop_s", o.stop_s, 0.001, 1e5);
  visitor.range("inrush_a", o.inrush_a, 0.0, 2000.0);
  visitor.number("inrush_s", o.inrush_s, 0.001, 1e3);
  visitor.range("crank_a", o.crank_a, 0.0, 2000.0);
  visitor.range("crank_s", o.crank_s, 0.001, 1e3);
  visitor.range("rounds", o.rounds, 0.0, 1000.0);
  visitor.range("accelerate_a", o.accelerate_a, 0.0, 2000.0);
  visitor.range("accelerate_s", o.accelerate_s, 0.001, 1e5);
  visitor.range("cruise_a", o.cruise_a, 0.0, 2000.0);
  visitor.range("cruise_s", o.cruise_s, 0.001, 1e5);
  visitor.number("braking_share", o.braking_share, 0.0, 1.0);
  visitor.range("braking_a", o.braking_a, 0.0, 2000.0);
  visitor.range("braking_s", o.braking_s, 0.001, 1e5);
  visitor.number("net_charge_ah", o.net_charge_ah, -1000.0, 1000.0);
  visitor.count("early_cranks", o.early_cranks, 0, 10000);
  visitor.number("early_s", o.early_s, 1.0, 1e6);
}

template <typename Visitor>
void visitFields(Visitor& visitor, Phase& phase) {
  visitor.number("duration_s", phase.duration, 0.001, 1e6);
  visitor.number("current_a", phase.begin, -2000.0, 2000.0);
  visitor.number("to_current_a", phase.end, -2000.0, 2000.0);
  visitor.number("voltage_limit_v", phase.voltage_limit, 1.0, kScenarioVoltageLimit);
}

/// A visitor that collects one sentence for every value outside its bounds.
class FieldJudge {
 public:
  explicit FieldJudge(std::string prefix = "") : prefix_(std::move(prefix)) {}

  void number(const std::string& key, double value, double lowest, double highest) {
    if (value >= lowest && value <= highest) return;
    std::ostringstream text;
    text << prefix_ << key << " is " << value << ", expected " << lowest << " to " << highest;
    faults_.push_back(text.str());
  }
  void count(const std::string& key, int value, int lowest, int highest) {
    number(key, value, lowest, highest);
  }
  void range(const std::string& key, const Range& range, double lowest, double highest) {
    number(key, range.low, lowest, highest);
    number(key, range.high, lowest, highest);
    if (range.low > range.high) faults_.push_back(prefix_ + key + " begins above its end");
  }
  void flag(const std::string&, bool) {}
  template <typename Enum, std::size_t count>
  void choice(const std::string&, Enum, const std::array<Choice<Enum>, count>&) {}

  const std::vector<std::string>& faults() const { return faults_; }

 private:
  std::string prefix_;
  std::vector<std::string> faults_;
};

/// @return one sentence for every field of `options` outside its bounds.
template <typename Options>
std::vector<std::string> fieldFaults(Options options) {
  FieldJudge judge;
  visitFields(judge, options);
  return judge.faults();
}

}  // namespace battery_sof_simulator
