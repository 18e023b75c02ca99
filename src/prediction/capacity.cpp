#include "prediction/capacity.hpp"

#include <cmath>

#include "prediction/event_corrections.hpp"

namespace battery_sof {
namespace {

constexpr double kFullVoltage = 12.9, kFullSpread = 0.1;  // [V] of a block at rest

}  // namespace

std::optional<Interval> estimatedCapacity(const Fit& fit) {
  const BatteryModel composition = compositionOf(fit);
  const auto slope = composition.parameterRow("ocv_slope"),
             exhausted = composition.parameterRow("exhaustion_voltage");
  if (!slope || !exhausted || fit.estimates.empty()) return std::nullopt;
  const ParameterEstimate& k = fit.estimates[static_cast<std::size_t>(*slope)];
  if (!k.determined || !(k.value > 0.0)) return std::nullopt;
  const double end = fit.estimates[static_cast<std::size_t>(*exhausted)].value;
  const double capacity = (kFullVoltage - end) / k.value;
  const Eigen::MatrixXd& V = fit.covariance;
  const double d_end = -1.0 / k.value, d_slope = -capacity / k.value;
  const double variance = d_end * d_end * (V(*exhausted, *exhausted) + kFullSpread * kFullSpread) +
                          d_slope * d_slope * V(*slope, *slope) +
                          2.0 * d_end * d_slope * V(*exhausted, *slope);
  return ninetyPercent(capacity, std::sqrt(variance));
}

}  // namespace battery_sof
