#include "simulator/fields.hpp"

#include <sstream>

namespace battery_sof_simulator {

Fields fieldsOf(BatteryParameters& p) {
  return {{"capacity_ah", &p.capacity_ah, 1.0, 1000.0},
          {"inductance_h", &p.inductance_h, 0.0, 1e-4},
          {"r_ohmic_ohm", &p.r_ohmic_ohm, 1e-5, 1.0},
          {"r1_charge_ohm", &p.r1_charge_ohm, 1e-5, 1.0},
          {"r1_discharge_ohm", &p.r1_discharge_ohm, 1e-5, 1.0},
          {"r1_knee_current_a", &p.r1_knee_current_a, 0.1, 1e6},
          {"r1_knee_share", &p.r1_knee_share, 0.0, 1.0},
          {"r1_transition_a", &p.r1_transition_a, 0.01, 1000.0},
          {"r1_transition_at_a", &p.r1_transition_at_a, -100.0, 100.0},
          {"cpe1_exponent", &p.cpe1_exponent, 0.1, 1.0},
          {"cpe1_corner_hz", &p.cpe1_corner_hz, 0.01, 1e4},
          {"i0_a", &p.i0_a, 1e-3, 1000.0},
          {"alpha", &p.alpha, 0.05, 0.95},
          {"beta_per_v", &p.beta_per_v, 1.0, 200.0},
          {"cpe2_exponent", &p.cpe2_exponent, 0.1, 1.0},
          {"cpe2_capacitance_f", &p.cpe2_capacitance_f, 1.0, 1e6},
          {"cpe2_reference_rad_per_s", &p.cpe2_reference_rad_per_s, 1e-4, 1e3},
          {"u0_v", &p.u0_v, 1.0, 100.0},
          {"u0_slope_v", &p.u0_slope_v, 0.0, 100.0},
          {"u_gas_v", &p.u_gas_v, 1.0, 100.0},
          {"r_gas_ohm", &p.r_gas_ohm, 1e-3, 1e6},
          {"gas_current_a", &p.gas_current_a, 0.0, 100.0},
          {"gas_slope_per_v", &p.gas_slope_per_v, 0.0, 20.0},
          {"gas_slope_per_k", &p.gas_slope_per_k, 0.0, 1.0},
          {"lead_ion_limit_a", &p.lead_ion_limit_a, 0.1, 1e9},
          {"lead_ion_time_s", &p.lead_ion_time_s, 0.1, 1e4},
          {"lead_ion_halving_k", &p.lead_ion_halving_k, 1.0, 1e3},
          {"r_per_k", &p.r_per_k, -0.015, 0.015},
          {"activation_j_per_mol", &p.activation_j_per_mol, 0.0, 2e5},
          {"heat_capacity_j_per_k", &p.heat_capacity_j_per_k, 10.0, 1e9},
          {"thermal_resistance_k_per_w", &p.thermal_resistance_k_per_w, 1e-6, 1e3}};
}

Fields fieldsOf(BatteryEffects& e) {
  return {{"inductance", &e.inductance},
          {"r1_asymmetry", &e.r1_asymmetry},
          {"r1_smooth", &e.r1_smooth},
          {"r1_current_dependence", &e.r1_current_dependence},
          {"cpe1", &e.cpe1},
          {"cpe1_fractional", &e.cpe1_fractional},
          {"cpe2_fractional", &e.cpe2_fractional},
          {"ocv_slope", &e.ocv_slope},
          {"gassing", &e.gassing},
          {"charge_acceptance", &e.charge_acceptance},
          {"self_heating", &e.self_heating}};
}

Fields fieldsOf(Additions& a) {
  return {{"second_electrode", &a.second_electrode},
          {"electrode3_capacitance_f", &a.electrode3_capacitance_f, 1.0, 1e9},
          {"electrode3_exponent", &a.electrode3_exponent, 0.1, 1.0},
          {"electrode3_i0_a", &a.electrode3_i0_a, 1e-3, 1000.0},
          {"electrode3_beta_per_v", &a.electrode3_beta_per_v, 1.0, 1e6},
          {"fast_arc", &a.fast_arc},
          {"fast_arc_ohm", &a.fast_arc_ohm, 0.0, 1.0},
          {"fast_arc_time_s", &a.fast_arc_time_s, 1e-4, 100.0},
          {"acid_transport", &a.acid_transport},
          {"acid_1_ohm", &a.acid_1_ohm, 0.0, 1.0},
          {"acid_1_time_s", &a.acid_1_time_s, 0.1, 1e6},
          {"acid_2_ohm", &a.acid_2_ohm, 0.0, 1.0},
          {"acid_2_time_s", &a.acid_2_time_s, 0.1, 1e6},
          {"ocv_hysteresis", &a.ocv_hysteresis},
          {"hysteresis_v", &a.hysteresis_v, 0.0, 10.0},
          {"hysteresis_ah", &a.hysteresis_ah, 1e-3, 1000.0},
          {"high_rate_depletion", &a.high_rate_depletion},
          {"depletion_v", &a.depletion_v, 0.0, 10.0},
          {"depletion_limit_a", &a.depletion_limit_a, 1.0, 1e9},
          {"depletion_time_s", &a.depletion_time_s, 0.01, 1e5},
          {"coup_de_fouet", &a.coup_de_fouet},
          {"coup_v", &a.coup_v, 0.0, 10.0},
          {"coup_onset_ah", &a.coup_onset_ah, 1e-4, 100.0},
          {"coup_nuclei_ah", &a.coup_nuclei_ah, 1e-3, 1000.0},
          {"coup_erasing_ah", &a.coup_erasing_ah, 1e-3, 1000.0},
          {"coup_nuclei_at_start", &a.coup_nuclei_at_start, 0.0, 1.0},
          {"sulphate_history", &a.sulphate_history},
          {"sulphate_ah", &a.sulphate_ah, 1e-3, 1e6},
          {"sulphate_time_s", &a.sulphate_time_s, 0.1, 1e6},
          {"sulphate_charge_share", &a.sulphate_charge_share, 0.0, 10.0},
          {"sulphate_least", &a.sulphate_least, 1e-3, 1.0},
          {"sulphate_crystals", &a.sulphate_crystals},
          {"crystal_supply", &a.crystal_supply, 0.0, 1e6},
          {"crystal_nuclei_ah", &a.crystal_nuclei_ah, 1e-6, 1e3},
          {"crystal_ripening_s", &a.crystal_ripening_s, 0.1, 1e9},
          {"parameter_drift", &a.parameter_drift},
          {"drifting", &a.drifting},
          {"drift_per_h", &a.drift_per_h, -10.0, 10.0},
          {"parasitic_load_a", &a.parasitic_load_a, 0.0, 100.0},
          {"contact_step", &a.contact_step},
          {"contact_ohm", &a.contact_ohm, 0.0, 1.0},
          {"contact_from_s", &a.contact_from_s, 0.0, 1e6},
          {"memory_resistance", &a.memory_resistance},
          {"memory_ohm_per_a", &a.memory_ohm_per_a, 0.0, 1.0},
          {"memory_time_s", &a.memory_time_s, 0.01, 1e5},
          {"step_force", &a.step_force},
          {"step_force_v", &a.step_force_v, 0.0, 10.0},
          {"step_force_above_a", &a.step_force_above_a, 0.0, 2000.0},
          {"gated_tone", &a.gated_tone},
          {"gated_tone_v", &a.gated_tone_v, 0.0, 10.0},
          {"gated_tone_period_s", &a.gated_tone_period_s, 0.1, 1e5},
          {"capacitance_fall", &a.capacitance_fall},
          {"capacitance_fall_share", &a.capacitance_fall_share, 0.0, 0.99},
          {"dead_zone", &a.dead_zone},
          {"dead_zone_v", &a.dead_zone_v, 0.0, 1.0},
          {"hysteretic_r", &a.hysteretic_r},
          {"hysteretic_ohm", &a.hysteretic_ohm, 0.0, 1.0},
          {"hysteretic_from_a", &a.hysteretic_from_a, 0.0, 2000.0}};
}

Fields fieldsOf(PorousParameters& p) {
  return {{"capacity_ah", &p.capacity_ah, 1.0, 1000.0},
          {"area_m2", &p.area_m2, 1e-3, 10.0},
          {"negative_m", &p.negative.thickness_m, 1e-4, 1e-2},
          {"separator_m", &p.separator_m, 1e-4, 1e-2},
          {"positive_m", &p.positive.thickness_m, 1e-4, 1e-2},
          {"negative_porosity", &p.negative.porosity, 0.3, 0.95},
          {"separator_porosity", &p.separator_porosity, 0.3, 1.0},
          {"positive_porosity", &p.positive.porosity, 0.3, 0.95},
          {"grid_ohm", &p.grid_ohm, 0.0, 1.0},
          {"full_acid_mol_per_m3", &p.full_acid_mol_per_m3, 1000.0, 8000.0},
          {"negative_surface_per_m", &p.negative.surface_per_m, 1e4, 1e9},
          {"positive_surface_per_m", &p.positive.surface_per_m, 1e4, 1e9},
          {"negative_exchange_a_per_m2", &p.negative.exchange_a_per_m2, 1e-6, 100.0},
          {"positive_exchange_a_per_m2", &p.positive.exchange_a_per_m2, 1e-6, 100.0},
          {"negative_layer_f_per_m2", &p.negative.layer_f_per_m2, 1e-3, 100.0},
          {"positive_layer_f_per_m2", &p.positive.layer_f_per_m2, 1e-3, 100.0},
          {"diffusion_factor", &p.diffusion_factor, 0.01, 100.0},
          {"gassing", &p.gassing},
          {"gas_current_a", &p.gas_current_a, 0.0, 100.0},
          {"oxygen_potential_v", &p.oxygen_potential_v, 1.0, 3.0},
          {"hydrogen_potential_v", &p.hydrogen_potential_v, -2.0, 0.0},
          {"gas_slope_per_v", &p.gas_slope_per_v, 0.0, 60.0},
          {"lead_ion", &p.lead_ion},
          {"lead_ion_limit_a", &p.lead_ion_limit_a, 0.1, 1e9},
          {"lead_ion_time_s", &p.lead_ion_time_s, 0.1, 1e4},
          {"cells_per_region", &p.cells_per_region, 3, 30}};
}

Fields fieldsOf(AcquisitionOptions& a) {
  return {{"sample_rate_hz", &a.sample_rate_hz, 1.0, 1000.0},
          {"cutoff_hz", &a.cutoff_hz, 0.0, 490.0},
          {"voltage_white_v", &a.voltage_noise.white, 0.0, 10.0},
          {"voltage_correlated_v", &a.voltage_noise.correlated, 0.0, 10.0},
          {"voltage_correlation_time_s", &a.voltage_noise.correlation_time, 1e-3, 1e6},
          {"voltage_walk_v_per_sqrt_min", &a.voltage_noise.walk_per_sqrt_min, 0.0, 10.0},
          {"current_white_a", &a.current_noise.white, 0.0, 100.0},
          {"current_correlated_a", &a.current_noise.correlated, 0.0, 100.0},
          {"current_correlation_time_s", &a.current_noise.correlation_time, 1e-3, 1e6},
          {"current_walk_a_per_sqrt_min", &a.current_noise.walk_per_sqrt_min, 0.0, 100.0},
          {"voltage_step_v", &a.voltage_step_v, 0.0, 10.0},
          {"current_step_a", &a.current_step_a, 0.0, 100.0},
          {"current_offset_a", &a.current_offset_a, -100.0, 100.0},
          {"current_gain", &a.current_gain, -10.0, 10.0},
          {"current_delay_s", &a.current_delay_s, -1.0, 1.0},
          {"current_gain_charge", &a.current_gain_charge, 0.01, 10.0},
          {"current_gain_discharge", &a.current_gain_discharge, 0.01, 10.0},
          {"current_lag_s", &a.current_lag_s, 0.0, 10.0},
          {"voltage_lag_s", &a.voltage_lag_s, 0.0, 10.0},
          {"voltage_drift_v_per_h", &a.voltage_drift_v_per_h, -10.0, 10.0},
          {"current_limit_a", &a.current_limit_a, 0.1, kNoLimit},
          {"voltage_floor_v", &a.voltage_floor_v, -kNoLimit, kNoLimit},
          {"voltage_ceiling_v", &a.voltage_ceiling_v, -kNoLimit, kNoLimit},
          {"lost_share", &a.lost_share, 0.0, 0.9},
          {"frozen_per_min", &a.frozen_per_min, 0.0, 60.0},
          {"frozen_s", &a.frozen_s, 0.0, 1e4},
          {"tone_v", &a.tone_v, 0.0, 10.0},
          {"tone_hz", &a.tone_hz, 0.0, 1e6}};
}

Fields fieldsOf(AlternatingOptions& o) {
  return {{"charge_a", &o.charge_a, 0.0, 2000.0},
          {"discharge_a", &o.discharge_a, 0.0, 2000.0},
          {"turn_s", &o.turn_s, 0.001, 1e5},
          {"rest_share", &o.rest_share, 0.0, 1.0},
          {"rest_s", &o.rest_s, 0.001, 1e5},
          {"charge_target_ah", &o.charge_target_ah, -1000.0, 1000.0},
          {"pulse_count", &o.pulses.count, 0, 100000},
          {"pulse_a", &o.pulses.current_a, 0.0, 2000.0},
          {"pulse_s", &o.pulses.duration_s, 0.001, 1e5}};
}

Fields fieldsOf(LongChargesOptions& o) {
  Fields fields = fieldsOf(o.turns);
  const Fields more{{"long_charges_from_s", &o.from_s, 0.0, 1e6},
                    {"long_charge_a", &o.long_charge_a, 0.1, 2000.0},
                    {"long_charge_s", &o.long_charge_s, 0.001, 1e5},
                    {"after_a", &o.after_a, 0.0, 2000.0},
                    {"after_s", &o.after_s, 0.001, 1e5},
                    {"highest_charge_ah", &o.highest_charge_ah, -1000.0, 1000.0},
                    {"final_hold_a", &o.final_hold_a, 0.0, 2000.0},
                    {"final_hold_s", &o.final_hold_s, 0.001, 1e5},
                    {"final_peak_a", &o.final_peak_a, 0.0, 2000.0},
                    {"final_s", &o.final_s, 0.002, 1e5},
                    {"final_rest_s", &o.final_rest_s, 0.0, 1e5}};
  fields.insert(fields.end(), more.begin(), more.end());
  return fields;
}

Fields fieldsOf(CityOptions& o) {
  return {{"stop_a", &o.stop_a, 0.0, 2000.0},
          {"stop_s", &o.stop_s, 0.001, 1e5},
          {"inrush_a", &o.inrush_a, 0.0, 2000.0},
          {"inrush_s", &o.inrush_s, 0.001, 1e3},
          {"crank_a", &o.crank_a, 0.0, 2000.0},
          {"crank_s", &o.crank_s, 0.001, 1e3},
          {"rounds", &o.rounds, 0.0, 1000.0},
          {"accelerate_a", &o.accelerate_a, 0.0, 2000.0},
          {"accelerate_s", &o.accelerate_s, 0.001, 1e5},
          {"cruise_a", &o.cruise_a, 0.0, 2000.0},
          {"cruise_s", &o.cruise_s, 0.001, 1e5},
          {"braking_share", &o.braking_share, 0.0, 1.0},
          {"braking_a", &o.braking_a, 0.0, 2000.0},
          {"braking_s", &o.braking_s, 0.001, 1e5},
          {"net_charge_ah", &o.net_charge_ah, -1000.0, 1000.0},
          {"early_cranks", &o.early_cranks, 0, 10000},
          {"early_s", &o.early_s, 1.0, 1e6}};
}

Fields fieldsOf(Phase& phase) {
  return {{"duration_s", &phase.duration, 0.001, 1e6},
          {"current_a", &phase.begin, -2000.0, 2000.0},
          {"to_current_a", &phase.end, -2000.0, 2000.0},
          {"voltage_limit_v", &phase.voltage_limit, 1.0, kScenarioVoltageLimit}};
}

Fields fieldsOf(ListedPhases& listed) {
  Fields fields;
  for (std::size_t k = 0; k < listed.phases.size(); ++k)
    for (Field field : fieldsOf(listed.phases[k])) {
      field.key = "phases[" + std::to_string(k) + "]." + field.key;
      fields.push_back(field);
    }
  return fields;
}

std::vector<std::string> boundsFaults(const Fields& fields) {
  std::vector<std::string> faults;
  for (const Field& field : fields) {
    const auto check = [&](double value) {
      if (value >= field.lowest && value <= field.highest) return;
      std::ostringstream text;
      text << field.key << " is " << value << ", expected " << field.lowest << " to "
           << field.highest;
      faults.push_back(text.str());
    };
    if (const auto* number = std::get_if<double*>(&field.place)) check(**number);
    if (const auto* count = std::get_if<int*>(&field.place)) check(**count);
    const auto* range = std::get_if<Range*>(&field.place);
    if (range == nullptr) continue;
    check((*range)->low);
    check((*range)->high);
    if ((*range)->low > (*range)->high) faults.push_back(field.key + " begins above its end");
  }
  return faults;
}

std::string faultOf(const std::string& name, double value, const std::string& expected) {
  return name + " is " + std::to_string(value) + ", expected " + expected;
}

std::string join(const std::vector<std::string>& faults) {
  std::string text;
  for (const auto& fault : faults) text += (text.empty() ? "" : "; ") + fault;
  return text;
}

void requireNone(const std::vector<std::string>& faults, const std::string& where) {
  if (!faults.empty()) throw std::invalid_argument(where + ": " + join(faults));
}

}  // namespace battery_sof_simulator
