#pragma once

#include <array>
#include <cmath>

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
  BesselFilter(double cutoff, double rate);

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
  std::array<Section, kOrder / 2> sections_;
  double delay_;
};

}  // namespace battery_sof_simulator
