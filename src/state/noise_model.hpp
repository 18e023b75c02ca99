#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <vector>

#include "model/input_sequence.hpp"

namespace battery_sof {

/**
 * @brief What a residual is made of when the model is right: white noise, noise with a memory, and
 * a walk.
 *
 *     e = d + a + w,   d: random walk,  a: AR(1) with time constant ar_time,  w: white          (docs/physics.md#noise-of-a-residual)
 */
struct NoiseModel {
  /// [V], of one sample; an average of m samples has white_std / sqrt(m)
  double white_std = 0.002;
  double ar_std = 0.002;   ///< [V], stationary
  double ar_time = 2.0;    ///< [s]
  double walk_std = 1e-4;  ///< [V/sqrt(s)]
};

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

/// @return the filter of a noise.
inline NoiseFilter<double> filterOf(const NoiseModel& noise) {
  return {noise.white_std * noise.white_std, noise.ar_std * noise.ar_std, noise.ar_time,
          noise.walk_std * noise.walk_std};
}

/**
 * @brief Turns residuals of that noise into independent ones of unit variance: the innovations of a
 * Kalman filter.
 *
 *     v_n = (e_n - d_n - a_n) / sqrt(S_n),   S_n the innovation's variance
 *
 * A sample with count 0 is not taken in and comes out as zero. Linear in e, so the columns of a
 * Jacobian are whitened by the same filter. Gains depend on the intervals alone and are computed
 * once; d starts at zero (u_dc holds the level).
 */
class Whitening {
 public:
  /// @param samples durations and counts are used.  @throws std::invalid_argument for a noise that
  /// is not finite, has white_std or ar_time at or below 0, or a negative part.
  Whitening(const NoiseModel& noise, const std::vector<InputSample>& samples);

  /// sum_n ln S_n, S_n in V^2, of the samples taken in: with the squares of v_n this is
  /// -2 ln likelihood up to a constant.
  double logDeterminant() const { return log_determinant_; }

  /// Filter memory of a set of columns.
  template <typename Row>
  struct Memory {
    Row drift, colored;
  };

  /// Whitens sample n of all columns in place; samples in order. @param memory zero before the
  /// first.
  template <typename Row>
  void apply(std::size_t n, Row& row, Memory<Row>& memory) const {
    const Gain& gain = gains_[n];
    memory.colored *= gain.persistence;
    row -= memory.drift + memory.colored;
    memory.drift += gain.drift * row;
    memory.colored += gain.colored * row;
    row *= gain.scale;
  }

  /// @return a whole column whitened.
  Eigen::VectorXd whitened(const Eigen::VectorXd& column) const;

 private:
  struct Gain {
    double persistence, drift, colored, scale;
  };
  std::vector<Gain> gains_;
  double log_determinant_ = 0.0;
};

/**
 * @brief The noise that makes a residual most likely, by Fisher scoring on the logarithms of its
 * four numbers.
 *
 * @param residual [V], one a sample.
 * @param min_white [V], what the channel's resolution adds at least (LSB / sqrt(12)).
 * @throws std::invalid_argument when the sizes differ or there are fewer than 30 samples.
 */
NoiseModel fitNoise(const Eigen::VectorXd& residual, const std::vector<InputSample>& samples,
                    double min_white = 1e-5);

/**
 * @brief fitNoise() of means over neighbouring samples.
 * @param time [s], not decreasing.  @param residual [V], one a time; none: not measured.
 * @param each samples of a mean, at least 1.  @param fewest means with a value, at least 30.
 * @return none of fewer.
 */
std::optional<NoiseModel> fitNoiseToMeans(const Eigen::Ref<const Eigen::VectorXd>& time,
                                          const std::vector<std::optional<double>>& residual,
                                          std::size_t each, std::size_t fewest);

/// -2 ln likelihood of a residual, without the constant n ln(2 pi).
double deviance(const NoiseModel& noise, const Eigen::VectorXd& residual,
                const std::vector<InputSample>& samples);

}  // namespace battery_sof
