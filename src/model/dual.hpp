#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "model/instruction_sets.hpp"

namespace battery_sof {

/**
 * @brief A number with its derivatives along the tangents of a simulation.
 *
 *     d f(a, b) / d tangent = df/da (d a / d tangent) + df/db (d b / d tangent)
 *
 * It carries derivatives up to the last tangent that reaches it, rounded up to a multiple of four;
 * those behind are zero and cost nothing. A constant carries none.
 */
class Dual {
 public:
  static constexpr int kMaxTangents = 48;

  Dual(double value = 0.0) : value_(value) {}  // NOLINT(google-explicit-constructor)
  /// @param derivatives at most kMaxTangents.
  Dual(double value, const Eigen::RowVectorXd& derivatives);
  Dual(const Dual& other) : value_(other.value_) { carry(other, Same()); }
  Dual& operator=(const Dual& other) {
    value_ = other.value_;
    carry(other, Same());
    return *this;
  }
  ~Dual() = default;
  /// The unknown of an equation: the first tangent is its own.
  static Dual unknown(double value) {
    Dual x(value);
    x.fill(0, kAtOnce, [](int k) { return k == 0 ? Pair{1.0, 0.0} : Pair{}; });
    return x;
  }
  /// f(x) where value and slope of f at x are known.
  static Dual mapped(const Dual& x, double value, double slope) {
    return {value, x, [slope](Pair dx) { return dx * slope; }};
  }

  double value() const { return value_; }
  double& value() { return value_; }
  double derivative(int tangent) const { return tangent < carried_ ? derivatives_[tangent] : 0.0; }
  /// To the unknown.
  double slope() const { return derivative(0); }
  /// Whether no tangent reaches it.
  bool isConstant() const {
    return std::all_of(derivatives_, derivatives_ + carried_, [](double x) { return x == 0.0; });
  }
  /// Calls change(derivative) for all that are carried.
  template <typename Change>
  void changeDerivatives(const Change& change) {
    std::for_each(derivatives_, derivatives_ + carried_, change);
  }

  BATTERY_SOF_INLINE friend Dual operator+(const Dual& a, const Dual& b) {
    return {a.value_ + b.value_, a, b, [](Pair da, Pair db) { return da + db; }};
  }
  BATTERY_SOF_INLINE friend Dual operator-(const Dual& a, const Dual& b) {
    return {a.value_ - b.value_, a, b, [](Pair da, Pair db) { return da - db; }};
  }
  BATTERY_SOF_INLINE friend Dual operator*(const Dual& a, const Dual& b) {
    return {a.value_ * b.value_, a, b,
            [p = a.value_, q = b.value_](Pair da, Pair db) { return da * q + db * p; }};
  }
  BATTERY_SOF_INLINE friend Dual operator/(const Dual& a, const Dual& b) {
    const double p = a.value_, q = b.value_, inverse_square = 1.0 / (q * q);
    return {p / q, a, b, [p, q, inverse_square](Pair da, Pair db) {
              return (da * q - db * p) * inverse_square;
            }};
  }

 private:
  using Pair = Register<2>::Type;
  static constexpr int kAtOnce = 4;

  struct Same {
    Pair operator()(Pair x) const { return x; }
  };

  template <typename Rule>
  BATTERY_SOF_INLINE Dual(double value, const Dual& a, const Rule& rule) : value_(value) {
    carry(a, rule);
  }
  template <typename Rule>
  BATTERY_SOF_INLINE Dual(double value, const Dual& a, const Dual& b, const Rule& rule)
      : value_(value) {
    const Pair none = {};
    const int both = std::min(a.carried_, b.carried_);
    fill(0, both, [&](int k) { return rule(a.pair(k), b.pair(k)); });
    if (a.carried_ >= b.carried_)
      fill(both, a.carried_, [&](int k) { return rule(a.pair(k), none); });
    else
      fill(both, b.carried_, [&](int k) { return rule(none, b.pair(k)); });
  }

  template <typename Rule>
  BATTERY_SOF_INLINE void carry(const Dual& a, const Rule& rule) {
    fill(0, a.carried_, [&](int k) { return rule(a.pair(k)); });
  }
  template <typename PairAt>
  BATTERY_SOF_INLINE void fill(int first, int last, const PairAt& pairAt) {
    // Both are read before one is written: as a plain copy GCC would call memcpy for a few numbers.
    for (int k = first; k < last; k += kAtOnce) {
      const Pair lower = pairAt(k), upper = pairAt(k + 2);
      at<2>(derivatives_ + k) = lower;
      at<2>(derivatives_ + k + 2) = upper;
    }
    carried_ = last;
  }
  Pair pair(int k) const { return at<2>(derivatives_ + k); }

  double value_;
  int carried_ = 0;
  alignas(16) double derivatives_[kMaxTangents];
};

inline Dual::Dual(double value, const Eigen::RowVectorXd& derivatives) : value_(value) {
  for (Eigen::Index k = 0; k < derivatives.size(); ++k) {
    if (derivatives[k] == 0.0) continue;
    for (const int last = (static_cast<int>(k) / kAtOnce + 1) * kAtOnce; carried_ < last;)
      derivatives_[carried_++] = 0.0;
    derivatives_[k] = derivatives[k];
  }
}

inline Dual operator-(const Dual& a) { return Dual::mapped(a, -a.value(), -1.0); }
inline Dual operator+(const Dual& a, double b) {
  Dual sum = a;
  sum.value() += b;
  return sum;
}
inline Dual operator+(double a, const Dual& b) { return b + a; }
inline Dual operator-(const Dual& a, double b) { return a + -b; }
inline Dual operator-(double a, const Dual& b) { return Dual::mapped(b, a - b.value(), -1.0); }
inline Dual operator*(const Dual& a, double b) { return Dual::mapped(a, a.value() * b, b); }
inline Dual operator*(double a, const Dual& b) { return b * a; }
inline Dual operator/(const Dual& a, double b) { return Dual::mapped(a, a.value() / b, 1.0 / b); }
inline Dual operator/(double a, const Dual& b) {
  return Dual::mapped(b, a / b.value(), -a / (b.value() * b.value()));
}
inline bool operator<(const Dual& a, const Dual& b) { return a.value() < b.value(); }

inline Dual exp(const Dual& x) {
  const double value = std::exp(x.value());
  return Dual::mapped(x, value, value);
}
inline Dual log(const Dual& x) { return Dual::mapped(x, std::log(x.value()), 1.0 / x.value()); }
inline Dual sqrt(const Dual& x) {
  const double value = std::sqrt(x.value());
  return Dual::mapped(x, value, 0.5 / value);
}
inline Dual sin(const Dual& x) { return Dual::mapped(x, std::sin(x.value()), std::cos(x.value())); }
inline Dual tanh(const Dual& x) {
  const double value = std::tanh(x.value());
  return Dual::mapped(x, value, 1.0 - value * value);
}

}  // namespace battery_sof
