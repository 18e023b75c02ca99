#include <algorithm>
#include <cmath>
#include <map>

#include "simulator/generator/catalogue_draft.hpp"

namespace battery_sof_simulator {
namespace {

constexpr double kNoGassing = 13.4;  // [V], below which a side reaction is not to be seen
const CrankRanges kCrank{{230.0, 300.0}, {0.3, 0.7}, {150.0, 200.0}};

AlternatingOptions drawTurns(double duration, Dice& dice) {
  AlternatingOptions o;
  o.charge_a = {dice.between({5.0, 12.0}), dice.between({30.0, 50.0})};
  o.discharge_a = {dice.between({5.0, 12.0}), dice.between({40.0, 75.0})};
  o.turn_s = {dice.between({1.5, 3.0}), dice.between({7.0, 15.0})};
  o.rest_share = dice.between({0.05, 0.25});
  o.charge_target_ah = dice.between({-0.2, 0.2});
  o.pulses.count = std::max(1, static_cast<int>(duration / dice.between({150.0, 330.0})));
  return o;
}

ProfileOptions drawLongCharges(double duration, Dice& dice) {
  LongChargesOptions o;
  o.turns = drawTurns(duration, dice);
  o.from_s = dice.between({0.15, 0.5}) * duration;
  o.long_charge_a = {dice.between({20.0, 32.0}), dice.between({36.0, 50.0})};
  o.long_charge_s = {dice.between({15.0, 25.0}), dice.between({40.0, 70.0})};
  o.highest_charge_ah = dice.between({0.4, 0.8});
  return o;
}

ProfileOptions drawCity(Dice& dice) {
  CityOptions o;
  o.stop_a = {dice.between({8.0, 18.0}), dice.between({25.0, 40.0})};
  o.stop_s = {dice.between({5.0, 12.0}), dice.between({20.0, 45.0})};
  o.cruise_a = {dice.between({1.0, 5.0}), dice.between({12.0, 28.0})};
  o.braking_a = {dice.between({30.0, 50.0}), dice.between({60.0, 90.0})};
  o.braking_share = dice.between({0.6, 0.95});
  o.net_charge_ah = dice.between({-0.3, 1.0});
  o.early_cranks = dice.share() < 0.5 ? 5 : 0;
  return o;
}

/// Two plateaus of constant voltage, then rest: what the side reaction takes depends on voltage.
void exerciseGassing(Scenario& s, Dice& dice) {
  const double length = std::min(600.0, 0.26 * s.duration);
  const double low = dice.between({13.6, 13.75}), high = dice.between({14.4, 14.6});
  s.voltage_limit = high;
  insertAt(s, 0.15 * s.duration, {{length, 80.0, 80.0, low}, rest(40.0)});
  insertAt(s, 0.55 * s.duration, {{length, 80.0, 80.0, high}, rest(40.0)});
}

void exerciseCharging(Scenario& s, Dice& dice) {
  LongChargesOptions o;
  o.turns = drawTurns(s.duration, dice);
  o.from_s = 0.1 * s.duration;
  o.long_charge_a = {30.0, dice.between({45.0, 60.0})};
  o.long_charge_s = {30.0, 60.0};
  o.highest_charge_ah = dice.between({0.8, 1.2});
  s.profile = o;
  s.voltage_limit = dice.between({14.2, 14.6});
}

/// The same charge right after a discharge, and after a rest (docs/physics.md#sulphate_history).
void exerciseHistory(Scenario& s, Dice& dice) {
  exerciseCharging(s, dice);
  const double current = dice.between({35.0, 45.0});
  for (double share : {0.3, 0.6})
    insertAt(s, share * s.duration,
             {swing(-0.5, current), swing(0.45, current), rest(120.0), swing(0.3, current)});
}

/// Stops of many sizes, each recharged by a generator that holds the voltage.
void exerciseFreshSulphate(Scenario& s, Dice& dice) {
  s.profile = drawCity(dice);
  s.voltage_limit = dice.between({13.9, 14.7});
}

void exerciseAcid(Scenario& s, Dice& dice) {
  for (double share : {0.15, 0.4, 0.65, 0.85}) {
    const double sign = dice.sign();
    insertAt(s, share * s.duration,
             {swing(sign * dice.between({0.4, 0.7}), dice.between({30.0, 50.0})),
              rest(dice.between({80.0, 120.0}))});
  }
}

void exerciseChargeSwings(Scenario& s, Dice& dice) {
  double sign = dice.sign();
  for (double share : {0.1, 0.35, 0.6, 0.85}) {
    insertAt(s, share * s.duration,
             {swing(sign * dice.between({1.0, 2.0}), dice.between({45.0, 65.0})),
              rest(dice.between({30.0, 60.0}))});
    sign = -sign;
  }
}

void exerciseHeavyDischarge(Scenario& s, Dice& dice) {
  for (double share : {0.1, 0.3, 0.5, 0.7, 0.9}) {
    std::vector<Phase> phases{steady(dice.between({20.0, 40.0}), -dice.between({80.0, 130.0}))};
    appendCrank(phases, kCrank, dice);
    phases.push_back(rest(20.0));
    appendCrank(phases, kCrank, dice);
    insertAt(s, share * s.duration, phases);
  }
}

/// Discharges after charges that took the battery near full.
void exerciseFullCharge(Scenario& s, Dice& dice) {
  insertAt(s, 0.0, {rest(20.0), steady(dice.between({60.0, 90.0}), -dice.between({15.0, 35.0}))});
  for (double share : {0.3, 0.6, 0.85})
    insertAt(s, share * s.duration,
             {swing(dice.between({1.0, 1.5}), 45.0), rest(30.0),
              steady(dice.between({60.0, 90.0}), -dice.between({15.0, 35.0}))});
}

void exerciseHeat(Scenario& s, Dice& dice) {
  AlternatingOptions o = drawTurns(s.duration, dice);
  o.charge_a = {70.0, 130.0};
  o.discharge_a = {80.0, 180.0};
  s.profile = o;
  s.voltage_limit = 14.6;
}

/// Currents on both sides of 60 A.
void exerciseThreshold(Scenario& s, Dice& dice) {
  for (double share : {0.1, 0.3, 0.5, 0.7, 0.9})
    insertAt(s, share * s.duration,
             {steady(4.0, -dice.between({45.0, 58.0})), steady(4.0, -dice.between({62.0, 80.0})),
              steady(4.0, -dice.between({90.0, 140.0})), steady(8.0, dice.between({65.0, 90.0}))});
}

/// Short turns at small current, so that nothing slow or limited shows; pulses show the resistance.
AlternatingOptions drawTameTurns(double duration, Dice& dice) {
  AlternatingOptions o;
  o.charge_a = {dice.between({2.0, 4.0}), dice.between({6.0, 9.0})};
  o.discharge_a = {dice.between({3.0, 5.0}), dice.between({8.0, 12.0})};
  o.turn_s = {dice.between({1.5, 2.5}), dice.between({5.0, 7.0})};
  o.rest_share = dice.between({0.05, 0.25});
  o.pulses.count = std::max(1, static_cast<int>(duration / dice.between({240.0, 330.0})));
  o.pulses.current_a = {150.0, 250.0};
  o.pulses.duration_s = 0.5;
  return o;
}

/// What exercise() gives an effect, from the drive's start on.
Scenario exercisedFromTheStart(Scenario s, const std::string& id, Dice& dice) {
  s.inserts.clear();
  exercise(s, id, dice);
  if (s.inserts.empty())
    insertAt(s, 0.0, {steady(dice.between({40.0, 60.0}), dice.between({30.0, 50.0}))});
  s.inserts.front().at = 0.0;
  return s;
}

}  // namespace

void drawCatalogueDrive(CatalogueDraft& draft, Dice& dice) {
  Scenario& s = draft.scenario;
  s.voltage_limit = dice.between({13.5, 14.6});
  const double kind = dice.share();
  if (kind < 1.0 / 3.0)
    s.profile = drawTurns(s.duration, dice);
  else if (kind < 2.0 / 3.0)
    s.profile = drawLongCharges(s.duration, dice);
  else
    s.profile = drawCity(dice);
  const int rests = 2 + static_cast<int>(3.0 * dice.share());
  for (int k = 0; k < rests; ++k) {
    std::vector<Phase> phases{rest(dice.between({30.0, 120.0}))};
    if (dice.share() < 0.5) appendCrank(phases, kCrank, dice);
    insertAt(s, (k + dice.between({0.2, 0.9})) / rests * s.duration, phases);
  }
}

void drawAbsentDrive(CatalogueDraft& draft, const std::string& id, Dice& dice) {
  Scenario& s = draft.scenario;
  const double half = std::round(0.5 * s.duration);
  Scenario second = s;
  second.duration = s.duration - half;
  second = exercisedFromTheStart(second, id, dice);
  s.profile = drawTameTurns(half, dice);
  if (id == "gassing") s.voltage_limit = kNoGassing;
  s.inserts.clear();
  if (id != "acid_transport")
    for (double share : {0.15, 0.35})
      insertAt(s, share * s.duration, {rest(dice.between({30.0, 60.0}))});
  for (const Insert& insert : second.inserts)
    s.inserts.push_back({half + insert.at, insert.phases});
  s.later = LaterPart{half, second.voltage_limit, second.profile};
  draft.regime_from = half;
}

void exercise(Scenario& s, const std::string& id, Dice& dice) {
  const std::map<std::string, void (*)(Scenario&, Dice&)> needs{
      {"gassing", exerciseGassing},
      {"charge_acceptance", exerciseCharging},
      {"sulphate_history", exerciseHistory},
      {"fresh_sulphate", exerciseFreshSulphate},
      {"acid_transport", exerciseAcid},
      {"ocv_soc", exerciseChargeSwings},
      {"ocv_hysteresis", exerciseChargeSwings},
      {"high_rate_depletion", exerciseHeavyDischarge},
      {"coup_de_fouet", exerciseFullCharge},
      {"self_heating", exerciseHeat},
      {"step_force", exerciseThreshold}};
  const auto need = needs.find(id);
  if (need != needs.end()) need->second(s, dice);
}

}  // namespace battery_sof_simulator
