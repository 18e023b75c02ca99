#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "simulator/fields.hpp"
#include "simulator/generator/catalogue_draft.hpp"

namespace battery_sof_simulator {
namespace {

constexpr double kMinCapacitance = 300.0;   // [F] (docs/physics.md#second_electrode)
constexpr double kDistinct = 4.0;           // ratio of time constants
constexpr double kRoom = 0.2;               // of the state of charge
constexpr Range kLeadIonLimit{20.0, 70.0};  // [A]
constexpr Range kLeadIonTime{3.0, 40.0};    // [s]

/// Where a scenario keeps a number or a flag, its porous block first; null: nowhere.
template <typename Value>
Value* placeOf(Scenario& s, const std::string& key) {
  std::vector<Fields> all{fieldsOf(s.battery), fieldsOf(s.effects), fieldsOf(s.additions),
                          fieldsOf(s.acquisition)};
  if (s.porous) all.insert(all.begin(), fieldsOf(*s.porous));
  for (const Fields& fields : all)
    for (const Field& field : fields)
      if (auto* const* place = std::get_if<Value*>(&field.place); place && field.key == key)
        return *place;
  return nullptr;
}

/// How a number of an addition is drawn, and what the scale does to it.
enum class As {
  kPlain,      ///< uniform; no part in the scale: times, places
  kLog,        ///< the same, uniform in its logarithm
  kAmplitude,  ///< gamma is the value itself; without the addition the place keeps what it has
  /// gamma is 1 / value, infinite without the addition; the place then keeps what it has
  kLimit,
  kLogLimit,  ///< the same, uniform in its logarithm
  kSigned,    ///< of either sign; gamma is the value
};
struct Number {
  const char* key;
  As as;
  Range range;
};

/// Draws what makes up one addition, times a scale (>= 0 and finite), sets it in a scenario and
/// writes it down after scaling, by key of scenario files.
struct Addition {
  CatalogueDraft& draft;
  Dice& dice;
  double scale;
  Scenario& scenario = draft.scenario;

  bool present() const { return scale > 0.0; }  ///< whether anything is left of the addition
  void set(const std::string& key, double value) {
    draft.strength[key] = value;
    *placeOf<double>(scenario, key) = value;
  }
  void draw(const Number& one) {
    if (one.as == As::kSigned) return set(one.key, signedValue(one.range));
    const bool logarithmic = one.as == As::kLog || one.as == As::kLogLimit;
    const double value = logarithmic ? dice.logBetween(one.range) : dice.between(one.range);
    if (one.as == As::kPlain || one.as == As::kLog) return set(one.key, value);
    setWhilePresent(one.key, one.as == As::kAmplitude ? scale * value : value / scale);
  }
  void draw(const std::vector<Number>& numbers) {
    for (const Number& one : numbers) draw(one);
  }
  /// A value that is written down, and acts unless the addition is gone.
  void setWhilePresent(const std::string& key, double value) {
    if (present()) return set(key, value);
    draft.strength[key] = value;
  }
  /// The scale times a number of either sign.
  double signedValue(const Range& range) { return scale * (dice.sign() * dice.between(range)); }
  /// Switches a flag of the scenario on while the addition is there.
  void mark(const std::string& flag) {
    if (bool* place = placeOf<bool>(scenario, flag)) *place = present();
  }
  /// Says that an effect is there, whatever the scale.
  void alsoTrue(const std::string& id) { draft.effects.push_back(id); }
};

/// Additions that are a flag of their name, if there is one, and numbers.
const std::map<std::string, std::vector<Number>> kPlainAdditions{
    {"fast_arc",
     {{"fast_arc_ohm", As::kAmplitude, {1e-3, 2e-3}}, {"fast_arc_time_s", As::kLog, {0.05, 0.4}}}},
    {"inductance", {{"inductance_h", As::kAmplitude, {1.5e-6, 3e-6}}}},
    {"charge_acceptance",
     {{"lead_ion_limit_a", As::kLogLimit, kLeadIonLimit},
      {"lead_ion_time_s", As::kLog, kLeadIonTime}}},
    {"acid_transport",
     {{"acid_1_ohm", As::kAmplitude, {1.75e-3, 3e-3}},
      {"acid_1_time_s", As::kLog, {20.0, 100.0}},
      {"acid_2_ohm", As::kAmplitude, {3.5e-3, 6e-3}},
      {"acid_2_time_s", As::kLog, {150.0, 1500.0}}}},
    {"ocv_hysteresis",
     {{"hysteresis_v", As::kAmplitude, {0.02, 0.04}}, {"hysteresis_ah", As::kLog, {0.05, 0.4}}}},
    {"high_rate_depletion",
     {{"depletion_v", As::kPlain, {0.17, 0.25}},
      {"depletion_limit_a", As::kLogLimit, {300.0, 600.0}},
      {"depletion_time_s", As::kPlain, {10.0, 60.0}}}},
    {"coup_de_fouet",
     {{"coup_v", As::kAmplitude, {0.1, 0.3}},
      {"coup_nuclei_ah", As::kLog, {0.1, 0.4}},
      {"coup_erasing_ah", As::kLog, {0.6, 1.6}},
      {"coup_nuclei_at_start", As::kPlain, {0.0, 0.15}}}},
    // The scale acts on 1/C_th and on R_th: the time constant stays.
    {"self_heating",
     {{"heat_capacity_j_per_k", As::kLimit, {12e3, 13.5e3}},
      {"thermal_resistance_k_per_w", As::kAmplitude, {1.25, 2.0}},
      {"activation_j_per_mol", As::kPlain, {50e3, 60e3}}}},
    {"current_offset", {{"current_offset_a", As::kSigned, {0.7, 2.0}}}},
    {"time_skew", {{"current_delay_s", As::kSigned, {0.02, 0.05}}}},
    {"voltage_drift", {{"voltage_drift_v_per_h", As::kSigned, {0.02, 0.06}}}},
    {"parasitic_load", {{"parasitic_load_a", As::kAmplitude, {0.2, 0.3}}}},
    {"dropouts",
     {{"lost_share", As::kAmplitude, {0.02, 0.1}}, {"frozen_per_min", As::kAmplitude, {2.0, 5.0}}}},
    {"memory_resistance",
     {{"memory_ohm_per_a", As::kAmplitude, {0.6e-4, 1.5e-4}},
      {"memory_time_s", As::kPlain, {15.0, 60.0}}}},
    {"step_force", {{"step_force_v", As::kAmplitude, {0.05, 0.15}}}},
    {"dead_zone", {{"dead_zone_v", As::kAmplitude, {0.02, 0.05}}}},
    {"hysteretic_r",
     {{"hysteretic_ohm", As::kAmplitude, {0.5e-3, 1.2e-3}},
      {"hysteretic_from_a", As::kPlain, {20.0, 35.0}}}}};

void addCpe2(Addition& s) {
  s.scenario.effects.cpe2_fractional = true;
  s.set("cpe2_exponent", 1.0 - s.scale * (1.0 - s.dice.between({0.75, 0.88})));
}

/// r_1 of both directions falls with current; at small current it is r_x more than at large. A
/// scale below 1 takes back the share of r_1 that falls, one above 1 makes r_x larger.
void addCurrentDependence(Addition& s) {
  BatteryParameters& b = s.scenario.battery;
  s.mark("r1_current_dependence");
  const double as_drawn = s.dice.between({3e-3, 6e-3}), extra = std::max(1.0, s.scale) * as_drawn;
  s.draft.strength["r_x_ohm"] = s.scale * as_drawn;
  b.r1_knee_share = std::min(1.0, s.scale);
  s.draw({"r1_knee_current_a", As::kLog, {8.0, 40.0}});
  const double smallest = std::min(b.r1_discharge_ohm, b.r1_charge_ohm);
  b.r_ohmic_ohm += smallest - std::min(smallest, 0.3 * extra);
  b.r1_discharge_ohm += extra - smallest;
  b.r1_charge_ohm += extra - smallest;
}

void addChargeTransfer(Addition& s) {
  Dice& dice = s.dice;
  if (dice.share() < 0.5)
    s.set("i0_a", std::pow(dice.share() < 0.5 ? dice.between({0.2, 0.4}) : dice.between({2.5, 5.0}),
                           s.scale));
  else
    s.set("alpha", 0.5 + s.scale * (dice.sign() * dice.between({0.1, 0.2})));
}

/// With C_3 beta_3 far from C_2 beta: two electrodes of one time constant are one. The scale acts
/// on 1/beta_3 and on C_3: C_3 / (I_03 beta_3) stays, and u_3 is times the scale.
void addSecondElectrode(Addition& s) {
  const BatteryParameters& b = s.scenario.battery;
  s.mark("second_electrode");
  const double beta = 1.0 / s.dice.between({0.02, 0.04});
  s.setWhilePresent("electrode3_beta_per_v", beta / s.scale);
  const double alike = b.beta_per_v * b.cpe2_capacitance_f / beta;
  const bool faster = kDistinct * kMinCapacitance < alike;
  s.draw({"electrode3_capacitance_f", As::kLogLimit,
          faster ? Range{kMinCapacitance, alike / kDistinct} : Range{kDistinct * alike, 6000.0}});
  s.set("electrode3_exponent", s.dice.share() < 0.5 ? 1.0 : s.dice.between({0.85, 1.0}));
}

/// A limited main reaction that an addition needs, whatever that one's scale; without it a side
/// reaction does not show and sulphate has nothing to act on.
void addCompanion(Addition& s, const Number& limit, const Number& time) {
  s.scenario.effects.charge_acceptance = true;
  s.draw({limit, time});
  s.alsoTrue("charge_acceptance");
}

/// A side reaction without its companion.
void addSideReaction(Addition& s) {
  s.scenario.effects.gassing = s.present() ? GassingLaw::kTafel : GassingLaw::kNone;
  s.draw(
      {{"gas_current_a", As::kAmplitude, {1.5, 3.0}}, {"gas_slope_per_v", As::kPlain, {1.4, 3.0}}});
}

/// With a limited main reaction: a side reaction shows where that no longer takes the current.
void addGassing(Addition& s) {
  addCompanion(s, {"lead_ion_limit_a", As::kPlain, {12.0, 25.0}},
               {"lead_ion_time_s", As::kPlain, {3.0, 15.0}});
  addSideReaction(s);
}

void addSulphateHistory(Addition& s) {
  addCompanion(s, {"lead_ion_limit_a", As::kLog, kLeadIonLimit},
               {"lead_ion_time_s", As::kLog, kLeadIonTime});
  s.mark("sulphate_history");
  s.draw({{"sulphate_ah", As::kLogLimit, {0.2, 0.8}},
          {"sulphate_time_s", As::kLog, {300.0, 1800.0}},
          {"sulphate_charge_share", As::kPlain, {0.6, 1.0}}});
}

/// The surface of crystals feeds a limited main reaction whose lasting supply is small.
void addFreshSulphate(Addition& s) {
  s.scenario.effects.charge_acceptance = s.present();
  if (s.present()) s.alsoTrue("charge_acceptance");
  s.mark("sulphate_crystals");
  s.draw({{"lead_ion_limit_a", As::kLogLimit, {1.5, 6.0}},
          {"lead_ion_time_s", As::kLog, {3.0, 12.0}},
          {"crystal_supply", As::kLog, {40.0, 160.0}},
          {"crystal_nuclei_ah", As::kLog, {0.01, 0.05}},
          {"crystal_ripening_s", As::kLog, {600.0, 3600.0}}});
}

/// u_0 at the start stays as drawn.
void addOcvSlope(Addition& s) {
  BatteryParameters& b = s.scenario.battery;
  const double below = s.scenario.start.soc - kReferenceSoc;
  const double u0 = b.u0_v + b.u0_slope_v * below;
  s.mark("ocv_slope");
  s.draw({"u0_slope_v", As::kAmplitude, {1.5, 1.8}});
  b.u0_v = u0 - b.u0_slope_v * below;
}

void addParameterDrift(Addition& s) {
  struct Drifting {
    DriftingParameter parameter;
    Range per_h;
  };
  const std::array<Drifting, 4> all{{{DriftingParameter::kROhmic, {0.6, 1.2}},
                                     {DriftingParameter::kR1, {0.5, 1.0}},
                                     {DriftingParameter::kCpe2Capacitance, {0.6, 1.2}},
                                     {DriftingParameter::kU0, {0.005, 0.015}}}};
  const Drifting one = s.dice.oneOf(all);
  s.mark("parameter_drift");
  s.scenario.additions.drifting = one.parameter;
  s.set("drift_per_h", s.signedValue(one.per_h));
}

void addCurrentGain(Addition& s) {
  const double error = s.signedValue({0.025, 0.05});
  s.set(s.dice.share() < 0.5 ? "current_gain_charge" : "current_gain_discharge", 1.0 + error);
}

void addSensorLag(Addition& s) {
  s.draw({s.dice.share() < 0.5 ? "current_lag_s" : "voltage_lag_s", As::kAmplitude, {0.04, 0.1}});
}

/// Not finer than without the fault.
void addQuantisation(Addition& s) {
  const AcquisitionOptions& a = s.scenario.acquisition;
  s.set("voltage_step_v", std::max(a.voltage_step_v, s.scale * s.dice.between({0.01, 0.02})));
  s.set("current_step_a", std::max(a.current_step_a, s.scale * s.dice.between({0.5, 1.0})));
}

void addContactStep(Addition& s) {
  s.mark("contact_step");
  s.draw({"contact_ohm", As::kAmplitude, {1e-3, 3e-3}});
  s.set("contact_from_s", s.dice.between({0.3, 0.7}) * s.scenario.duration);
}

/// At scale 1 within what every crank reaches. gamma: 1 / limit, and 1 / depth below u_0.
void addClipping(Addition& s) {
  const BatteryParameters& b = s.scenario.battery;
  const double u0 = openCircuitVoltage(b, s.scenario.start.soc).value;
  const double which = s.dice.share();
  if (which < 0.67) s.draw({"current_limit_a", As::kLimit, {80.0, 130.0}});
  if (which > 0.33)
    s.set("voltage_floor_v",
          u0 - (0.2 + s.dice.between({90.0, 130.0}) * (b.r_ohmic_ohm + b.r1_discharge_ohm)) /
                   s.scale);
}

/// Not near a multiple of the sample rate, where the tone would be a constant.
void addAliasing(Addition& s) {
  s.draw({"tone_v", As::kAmplitude, {0.005, 0.02}});
  const double turns = std::floor(s.dice.between({1.0, 6.0}));
  s.set("tone_hz", (turns + s.dice.between({0.05, 0.95})) * s.scenario.acquisition.sample_rate_hz);
}

void addGatedTone(Addition& s) {
  s.mark("gated_tone");
  s.set("gated_tone_v", s.scale * 0.02);
  s.draw({"gated_tone_period_s", As::kPlain, {20.0, 60.0}});
}

/// gamma: the rate, ln(1 / (1 - share)) an hour.
void addCapacitanceFall(Addition& s) {
  s.mark("capacitance_fall");
  s.set("capacitance_fall_share", 1.0 - std::pow(1.0 - 0.6, s.scale));
}

/// Additions that are more than numbers of a flag.
const std::map<std::string, void (*)(Addition&)> kSpecialAdditions{
    {"cpe2", addCpe2},
    {"current_dependent_resistance", addCurrentDependence},
    {"charge_transfer", addChargeTransfer},
    {"second_electrode", addSecondElectrode},
    {"gassing", addGassing},
    {"sulphate_history", addSulphateHistory},
    {"fresh_sulphate", addFreshSulphate},
    {"ocv_soc", addOcvSlope},
    {"parameter_drift", addParameterDrift},
    {"current_gain", addCurrentGain},
    {"sensor_lag", addSensorLag},
    {"quantisation", addQuantisation},
    {"contact_resistance", addContactStep},
    {"clipping", addClipping},
    {"aliasing", addAliasing},
    {"gated_tone", addGatedTone},
    {"capacitance_fall", addCapacitanceFall}};

void addToPorous(Addition& s, const std::string& id) {
  PorousParameters& p = *s.scenario.porous;
  if (id == "acid_transport") {
    // gamma: what 1 / diffusion_factor is more than the block's own.
    const double own = p.diffusion_factor, slow = s.dice.between({0.3, 0.5});
    return s.set("diffusion_factor", own / (1.0 + s.scale * (own / slow - 1.0)));
  }
  if (id != "charge_acceptance" && id != "gassing")
    throw std::invalid_argument("a porous block has no effect \"" + id + "\"");
  if (s.present() || id == "gassing") s.alsoTrue("charge_acceptance");
  p.lead_ion = s.present() || id == "gassing";
  if (id == "charge_acceptance") return s.draw(kPlainAdditions.at(id));
  if (s.present()) s.alsoTrue("gassing");
  p.gassing = s.present();
  s.draw({{"lead_ion_limit_a", As::kPlain, {12.0, 25.0}},
          {"lead_ion_time_s", As::kPlain, {3.0, 15.0}},
          {"gas_current_a", As::kAmplitude, {0.3, 1.0}},
          {"gas_slope_per_v", As::kPlain, {15.0, 22.0}}});
}

/// Whether a drive takes the charge up (1) or down (-1).
double trendOf(const Scenario& scenario) {
  const auto* city = std::get_if<CityOptions>(&scenario.profile);
  if (city == nullptr) throw std::invalid_argument("the drive's charge has no trend");
  return std::copysign(1.0, city->net_charge_ah);
}

}  // namespace

void addEffect(CatalogueDraft& draft, const std::string& id, Dice& dice, double scale) {
  Addition s{draft, dice, scale};
  if (draft.scenario.porous) return addToPorous(s, id);
  if (s.present() && draft.order.what.kind != kUnlistedLaw) s.alsoTrue(id);
  if (const auto special = kSpecialAdditions.find(id); special != kSpecialAdditions.end())
    return special->second(s);
  const auto found = kPlainAdditions.find(id);
  if (found == kPlainAdditions.end())
    throw std::invalid_argument("no effect is called \"" + id + "\"");
  s.mark(id);
  s.draw(found->second);
  if (id == "dropouts") draft.scenario.acquisition.frozen_s = {0.1, 1.5};
}

void addMask(CatalogueDraft& draft, const std::string& id, Dice& dice, double scale) {
  if (id == "time_skew") return addEffect(draft, id, dice, scale);
  Addition s{draft, dice, scale};
  if (s.present()) s.alsoTrue(id);
  if (id == "gassing") return addSideReaction(s);
  if (id == "current_gain")
    return s.set("current_gain_charge", 1.0 + s.scale * dice.between({0.025, 0.05}));
  if (id == "voltage_drift")
    return s.set("voltage_drift_v_per_h",
                 -trendOf(s.scenario) * s.scale * dice.between({0.02, 0.06}));
  throw std::invalid_argument("no mask is called \"" + id + "\"");
}

void addAbsent(CatalogueDraft& draft, const std::string& id, Dice& dice, double scale) {
  if (id != "gassing") return addEffect(draft, id, dice, scale);
  Addition s{draft, dice, scale};
  if (s.present()) s.alsoTrue(id);
  // Room for what two plateaus put in; u_0 at the start stays.
  s.scenario.start.soc -= kRoom;
  s.scenario.battery.u0_v += kRoom * s.scenario.battery.u0_slope_v;
  // Far above the first half's currents, below those of a plateau; slow against its turns.
  addCompanion(s, {"lead_ion_limit_a", As::kPlain, {40.0, 60.0}},
               {"lead_ion_time_s", As::kPlain, {20.0, 40.0}});
  addSideReaction(s);
}

}  // namespace battery_sof_simulator
