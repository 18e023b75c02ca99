#include "simulator/out_of_model_label.hpp"

#include <nlohmann/json.hpp>

namespace battery_sof_reference {
namespace {

using Json = nlohmann::json;

Json jsonOf(const SplitRms& rms) { return {{"training", rms.training}, {"holdout", rms.holdout}}; }

Json nameOr(const std::string& name) { return name == "-" ? Json(nullptr) : Json(name); }

Json noiseOf(const OutOfModelCase& one) {
  return {{"voltage_white_v", one.voltage_noise.white},
          {"voltage_correlated_v", one.voltage_noise.correlated},
          {"voltage_correlation_time_s", one.voltage_noise.correlation_time},
          {"voltage_walk_v_per_sqrt_min", one.voltage_noise.walk_per_sqrt_min},
          {"voltage_step_v", one.voltage_step_v},
          {"current_white_a", one.current_noise.white},
          {"current_step_a", one.current_step_a}};
}

Json baseOf(const BatteryParameters& b) {
  return {{"r_discharge_ohm", b.r_ohmic_ohm + b.r1_discharge_ohm},
          {"r_charge_ohm", b.r_ohmic_ohm + b.r1_charge_ohm},
          {"c2_f", b.cpe2_capacitance_f},
          {"beta_per_v", b.beta_per_v},
          {"u_dc_v", b.u0_v}};
}

Json channelOf(const ImperfectChannel& c) {
  return {{"poles", c.poles},         {"corner_hz", c.corner_hz}, {"late_share", c.late_share},
          {"bow_steps", c.bow_steps}, {"ripple", c.ripple},       {"step", c.step}};
}

Json recorderOf(const OutOfModelCase& one) {
  if (!one.recorder) return nullptr;
  const ImperfectRecorder& r = *one.recorder;
  return {{"voltage", channelOf(r.voltage)}, {"current", channelOf(r.current)},
          {"jitter_share", r.jitter_share},  {"ripple_hz", r.ripple_hz},
          {"smooth_rms_v", r.smooth_rms_v},  {"steps_rms_v", one.steps_rms_v}};
}

}  // namespace

std::string labelOf(const OutOfModelCase& one) {
  const Json label{{"schema", "battery_sof/stranger/1"},
                   {"kind", one.order.kind},
                   {"mechanism", nameOr(one.order.mechanism)},
                   {"form", nameOr(one.order.form)},
                   {"drive", one.order.drive},
                   {"seed", one.order.seed},
                   {"duration_s", one.scenario.duration},
                   {"sample_rate_hz", *one.order.rate},
                   {"attempt", one.attempt},
                   {"strength", one.strength},
                   {"scale", one.order.scale},
                   {"rms_v", jsonOf(one.effect)},
                   {"visible_rms_v", jsonOf(one.visible)},
                   {"crank_v", one.crank_v},
                   {"noise", noiseOf(one)},
                   {"base", baseOf(one.scenario.battery)},
                   {"voltage_limit_v", one.scenario.voltage_limit},
                   {"recorder", recorderOf(one)}};
  return label.dump(2) + "\n";
}

}  // namespace battery_sof_reference
