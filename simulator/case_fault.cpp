#include <algorithm>
#include <cmath>
#include <map>

#include "simulator/case_strength.hpp"

namespace battery_sof_reference {
namespace {

void addCurrentOffset(Strength& s) {
  s.set("current_offset_a", s.scenario().acquisition.current_offset_a,
        s.scale() * (s.sign() * s.between({0.7, 2.0})));
}

void addCurrentGain(Strength& s) {
  AcquisitionOptions& a = s.scenario().acquisition;
  const double error = s.scale() * (s.sign() * s.between({0.025, 0.05}));
  if (s.share() < 0.5)
    s.set("current_gain_charge", a.current_gain_charge, 1.0 + error);
  else
    s.set("current_gain_discharge", a.current_gain_discharge, 1.0 + error);
}

void addTimeSkew(Strength& s) {
  s.set("current_delay_s", s.scenario().acquisition.current_delay_s,
        s.scale() * (s.sign() * s.between({0.02, 0.05})));
}

void addSensorLag(Strength& s) {
  AcquisitionOptions& a = s.scenario().acquisition;
  if (s.share() < 0.5)
    s.drawAmplitude("current_lag_s", a.current_lag_s, {0.04, 0.1});
  else
    s.drawAmplitude("voltage_lag_s", a.voltage_lag_s, {0.04, 0.1});
}

/// Not finer than without the fault.
void addQuantisation(Strength& s) {
  AcquisitionOptions& a = s.scenario().acquisition;
  s.set("voltage_step_v", a.voltage_step_v,
        std::max(a.voltage_step_v, s.scale() * s.between({0.01, 0.02})));
  s.set("current_step_a", a.current_step_a,
        std::max(a.current_step_a, s.scale() * s.between({0.5, 1.0})));
}

void addContactStep(Strength& s) {
  Additions& a = s.scenario().additions;
  a.contact_step = s.present();
  s.drawAmplitude("contact_ohm", a.contact_ohm, {1e-3, 3e-3});
  s.set("contact_from_s", a.contact_from_s, s.between({0.3, 0.7}) * s.scenario().duration);
}

/// At scale 1 within what every crank reaches. gamma: 1 / limit, and 1 / depth below u_0.
void addClipping(Strength& s) {
  AcquisitionOptions& a = s.scenario().acquisition;
  const BatteryParameters& b = s.scenario().battery;
  const double u0 = openCircuitVoltage(b, s.scenario().start.soc).value;
  const double which = s.share();
  if (which < 0.67) s.drawLimit("current_limit_a", a.current_limit_a, {80.0, 130.0});
  if (which > 0.33)
    s.set("voltage_floor_v", a.voltage_floor_v,
          u0 - (0.2 + s.between({90.0, 130.0}) * (b.r_ohmic_ohm + b.r1_discharge_ohm)) / s.scale());
}

void addDropouts(Strength& s) {
  AcquisitionOptions& a = s.scenario().acquisition;
  s.drawAmplitude("lost_share", a.lost_share, {0.02, 0.1});
  s.drawAmplitude("frozen_per_min", a.frozen_per_min, {2.0, 5.0});
  a.frozen_s = {0.1, 1.5};
}

void addVoltageDrift(Strength& s) {
  s.set("voltage_drift_v_per_h", s.scenario().acquisition.voltage_drift_v_per_h,
        s.scale() * (s.sign() * s.between({0.02, 0.06})));
}

/// Not near a multiple of the sample rate, where the tone would be a constant.
void addAliasing(Strength& s) {
  AcquisitionOptions& a = s.scenario().acquisition;
  s.drawAmplitude("tone_v", a.tone_v, {0.005, 0.02});
  const double turns = std::floor(s.between({1.0, 6.0}));
  s.set("tone_hz", a.tone_hz, (turns + s.between({0.05, 0.95})) * a.sample_rate_hz);
}

void addMemoryResistance(Strength& s) {
  Additions& a = s.scenario().additions;
  a.memory_resistance = s.present();
  s.drawAmplitude("memory_ohm_per_a", a.memory_ohm_per_a, {0.6e-4, 1.5e-4});
  s.draw("memory_time_s", a.memory_time_s, {15.0, 60.0});
}

void addStepForce(Strength& s) {
  Additions& a = s.scenario().additions;
  a.step_force = s.present();
  s.drawAmplitude("step_force_v", a.step_force_v, {0.05, 0.15});
}

void addGatedTone(Strength& s) {
  Additions& a = s.scenario().additions;
  a.gated_tone = s.present();
  s.set("gated_tone_v", a.gated_tone_v, s.scale() * 0.02);
  s.draw("gated_tone_period_s", a.gated_tone_period_s, {20.0, 60.0});
}

/// gamma: the rate, ln(1 / (1 - share)) an hour.
void addCapacitanceFall(Strength& s) {
  s.scenario().additions.capacitance_fall = s.present();
  s.set("capacitance_fall_share", s.scenario().additions.capacitance_fall_share,
        1.0 - std::pow(1.0 - 0.6, s.scale()));
}

void addDeadZone(Strength& s) {
  s.scenario().additions.dead_zone = s.present();
  s.drawAmplitude("dead_zone_v", s.scenario().additions.dead_zone_v, {0.02, 0.05});
}

void addHystereticR(Strength& s) {
  Additions& a = s.scenario().additions;
  a.hysteretic_r = s.present();
  s.drawAmplitude("hysteretic_ohm", a.hysteretic_ohm, {0.5e-3, 1.2e-3});
  s.draw("hysteretic_from_a", a.hysteretic_from_a, {20.0, 35.0});
}

const std::map<std::string, void (*)(Strength&)>& faultsById() {
  static const std::map<std::string, void (*)(Strength&)> all{
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
    return kind.mechanism == "unknown" && kind.id == id;
  });
}

}  // namespace

bool isFault(const std::string& id) { return faultsById().count(id) > 0; }

void addFault(Strength& strength, const std::string& id) {
  if (strength.present() && !isUnlisted(id)) strength.alsoTrue(id);
  faultsById().at(id)(strength);
}

}  // namespace battery_sof_reference
