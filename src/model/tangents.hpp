#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "effects/effect_definition.hpp"

namespace battery_sof {

/// Derivatives that a number of arithmetic S carries.
template <typename S>
struct Width {
  static constexpr int value = 0;
};
template <int N>
struct Width<Dual<N>> {
  static constexpr int value = N;
};

inline const double* derivativesOf(const double&) { return nullptr; }
template <int N>
const double* derivativesOf(const Dual<N>& x) {
  return x.derivatives().data();
}

template <typename S>
Eigen::VectorXd valuesOf(const std::vector<S>& numbers) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(numbers.size()));
  for (std::size_t j = 0; j < numbers.size(); ++j)
    values[static_cast<Eigen::Index>(j)] = valueOf(numbers[j]);
  return values;
}

/// A number with its row of the seeds.
inline double seeded(double value, const Eigen::Ref<const Eigen::MatrixXd>&, Eigen::Index, double) {
  return value;
}
template <int N>
Dual<N> seeded(double value, const Eigen::Ref<const Eigen::MatrixXd>& seeds, Eigen::Index row,
               const Dual<N>&) {
  Dual<N> x(value);
  if (seeds.cols() > 0) x.derivatives().head(seeds.cols()) = seeds.row(row).transpose();
  return x;
}

/// Below it nothing has a meaning; further down, numbers that fade away get stuck where the
/// processor is slow.
inline constexpr double kFaded = 1e-200;

inline void dropFaded(double& x) {
  if (std::abs(x) < kFaded) x = 0.0;
}
template <int N>
void dropFaded(Dual<N>& x) {
  dropFaded(x.value());
  x.derivatives() = (x.derivatives().array().abs() < kFaded).select(0.0, x.derivatives());
}

}  // namespace battery_sof
