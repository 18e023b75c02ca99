#include "simulator/case_draft.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace battery_sof_reference {
namespace {

constexpr std::uint32_t kBatteryStream = 10, kDriveStream = 11, kEffectStream = 12;
constexpr double kReferenceSoc = 0.8;  // of BatteryParameters::u0_v
constexpr double kOhmicShare = 0.4;    // of the smaller total resistance
// of the sample rate; 20 Hz at 100 Hz (docs/physics.md#acquisition)
constexpr double kCutoffShare = 0.2;
constexpr double kShortest = 60.0, kLongest = 14400.0;  // [s]

void requireKnown(const CaseKind& kind) {
  const auto& all = caseKinds();
  const bool known = std::any_of(all.begin(), all.end(), [&](const CaseKind& one) {
    return one.mechanism == kind.mechanism && one.id == kind.id;
  });
  if (!known)
    throw std::invalid_argument("no kind of case is \"" + kind.mechanism + " " + kind.id +
                                "\"; --list names them all");
}

std::vector<double> scalesOf(const CaseKind& kind, const std::vector<double>& asked) {
  const std::size_t additions = additionsOf(kind).size();
  for (double scale : asked)
    if (!std::isfinite(scale) || scale < 0.0)
      throw std::invalid_argument("scale is " + std::to_string(scale) + ", expected 0 or more");
  if (asked.size() == 1 && (additions > 0 || asked.front() == 1.0))
    return std::vector<double>(additions, asked.front());
  if (asked.size() != additions)
    throw std::invalid_argument("scale has " + std::to_string(asked.size()) + " numbers, but \"" +
                                kind.mechanism + " " + kind.id + "\" adds " +
                                std::to_string(additions));
  return asked;
}

double logBetween(Dice& dice, const Range& range) {
  return range.low * std::pow(range.high / range.low, dice.share());
}

void drawNoise(AcquisitionOptions& a, Dice& dice) {
  a.voltage_noise = {dice.between({0.5e-3, 3e-3}), dice.between({0.5e-3, 4e-3}),
                     logBetween(dice, {0.3, 30.0}), dice.between({0.1e-3, 1e-3})};
  a.current_noise = {dice.between({0.02, 0.1}), 0.0, 2.0, 0.0};
  a.voltage_step_v = 1e-3;
  a.current_step_a = dice.between({0.01, 0.05});
}

void makeTwoElectrodes(Scenario& s, Dice& dice) {
  s.effects.cpe2_fractional = true;
  s.battery.cpe2_exponent = dice.between({0.85, 0.97});
  s.battery.cpe2_capacitance_f = dice.between({900.0, 1600.0});
  s.battery.beta_per_v = dice.between({33.0, 43.0});
  s.battery.alpha = dice.between({0.4, 0.55});
  s.additions.second_electrode = true;
  s.additions.electrode3_capacitance_f = dice.between({1500.0, 4000.0});
  s.additions.electrode3_exponent = dice.between({0.85, 0.97});
  s.additions.electrode3_beta_per_v = dice.between({38.0, 52.0});
  s.additions.electrode3_i0_a = dice.between({0.7, 1.5});
}

void makeFullCircuit(Scenario& s, Dice& dice) {
  const GassingLaw gassing = s.effects.gassing;
  s.effects = BatteryEffects{};
  s.effects.gassing = gassing;
  s.effects.ocv_slope = false;
  s.battery.inductance_h = dice.between({0.05e-6, 0.5e-6});
  s.battery.r1_knee_current_a = dice.between({15.0, 60.0});
  s.battery.r1_transition_a = dice.between({2.0, 8.0});
  s.battery.cpe1_exponent = dice.between({0.55, 0.8});
  s.battery.cpe1_corner_hz = logBetween(dice, {5.0, 50.0});
  s.battery.cpe2_exponent = dice.between({0.8, 0.95});
}

void makePorousLine(Scenario& s, Dice& dice) {
  s.effects.cpe2_fractional = true;
  s.battery.cpe2_exponent = dice.between({0.6, 0.75});
  s.additions.fast_arc = true;
  s.additions.fast_arc_ohm = dice.between({0.5e-3, 2e-3});
  s.additions.fast_arc_time_s = logBetween(dice, {0.01, 0.3});
}

void makeKinetics(Scenario& s, Dice& dice) {
  s.battery.i0_a = logBetween(dice, {0.3, 3.0});
  s.battery.alpha = dice.share() < 0.5 ? dice.between({0.35, 0.45}) : dice.between({0.55, 0.65});
}

void makeAdded(CaseDraft& draft, const std::vector<std::string>& ids, Dice& effect, Dice& drive) {
  (draft.porous ? addPorousEffect : addEffect)(draft, ids.front(), effect, draft.scale.front());
  exercise(draft, ids.front(), drive);
  if (ids.size() < 2) return;
  exerciseMask(draft, ids.back(), drive);
  addMask(draft, ids.back(), effect, draft.scale.back());
}

void makeAbsent(CaseDraft& draft, const std::string& id, Dice& effect, Dice& drive) {
  addAbsent(draft, id, effect, draft.scale.front());
  drawAbsentDrive(draft, id, drive);
}

}  // namespace

void drawBase(CaseDraft& draft, Dice& dice) {
  Scenario& s = draft.scenario;
  s.effects = plainCircuit();
  const double r_discharge = dice.between({4e-3, 8e-3}), r_charge = dice.between({5e-3, 10e-3});
  s.battery.r_ohmic_ohm = kOhmicShare * std::min(r_discharge, r_charge);
  s.battery.r1_discharge_ohm = r_discharge - s.battery.r_ohmic_ohm;
  s.battery.r1_charge_ohm = r_charge - s.battery.r_ohmic_ohm;
  s.battery.cpe2_capacitance_f = dice.between({500.0, 2000.0});
  s.battery.beta_per_v = dice.between({15.0, 35.0});
  s.start.soc = dice.between({0.6, 0.9});
  const double u0 = dice.between({12.4, 12.9});
  s.battery.u0_v = u0 - s.battery.u0_slope_v * (s.start.soc - kReferenceSoc);
  drawNoise(s.acquisition, dice);
}

void drawStructure(CaseDraft& draft, Dice& dice) {
  struct Structure {
    const char* name;
    void (*make)(Scenario&, Dice&);
    std::vector<std::string> effects;
  };
  const std::vector<Structure> all{
      // its alpha is another
      {"two_electrodes", makeTwoElectrodes, {"cpe2", "second_electrode", "charge_transfer"}},
      {"full_circuit",
       makeFullCircuit,
       {"cpe2", "fast_arc", "current_dependent_resistance", "inductance"}},
      {"porous_line", makePorousLine, {"cpe2", "fast_arc"}},
      {"kinetics", makeKinetics, {"charge_transfer"}}};
  const Structure& one =
      all[static_cast<std::size_t>(dice.share() * static_cast<double>(all.size()))];
  one.make(draft.scenario, dice);
  draft.structure = one.name;
  draft.effects.insert(draft.effects.end(), one.effects.begin(), one.effects.end());
}

void drawPorous(CaseDraft& draft, Dice& dice) {
  PorousParameters p;
  const double thickness = dice.between({0.9, 1.1});
  p.negative_m *= thickness;
  p.separator_m *= dice.between({0.85, 1.0}) * thickness;
  p.positive_m *= thickness;
  p.area_m2 *= dice.between({1.1, 1.2});
  p.grid_ohm = dice.between({2.5e-3, 5e-3});
  p.negative_exchange_a_per_m2 = logBetween(dice, {0.03, 0.12});
  p.positive_exchange_a_per_m2 = logBetween(dice, {0.002, 0.008});
  p.negative_layer_f_per_m2 = logBetween(dice, {0.2, 2.0});
  p.positive_layer_f_per_m2 = logBetween(dice, {0.75, 2.5});
  p.diffusion_factor = dice.between({0.8, 1.25});
  draft.porous = p;
  draft.structure = "porous";
  draft.effects = {"fast_arc", "second_electrode", "charge_transfer",
                   "cpe2",     "acid_transport",   "ocv_soc"};
}

Scenario recordedScenario(const CaseDraft& draft) {
  Scenario scenario = draft.scenario;
  if (!draft.quiet) return scenario;
  AcquisitionOptions& a = scenario.acquisition;
  a.voltage_noise = a.current_noise = NoiseOptions{};
  a.voltage_step_v = a.current_step_a = 0.0;
  return scenario;
}

CaseDraft drawCase(const CaseKind& kind, std::uint64_t seed, double duration, double rate,
                   const std::vector<double>& scale) {
  requireKnown(kind);
  if (!(duration >= kShortest && duration <= kLongest))
    throw std::invalid_argument("duration is " + std::to_string(duration) +
                                " s, expected 60 to 14400");
  Dice battery(seed, kBatteryStream), drive(seed, kDriveStream), effect(seed, kEffectStream);
  CaseDraft draft;
  draft.scenario.name = kind.mechanism + " " + kind.id;
  draft.scenario.seed = seed;
  draft.scenario.duration = duration;
  draft.scenario.acquisition.sample_rate_hz = rate;
  draft.scenario.acquisition.cutoff_hz = kCutoffShare * rate;
  draft.scale = scalesOf(kind, scale);
  drawBase(draft, battery);
  if (kind.mechanism.rfind("porous", 0) == 0) drawPorous(draft, battery);
  if (kind.mechanism.rfind("structural", 0) == 0) drawStructure(draft, battery);
  drawDrive(draft, drive);
  if (kind.mechanism == "porous_null") keepChargeNear(draft);
  if (kind.id == "-") return draft;
  if (kind.mechanism == "absent")
    makeAbsent(draft, kind.id, effect, drive);
  else
    makeAdded(draft, additionsOf(kind), effect, drive);
  return draft;
}

}  // namespace battery_sof_reference
