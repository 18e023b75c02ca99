#include "reference/full_battery.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "reference/increasing_root.hpp"

namespace battery_sof_reference {
namespace {

constexpr double kGamma = 1.0 - 0.70710678118654752440;  // 1 - 1/sqrt 2
constexpr double kCurrentTolerance = 1e-9;               // relative; 1 nA at 1 A is 4 uAs an hour
constexpr double kSecondsPerHour = 3600.0;
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
  state.main_charge = a.main_charge + share * (b.main_charge - a.main_charge);
  state.gas_charge = a.gas_charge + share * (b.gas_charge - a.gas_charge);
  // A share above 1 extrapolates; a concentration that falls within one step must not pass zero.
  state.lead_ion = std::max(0.0, a.lead_ion + share * (b.lead_ion - a.lead_ion));
  return state;
}

void requireValid(const BatteryParameters& parameters, const FullBattery::Start& start,
                  int substeps) {
  std::string text;
  for (const auto& fault : faultsOf(parameters)) text += fault + "; ";
  if (!(start.soc >= 0.0 && start.soc <= 1.0))
    text += "soc is " + std::to_string(start.soc) + ", expected 0 to 1; ";
  if (!(start.temperature >= -40.0 && start.temperature <= 80.0))
    text += "temperature is " + std::to_string(start.temperature) + " degC, expected -40 to 80; ";
  if (substeps < 1) text += "substeps is " + std::to_string(substeps) + ", expected 1 or more; ";
  if (!text.empty()) throw std::invalid_argument("battery: " + text.substr(0, text.size() - 2));
}

}  // namespace

FullBattery::FullBattery(const BatteryParameters& parameters, const BatteryEffects& effects,
                         const Start& start, int substeps)
    : parameters_((requireValid(parameters, start, substeps), parameters)),
      effects_(effects),
      start_(start),
      substeps_(substeps),
      stage_step_(kGamma * kStep / substeps),
      at_start_(atTemperature(parameters, start.temperature)),
      cpe1_(cpe1Of(parameters, effects)),
      cpe2_(cpe2Of(parameters, effects)),
      cpe1_stage_(cpe1_, stage_step_),
      cpe2_stage_(cpe2_, stage_step_) {
  if (!effects_.inductance) parameters_.inductance_h = 0.0;
}

BatteryState FullBattery::rested() const {
  BatteryState state;
  state.cpe1 = cpe1_.rested();
  state.cpe2 = cpe2_.rested();
  state.temperature = start_.temperature;
  return state;
}

BatteryState FullBattery::advance(const BatteryState& before, double current_end) const {
  const AtTemperature now = at(before);
  BatteryState state = before;
  for (int k = 1; k <= substeps_; ++k) {
    const double share = static_cast<double>(k) / substeps_;
    state = substep(state, before.current + share * (current_end - before.current), now);
  }
  state.current_rate = (current_end - before.current) / kStep;
  if (effects_.self_heating) state.temperature = warmed(before);
  return state;
}

BatteryState FullBattery::substep(const BatteryState& before, double current_end,
                                  const AtTemperature& at) const {
  const double current_inside = before.current + kGamma * (current_end - before.current);
  const BatteryState inside = eulerStage(before, current_inside, at);
  return eulerStage(between(before, inside, (1.0 - kGamma) / kGamma), current_end, at);
}

double FullBattery::voltage(const BatteryState& state) const {
  return parameters_.inductance_h * state.current_rate + voltageWithoutInductance(state);
}

double FullBattery::voltageWithoutInductance(const BatteryState& state) const {
  return at(state).r_ohmic * state.current + state.cpe1.voltage + openCircuit(soc(state)).value +
         state.cpe2.voltage;
}

double FullBattery::soc(const BatteryState& state) const {
  return start_.soc + state.main_charge / (kSecondsPerHour * parameters_.capacity_ah);
}

double FullBattery::gasCurrent(const BatteryState& state) const {
  const double u_x = openCircuit(soc(state)).value + state.cpe2.voltage;
  return gassing(parameters_, effects_.gassing, at(state), u_x).value;
}

Losses FullBattery::losses(const BatteryState& state) const {
  const AtTemperature now = at(state);
  const double u2 = state.cpe2.voltage;
  const double i_r2 = chargeTransfer(parameters_, now.i0, u2, state.lead_ion).value;
  const double nernst =
      std::log(std::max(state.lead_ion, kSmallestLeadIon)) / parameters_.beta_per_v;
  const double u_x = openCircuit(soc(state)).value + u2;
  Losses losses{};
  losses.r_ohmic = now.r_ohmic * state.current * state.current;
  losses.r1 = state.cpe1.voltage * state.r1_current;
  losses.cpe1 = cpe1_.dissipation(state.cpe1);
  losses.charge_transfer = (u2 + nernst) * i_r2;
  losses.lead_ion =
      effects_.charge_acceptance ? -nernst * now.lead_ion_limit * (1.0 - state.lead_ion) : 0.0;
  losses.cpe2 = cpe2_.dissipation(state.cpe2);
  losses.gassing = u_x * gassing(parameters_, effects_.gassing, now, u_x).value;
  return losses;
}

StoredEnergy FullBattery::stored(const BatteryState& state) const {
  const double p = std::max(state.lead_ion, kSmallestLeadIon);
  const double ions =
      at(state).lead_ion_limit * parameters_.lead_ion_time_s / parameters_.beta_per_v;
  const double u_middle = 0.5 * (openCircuit(soc(state)).value + openCircuit(start_.soc).value);
  StoredEnergy stored{};
  stored.inductance = 0.5 * parameters_.inductance_h * state.current * state.current;
  stored.cpe1 = cpe1_.storedEnergy(state.cpe1);
  stored.cpe2 = cpe2_.storedEnergy(state.cpe2);
  stored.lead_ion = effects_.charge_acceptance ? ions * (p * std::log(p) - p + 1.0) : 0.0;
  stored.main_reaction = u_middle * state.main_charge;
  return stored;
}

BatteryState FullBattery::eulerStage(const BatteryState& base, double current,
                                     const AtTemperature& at) const {
  BatteryState next = base;
  next.current = current;
  solveR1(next, base, at);
  solveReaction(next, base, at);
  return next;
}

void FullBattery::solveR1(BatteryState& next, const BatteryState& base,
                          const AtTemperature& at) const {
  const double conductance = cpe1_stage_.conductance();
  const double wanted = next.current + cpe1_stage_.sourceCurrent(base.cpe1);
  const auto excess = [&](double r1_current) {
    const Linearised v = r1Voltage(parameters_, effects_, r1_current);
    return Linearised{r1_current + conductance * at.r1_factor * v.value - wanted,
                      1.0 + conductance * at.r1_factor * v.slope};
  };
  next.r1_current = increasingRoot(excess, base.r1_current, tolerance(next.current));
  const double v1 = at.r1_factor * r1Voltage(parameters_, effects_, next.r1_current).value;
  next.cpe1 = cpe1_stage_.advance(base.cpe1, v1);
}

/// Pb2+ at the end of a stage, linear in its value before, and its derivative to u_2.
Linearised FullBattery::leadIonAfter(double before, const ReactionRates& rates,
                                     const AtTemperature& at) const {
  if (!effects_.charge_acceptance) return {1.0, 0.0};
  const double share = stage_step_ / parameters_.lead_ion_time_s;
  const double numerator = before + share * (1.0 + rates.backward / at.lead_ion_limit);
  const double denominator = 1.0 + share * (1.0 + rates.forward / at.lead_ion_limit);
  const double slope = share * parameters_.beta_per_v / at.lead_ion_limit / denominator;
  const double p = numerator / denominator;
  return {p, -slope * ((1.0 - parameters_.alpha) * rates.backward +
                       p * parameters_.alpha * rates.forward)};
}

/// i_r2 + i_CPE2 at the end of a stage against u_2.
Linearised FullBattery::mainCurrent(double u2, double source, double lead_ion_before,
                                    const AtTemperature& at) const {
  const ReactionRates rates = reactionRates(parameters_, at.i0, u2);
  const Linearised p = leadIonAfter(lead_ion_before, rates, at);
  const Linearised transfer = chargeTransfer(parameters_, at.i0, u2, p.value);
  const double conductance = cpe2_stage_.conductance();
  return {transfer.value + conductance * u2 - source,
          transfer.slope + p.slope * rates.forward + conductance};
}

void FullBattery::solveReaction(BatteryState& next, const BatteryState& base,
                                const AtTemperature& at) const {
  const double source = cpe2_stage_.sourceCurrent(base.cpe2);
  const double per_charge = 1.0 / (kSecondsPerHour * parameters_.capacity_ah);
  const double soc_before = soc(base);
  Linearised gas{};
  const auto excess = [&](double u2) {
    const Linearised main = mainCurrent(u2, source, base.lead_ion, at);
    const Linearised u0 = openCircuit(soc_before + stage_step_ * main.value * per_charge);
    gas = gassing(parameters_, effects_.gassing, at, u0.value + u2);
    const double u_x_slope = 1.0 + u0.slope * stage_step_ * per_charge * main.slope;
    return Linearised{main.value + gas.value - next.current, main.slope + gas.slope * u_x_slope};
  };
  const double u2 = increasingRoot(excess, base.cpe2.voltage, tolerance(next.current));
  next.cpe2 = cpe2_stage_.advance(base.cpe2, u2);
  next.lead_ion = leadIonAfter(base.lead_ion, reactionRates(parameters_, at.i0, u2), at).value;
  // What the solver's tolerance leaves over goes to the main reaction, so that no charge is lost.
  next.main_charge = base.main_charge + stage_step_ * (next.current - gas.value);
  next.gas_charge = base.gas_charge + stage_step_ * gas.value;
}

Linearised FullBattery::openCircuit(double soc) const {
  if (effects_.ocv_slope) return openCircuitVoltage(parameters_, soc);
  return {openCircuitVoltage(parameters_, start_.soc).value, 0.0};
}

AtTemperature FullBattery::at(const BatteryState& state) const {
  return effects_.self_heating ? atTemperature(parameters_, state.temperature) : at_start_;
}

double FullBattery::warmed(const BatteryState& state) const {
  const double outward =
      (state.temperature - start_.temperature) / parameters_.thermal_resistance_k_per_w;
  return state.temperature +
         kStep * (losses(state).total() - outward) / parameters_.heat_capacity_j_per_k;
}

}  // namespace battery_sof_reference
