#include "simulator/full_battery.hpp"

#include <algorithm>

#include "simulator/fields.hpp"

namespace battery_sof_simulator {
namespace {

constexpr double kGamma = 1.0 - 0.70710678118654752440;  // 1 - 1/sqrt 2
constexpr double kCurrentTolerance = 1e-9;               // relative; 1 nA at 1 A is 4 uAs an hour
constexpr double kSmallestLeadIon = 1e-300;

double tolerance(double current) { return kCurrentTolerance * (1.0 + std::abs(current)); }

LadderState between(const LadderState& a, const LadderState& b, double share) {
  return {a.voltage + share * (b.voltage - a.voltage),
          a.branches + share * (b.branches - a.branches)};
}

/// a + share (b - a), for the states that are integrated.
BatteryState between(const BatteryState& a, const BatteryState& b, double share) {
  BatteryState state = b;
  state.cpe1 = between(a.cpe1, b.cpe1, share);
  state.cpe2 = between(a.cpe2, b.cpe2, share);
  state.cpe3 = between(a.cpe3, b.cpe3, share);
  state.main_charge = a.main_charge + share * (b.main_charge - a.main_charge);
  state.gas_charge = a.gas_charge + share * (b.gas_charge - a.gas_charge);
  // A share above 1 extrapolates; a concentration that falls within one step must not pass zero.
  state.lead_ion = std::max(0.0, a.lead_ion + share * (b.lead_ion - a.lead_ion));
  return state;
}

void requireValid(const BatteryParameters& parameters, const Additions& additions,
                  const FullBattery::Start& start, int substeps) {
  auto faults = faultsOf(parameters);
  for (const auto& more : {fieldFaults(additions), faultsOf(start)})
    faults.insert(faults.end(), more.begin(), more.end());
  if (substeps < 1)
    faults.push_back("substeps is " + std::to_string(substeps) + ", expected 1 or more");
  requireNone(faults, "battery");
}

Cpe cpe3Of(const BatteryParameters& parameters, const Additions& additions) {
  if (!additions.second_electrode) return {};
  const double p = additions.electrode3_exponent;
  return {
      additions.electrode3_capacitance_f * std::pow(parameters.cpe2_reference_rad_per_s, 1.0 - p),
      p};
}

void addScaled(Losses& sum, const Losses& a, const Losses& b, double factor) {
  for (double Losses::*part :
       {&Losses::r_ohmic, &Losses::r1, &Losses::cpe1, &Losses::charge_transfer, &Losses::lead_ion,
        &Losses::cpe2, &Losses::gassing, &Losses::added})
    sum.*part += factor * (a.*part + b.*part);
}

}  // namespace

std::vector<std::string> faultsOf(const FullBattery::Start& start) {
  std::vector<std::string> faults;
  if (!(start.soc >= 0.0 && start.soc <= 1.0))
    faults.push_back(faultOf("soc", start.soc, "0 to 1"));
  if (!(start.temperature >= -40.0 && start.temperature <= 80.0))
    faults.push_back(faultOf("temperature_degc", start.temperature, "-40 to 80"));
  return faults;
}

FullBattery::FullBattery(const BatteryParameters& parameters, const BatteryEffects& effects,
                         const Start& start, int substeps, const Additions& additions)
    : parameters_((requireValid(parameters, additions, start, substeps), parameters)),
      effects_(effects),
      start_(start),
      substeps_(substeps),
      stage_step_(kGamma * kStep / substeps),
      at_start_(atTemperature(parameters, start.temperature)),
      additions_(additions),
      forces_(additions, kStep),
      cpe1_(cpe1Of(parameters, effects), stage_step_),
      cpe2_(cpe2Of(parameters, effects), stage_step_),
      cpe3_(cpe3Of(parameters, additions), stage_step_) {
  if (!effects_.inductance) parameters_.inductance_h = 0.0;
}

BatteryState FullBattery::rested() const {
  BatteryState state;
  state.cpe1 = cpe1_.rested();
  state.cpe2 = cpe2_.rested();
  state.cpe3 = cpe3_.rested();
  state.temperature = start_.temperature;
  state.added = forces_.settled(-additions_.parasitic_load_a);
  if (additions_.parasitic_load_a != 0.0) settleUnderParasiticLoad(state);
  return state;
}

void FullBattery::settleUnderParasiticLoad(BatteryState& state) const {
  const double current = batteryCurrent(state);
  if (effects_.charge_acceptance) state.lead_ion = 1.0 - current / at_start_.lead_ion_limit;
  const auto excess = [&](double u2) {
    const Linearised transfer = chargeTransfer(parameters_, at_start_.i0, u2, state.lead_ion);
    return Linearised{transfer.value - current, transfer.slope};
  };
  const double u2 = increasingRoot(excess, 0.0, tolerance(current));
  state.r1_current = current;
  state.cpe1 = cpe1_.settled(at_start_.r1_factor * r1Voltage(parameters_, effects_, current).value);
  state.cpe2 =
      cpe2_.settled(u2 + std::copysign(additions_.dead_zone ? additions_.dead_zone_v : 0.0, u2));
  if (additions_.second_electrode)
    state.cpe3 = cpe3_.settled(2.0 / additions_.electrode3_beta_per_v *
                               std::asinh(0.5 * current / additions_.electrode3_i0_a));
}

BatteryState FullBattery::advance(const BatteryState& before, double current_end) const {
  const Conditions now = at(before);
  BatteryState state = before;
  for (int k = 1; k <= substeps_; ++k) {
    const double share = static_cast<double>(k) / substeps_;
    state = substep(state, before.current + share * (current_end - before.current), now);
  }
  state.current_rate = (current_end - before.current) / kStep;
  state.added = forces_.advance(before.added, batteryCurrent(before), batteryCurrent(state));
  state.steps = before.steps + 1;
  if (effects_.self_heating) {
    const double outward =
        (before.temperature - start_.temperature) / parameters_.thermal_resistance_k_per_w;
    state.temperature +=
        kStep * (losses(before).total() - outward) / parameters_.heat_capacity_j_per_k;
  }
  return state;
}

BatteryState FullBattery::substep(const BatteryState& before, double current_end,
                                  const Conditions& at) const {
  const double current_inside = before.current + kGamma * (current_end - before.current);
  const BatteryState inside = eulerStage(before, current_inside, at);
  return eulerStage(between(before, inside, (1.0 - kGamma) / kGamma), current_end, at);
}

double FullBattery::voltageWithoutInductance(const BatteryState& state) const {
  const Conditions now = at(state);
  return now.r_ohmic * batteryCurrent(state) + state.cpe1.voltage +
         openCircuit(soc(state), now).value + state.cpe2.voltage + addedVoltage(state);
}

double FullBattery::addedVoltage(const BatteryState& state) const {
  const double time = static_cast<double>(state.steps) * kStep;
  return state.cpe3.voltage + forces_.voltage(state.added, time, batteryCurrent(state));
}

Losses FullBattery::losses(const BatteryState& state) const {
  const Conditions now = at(state);
  const double u2 = state.cpe2.voltage;
  const double i_r2 =
      chargeTransfer(parameters_, now.i0, activating(u2).value, state.lead_ion).value;
  const double nernst =
      std::log(std::max(state.lead_ion, kSmallestLeadIon)) / parameters_.beta_per_v;
  const double u_x = openCircuit(soc(state), now).value + u2;
  const double current = batteryCurrent(state);
  Losses losses{};
  losses.r_ohmic = now.r_ohmic * current * current;
  losses.r1 = state.cpe1.voltage * state.r1_current;
  losses.cpe1 = cpe1_.dissipation(state.cpe1);
  losses.charge_transfer = (u2 + nernst) * i_r2;
  losses.lead_ion =
      effects_.charge_acceptance ? -nernst * now.lead_ion_limit * (1.0 - state.lead_ion) : 0.0;
  losses.cpe2 = cpe2_.dissipation(state.cpe2);
  losses.gassing = u_x * gassing(parameters_, effects_.gassing, now, u_x).value;
  losses.added = addedVoltage(state) * current;
  return losses;
}

StoredEnergy FullBattery::stored(const BatteryState& state) const {
  const double p = std::max(state.lead_ion, kSmallestLeadIon);
  const double ions =
      at(state).lead_ion_limit * parameters_.lead_ion_time_s / parameters_.beta_per_v;
  const double u_middle =
      0.5 * (openCircuit(soc(state), at(state)).value + openCircuit(start_.soc, at_start_).value);
  StoredEnergy stored{};
  stored.inductance = 0.5 * parameters_.inductance_h * state.current * state.current;
  stored.cpe1 = cpe1_.storedEnergy(state.cpe1);
  stored.cpe2 = cpe2_.storedEnergy(state.cpe2);
  stored.lead_ion = effects_.charge_acceptance ? ions * (p * std::log(p) - p + 1.0) : 0.0;
  stored.main_reaction = u_middle * state.main_charge;
  return stored;
}

BatteryState FullBattery::eulerStage(const BatteryState& base, double current,
                                     const Conditions& at) const {
  BatteryState next = base;
  next.current = current;
  solveR1(next, base, at);
  solveReaction(next, base, at);
  if (additions_.second_electrode) solveSecondElectrode(next, base);
  return next;
}

void FullBattery::solveR1(BatteryState& next, const BatteryState& base,
                          const Conditions& at) const {
  const double conductance = cpe1_.conductance();
  const double wanted = batteryCurrent(next) + cpe1_.sourceCurrent(base.cpe1);
  const auto excess = [&](double r1_current) {
    const Linearised v = r1Voltage(parameters_, effects_, r1_current);
    return Linearised{r1_current + conductance * at.r1_factor * v.value - wanted,
                      1.0 + conductance * at.r1_factor * v.slope};
  };
  next.r1_current = increasingRoot(excess, base.r1_current, tolerance(next.current));
  const double v1 = at.r1_factor * r1Voltage(parameters_, effects_, next.r1_current).value;
  next.cpe1 = cpe1_.advance(base.cpe1, v1);
}

/// Pb2+ at the end of a stage, linear in its value before, and its derivative to u_2.
Linearised FullBattery::leadIonAfter(double before, const ReactionRates& rates,
                                     const Conditions& at) const {
  if (!effects_.charge_acceptance) return {1.0, 0.0};
  const double share = stage_step_ / parameters_.lead_ion_time_s;
  const double numerator = before + share * (1.0 + rates.backward / at.lead_ion_limit);
  const double denominator = 1.0 + share * (1.0 + rates.forward / at.lead_ion_limit);
  const double slope = share * parameters_.beta_per_v / at.lead_ion_limit / denominator;
  const double p = numerator / denominator;
  return {p, -slope * ((1.0 - parameters_.alpha) * rates.backward +
                       p * parameters_.alpha * rates.forward)};
}

/// The part of u_2 that drives the charge transfer.
Linearised FullBattery::activating(double u2) const {
  if (!additions_.dead_zone) return {u2, 1.0};
  const double beyond = std::abs(u2) - additions_.dead_zone_v;
  return beyond > 0.0 ? Linearised{std::copysign(beyond, u2), 1.0} : Linearised{0.0, 0.0};
}

/// i_r2 + i_CPE2 at the end of a stage against u_2.
Linearised FullBattery::mainCurrent(double u2, double source, double lead_ion_before,
                                    const Conditions& at) const {
  const Linearised eta = activating(u2);
  const ReactionRates rates = reactionRates(parameters_, at.i0, eta.value);
  const Linearised p = leadIonAfter(lead_ion_before, rates, at);
  const Linearised transfer = chargeTransfer(parameters_, at.i0, eta.value, p.value);
  const double conductance = at.cpe2_factor * cpe2_.conductance();
  return {transfer.value + conductance * u2 - source,
          (transfer.slope + p.slope * rates.forward) * eta.slope + conductance};
}

void FullBattery::solveReaction(BatteryState& next, const BatteryState& base,
                                const Conditions& at) const {
  const double source = at.cpe2_factor * cpe2_.sourceCurrent(base.cpe2);
  const double current = batteryCurrent(next);
  const double per_charge = 1.0 / (kSecondsPerHour * parameters_.capacity_ah);
  const double soc_before = soc(base);
  Linearised gas{};
  const auto excess = [&](double u2) {
    const Linearised main = mainCurrent(u2, source, base.lead_ion, at);
    const Linearised u0 = openCircuit(soc_before + stage_step_ * main.value * per_charge, at);
    gas = gassing(parameters_, effects_.gassing, at, u0.value + u2);
    const double u_x_slope = 1.0 + u0.slope * stage_step_ * per_charge * main.slope;
    return Linearised{main.value + gas.value - current, main.slope + gas.slope * u_x_slope};
  };
  const double u2 = increasingRoot(excess, base.cpe2.voltage, tolerance(next.current));
  next.cpe2 = cpe2_.advance(base.cpe2, u2);
  const ReactionRates rates = reactionRates(parameters_, at.i0, activating(u2).value);
  next.lead_ion = leadIonAfter(base.lead_ion, rates, at).value;
  // What the solver's tolerance leaves over goes to the main reaction, so that no charge is lost.
  next.main_charge = base.main_charge + stage_step_ * (current - gas.value);
  next.gas_charge = base.gas_charge + stage_step_ * gas.value;
}

void FullBattery::solveSecondElectrode(BatteryState& next, const BatteryState& base) const {
  const double current = batteryCurrent(next);
  const double source = cpe3_.sourceCurrent(base.cpe3);
  const double beta = additions_.electrode3_beta_per_v;
  const auto excess = [&](double u3) {
    const double forward = additions_.electrode3_i0_a * std::exp(0.5 * beta * u3);
    const double backward = additions_.electrode3_i0_a * std::exp(-0.5 * beta * u3);
    const double conductance = cpe3_.conductance();
    return Linearised{forward - backward + conductance * u3 - source - current,
                      0.5 * beta * (forward + backward) + conductance};
  };
  const double u3 = increasingRoot(excess, base.cpe3.voltage, tolerance(current));
  next.cpe3 = cpe3_.advance(base.cpe3, u3);
}

Linearised FullBattery::openCircuit(double soc, const Conditions& at) const {
  const Linearised u0 = openCircuitVoltage(parameters_, effects_.ocv_slope ? soc : start_.soc);
  return {at.u0_factor * u0.value, effects_.ocv_slope ? at.u0_factor * u0.slope : 0.0};
}

Conditions FullBattery::at(const BatteryState& state) const {
  Conditions now =
      effects_.self_heating ? atTemperature(parameters_, state.temperature) : at_start_;
  const Additions& a = additions_;
  const double time = static_cast<double>(state.steps) * kStep, hours = time / kSecondsPerHour;
  now.lead_ion_limit *= forces_.chargeLimitFactor(state.added);
  if (a.capacitance_fall) now.cpe2_factor *= std::pow(1.0 - a.capacitance_fall_share, hours);
  const double drift = a.parameter_drift ? 1.0 + a.drift_per_h * hours : 1.0;
  switch (a.drifting) {
    case DriftingParameter::kROhmic: now.r_ohmic *= drift; break;
    case DriftingParameter::kR1: now.r1_factor *= drift; break;
    case DriftingParameter::kCpe2Capacitance: now.cpe2_factor *= drift; break;
    case DriftingParameter::kU0: now.u0_factor *= drift; break;
  }
  now.r_ohmic += forces_.resistance(state.added, time);
  return now;
}

EnergyLedger::EnergyLedger(const FullBattery& battery, const BatteryState& start)
    : battery_(&battery), stored_at_start_(battery.stored(start).total()), last_(ratesOf(start)) {}

EnergyLedger::Rates EnergyLedger::ratesOf(const BatteryState& state) const {
  const double current = battery_->batteryCurrent(state);
  return {battery_->losses(state), current, battery_->voltageWithoutInductance(state) * current,
          battery_->stored(state).inductance};
}

void EnergyLedger::enter(const BatteryState& after) {
  const double half = 0.5 * FullBattery::kStep;
  const Rates now = ratesOf(after);
  balance_.charge_in += half * (last_.current + now.current);
  balance_.main_charge = after.main_charge;
  balance_.gas_charge = after.gas_charge;
  balance_.energy_in +=
      half * (last_.terminal_power + now.terminal_power) + now.inductance - last_.inductance;
  balance_.throughput += half * (std::abs(last_.terminal_power) + std::abs(now.terminal_power));
  balance_.stored = battery_->stored(after).total() - stored_at_start_;
  addScaled(balance_.lost, last_.lost, now.lost, half);
  last_ = now;
}

}  // namespace battery_sof_simulator
