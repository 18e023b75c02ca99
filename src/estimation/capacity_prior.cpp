#include "estimation/capacity_prior.hpp"

#include "util/constants.hpp"

namespace battery_sof {
namespace {

constexpr double kGiven = 0.95;       // [1], of the nominal capacity by a battery in use
constexpr double kEndSpread = 0.2;    // [V]
constexpr double kRatedHours = 20.0;  // in which the nominal capacity is drawn

}  // namespace

std::optional<CapacityPrior> CapacityPrior::of(const BatteryModel& model, double capacity) {
  const auto slope = model.parameterRow("ocv_slope"),
             end = model.parameterRow("exhaustion_voltage"),
             delay = model.parameterRow("pore_delay");
  if (!slope || !end || !delay) return std::nullopt;
  CapacityPrior prior;
  prior.slope_ = *slope;
  prior.end_ = *end;
  prior.delay_ = *delay;
  prior.capacity_ = capacity;
  return prior;
}

CapacityPrior::Residual CapacityPrior::at(const ParameterSpace& space,
                                          const Eigen::VectorXd& x) const {
  const CompositionPoint point = space.pointAt(x);
  const double drawn = kGiven * capacity_, k_s = point[slope_],
               rated = kRatedHours * kSecondsPerHour;
  const double longer = 1.0 + point[delay_] / rated;
  Residual residual{(kFullVoltage - point[end_] - drawn * k_s * longer) / kEndSpread,
                    Eigen::VectorXd::Zero(space.size())};
  for (Eigen::Index k = 0; k < space.size(); ++k) {
    const Eigen::Index row = space.rowOf(k);
    const double per = space[k].slope(point[row]) / kEndSpread;
    if (row == slope_) residual.slopes[k] = -drawn * longer * per;
    if (row == end_) residual.slopes[k] = -per;
    if (row == delay_) residual.slopes[k] = -drawn * k_s / rated * per;
  }
  return residual;
}

}  // namespace battery_sof
