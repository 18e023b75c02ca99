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
  static constexpr bool kIsDual = true;
  static constexpr int kMaxTangents = 48;

  Dual(double value = 0.0) : value_(value) {}  // NOLINT(google-explicit-constructor)
  /// @param derivatives at most kMaxTangents.
  Dual(double value, const Eigen::RowVectorXd& derivatives);
  Dual(const Dual& other) : value_(other.value_) { carry(other, Same()); }
  /// Assigned to itself, each number is written over itself.
  Dual& operator=(const Dual& other) {  // NOLINT(bugprone-unhandled-self-assignment)
    value_ = other.value_;
    carry(other, Same());
    return *this;
  }
  ~Dual() = default;
  /// f(x) where value and slope of f at x are known.
  static Dual mapped(const Dual& x, double value, double slope) {
    return {value, x, [slope](Pair dx) { return dx * slope; }};
  }

  double value() const { return value_; }
  double& value() { return value_; }
  double derivative(int tangent) const { return tangent < carried_ ? derivatives_[tangent] : 0.0; }
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

/// A number with its derivative to the one unknown of an equation.
class Slope {
 public:
  static constexpr bool kIsDual = true;

  Slope(double value = 0.0) : value_(value) {}  // NOLINT(google-explicit-constructor)
  static Slope unknown(double value) { return {value, 1.0}; }
  /// As Dual::mapped().
  static Slope mapped(const Slope& x, double value, double slope) {
    return {value, x.slope_ * slope};
  }

  double value() const { return value_; }
  double& value() { return value_; }
  double slope() const { return slope_; }
  bool isConstant() const { return slope_ == 0.0; }
  template <typename Change>
  void changeDerivatives(const Change& change) {
    change(slope_);
  }

  friend Slope operator+(const Slope& a, const Slope& b) {
    return {a.value_ + b.value_, a.slope_ + b.slope_};
  }
  friend Slope operator-(const Slope& a, const Slope& b) {
    return {a.value_ - b.value_, a.slope_ - b.slope_};
  }
  friend Slope operator*(const Slope& a, const Slope& b) {
    return {a.value_ * b.value_, a.slope_ * b.value_ + b.slope_ * a.value_};
  }
  friend Slope operator/(const Slope& a, const Slope& b) {
    return {a.value_ / b.value_,
            (a.slope_ * b.value_ - b.slope_ * a.value_) * (1.0 / (b.value_ * b.value_))};
  }

 private:
  Slope(double value, double slope) : value_(value), slope_(slope) {}

  double value_, slope_ = 0.0;
};

template <typename N, bool = N::kIsDual>
N operator-(const N& a) {
  return N::mapped(a, -a.value(), -1.0);
}
template <typename N, bool = N::kIsDual>
N operator+(const N& a, double b) {
  N sum = a;
  sum.value() += b;
  return sum;
}
template <typename N, bool = N::kIsDual>
N operator+(double a, const N& b) {
  return b + a;
}
template <typename N, bool = N::kIsDual>
N operator-(const N& a, double b) {
  return a + -b;
}
template <typename N, bool = N::kIsDual>
N operator-(double a, const N& b) {
  return N::mapped(b, a - b.value(), -1.0);
}
template <typename N, bool = N::kIsDual>
N operator*(const N& a, double b) {
  return N::mapped(a, a.value() * b, b);
}
template <typename N, bool = N::kIsDual>
N operator*(double a, const N& b) {
  return b * a;
}
template <typename N, bool = N::kIsDual>
N operator/(const N& a, double b) {
  return N::mapped(a, a.value() / b, 1.0 / b);
}
template <typename N, bool = N::kIsDual>
N operator/(double a, const N& b) {
  return N::mapped(b, a / b.value(), -a / (b.value() * b.value()));
}
template <typename N, bool = N::kIsDual>
bool operator<(const N& a, const N& b) {
  return a.value() < b.value();
}
template <typename N, bool = N::kIsDual>
bool operator<(const N& a, double b) {
  return a.value() < b;
}

template <typename N, bool = N::kIsDual>
N exp(const N& x) {
  const double value = std::exp(x.value());
  return N::mapped(x, value, value);
}
template <typename N, bool = N::kIsDual>
N log(const N& x) {
  return N::mapped(x, std::log(x.value()), 1.0 / x.value());
}
template <typename N, bool = N::kIsDual>
N sqrt(const N& x) {
  const double value = std::sqrt(x.value());
  return N::mapped(x, value, 0.5 / value);
}
template <typename N, bool = N::kIsDual>
N sin(const N& x) {
  return N::mapped(x, std::sin(x.value()), std::cos(x.value()));
}
template <typename N, bool = N::kIsDual>
N tanh(const N& x) {
  const double value = std::tanh(x.value());
  return N::mapped(x, value, 1.0 - value * value);
}

}  // namespace battery_sof
