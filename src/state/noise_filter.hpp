#pragma once

#include <cmath>

namespace battery_sof {

/**
 * @brief Kalman filter of white noise, AR(1) and random walk: its gains and variances, in any
 * arithmetic.
 *
 * The states are d (walk) and a (AR); see NoiseModel. At the start d is known to be zero and a has
 * its stationary variance.
 */
template <typename S>
class NoiseFilter {
 public:
  /// @param white, ar variances [V^2].  @param ar_time [s].  @param walk [V^2/s].
  NoiseFilter(S white, S ar, S ar_time, S walk)
      : white_(white), ar_(ar), ar_time_(ar_time), walk_(walk), p_dd_(0.0), p_da_(0.0), p_aa_(ar) {}

  /// What one sample needs.
  struct Step {
    S persistence;  ///< of a over the interval
    S drift;        ///< gain to d
    S colored;      ///< gain to a
    S variance;     ///< of the innovation [V^2]
  };

  /// Moves on and takes a sample in. @param count samples averaged.  @param first there is no
  /// interval before it.
  Step step(double duration, double count, bool first) {
    S persistence(1.0);
    if (!first) persistence = wait(duration);
    const S to_d = S(p_dd_ + p_da_), to_a = S(p_da_ + p_aa_);
    const S variance = S(to_d + to_a + white_ / count);
    const S drift = S(to_d / variance), colored = S(to_a / variance);
    p_dd_ = S(p_dd_ - drift * to_d);
    p_da_ = S(p_da_ - drift * to_a);
    p_aa_ = S(p_aa_ - colored * to_a);
    return {persistence, drift, colored, variance};
  }

  /// Moves on without a sample. @return persistence of a.
  S wait(double duration) {
    using std::exp;
    const S persistence = exp(S(-duration / ar_time_));
    p_dd_ = S(p_dd_ + walk_ * duration);
    p_da_ = S(p_da_ * persistence);
    p_aa_ = S(p_aa_ * persistence * persistence + ar_ * (1.0 - persistence * persistence));
    return persistence;
  }

  S variance() const { return S(p_dd_ + 2.0 * p_da_ + p_aa_); }  ///< of d + a [V^2]

  S p_dd() const { return p_dd_; }
  S p_da() const { return p_da_; }
  S p_aa() const { return p_aa_; }
  void setVariances(S p_dd, S p_da, S p_aa) {
    p_dd_ = p_dd;
    p_da_ = p_da;
    p_aa_ = p_aa;
  }

 private:
  S white_, ar_, ar_time_, walk_;
  S p_dd_, p_da_, p_aa_;
};

}  // namespace battery_sof
