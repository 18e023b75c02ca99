#pragma once

namespace battery_sof {

/**
 * @brief The exact step of the base model's state for alpha = 0.5, written once for one sample and for blocks of samples.
 *
 *     E  = exp(beta u_c2 / 2),   E+ = (i + sqrt(i^2 + 4 I_0^2)) / (2 I_0),   m = 1 / E+,   D = exp(-decay),   P = 1 - D
 *     E' = num / den,   num = E (E+ + m D) + P,   den = E P + E+ D + m
 *
 * with decay = beta sqrt(i^2 + 4 I_0^2) dt / (2 C_2). See OverpotentialStep for the differential equation.
 * @tparam T double, or an Eigen array of doubles (element by element).
 */
template <typename T>
struct ClosedFormStep {
  T e_plus;  ///< E+, > 0
  T m;       ///< 1 / E+
  T D;       ///< exp(-decay), in (0, 1]
  T P;       ///< 1 - D

  /// num of the header. @param E state before, > 0.
  T numerator(const T& E) const { return E * (e_plus + m * D) + P; }
  /// den of the header.
  T denominator(const T& E) const { return E * P + e_plus * D + m; }
  /// d ln E' / d ln E: how much of a state survives the step, in (0, 1].
  T survival(const T& E, const T& num, const T& den) const {
    return D * (e_plus + m) * (e_plus + m) * E / (num * den);
  }
  /// d ln E' / d D.
  T slopeToD(const T& E, const T& num, const T& den) const {
    return ((E * m - 1.0) * den - (e_plus - E) * num) / (num * den);
  }
};

}  // namespace battery_sof
