#include "simulator/bessel_filter.hpp"

#include <cmath>
#include <complex>
#include <stdexcept>
#include <string>

#include "simulator/pi.hpp"

namespace battery_sof_reference {
namespace {

using Complex = std::complex<double>;
constexpr int kOrder = BesselFilter::kOrder;
constexpr int kRootIterations = 200;  // the roots stand after about 30

using Polynomial = std::array<double, kOrder + 1>;

/// Coefficients of theta_n, rising powers, by theta_n = (2n - 1) theta_(n-1) + s^2 theta_(n-2).
Polynomial reverseBessel() {
  Polynomial older{1.0}, newer{1.0, 1.0};
  for (int n = 2; n <= kOrder; ++n) {
    Polynomial next{};
    for (int k = 0; k <= n; ++k) next[k] = (2 * n - 1) * newer[k] + (k >= 2 ? older[k - 2] : 0.0);
    older = newer;
    newer = next;
  }
  return newer;
}

Complex valueOf(const Polynomial& polynomial, Complex s) {
  Complex value = 0.0;
  for (int k = kOrder; k >= 0; --k) value = value * s + polynomial[k];
  return value;
}

/// All roots at once, by the Durand-Kerner iteration; the leading coefficient is 1.
std::array<Complex, kOrder> rootsOf(const Polynomial& polynomial) {
  std::array<Complex, kOrder> roots;
  for (int k = 0; k < kOrder; ++k) roots[k] = std::polar(6.0, 2.0 * kPi * (k + 0.3) / kOrder);
  for (int iteration = 0; iteration < kRootIterations; ++iteration)
    for (int k = 0; k < kOrder; ++k) {
      Complex others = 1.0;
      for (int m = 0; m < kOrder; ++m)
        if (m != k) others *= roots[k] - roots[m];
      roots[k] -= valueOf(polynomial, roots[k]) / others;
    }
  return roots;
}

double halfPowerFrequency(const Polynomial& polynomial) {
  double low = 0.0, high = 10.0;
  for (int k = 0; k < 100; ++k) {
    const double middle = 0.5 * (low + high);
    const double fall = std::abs(valueOf(polynomial, Complex(0.0, middle))) / polynomial[0];
    (fall < std::sqrt(2.0) ? low : high) = middle;
  }
  return low;
}

void requireValid(double cutoff, double rate) {
  if (cutoff > 0.0 && rate > 0.0 && cutoff < 0.5 * rate) return;
  throw std::invalid_argument("Bessel filter: cut-off is " + std::to_string(cutoff) +
                              " Hz, expected above 0 and below half of " + std::to_string(rate) +
                              " Hz");
}

}  // namespace

BesselFilter::BesselFilter(double cutoff, double rate) {
  requireValid(cutoff, rate);
  const Polynomial polynomial = reverseBessel();
  const double half_power = halfPowerFrequency(polynomial);
  const double warped = 2.0 * rate * std::tan(kPi * cutoff / rate);
  std::size_t section = 0;
  for (const Complex& root : rootsOf(polynomial)) {
    if (root.imag() < 0.0) continue;
    const Complex pole = root * warped / half_power;
    const Complex z = (2.0 * rate + pole) / (2.0 * rate - pole);
    const double a1 = -2.0 * z.real(), a2 = std::norm(z);
    sections_.at(section++) = {0.25 * (1.0 + a1 + a2), a1, a2};
  }
  delay_ = half_power / warped;  // theta_n delays by 1 at s = 0
}

void BesselFilter::settle(double value) {
  for (Section& s : sections_) s.in1 = s.in2 = s.out1 = s.out2 = value;
}

double BesselFilter::push(double input) {
  for (Section& section : sections_) input = section.push(input);
  return input;
}

double BesselFilter::Section::push(double input) {
  const double output = gain * (input + 2.0 * in1 + in2) - a1 * out1 - a2 * out2;
  in2 = in1;
  in1 = input;
  out2 = out1;
  out1 = output;
  return output;
}

}  // namespace battery_sof_reference
