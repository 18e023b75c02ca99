#include "battery_sof/diagnose/row_simulation.hpp"

#include <algorithm>
#include <cmath>

#include "battery_sof/model/effect.hpp"

namespace battery_sof {
namespace {

/// Samples of a row as one: their mean current drives from the middle of the row before to the middle of this one.
DriveSample averaged(const Drive& drive, std::size_t begin, std::size_t end, const DriveSample* before) {
  DriveSample row = drive.samples[begin];
  double time = 0.0, current = 0.0, voltage = 0.0, measured = 0.0, missed = 0.0;
  bool gap = false;
  for (std::size_t n = begin; n < end; ++n) {
    const DriveSample& sample = drive.samples[n];
    time += sample.step.time;
    current += sample.step.current;
    missed += sample.step.missed;
    gap = gap || (sample.step.gap && n > 0);
    if (!(sample.count > 0.0)) continue;
    voltage += sample.voltage;
    measured += 1.0;
  }
  const double count = static_cast<double>(end - begin);
  row.step.time = time / count;
  row.step.current = current / count;
  row.step.slope = 0.0;
  row.step.averaged = true;
  row.step.gap = gap;
  row.step.missed = missed;
  row.step.duration = before ? row.step.time - before->step.time : 0.0;
  row.step.held = gap || !before ? 0.0 : 0.5 * (before->step.current + row.step.current);
  row.voltage = measured > 0.0 ? voltage / measured : row.voltage;
  row.count = measured;
  return row;
}

Drive rowsOf(const Drive& drive, const BaseResponse& response) {
  Drive rows;
  rows.trace = drive.trace;
  for (std::size_t row = 0; row + 1 < response.first.size(); ++row) {
    const DriveSample* before = rows.samples.empty() ? nullptr : &rows.samples.back();
    rows.samples.push_back(averaged(drive, response.first[row], response.first[row + 1], before));
  }
  rows.first_time = rows.samples.empty() ? drive.first_time : rows.samples.front().step.time;
  return rows;
}

bool actsAtEdges(const BatteryModel& model) {
  const auto& ids = model.effects();
  return std::any_of(ids.begin(), ids.end(), [](const std::string& id) { return effectInfo(id).acts_at_edges; });
}

}  // namespace

RowSimulation::RowSimulation(const Drive& drive, const BaseResponse& response)
    : drive_(drive), response_(response), rows_(rowsOf(drive, response)) {}

RowErrors RowSimulation::errors(const BatteryModel& model, const CompositionPoint& point, const Eigen::MatrixXd& seeds) const {
  const bool at_edges = actsAtEdges(model);
  const Drive& drive = at_edges ? drive_ : rows_;
  const std::size_t per_row = at_edges && response_.first.size() > 1 ? response_.first[1] - response_.first[0] : 1;
  const ModelPoint start{point.parameters, point.state, drive.first_time, drive.first_time};
  Simulation simulation = seeds.cols() > 0 ? Simulation(model, start, seeds) : Simulation(model, start);
  RowErrors out{Eigen::VectorXd::Zero(response_.error.size()), Eigen::MatrixXd::Zero(response_.error.size(), seeds.cols())};
  Eigen::VectorXd measured = out.error;
  const auto last = static_cast<std::size_t>(out.error.size()) * per_row;
  for (std::size_t n = 0; n < last; ++n) {
    const DriveSample& sample = drive.samples[n];
    const double error = simulation.follow(sample);
    if (!(sample.count > 0.0)) continue;
    const auto row = static_cast<Eigen::Index>(n / per_row);
    const double scale = sample.voltage_drives ? -response_.resistance[row] : 1.0;
    out.error[row] += scale * error;
    measured[row] += 1.0;
    if (seeds.cols() == 0) continue;
    if (sample.voltage_drives)
      out.sensitivity.row(row) -= scale * simulation.currentErrorDerivatives().transpose();
    else
      out.sensitivity.row(row) += simulation.voltageDerivatives().transpose();
  }
  out.error.array() /= measured.array().max(1.0);
  for (Eigen::Index k = 0; k < seeds.cols(); ++k) out.sensitivity.col(k).array() /= measured.array().max(1.0);
  if (!out.error.allFinite() || !out.sensitivity.allFinite()) return {};
  return out;
}

}  // namespace battery_sof
