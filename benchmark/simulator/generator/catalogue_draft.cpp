#include "simulator/generator/catalogue_draft.hpp"

#include <stdexcept>

namespace battery_sof_simulator {
namespace {

constexpr std::uint32_t kBatteryStream = 10, kDriveStream = 11, kEffectStream = 12,
                        kIndependentStream = 13;
// of the sample rate; 20 Hz at 100 Hz (docs/physics.md#acquisition)
constexpr double kCutoffShare = 0.2;
constexpr double kTrendTime = 1200.0;        // [s], in which a trend moves what is drawn for it
constexpr double kLongestCrank = 1.0;        // [s]
constexpr double kSwingAgainstTrend = 0.25;  // of its length
constexpr double kUsualRate = 100.0;         // [Hz]
constexpr double kShortest = 60.0, kLongest = 14400.0;  // [s]

std::vector<double> scalesOf(const ScenarioKind& kind, const std::vector<double>& asked) {
  const std::size_t additions = additionsOf(kind).size();
  if (asked.size() == 1 && (additions > 0 || asked.front() == 1.0))
    return std::vector<double>(additions, asked.front());
  if (asked.size() != additions)
    throw std::invalid_argument("scale has " + std::to_string(asked.size()) + " numbers, but \"" +
                                kind.kind + " " + kind.id + "\" adds " + std::to_string(additions));
  return asked;
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
  s.battery.cpe1_corner_hz = dice.logBetween({5.0, 50.0});
  s.battery.cpe2_exponent = dice.between({0.8, 0.95});
}

void makePorousLine(Scenario& s, Dice& dice) {
  s.effects.cpe2_fractional = true;
  s.battery.cpe2_exponent = dice.between({0.6, 0.75});
  s.additions.fast_arc = true;
  s.additions.fast_arc_ohm = dice.between({0.5e-3, 2e-3});
  s.additions.fast_arc_time_s = dice.logBetween({0.01, 0.3});
}

void makeKinetics(Scenario& s, Dice& dice) {
  s.battery.i0_a = dice.logBetween({0.3, 3.0});
  s.battery.alpha = dice.share() < 0.5 ? dice.between({0.35, 0.45}) : dice.between({0.55, 0.65});
}

/// Gives a drive what the second of two effects needs to act against the first: for voltage_drift a
/// charge that rises or falls all the time.
void exerciseMask(Scenario& s, const std::string& id, Dice& dice) {
  if (id != "voltage_drift") return;
  CityOptions city;
  const double sign = dice.sign();
  city.net_charge_ah = sign * dice.between({2.0, 3.5}) * s.duration / kTrendTime;
  s.profile = city;
  for (Insert& insert : s.inserts)
    for (Phase& phase : insert.phases)
      if (sign * phase.begin < 0.0 && phase.duration > kLongestCrank)
        phase.duration *= kSwingAgainstTrend;
}

/// Keeps a drawn drive's charge within about 0.5 Ah.
void keepChargeNear(Scenario& s) {
  if (auto* charges = std::get_if<LongChargesOptions>(&s.profile))
    charges->highest_charge_ah = std::min(charges->highest_charge_ah, 0.45);
  if (auto* city = std::get_if<CityOptions>(&s.profile)) city->net_charge_ah = 0.1;
}

/// What a drive is made for: the addition, or an effect of chance.
std::string exercisedBy(const Order& order, const std::string& id) {
  if (!order.independent_drive) return id;
  std::vector<std::string> effects;
  for (const ScenarioKind& kind : scenarioKinds())
    if (kind.kind == "effect") effects.push_back(kind.id);
  return Dice(order.seed, kIndependentStream).oneOf(effects);
}

/// The base circuit with its parameters, noise and quantisation drawn.
void drawBase(CatalogueDraft& draft, Dice& dice) {
  Scenario& s = draft.scenario;
  s.effects = plainCircuit();
  const double r_discharge = dice.between({4e-3, 8e-3}), r_charge = dice.between({5e-3, 10e-3});
  setResistances(s.battery, r_discharge, r_charge);
  s.battery.cpe2_capacitance_f = dice.between({500.0, 2000.0});
  s.battery.beta_per_v = dice.between({15.0, 35.0});
  s.start.soc = dice.between({0.6, 0.9});
  const double u0 = dice.between({12.4, 12.9});
  s.battery.u0_v = u0 - s.battery.u0_slope_v * (s.start.soc - kReferenceSoc);
  AcquisitionOptions& a = s.acquisition;
  a.voltage_noise = {dice.between({0.5e-3, 3e-3}), dice.between({0.5e-3, 4e-3}),
                     dice.logBetween({0.3, 30.0}), dice.between({0.1e-3, 1e-3})};
  a.current_noise = {dice.between({0.02, 0.1}), 0.0, 2.0, 0.0};
  a.voltage_step_v = 1e-3;
  a.current_step_a = dice.between({0.01, 0.05});
}

/// Another structure in place of the base circuit's, without any tier-P effect: two_electrodes,
/// full_circuit (Fig. 4 without gassing, u_0 constant), porous_line or kinetics.
void drawStructure(CatalogueDraft& draft, Dice& dice) {
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
  const Structure one = dice.oneOf(all);
  one.make(draft.scenario, dice);
  draft.structure = one.name;
  draft.effects.insert(draft.effects.end(), one.effects.begin(), one.effects.end());
}

/// A porous block in place of the circuit, with dissolved Pb2+ and gassing left out.
void drawPorous(CatalogueDraft& draft, Dice& dice) {
  PorousParameters p;
  const double thickness = dice.between({0.9, 1.1});
  p.negative.thickness_m *= thickness;
  p.separator_m *= dice.between({0.85, 1.0}) * thickness;
  p.positive.thickness_m *= thickness;
  p.area_m2 *= dice.between({1.1, 1.2});
  p.grid_ohm = dice.between({2.5e-3, 5e-3});
  p.negative.exchange_a_per_m2 = dice.logBetween({0.03, 0.12});
  p.positive.exchange_a_per_m2 = dice.logBetween({0.002, 0.008});
  p.negative.layer_f_per_m2 = dice.logBetween({0.2, 2.0});
  p.positive.layer_f_per_m2 = dice.logBetween({0.75, 2.5});
  p.diffusion_factor = dice.between({0.8, 1.25});
  draft.scenario.porous = p;
  draft.structure = "porous";
  draft.effects = {"fast_arc", "second_electrode", "charge_transfer",
                   "cpe2",     "acid_transport",   "ocv_soc"};
}

}  // namespace

Scenario recordedScenario(const CatalogueDraft& draft) {
  Scenario scenario = draft.scenario;
  if (!draft.order.quiet) return scenario;
  AcquisitionOptions& a = scenario.acquisition;
  a.voltage_noise = a.current_noise = NoiseOptions{};
  a.voltage_step_v = a.current_step_a = 0.0;
  return scenario;
}

CatalogueDraft drawCatalogue(const Order& order) {
  requireSound(order, kShortest, kLongest);
  if (!order.drive.empty())
    throw std::invalid_argument("--drive: drives of \"" + order.what.kind +
                                "\" are what its addition needs");
  const ScenarioKind kind = meantBy(order.what).front();
  Dice battery(order.seed, kBatteryStream), drive(order.seed, kDriveStream),
      effect(order.seed, kEffectStream);
  CatalogueDraft draft;
  draft.order = order;
  draft.order.what = kind;
  Scenario& s = draft.scenario;
  s.name = kind.kind + " " + kind.id;
  s.seed = order.seed;
  s.duration = order.duration.value_or(usualDuration(kind));
  s.acquisition.sample_rate_hz = order.rate.value_or(kUsualRate);
  s.acquisition.cutoff_hz = kCutoffShare * s.acquisition.sample_rate_hz;
  draft.order.scale = scalesOf(kind, order.scale);
  drawBase(draft, battery);
  if (kind.kind.rfind("porous", 0) == 0) drawPorous(draft, battery);
  if (kind.kind.rfind("structural", 0) == 0) drawStructure(draft, battery);
  drawCatalogueDrive(draft, drive);
  if (kind.kind == "porous_control") keepChargeNear(s);
  const std::vector<std::string> ids = additionsOf(kind);
  if (ids.empty()) return draft;
  const std::vector<double>& scale = draft.order.scale;
  if (kind.kind == "absent") {
    addAbsent(draft, kind.id, effect, scale.front());
    drawAbsentDrive(draft, kind.id, drive);
    return draft;
  }
  addEffect(draft, ids.front(), effect, scale.front());
  exercise(s, exercisedBy(order, ids.front()), drive);
  if (ids.size() < 2) return draft;
  exerciseMask(s, ids.back(), drive);
  addMask(draft, ids.back(), effect, scale.back());
  return draft;
}

}  // namespace battery_sof_simulator
