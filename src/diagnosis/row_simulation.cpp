#include "diagnosis/row_simulation.hpp"

#include <algorithm>
#include <cmath>

#include "model/effect.hpp"

namespace battery_sof {
namespace {

/// Samples of a row as one: their mean current is the input from the middle of the row before to
/// the middle of this one.
InputSample averaged(const InputSequence& inputs, std::size_t begin, std::size_t end,
                     const InputSample* before) {
  InputSample row = inputs.samples[begin];
  double time = 0.0, current = 0.0, voltage = 0.0, measured = 0.0, missed = 0.0;
  bool gap = false;
  for (std::size_t n = begin; n < end; ++n) {
    const InputSample& sample = inputs.samples[n];
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
  if (end - begin > 1) {
    row.step.slope = 0.0;
    row.step.span =
        meanSpan(inputs.samples[begin].step.time, inputs.samples[end - 1].step.time, end - begin);
  }
  row.step.gap = gap;
  row.step.missed = missed;
  row.step.duration = before ? row.step.time - before->step.time : 0.0;
  row.step.held = gap || !before ? 0.0 : 0.5 * (before->step.current + row.step.current);
  row.voltage = measured > 0.0 ? voltage / measured : row.voltage;
  row.count = measured;
  return row;
}

constexpr double kEdge = 2.0;  // [A], within a row: its current moves

/// Whether the current moves within a row or on the way into it.
bool moves(const InputSequence& inputs, std::size_t begin, std::size_t end) {
  double low = inputs.samples[begin].step.current, high = low;
  for (std::size_t n = begin > 0 ? begin - 1 : 0; n < end; ++n) {
    low = std::min(low, inputs.samples[n].step.current);
    high = std::max(high, inputs.samples[n].step.current);
  }
  return high - low > kEdge;
}

/// Whether one of its effects acts at edges of the current.
bool actsAtEdges(const BatteryModel& model) {
  const auto& ids = model.effects();
  return std::any_of(ids.begin(), ids.end(),
                     [](const std::string& id) { return effectInfo(id).acts_at_edges; });
}

}  // namespace

RowSimulation::Grid RowSimulation::gridOf(const InputSequence& inputs, bool fine_at_edges) const {
  Grid grid;
  grid.inputs.trace = inputs.trace;
  const std::size_t rows = response_.error.size();
  for (std::size_t row = 0; row < rows; ++row) {
    const std::size_t begin = response_.first[row], end = response_.first[row + 1];
    const bool whole = end - begin == 1 || (fine_at_edges && moves(inputs, begin, end));
    for (std::size_t n = begin; n < end; n = whole ? n + 1 : end) {
      const InputSample* before =
          grid.inputs.samples.empty() ? nullptr : &grid.inputs.samples.back();
      grid.inputs.samples.push_back(averaged(inputs, n, whole ? n + 1 : end, before));
      grid.row.push_back(row);
    }
  }
  grid.inputs.first_time = grid.inputs.samples.front().step.time;
  grid.coarseness = Eigen::VectorXd::Zero(response_.error.size());
  return grid;
}

RowSimulation::RowSimulation(const InputSequence& inputs, const Linearization& response,
                             const CompositionPoint& base)
    : response_(response), rows_(gridOf(inputs, false)), edges_(gridOf(inputs, true)) {
  for (Grid* grid : {&rows_, &edges_}) {
    const RowErrors coarse = simulated(*grid, BatteryModel(), base, {});
    if (coarse.error.size() > 0) grid->coarseness = response.error - coarse.error;
  }
}

RowErrors RowSimulation::errors(const BatteryModel& model, const CompositionPoint& point,
                                const Eigen::MatrixXd& seeds) const {
  const Grid& grid = actsAtEdges(model) ? edges_ : rows_;
  RowErrors out = simulated(grid, model, point, seeds);
  if (out.error.size() > 0) out.error += grid.coarseness;
  return out;
}

RowErrors RowSimulation::simulated(const Grid& grid, const BatteryModel& model,
                                   const CompositionPoint& point,
                                   const Eigen::MatrixXd& seeds) const {
  const ModelPoint start = point.at(grid.inputs.first_time);
  Simulation simulation =
      seeds.cols() > 0 ? Simulation(model, start, seeds) : Simulation(model, start);
  RowErrors out{Eigen::VectorXd::Zero(response_.error.size()),
                Eigen::MatrixXd::Zero(response_.error.size(), seeds.cols())};
  Eigen::VectorXd measured = out.error;
  for (std::size_t n = 0; n < grid.inputs.samples.size(); ++n) {
    const InputSample& sample = grid.inputs.samples[n];
    const double error = simulation.follow(sample);
    if (!(sample.count > 0.0)) continue;
    const Eigen::Index row = grid.row[n];
    const double scale = sample.voltage_controlled ? -response_.resistance[row] : 1.0;
    out.error[row] += scale * sample.count * error;
    measured[row] += sample.count;
    if (seeds.cols() == 0) continue;
    if (sample.voltage_controlled)
      out.sensitivity.row(row) -=
          scale * sample.count * simulation.currentErrorDerivatives().transpose();
    else
      out.sensitivity.row(row) += sample.count * simulation.voltageDerivatives().transpose();
  }
  const Eigen::ArrayXd counts = measured.array().max(1.0);
  out.error.array() /= counts;
  out.sensitivity.array().colwise() /= counts;
  if (!out.error.allFinite() || !out.sensitivity.allFinite()) return {};
  return out;
}

}  // namespace battery_sof
