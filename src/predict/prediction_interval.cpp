#include "battery_sof/predict/prediction_interval.hpp"

#include <algorithm>
#include <cmath>

namespace battery_sof {

Interval voltageInterval(const FittedModel& model, double current,
                         const Overpotential& overpotential, double model_error) {
  Eigen::Matrix<double, kCovarianceRows, 1> g;
  g[kRowRDischarge] = std::min(current, 0.0);
  g[kRowRCharge] = std::max(current, 0.0);
  g[kRowC2] = overpotential.d_c2;
  g[kRowBeta] = overpotential.d_beta;
  g[kRowUDc] = 1.0;
  g[kRowState] = overpotential.d_initial;
  const double parameter_variance = std::max(0.0, g.dot(model.covariance * g));
  const double half = kNinetyPercent * std::sqrt(parameter_variance + model_error * model_error);
  const double u = terminalVoltage(model.parameters, current, overpotential.value);
  return {u, u - half, u + half};
}

}  // namespace battery_sof
