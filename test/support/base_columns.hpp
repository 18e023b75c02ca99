#pragma once

#include <vector>

#include "estimation/base_normal_equations.hpp"
#include "support/base_circuit.hpp"

namespace battery_sof::test {

using BaseColumns = Eigen::Matrix<double, Eigen::Dynamic, kBaseColumns>;

/// A window's samples with the paper's weights, those of a Series without masked samples.
inline std::vector<BaseNormalEquations::Sample> fitSamples(const Series& series, IndexRange range) {
  const std::vector<char> none;
  return WindowSamples{series, range, {}, gapThreshold(series), none}.copied();
}

/// The columns of BaseColumn, one row a sample, step by step. @param offset [V], of the target.
inline BaseColumns columnsOf(const std::vector<BaseNormalEquations::Sample>& samples,
                             const OverpotentialSweep::Point& point, double offset) {
  BaseParameters p;
  p.c2 = point.c2;
  p.beta = point.beta;
  const BaseStep step(p);
  Overpotential u{point.u_c2_first, 1.0, 0.0, 0.0};
  BaseColumns columns(static_cast<Eigen::Index>(samples.size()), kBaseColumns);
  for (std::size_t n = 0; n < samples.size(); ++n) {
    const auto& sample = samples[n];
    u = step.advance(u, sample.held.current, sample.held.duration);
    columns.row(static_cast<Eigen::Index>(n)) << sample.discharge, sample.charge, 1.0,
        u.d_c2 * p.c2, u.d_beta * p.beta, u.d_initial, sample.voltage - offset - u.value;
  }
  return columns;
}

}  // namespace battery_sof::test
