#pragma once
// Stands in for what is not here yet: regimes, segments, absorption, omnibus, comparison.
#include <algorithm>
#include <cmath>

#include "battery_sof/diagnose/hypotheses.hpp"
#include "battery_sof/diagnose/absorption.hpp"
#include "battery_sof/diagnose/diagnosis.hpp"
#include "battery_sof/diagnose/regimes.hpp"
#include "battery_sof/diagnose/residual_force.hpp"
#include "battery_sof/identify/fit_quality.hpp"

namespace battery_sof {
inline std::vector<RegimeFinding> regimeFindings(const Drive&, const Eigen::VectorXd&) { return {}; }
inline std::vector<MismatchSegment> mismatchSegments(const Drive&, const WhitenedFit&, const std::vector<Regime>&) { return {}; }
inline std::vector<RegimeComparison> compareRegimes(const Series&, IndexRange, const std::vector<double>&, const std::vector<double>&) { return {}; }
inline ErrorMetrics errorMetrics(const Series& series, IndexRange range, const std::vector<double>& voltage) {
  const std::vector<double> measured(series.voltage.begin() + range.first, series.voltage.begin() + range.last);
  const std::vector<double> modelled(voltage.begin() + range.first, voltage.begin() + range.last);
  ErrorMetrics metrics;
  metrics.q_dyn_percent = qDyn(measured, modelled).value_or(0.0);
  metrics.rmse = rootMeanSquareError(measured, modelled);
  for (std::size_t k = 0; k < measured.size(); ++k) metrics.max_abs = std::max(metrics.max_abs, std::abs(measured[k] - modelled[k]));
  return metrics;
}
}  // namespace battery_sof
