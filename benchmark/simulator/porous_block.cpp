#include "simulator/porous_block.hpp"

#include <cmath>

#include "simulator/fields.hpp"

namespace battery_sof_simulator {
namespace {

using Field = PorousState::Field;
using Eigen::Index;

constexpr double kFaraday = 96485.33212;                         // [As/mol]
constexpr double kThermal = 8.314462618 * 298.15 / kFaraday;     // RT/F [V]
constexpr double kCationShare = 0.72;                            // t+ (Sulzer 2019)
constexpr double kNegativeExpansion = 0.5 * (4.8e-5 - 1.83e-5);  // (PbSO4 - Pb) / 2 [m3/mol]
constexpr double kPositiveExpansion = 0.5 * (4.8e-5 - 2.5e-5);   // (PbSO4 - PbO2) / 2 [m3/mol]
constexpr double kWaterVolume = 17.5e-6, kAcidVolume = 45e-6;    // partial molar [m3/mol]
constexpr double kWaterMass = 18.01e-3;                          // [kg/mol]
constexpr double kLongestNewtonStep = 0.05;                      // [V], two RT/F
constexpr double kPotentialTolerance = 1e-10;                    // [V]
constexpr int kMaxIterations = 100;

/// Decadic logarithm of the acid's molality [mol/kg].
Field logMolality(const Field& acid) {
  return (acid * kWaterVolume / ((1.0 - acid * kAcidVolume) * kWaterMass)).log() / std::log(10.0);
}

/// Bode's equilibrium potentials against hydrogen [V] (Sulzer 2019).
Field negativeEquilibrium(const Field& acid) {
  const Field m = logMolality(acid);
  return -0.294 - m * (0.074 + m * (0.030 + m * (0.031 + m * 0.012)));
}
Field positiveEquilibrium(const Field& acid) {
  const Field m = logMolality(acid);
  return 1.628 + m * (0.074 + m * (0.033 + m * (0.043 + m * 0.022)));
}

/// kappa [S/m], D [m2/s], and chi (RT/F) [V] of the acid (Sulzer 2019, Chapman 1968).
Field conductivity(const Field& acid) {
  return 1e-4 * acid * (6.23 - acid * (1.34e-4 + acid * 1.61e-8)).exp();
}
Field diffusivity(const Field& acid) { return 1e-9 * (1.75 + 260e-6 * acid); }
Field thermodynamicVoltage(const Field& acid) {
  return 2.0 * (1.0 - kCationShare) * kThermal * (0.49 + 4.1e-4 * acid);
}

/// Solution of a tridiagonal system with equal off-diagonals -link(k) between k and k + 1.
Field solveTridiagonal(const Field& link, Field diagonal, Field right) {
  const Index n = diagonal.size();
  for (Index k = 1; k < n; ++k) {
    const double factor = link[k - 1] / diagonal[k - 1];
    diagonal[k] -= factor * link[k - 1];
    right[k] += factor * right[k - 1];
  }
  right[n - 1] /= diagonal[n - 1];
  for (Index k = n - 2; k >= 0; --k) right[k] = (right[k] + link[k] * right[k + 1]) / diagonal[k];
  return right;
}

/// Of the pores alone, when full [m].
double porousThickness(const PorousParameters& p) {
  return p.negative.porosity * p.negative.thickness_m + p.separator_porosity * p.separator_m +
         p.positive.porosity * p.positive.thickness_m;
}

const PorousParameters& valid(const PorousParameters& parameters, double soc, double step) {
  auto faults = faultsOf(parameters);
  if (!(soc >= 0.3 && soc <= 1.0)) faults.push_back(faultOf("soc", soc, "0.3 to 1"));
  if (!(step > 0.0 && step <= 1.0)) faults.push_back(faultOf("step", step, "above 0 to 1"));
  requireNone(faults, "porous block");
  return parameters;
}

}  // namespace

std::vector<std::string> faultsOf(const PorousParameters& p) {
  auto faults = fieldFaults(p);
  if (!faults.empty()) return faults;
  const double needed = p.capacity_ah * kSecondsPerHour / kFaraday;
  if (porousThickness(p) * p.area_m2 * p.full_acid_mol_per_m3 < needed)
    faults.push_back("the pores hold less acid than capacity_ah needs");
  return faults;
}

PorousBlock::PorousBlock(const PorousParameters& parameters, double soc, double step)
    : parameters_(valid(parameters, soc, step)),
      soc_at_start_(soc),
      step_(step),
      per_region_(parameters.cells_per_region),
      negative_{parameters.negative, 0, 0.5, -kNegativeExpansion, false},
      positive_{parameters.positive, 2 * per_region_, 1.5, kPositiveExpansion, true} {}

double PorousBlock::width(Index cell) const {
  const PorousParameters& p = parameters_;
  const double thickness = cell < per_region_       ? p.negative.thickness_m
                           : cell < 2 * per_region_ ? p.separator_m
                                                    : p.positive.thickness_m;
  return thickness / static_cast<double>(per_region_);
}

PorousState PorousBlock::rested() const {
  const PorousParameters& p = parameters_;
  const double used = (1.0 - soc_at_start_) * p.capacity_ah * kSecondsPerHour / kFaraday;
  const auto porosity_after = [&](const PorousElectrode& electrode, double expansion) {
    return Field::Constant(
        per_region_, electrode.porosity - expansion * used / (p.area_m2 * electrode.thickness_m));
  };
  PorousState state;
  state.porosity.resize(3 * per_region_);
  state.porosity << porosity_after(p.negative, kNegativeExpansion),
      Field::Constant(per_region_, p.separator_porosity),
      porosity_after(p.positive, kPositiveExpansion);
  const double full = p.full_acid_mol_per_m3 * p.area_m2 * porousThickness(p);
  state.acid = Field::Ones(3 * per_region_);
  state.acid *= (full - used) / acid(state);
  state.negative = negativeEquilibrium(state.acid.head(per_region_));
  state.positive = positiveEquilibrium(state.acid.tail(per_region_));
  state.lead_ion = Field::Ones(per_region_);
  state.cell_voltage = state.positive[0] - state.negative[0];
  return state;
}

PorousState PorousBlock::advance(const PorousState& before, double current_end) const {
  const PorousParameters& p = parameters_;
  const Paths links = paths(before);
  PorousState next = before;
  next.current = current_end;
  const Reaction n = solvePotentials(negative_, setting(negative_, before, links, current_end),
                                     before, next.negative);
  const Reaction q = solvePotentials(positive_, setting(positive_, before, links, current_end),
                                     before, next.positive);
  const double n_area = p.area_m2 * width(0), p_area = p.area_m2 * width(positive_.first);
  next.oxygen_current = p_area * q.side.sum();
  next.gas_current = -n_area * n.side.sum();
  next.gas_charge += step_ * next.gas_current;
  next.main_charge -= step_ * n_area * n.main.sum();
  next.cell_voltage = cellVoltage(next, links);
  moveAcid(before, n, q, next);
  if (p.lead_ion) {
    const double share = step_ / p.lead_ion_time_s;
    const double limit = p.lead_ion_limit_a / (p.area_m2 * p.negative.thickness_m);
    // a j = A - B p with the potentials known, so that p at the step's end follows from a j.
    next.lead_ion = (before.lead_ion + share * (1.0 + n.main / limit)) / (1.0 + share);
  }
  return next;
}

double PorousBlock::acid(const PorousState& state) const {
  double sum = 0.0;
  for (Index k = 0; k < state.acid.size(); ++k) sum += width(k) * state.porosity[k] * state.acid[k];
  return parameters_.area_m2 * sum;
}

/// Conductance between the middles of neighbouring cells.
PorousState::Field PorousBlock::between(const Field& conductivity) const {
  Field conductance(conductivity.size() - 1);
  for (Index k = 0; k + 1 < conductivity.size(); ++k)
    conductance[k] = 2.0 / (width(k) / conductivity[k] + width(k + 1) / conductivity[k + 1]);
  return conductance;
}

PorousBlock::Paths PorousBlock::paths(const PorousState& state) const {
  const Field kappa = conductivity(state.acid) * state.porosity * state.porosity.sqrt();
  const Field logarithm = state.acid.log(), voltage = thermodynamicVoltage(state.acid);
  const Index faces = state.acid.size() - 1;
  Paths paths;
  paths.conductance = between(kappa);
  paths.driven = paths.conductance * 0.5 * (voltage.head(faces) + voltage.tail(faces)) *
                 (logarithm.tail(faces) - logarithm.head(faces));
  return paths;
}

PorousBlock::Setting PorousBlock::setting(const Electrode& e, const PorousState& before,
                                          const Paths& paths, double current_end) const {
  const Field acid = before.acid.segment(e.first, per_region_);
  const Field relative = acid / parameters_.full_acid_mol_per_m3;
  Setting s;
  s.equilibrium = e.positive ? positiveEquilibrium(acid) : negativeEquilibrium(acid);
  s.exchange = e.surface_per_m * e.exchange_a_per_m2 * relative;
  if (e.positive) s.exchange *= relative;
  s.conductance = paths.conductance.segment(e.first, per_region_ - 1);
  s.driven = paths.driven.segment(e.first, per_region_ - 1);
  const double separator_current = -current_end / parameters_.area_m2;
  s.inflow = e.positive ? separator_current : -separator_current;
  s.recombination =
      e.positive ? 0.0 : -before.oxygen_current / (parameters_.area_m2 * e.thickness_m);
  return s;
}

PorousBlock::Reaction PorousBlock::reaction(const Electrode& e, const Setting& s,
                                            const Field& potential,
                                            const PorousState& before) const {
  const PorousParameters& p = parameters_;
  const Field up = s.exchange * ((potential - s.equilibrium) / kThermal).exp();
  const Field down = s.exchange.square() / up;
  Reaction r;
  if (!e.positive && p.lead_ion) {
    const double share = step_ / p.lead_ion_time_s;
    const double limit = p.lead_ion_limit_a / (p.area_m2 * p.negative.thickness_m);
    const Field rest = 1.0 + share * (1.0 + down / limit);
    const Field ion = (before.lead_ion + share * (1.0 + up / limit)) / rest;
    r.main = up - ion * down;
    const Field ion_slope = share / limit * (up + ion * down) / rest / kThermal;
    r.slope = (up + ion * down) / kThermal - ion_slope * down;
  } else {
    r.main = up - down;
    r.slope = (up + down) / kThermal;
  }
  r.side = Field::Constant(per_region_, s.recombination);
  if (!p.gassing) return r;
  const double direction = e.positive ? 1.0 : -1.0;
  const double potential_there = e.positive ? p.oxygen_potential_v : p.hydrogen_potential_v;
  const Field gas = p.gas_current_a / (p.area_m2 * e.thickness_m) *
                    (direction * p.gas_slope_per_v * (potential - potential_there)).exp();
  r.side += direction * gas;
  r.slope += p.gas_slope_per_v * gas;
  return r;
}

PorousBlock::Reaction PorousBlock::solvePotentials(const Electrode& e, const Setting& s,
                                                   const PorousState& before,
                                                   Field& potential) const {
  const Index n = per_region_;
  const double dx = width(e.first), layer = e.surface_per_m * e.layer_f_per_m2 / step_;
  const Field old = potential;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    Reaction r = reaction(e, s, potential, before);
    Field excess = -dx * (r.main + r.side + layer * (potential - old));
    Field diagonal = dx * (r.slope + layer);
    const Field flow = s.conductance * (potential.tail(n - 1) - potential.head(n - 1)) + s.driven;
    excess.head(n - 1) += flow;
    excess.tail(n - 1) -= flow;
    diagonal.head(n - 1) += s.conductance;
    diagonal.tail(n - 1) += s.conductance;
    // At the interface the current leaves the negative's acid and enters the positive's.
    excess[e.positive ? 0 : n - 1] -= s.inflow;
    const Field change = solveTridiagonal(s.conductance, diagonal, excess)
                             .max(-kLongestNewtonStep)
                             .min(kLongestNewtonStep);
    potential += change;
    if (change.abs().maxCoeff() < kPotentialTolerance) return r;
  }
  throw NoSolution("the porous electrodes' potentials have no solution");
}

double PorousBlock::cellVoltage(const PorousState& state, const Paths& paths) const {
  const Index first = per_region_ - 1, count = per_region_ + 1;
  const double separator_current = -state.current / parameters_.area_m2;
  const double across = ((paths.driven.segment(first, count) - separator_current) /
                         paths.conductance.segment(first, count))
                            .sum();
  return state.positive[0] - state.negative[per_region_ - 1] + across;
}

void PorousBlock::moveAcid(const PorousState& before, const Reaction& negative,
                           const Reaction& positive, PorousState& next) const {
  const Index n = per_region_;
  Field gained = Field::Zero(3 * n);
  const auto add = [&](const Electrode& e, const Reaction& r, const Field& change) {
    const Field layer = e.surface_per_m * e.layer_f_per_m2 / step_ * change;
    gained.segment(e.first, n) =
        (e.per_electron * r.main + r.side - kCationShare * (r.main + r.side + layer)) / kFaraday;
    next.porosity.segment(e.first, n) += step_ * e.expansion * r.main / kFaraday;
  };
  add(negative_, negative, next.negative - before.negative);
  add(positive_, positive, next.positive - before.positive);
  const Field link = between(parameters_.diffusion_factor * diffusivity(before.acid) *
                             before.porosity * before.porosity.sqrt());
  Field held(3 * n), diagonal(3 * n);
  for (Index k = 0; k < 3 * n; ++k) {
    diagonal[k] = width(k) / step_ * next.porosity[k];
    held[k] = width(k) * (before.porosity[k] * before.acid[k] / step_ + gained[k]);
  }
  diagonal.head(3 * n - 1) += link;
  diagonal.tail(3 * n - 1) += link;
  next.acid = solveTridiagonal(link, diagonal, held);
}

}  // namespace battery_sof_simulator
