#include "simulator/cpe_ladder.hpp"

#include <cmath>
#include <stdexcept>

#include "simulator/fields.hpp"

namespace battery_sof_simulator {
namespace {

constexpr double kLowestRate = 1e-5;   // [rad/s]
constexpr double kHighestRate = 1e5;   // [rad/s]
constexpr int kBranchesPerDecade = 2;  // quadrature error exp(-pi^2 / 1.15), 4.2
constexpr int kDecades = 10;

}  // namespace

std::complex<double> analyticAdmittance(const Cpe& cpe, double omega) {
  return cpe.scale * std::pow(std::complex<double>(0.0, omega), cpe.exponent);
}

CpeLadder::CpeLadder(const Cpe& cpe, double step) : step_(step), capacitance_(cpe.scale) {
  if (!(cpe.scale >= 0.0) || !std::isfinite(cpe.scale))
    throw std::invalid_argument(faultOf("CPE: scale", cpe.scale, "0 or more"));
  if (!(cpe.exponent > 0.0 && cpe.exponent <= 1.0))
    throw std::invalid_argument(faultOf("CPE: exponent", cpe.exponent, "above 0 to 1"));
  const double p = cpe.exponent;
  if (cpe.scale > 0.0 && p < 1.0) {
    const double weight = cpe.scale * std::sin(p * kPi) / kPi;
    const int count = kBranchesPerDecade * kDecades;
    const double spacing = std::log(10.0) / kBranchesPerDecade;
    rate_.resize(count + 1);
    conductance_.resize(count + 1);
    for (int k = 0; k < count; ++k) {
      rate_[k] = kLowestRate * std::exp((k + 0.5) * spacing);
      conductance_[k] = weight * std::pow(rate_[k], p) * spacing;
    }
    rate_[count] = kLowestRate * p / (p + 1.0);
    conductance_[count] = weight * std::pow(kLowestRate, p) / p;
    capacitance_ = weight * std::pow(kHighestRate, p - 1.0) / (1.0 - p);
  }
  share_ = rate_ * step / (1.0 + rate_ * step);
  step_conductance_ = conductance_ / (1.0 + rate_ * step);
  total_ = capacitance_ / step + step_conductance_.sum();
}

std::complex<double> CpeLadder::admittance(double omega) const {
  const std::complex<double> s(0.0, omega);
  std::complex<double> sum = capacitance_ * s;
  for (Eigen::Index k = 0; k < rate_.size(); ++k) sum += conductance_[k] * s / (s + rate_[k]);
  return sum;
}

}  // namespace battery_sof_simulator
