#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "simulator/numerics.hpp"

namespace battery_sof_simulator {

/// One electrode of a cell, as it is when full.
struct PorousElectrode {
  double thickness_m, porosity;  ///< [m], [1]
  double surface_per_m;          ///< a [1/m]
  double exchange_a_per_m2;      ///< j_0 [A/m2]
  double layer_f_per_m2;         ///< C_dl [F/m2]
};

/// A 12 V block of six equal cells with porous electrodes; 50 Ah as defaults stand. Values of
/// Sulzer et al. 2019 (17 Ah), area scaled to 50 Ah and thickness by 0.8 for a spiral block
/// (docs/physics.md#porous-electrode), unless said otherwise.
struct PorousParameters {
  double capacity_ah = 50.0;  ///< for the state of charge alone [Ah]
  double area_m2 = 0.174;     ///< of a cell's electrodes [m2]
  PorousElectrode negative{0.72e-3, 0.53, 2.3e6, 0.06, 0.2};
  /// its layer is 0.2 F/m2 in the source; the paper's block has 1000 F
  PorousElectrode positive{1.0e-3, 0.57, 2.3e7, 0.004, 1.5};
  double separator_m = 1.2e-3;           ///< thickness [m]
  double separator_porosity = 0.92;      ///< [1]
  double grid_ohm = 3e-3;                ///< grids and straps of the block [Ohm]
  double full_acid_mol_per_m3 = 5650.0;  ///< at full charge
  double diffusion_factor = 1.0;         ///< of the acid's diffusion coefficient [1]
  bool gassing = false;
  double gas_current_a = 0.05;          ///< of each electrode at its potential below [A]
  double oxygen_potential_v = 1.87;     ///< phi_s - phi_e of the positive [V]
  double hydrogen_potential_v = -0.53;  ///< phi_s - phi_e of the negative; together 2.4 V [V]
  double gas_slope_per_v = 19.0;        ///< of each, 0.12 V a decade [1/V]
  bool lead_ion = false;
  double lead_ion_limit_a = 60.0;  ///< largest lasting charging current [A]
  double lead_ion_time_s = 15.0;   ///< [s] (both: docs/physics.md#charge_acceptance)
  int cells_per_region = 15;       ///< of the grid
};

/// Everything a porous block remembers, at one instant.
struct PorousState {
  using Field = Eigen::Array<double, Eigen::Dynamic, 1, 0, 90, 1>;
  Field acid;                   ///< c over all three regions, from the negative grid on [mol/m3]
  Field porosity;               ///< the same [1]
  Field negative, positive;     ///< phi_s - phi_e across an electrode [V]
  Field lead_ion;               ///< p over the negative electrode [1]
  double current = 0.0;         ///< positive into the block [A]
  double cell_voltage = 0.0;    ///< without grids [V]
  double oxygen_current = 0.0;  ///< made at the positive [A]
  double gas_current = 0.0;     ///< side reactions of the negative [A]
  double main_charge = 0.0;     ///< through the negative's main reaction since the start [As]
  double gas_charge = 0.0;      ///< through its side reactions since the start [As]
};

/// Porous-electrode model of a lead-acid block in one dimension (docs/physics.md#porous-electrode).
///     d(eps c)/dt = d/dx(eps^1.5 D dc/dx) - t+ di_e/dx /F + s a j/F,    s_n = 1/2, s_p = 3/2
///     i_e = kappa eps^1.5 (chi (RT/F) dlnc/dx - dphi_e/dx)
///     di_e/dx = a j + a j_side + a C_dl d(phi_s - phi_e)/dt
///     j = j_0 (e^{F eta/RT} - e^{-F eta/RT}),   eta = phi_s - phi_e - U(c)
///     deps/dt = -V_n a j/F,  +V_p a j/F
///     u = 6 (phi_s,p - phi_s,n) + r_grid i
/// phi_s is uniform in an electrode: lead and lead dioxide conduct so well that 300 A drop 0.1 mV.
/// With lead_ion the negative's charging branch is multiplied by p, locally: dp/dt = (1 - p)/tau +
/// a j/(q_lim tau), q_lim = i_lim / (area thickness). With gassing oxygen forms at the positive and
/// hydrogen at the negative, each I_g e^{+-c (phi_s - phi_e - its potential)} spread over the
/// electrode, and the oxygen is reduced at the negative one step later. No convection, 25 degC, no
/// dissolved Pb2+ otherwise; the state of charge is the negative's.
///
/// Implicit Euler in two parts: potentials with the acid held (per electrode a tridiagonal system,
/// by Newton), then the acid with the reactions held (tridiagonal). Both parts conserve charge and
/// acid exactly. With steps of 1 ms the voltage is within 1 mV of that with half of it, 50 ms after
/// a step of the current (a test holds this).
class PorousBlock {
 public:
  using State = PorousState;
  static constexpr double kStep = 0.001;  ///< [s]

  /// @param soc at the start, 0.3 to 1, at rest.
  /// @param step by which advance() moves [s]; drives need kStep.
  /// @throws std::invalid_argument naming every fault.
  PorousBlock(const PorousParameters& parameters, double soc, double step = kStep);

  PorousState rested() const;

  /// @return the state a step later, the current being current_end all the while [A].
  PorousState advance(const PorousState& before, double current_end) const;

  double voltage(const PorousState& state) const {  ///< at the terminals of six cells [V]
    return 6.0 * state.cell_voltage + parameters_.grid_ohm * state.current;
  }
  double soc(const PorousState& state) const {  ///< [1]
    return soc_at_start_ + state.main_charge / (kSecondsPerHour * parameters_.capacity_ah);
  }
  double acid(const PorousState& state) const;  ///< in the pores of one cell [mol]

 private:
  using Field = PorousState::Field;
  /// An electrode with its place in the grid and the constants of its reaction.
  struct Electrode : PorousElectrode {
    Eigen::Index first;   // cell of the grid
    double per_electron;  // s [1]
    double expansion;     // change of porosity per a j/F [m3/mol]
    bool positive;
  };
  /// What does not change while an electrode's potentials are solved for.
  struct Setting {
    Field equilibrium;     // U [V]
    Field exchange;        // a j_0 [A/m3]
    Field conductance;     // between neighbouring cells [S/m2]
    Field driven;          // by the acid's gradient, between them [A/m2]
    double inflow;         // of current at the interface to the separator, into the acid [A/m2]
    double recombination;  // a j_side that does not follow from the potential [A/m3]
  };
  /// Current densities of an electrode's cells at their potentials, and the slope of their sum.
  struct Reaction {
    Field main, side, slope;  // [A/m3], [A/m3], [A/(m3 V)]
  };
  /// Conductances between neighbouring cells, and the current that the acid's gradient drives.
  struct Paths {
    Field conductance, driven;  // [S/m2], [A/m2]
  };

  double width(Eigen::Index cell) const;
  Field between(const Field& conductivity) const;
  Paths paths(const PorousState& state) const;
  Setting setting(const Electrode& electrode, const PorousState& before, const Paths& paths,
                  double current_end) const;
  Reaction reaction(const Electrode& electrode, const Setting& setting, const Field& potential,
                    const PorousState& before) const;
  /// Moves an electrode's potentials to the step's end. @return what then reacts.
  Reaction solvePotentials(const Electrode& electrode, const Setting& setting,
                           const PorousState& before, Field& potential) const;
  void moveAcid(const PorousState& before, const Reaction& negative, const Reaction& positive,
                PorousState& next) const;
  double cellVoltage(const PorousState& state, const Paths& paths) const;

  PorousParameters parameters_;
  double soc_at_start_;
  double step_;  // [s]
  Eigen::Index per_region_;
  Electrode negative_, positive_;
};

/// @return one sentence for every number outside its bounds; empty when all is well.
std::vector<std::string> faultsOf(const PorousParameters& parameters);

}  // namespace battery_sof_simulator
