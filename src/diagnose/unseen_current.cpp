#include "battery_sof/diagnose/unseen_current.hpp"

#include <algorithm>
#include <cmath>

namespace battery_sof {
namespace {

/// theta (1 - theta) (i_k - i_k-1)^2 of the samples around an instant [A^2]; 0 outside and across gaps.
double steppedVariance(const Drive& drive, double time) {
  const auto& samples = drive.samples;
  const auto after =
      std::lower_bound(samples.begin(), samples.end(), time, [](const DriveSample& sample, double at) { return sample.step.time < at; });
  if (after == samples.begin() || after == samples.end() || after->step.gap) return 0.0;
  const DriveStep &from = std::prev(after)->step, &to = after->step;
  const double theta = (time - from.time) / std::max(to.time - from.time, 1e-9);
  return theta * (1.0 - theta) * std::pow(to.current - from.current, 2);
}

double ohmic(const CompositionPoint& point) { return 0.5 * (point.parameters[kRowRDischarge] + point.parameters[kRowRCharge]); }

}  // namespace

Eigen::VectorXd unseenVariance(const Drive& drive, const BaseResponse& response, const BatteryModel& model, const CompositionPoint& point) {
  const auto skew = model.parameterRow("channel_skew");
  const auto rows = static_cast<std::size_t>(response.error.size());
  if (!skew || rows == 0 || response.first[1] - response.first[0] > 1) return {};
  Eigen::VectorXd variance(static_cast<Eigen::Index>(rows));
  for (std::size_t row = 0; row < rows; ++row) {
    const auto at = static_cast<Eigen::Index>(row);
    const double resistance = response.voltage_drives[row] ? response.resistance[at] : ohmic(point);
    variance[at] = resistance * resistance * steppedVariance(drive, response.time[at] - point.parameters[*skew]);
  }
  return variance;
}

Drive withUnseen(Drive drive, const BatteryModel& model, const CompositionPoint& point, double noise) {
  const auto skew = model.parameterRow("channel_skew");
  if (!skew) return drive;
  const Drive measured = drive;
  for (DriveSample& sample : drive.samples) {
    if (sample.step.averaged) continue;
    const double unseen = ohmic(point) * ohmic(point) * steppedVariance(measured, sample.step.time - point.parameters[*skew]);
    sample.count *= noise * noise / (noise * noise + unseen);
  }
  return drive;
}

}  // namespace battery_sof
