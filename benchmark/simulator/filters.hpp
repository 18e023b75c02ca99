#pragma once

#include <array>
#include <cmath>
#include <complex>
#include <stdexcept>
#include <string>

#include "simulator/numerics.hpp"

namespace battery_sof_simulator {

/// tau dy/dt = x - y over steps of one length, exact for an x that is linear over a step.
struct LowPass {
  /// @param tau [s]; 0: y is x.  @param step [s], > 0.
  LowPass(double tau, double step)
      : decay(tau > 0.0 ? std::exp(-step / tau) : 0.0), delay(tau / step) {}
  /// @return y at a step's end. @param before y at its begin.  @param begin, end x there.
  double advance(double before, double begin, double end) const {
    const double lag = delay * (end - begin);
    return end - lag + (before - (begin - lag)) * decay;
  }
  double decay, delay;  ///< delay: tau / step
};

/// LowPass of a series that is linear between pushes; before the first it stood at that value.
struct Lag {
  LowPass law;
  double last = 0.0, output = 0.0;
  bool begun = false;

  double push(double input) {
    if (law.delay == 0.0) return input;
    if (!begun) last = output = input;
    begun = true;
    output = law.advance(output, last, input);
    last = input;
    return output;
  }
};

/// 8th-order Bessel low-pass, as in front of the paper's recordings (section V).
///     H(s) = theta_8(0) / theta_8(s w_3 / w_c)
///     theta_8: reverse Bessel polynomial,  w_3: its -3 dB frequency,  w_c: the cut-off
/// so that |H| is 1/sqrt 2 at the cut-off. Turned into four second-order sections by the bilinear
/// transform with the cut-off kept in place. Gain 1 at 0 Hz; the delay of slow signals is delay()
/// exactly and hardly changes up to the cut-off.
class BesselFilter {
 public:
  static constexpr int kOrder = 8;

  /// @param cutoff [Hz], above 0 and below rate / 2.  @param rate of the samples [Hz].
  /// @throws std::invalid_argument otherwise.
  BesselFilter(double cutoff, double rate) {
    if (!(cutoff > 0.0 && rate > 0.0 && cutoff < 0.5 * rate))
      throw std::invalid_argument("Bessel filter: cut-off is " + std::to_string(cutoff) +
                                  " Hz, expected above 0 and below half of " +
                                  std::to_string(rate) + " Hz");
    const double warped = 2.0 * rate * std::tan(kPi * cutoff / rate);
    for (std::size_t k = 0; k < kRoots.size(); ++k) {
      const std::complex<double> pole = kRoots[k] * warped / kHalfPower;
      const std::complex<double> z = (2.0 * rate + pole) / (2.0 * rate - pole);
      const double a1 = -2.0 * z.real(), a2 = std::norm(z);
      sections_[k] = {0.25 * (1.0 + a1 + a2), a1, a2};
    }
    delay_ = kHalfPower / warped;  // theta_n delays by 1 at s = 0
  }

  /// Forgets the past: the filter has seen `value` for ever.
  void settle(double value) {
    for (Section& s : sections_) s.in1 = s.in2 = s.out1 = s.out2 = value;
  }

  /// @return the next output for the next input.
  double push(double input) {
    for (Section& section : sections_) input = section.push(input);
    return input;
  }

  double delay() const { return delay_; }  ///< of a slow signal [s]

 private:
  struct Section {
    double gain, a1, a2;
    double in1 = 0.0, in2 = 0.0, out1 = 0.0, out2 = 0.0;
    double push(double input) {
      const double output = gain * (input + 2.0 * in1 + in2) - a1 * out1 - a2 * out2;
      in2 = in1;
      in1 = input;
      out2 = out1;
      return out1 = output;
    }
  };
  /// Roots of theta_8 above the real axis, and w_3, where |theta_8(j w)| is sqrt 2 theta_8(0).
  static constexpr double kHalfPower = 3.179617237510652;
  inline static const std::array<std::complex<double>, kOrder / 2> kRoots{
      {{-5.5878860432632926, 0.86761444535210752},
       {-2.8389839488976341, 6.3539112986048858},
       {-4.3682892172024701, 4.4144425004715657},
       {-5.2048407906367364, 2.616175152642795}}};
  std::array<Section, kOrder / 2> sections_;
  double delay_;
};

}  // namespace battery_sof_simulator
