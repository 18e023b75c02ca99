#pragma once

#include <cmath>

#include "model/base_model.hpp"
#include "model/closed_form_step.hpp"

/// The base circuit's equations one by one, and its step as a test calls it.
namespace battery_sof::test {

/// Charge-transfer current [A] (paper, eq. 1).
inline double chargeTransferCurrent(const BaseParameters& p, double u) {
  return p.i0 * (std::exp(p.alpha * p.beta * u) - std::exp((p.alpha - 1.0) * p.beta * u));
}

/// Terminal voltage [V] (paper, Fig. 3).
inline double terminalVoltage(const BaseParameters& p, double current, double u_c2) {
  return p.u_dc + ohmicResistance(p, current) * current + u_c2;
}

/// Where u_c2 settles under a held current [V], for a symmetric reaction.
inline double settledOverpotential(const BaseParameters& p, double current) {
  return 2.0 / p.beta * std::asinh(0.5 * current / p.i0);
}

/// closedFormSlopes() in volts, the derivatives carried along.
class BaseStep {
 public:
  explicit BaseStep(const BaseParameters& parameters) : p_(parameters) {}

  double advance(double u_c2, double current, double dt) const {
    return advance(Overpotential{u_c2, 1.0, 0.0, 0.0}, current, dt).value;
  }
  Overpotential advance(const Overpotential& before, double current, double dt) const {
    const double w = p_.beta * before.value, half_rate = 0.5 * p_.beta * dt / p_.c2;
    const ClosedFormSlopes after = closedFormSlopes(w, current, p_.i0, half_rate);
    const double moved = after.to_half_rate * half_rate;
    return {after.w / p_.beta, after.to_w * before.d_initial,
            after.to_w * before.d_c2 - moved / (p_.c2 * p_.beta),
            after.to_w * before.d_beta + (after.to_w * w + moved - after.w) / (p_.beta * p_.beta)};
  }

 private:
  BaseParameters p_;
};

}  // namespace battery_sof::test
