#pragma once

#include "simulator/additions.hpp"
#include "simulator/battery_elements.hpp"
#include "simulator/numerics.hpp"

namespace battery_sof_simulator {

/// Everything a battery remembers, at one instant.
struct BatteryState {
  LadderState cpe1;           ///< beside r_1; its voltage is v_1 [V]
  LadderState cpe2;           ///< beside r_2; its voltage is u_2 [V]
  LadderState cpe3;           ///< of the second electrode; its voltage is u_3 [V]
  AddedState added;           ///< of the other additions
  long steps = 0;             ///< of FullBattery::kStep since the start
  double main_charge = 0.0;   ///< through u_0 since the start [As]
  double gas_charge = 0.0;    ///< through the gassing branch since the start [As]
  double lead_ion = 1.0;      ///< p = [Pb2+] / [Pb2+]_eq [1]
  double temperature = 25.0;  ///< of the block [degC]
  double current = 0.0;       ///< at the sensor, positive into the battery [A]
  double current_rate = 0.0;  ///< di/dt over the last step [A/s]
  double r1_current = 0.0;    ///< through r_1 [A]
};

/// Power turned into heat or gas in each element [W]; each >= 0 but the last, which is what the
/// additions take up, lost or stored.
struct Losses {
  double r_ohmic, r1, cpe1, charge_transfer, lead_ion, cpe2, gassing, added;
  double total() const {
    return r_ohmic + r1 + cpe1 + charge_transfer + lead_ion + cpe2 + gassing + added;
  }
};

/// Energy kept in each element [J]; main_reaction counts from the start and may be negative.
struct StoredEnergy {
  double inductance, cpe1, cpe2, lead_ion, main_reaction;
  double total() const { return inductance + cpe1 + cpe2 + lead_ion + main_reaction; }
};

/// The impedance-based nonlinear simulation model (paper, Fig. 4, III-B) in the time domain.
///     u   = L di/dt + r_i i + v_1 + U_x,                U_x = u_0(SOC) + u_2
///     i   = i_r1 + i_CPE1,       v_1 = r_1(i_r1) i_r1,   i_CPE1 from v_1 by CpeLadder
///     i   = i_main + i_g(U_x),   i_main = i_r2(u_2, p) + i_CPE2,   dSOC/dt = i_main / (3600 C_20)
///     dp/dt = (1 - p)/tau_d - i_r2/(i_lim tau_d)         with charge_acceptance, else p = 1
///     C_th dT/dt = losses - (T - T_a)/R_th               with self_heating, else T = T_a
/// The current goes linearly from one step's end to the next. Integrated with the two-stage,
/// stiffly accurate, L-stable diagonally implicit Runge-Kutta method of second order (gamma = 1 -
/// 1/sqrt 2): each stage is one implicit Euler step, solved to 1e-9 of the current for i_r1 and for
/// u_2, everything else being linear and eliminated. T is moved by explicit Euler.
///
/// Every element is passive, with eta = u_2 + ln(p)/beta:
///     charge transfer dissipates   eta i_r2 >= 0
///     Pb2+ dissipates              -i_lim/beta ln(p) (1 - p) >= 0
///     Pb2+ stores                  i_lim tau_d/beta (p ln p - p + 1) >= 0
/// Additions (additions.hpp) lie in series or change a parameter; i is then what enters the block,
/// the sensor's current less the parasitic load. The second electrode is integrated with the rest,
/// the others step by step. With sulphate_history, sulphate_crystals or a changing capacitance the energy
/// books do not close exactly: Pb2+ and CPE2 then change what they hold without current.
///
/// Not modelled: self-discharge, ageing; u_0 and CPEs over temperature. Where the gassing branch
/// attaches in Fig. 4 is not said in the text; here it lies across u_0 and r_2 || CPE2.
class FullBattery {
 public:
  using State = BatteryState;

  /// How the battery stands before the first step: rested, at this state of charge and temperature.
  struct Start {
    double soc = 0.8;           ///< [1], 0 to 1
    double temperature = 25.0;  ///< of block and surroundings [degC], -40 to 80
  };

  /// Time over which the current is linear, and what advance() moves by [s].
  static constexpr double kStep = 0.001;

  /// @param substeps integration steps within kStep, >= 1. With 1 the voltage is within 0.1 mV of
  ///                 that with 2 in the shipped scenarios (a test holds 0.5 mV).
  /// @throws std::invalid_argument naming every fault of parameters, additions, start and substeps.
  FullBattery(const BatteryParameters& parameters, const BatteryEffects& effects,
              const Start& start, int substeps = 1, const Additions& additions = {});

  BatteryState rested() const;

  /// @return the state kStep later, the sensor's current having gone linearly to current_end [A].
  BatteryState advance(const BatteryState& before, double current_end) const;

  double voltage(const BatteryState& state) const {  ///< u [V]
    return parameters_.inductance_h * state.current_rate + voltageWithoutInductance(state);
  }
  double voltageWithoutInductance(const BatteryState& state) const;  ///< u - L di/dt [V]
  double batteryCurrent(const BatteryState& state) const {           ///< into the block [A]
    return state.current - additions_.parasitic_load_a;
  }
  double soc(const BatteryState& state) const {  ///< [1]
    return start_.soc + state.main_charge / (kSecondsPerHour * parameters_.capacity_ah);
  }
  Losses losses(const BatteryState& state) const;
  StoredEnergy stored(const BatteryState& state) const;

 private:
  BatteryState substep(const BatteryState& before, double current_end, const Conditions& at) const;
  /// An implicit Euler step of a stage's length, the current at its end being given.
  BatteryState eulerStage(const BatteryState& base, double current, const Conditions& at) const;
  void solveR1(BatteryState& next, const BatteryState& base, const Conditions& at) const;
  void solveReaction(BatteryState& next, const BatteryState& base, const Conditions& at) const;
  Linearised leadIonAfter(double before, const ReactionRates& rates, const Conditions& at) const;
  Linearised mainCurrent(double u2, double source, double lead_ion_before,
                         const Conditions& at) const;
  void solveSecondElectrode(BatteryState& next, const BatteryState& base) const;
  Linearised activating(double u2) const;
  Linearised openCircuit(double soc, const Conditions& at) const;
  double addedVoltage(const BatteryState& state) const;
  void settleUnderParasiticLoad(BatteryState& state) const;
  Conditions at(const BatteryState& state) const;

  BatteryParameters parameters_;
  BatteryEffects effects_;
  Start start_;
  int substeps_;
  double stage_step_;  // [s]
  Conditions at_start_;
  Additions additions_;
  AddedVoltages forces_;
  CpeLadder cpe1_, cpe2_, cpe3_;
};

/// @return one sentence for every number outside its bounds; empty when all is well.
std::vector<std::string> faultsOf(const FullBattery::Start& start);

/// Charge and energy books over a stretch of time.
struct Balance {
  double charge_in = 0.0;    ///< int i dt [As]
  double main_charge = 0.0;  ///< 3600 C_20 dSOC [As]
  double gas_charge = 0.0;   ///< [As]
  double energy_in = 0.0;    ///< int u i dt [J]
  double throughput = 0.0;   ///< int |u i| dt [J]
  double stored = 0.0;       ///< change of what every element keeps [J]
  Losses lost{};             ///< int losses dt [J], by element

  double chargeError() const { return charge_in - main_charge - gas_charge; }  ///< [As]
  double energyError() const { return energy_in - stored - lost.total(); }     ///< [J]
};

/// Keeps the books of a simulated battery: what went in, where it is, what was lost.
///     int i dt = 3600 C_20 dSOC + gassing charge,      int u i dt = d(stored) + int losses dt
/// Current and power are those entering the block, behind a parasitic load. Integrated by the
/// trapezoidal rule over the steps' ends, separately from the battery's own integration, so that
/// the balances test the latter. The voltage across L, which a step's ramp changes, is exact.
class EnergyLedger {
 public:
  /// @param battery outlives the ledger.
  EnergyLedger(const FullBattery& battery, const BatteryState& start);

  /// Enters one step, from the state entered last (or the start) to this one.
  void enter(const BatteryState& after);

  const Balance& balance() const { return balance_; }

 private:
  /// What is summed up, at one step's end.
  struct Rates {
    Losses lost;                                 // [W]
    double current, terminal_power, inductance;  // [A], [W] without the inductance's, stored [J]
  };
  Rates ratesOf(const BatteryState& state) const;

  const FullBattery* battery_;
  double stored_at_start_;
  Rates last_;
  Balance balance_;
};

}  // namespace battery_sof_simulator
