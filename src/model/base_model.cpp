#include "model/base_model.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "model/closed_form_step.hpp"
#include "util/number_text.hpp"

namespace battery_sof {
namespace {

// |beta u / 2| beyond which the branch empties the capacitor faster than any sampling can see (see
// header).
constexpr double kClosedFormLimit = 300.0;
// The same for the implicit step, as the larger of the two exponents: below 1e-8 s for all of Table
// I.
constexpr double kImplicitLimit = 30.0;
// [V] per step; far below the required 1 mV
constexpr double kImplicitTolerance = 1e-6;
constexpr double kNewtonTolerance = 1e-13;  // [V]

void requirePositive(double value, const char* name) {
  if (std::isfinite(value) && value > 0.0) return;
  ClassicStream message;
  message << name << " is " << value << ", expected a finite value above 0";
  throw std::invalid_argument(message.str());
}

/// Slope of the charge-transfer current, d i_r2 / d u [A/V].
double chargeTransferConductance(const BaseParameters& p, double u) {
  return p.i0 * p.beta *
         (p.alpha * std::exp(p.alpha * p.beta * u) +
          (1.0 - p.alpha) * std::exp((p.alpha - 1.0) * p.beta * u));
}

/// du/dt of the state equation [V/s].
double stateRate(const BaseParameters& p, double u, double current) {
  return (current - chargeTransferCurrent(p, u)) / p.c2;
}

/// Solves u = start + weight * du/dt(u); the root lies between start and the settled state, rate
/// falls with u.
double solveStage(const BaseParameters& p, double start, double weight, double current,
                  double settled) {
  double low = std::min(start, settled);
  double high = std::max(start, settled);
  double u = start;
  for (int k = 0; k < 100 && high - low > kNewtonTolerance; ++k) {
    const double residual = u - start - weight * stateRate(p, u, current);
    (residual > 0.0 ? high : low) = u;
    const double step = residual / (1.0 + weight * chargeTransferConductance(p, u) / p.c2);
    if (std::abs(step) < kNewtonTolerance) break;
    u -= step;
    if (!(u > low && u < high)) u = 0.5 * (low + high);
  }
  return u;
}

/// One step of Alexander's L-stable SDIRK of order 2 with its exact derivative.
Overpotential sdirkStep(const BaseParameters& p, const Overpotential& before, double current,
                        double settled, double dt) {
  const double gamma = 1.0 - std::sqrt(0.5);
  const double w = gamma * dt;
  const double ratio = (1.0 - gamma) / gamma;
  const double u1 = solveStage(p, before.value, w, current, settled);
  const double start2 = before.value + ratio * (u1 - before.value);
  const double u2 = solveStage(p, start2, w, current, settled);

  const double g1 = chargeTransferConductance(p, u1) / p.c2;
  const double g2 = chargeTransferConductance(p, u2) / p.c2;
  // Explicit partial derivatives of du/dt at a stage: to C_2 and to beta.
  const auto rate_c2 = [&](double u) { return -stateRate(p, u, current) / p.c2; };
  const auto derivative = [&](double s, double rate1, double rate2) {
    const double s1 = (s + w * rate1) / (1.0 + w * g1);
    return (s + ratio * (s1 - s) + w * rate2) / (1.0 + w * g2);
  };
  Overpotential after;
  after.value = u2;
  after.d_initial = derivative(before.d_initial, 0.0, 0.0);
  after.d_c2 = derivative(before.d_c2, rate_c2(u1), rate_c2(u2));
  after.d_beta = derivative(before.d_beta, -u1 * g1 / p.beta, -u2 * g2 / p.beta);
  return after;
}

Overpotential clamped(const Overpotential& state, double limit) {
  if (std::abs(state.value) <= limit) return state;
  return {std::copysign(limit, state.value), 0.0, 0.0, 0.0};
}

}  // namespace

const std::array<ParameterInfo, 4>& tableOne() {
  static const std::array<ParameterInfo, 4> table = {{
      {"r_discharge", "r_-", "ohm", 0.008, 0.001, 0.1, "paper, Table I"},
      {"r_charge", "r_+", "ohm", 0.010, 0.001, 0.1, "paper, Table I"},
      {"c2", "C_2", "F", 1000.0, 100.0, 5000.0, "paper, Table I"},
      {"beta", "beta", "1/V", 20.0, 1.0, 1000.0, "paper, Table I"},
  }};
  return table;
}

void requireValid(const BaseParameters& p) {
  requirePositive(p.r_discharge, "r_discharge [Ohm]");
  requirePositive(p.r_charge, "r_charge [Ohm]");
  requirePositive(p.c2, "c2 [F]");
  requirePositive(p.beta, "beta [1/V]");
  requirePositive(p.i0, "i0 [A]");
  requirePositive(p.alpha, "alpha");
  if (p.alpha >= 1.0)
    throw std::invalid_argument("alpha is " + std::to_string(p.alpha) + ", expected in (0, 1)");
  if (!std::isfinite(p.u_dc)) throw std::invalid_argument("u_dc [V] is not finite");
}

double ohmicResistance(const BaseParameters& p, double current) {
  return current < 0.0 ? p.r_discharge : p.r_charge;
}

double chargeTransferCurrent(const BaseParameters& p, double u) {
  return p.i0 * (std::exp(p.alpha * p.beta * u) - std::exp((p.alpha - 1.0) * p.beta * u));
}

double terminalVoltage(const BaseParameters& p, double current, double u_c2) {
  return p.u_dc + ohmicResistance(p, current) * current + u_c2;
}

double settledOverpotential(const BaseParameters& p, double current) {
  if (p.alpha == 0.5) return 2.0 / p.beta * std::asinh(0.5 * current / p.i0);
  // exp(a y) - exp((a - 1) y) grows at least as sinh with the smaller exponent: that bounds the
  // root.
  const double smaller = std::min(p.alpha, 1.0 - p.alpha);
  const double bound = std::asinh(0.5 * std::abs(current) / p.i0) / (smaller * p.beta);
  double low = current < 0.0 ? -bound : 0.0;
  double high = current < 0.0 ? 0.0 : bound;
  double u = 0.5 * (low + high);
  for (int k = 0; k < 200; ++k) {
    const double residual = chargeTransferCurrent(p, u) - current;
    (residual > 0.0 ? high : low) = u;
    const double step = residual / chargeTransferConductance(p, u);
    if (std::abs(step) < kNewtonTolerance) break;
    u -= step;
    if (!(u > low && u < high)) u = 0.5 * (low + high);
  }
  return u;
}

OverpotentialStep::OverpotentialStep(const BaseParameters& parameters) : parameters_(parameters) {
  requireValid(parameters);
}

double OverpotentialStep::advance(double u_c2, double current, double dt) const {
  return advance(Overpotential{u_c2, 1.0, 0.0, 0.0}, current, dt).value;
}

Overpotential OverpotentialStep::advance(const Overpotential& before, double current,
                                         double dt) const {
  if (!(dt >= 0.0) || !std::isfinite(current) || !std::isfinite(before.value)) {
    ClassicStream message;
    message << "step of u_c2 = " << before.value << " V under " << current << " A over " << dt
            << " s: all must be finite and the interval not negative";
    throw std::invalid_argument(message.str());
  }
  return parameters_.alpha == 0.5 ? advanceClosedForm(before, current, dt)
                                  : advanceImplicit(before, current, dt);
}

Overpotential OverpotentialStep::advanceClosedForm(const Overpotential& before, double current,
                                                   double dt) const {
  // Symbols as in ClosedFormStep; ln E = beta u / 2.
  const auto& p = parameters_;
  const Overpotential s = clamped(before, 2.0 * kClosedFormLimit / p.beta);
  const CurrentShares shares = sharesOf(current, p.i0);
  const double decay = p.beta * shares.R * dt / (2.0 * p.c2);
  const ClosedFormStep<double> step{shares.charging, shares.discharging, shares.mixed,
                                    std::exp(-decay), -std::expm1(-decay)};
  const double E = std::exp(0.5 * p.beta * s.value);
  const double x = step.nextX(E, 1.0);
  const double y = step.nextY(E, 1.0);
  const double survival = step.D * (E / x) / y;                       // d ln E' / d ln E
  const double to_decay = -step.D * (step.slopeToD(E, 1.0) / x) / y;  // d ln E' / d decay
  Overpotential after;
  after.value = 2.0 / p.beta * std::log(x / y);
  after.d_initial = survival * s.d_initial;
  after.d_c2 = survival * s.d_c2 - 2.0 / p.beta * to_decay * decay / p.c2;
  after.d_beta = survival * s.d_beta +
                 (survival * s.value - after.value + 2.0 / p.beta * to_decay * decay) / p.beta;
  return after;
}

Overpotential OverpotentialStep::advanceImplicit(const Overpotential& before, double current,
                                                 double dt) const {
  const auto& p = parameters_;
  const double limit = kImplicitLimit / (std::max(p.alpha, 1.0 - p.alpha) * p.beta);
  const double settled = settledOverpotential(p, current);
  Overpotential state = clamped(before, limit);
  double left = dt;
  double h = dt;
  while (left > 0.0) {
    h = std::min(h, left);
    const double whole = sdirkStep(p, state, current, settled, h).value;
    const Overpotential half = sdirkStep(p, state, current, settled, 0.5 * h);
    const Overpotential next = sdirkStep(p, half, current, settled, 0.5 * h);
    const double error = std::abs(next.value - whole) / 3.0;  // order 2: 1 / (2^2 - 1)
    // Below 1e-12 s no step changes any sampled voltage; it ends the search in pathological
    // cases.
    if (error <= kImplicitTolerance || h < 1e-12) {
      state = next;
      left -= h;
    }
    const double scale = 0.9 * std::cbrt(kImplicitTolerance / std::max(error, 1e-16));
    h *= std::clamp(scale, 0.1, 5.0);
  }
  return state;
}

}  // namespace battery_sof
