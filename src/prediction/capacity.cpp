#include "prediction/capacity.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "estimation/capacity_prior.hpp"
#include "prediction/event_corrections.hpp"
#include "util/constants.hpp"

namespace battery_sof {
std::optional<Interval> estimatedCapacity(const Fit& fit) {
  const BatteryModel composition = compositionOf(fit);
  const auto slope = composition.parameterRow("ocv_slope"),
             exhausted = composition.parameterRow("exhaustion_voltage"),
             delay = composition.parameterRow("pore_delay");
  const std::vector<ParameterEstimate>& estimates = fit.estimates;
  if (!slope || !exhausted || !delay || estimates.empty()) return std::nullopt;
  const auto valueAt = [&](Eigen::Index row) {
    return estimates[static_cast<std::size_t>(row)].value;
  };
  const double k = valueAt(*slope), theta = valueAt(*delay);
  if (!estimates[static_cast<std::size_t>(*slope)].determined || !(k > 0.0) ||
      estimates[static_cast<std::size_t>(*exhausted)].at_bound)
    return std::nullopt;
  const double load = std::max(0.0, -fit.excited.min_current) / kSecondsPerHour;  // [Ah/s]
  const double between = (kFullVoltage - valueAt(*exhausted)) / k;
  const Eigen::Vector3d slopes(-between / k, -1.0 / k, -load);
  const Eigen::Matrix3d V =
      fit.covariance({*slope, *exhausted, *delay}, {*slope, *exhausted, *delay});
  const double variance = slopes.dot(V * slopes) + std::pow(kFullSpread / k, 2);
  const double capacity = between - theta * load;
  if (!(capacity > 0.0)) return std::nullopt;
  const Interval known = ninetyPercent(capacity, std::sqrt(variance));
  if (!(known.lower > 0.0)) return std::nullopt;
  return known;
}

}  // namespace battery_sof
