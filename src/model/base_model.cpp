#include "model/base_model.hpp"

#include "util/text.hpp"

namespace battery_sof {
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
  const auto require_positive = [](const char* name, double value) {
    requireThat(value > 0.0, name, value, "a finite value above 0");
  };
  require_positive("r_discharge [Ohm]", p.r_discharge);
  require_positive("r_charge [Ohm]", p.r_charge);
  require_positive("c2 [F]", p.c2);
  require_positive("beta [1/V]", p.beta);
  require_positive("i0 [A]", p.i0);
  requireThat(p.alpha > 0.0 && p.alpha < 1.0, "alpha", p.alpha, "in (0, 1)");
  requireThat(true, "u_dc [V]", p.u_dc, "a finite value");
}

double ohmicResistance(const BaseParameters& p, double current) {
  return current < 0.0 ? p.r_discharge : p.r_charge;
}

}  // namespace battery_sof
