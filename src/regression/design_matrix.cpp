#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "recording/channel_statistics.hpp"
#include "regression/discrepancy_fit.hpp"

namespace battery_sof {
namespace {

constexpr double kFast = 0.06;  // [s]; sampled faster, samples are averaged
constexpr double kRow = 0.1;    // [s]
constexpr double kFlat = 1e-9;  // [1], of a regressor's range: it does not move
// quantile of the overpotential above which side reactions are looked for
constexpr double kTimesNear = 0.9;

std::size_t samplesPerRow(const InputSequence& inputs) {
  const double interval = medianDuration(inputs);
  return interval < kFast ? static_cast<std::size_t>(std::max(1.0, std::round(kRow / interval)))
                          : 1;
}

/// Directions as columns of seeds: resistances, u_dc and u_c2 themselves, c2 and beta by their
/// logarithms.
Eigen::MatrixXd directionSeeds(const ModelPoint& at) {
  Eigen::MatrixXd seeds =
      Eigen::MatrixXd::Zero(at.parameters.size() + at.state.size(), kBaseDirections);
  for (Eigen::Index k = 0; k < kBaseRows; ++k)
    seeds(k, k) = k == kRowC2 || k == kRowBeta ? at.parameters[k] : 1.0;
  seeds(at.parameters.size(), kBaseDirections - 1) = 1.0;
  return seeds;
}

/// Table I's magnitudes from a base circuit; u_dc and the first u_c2 are the circuit's own.
Eigen::VectorXd expectedFrom(const Eigen::VectorXd& parameters) {
  const std::array<ParameterInfo, 4>& known = tableOne();
  Eigen::VectorXd expected = Eigen::VectorXd::Zero(kBaseDirections);
  for (Eigen::Index k = 0; k < 2; ++k) expected[k] = known[k].magnitude - parameters[k];
  for (Eigen::Index k = 2; k < 4; ++k) expected[k] = std::log(known[k].magnitude / parameters[k]);
  return expected;
}

/// How u_c2 goes on from one sample to the next with small changes: A of what it was, B of the
/// current [1], [Ohm].
struct ReactionSlope {
  double of_state, of_current;
};

ReactionSlope slopeOf(const BaseParameters& parameters, double overpotential, double duration) {
  const double half = 0.5 * parameters.beta * std::clamp(overpotential, -1.0, 1.0);
  const double conductance =
      parameters.i0 * parameters.beta * std::cosh(std::clamp(half, -30.0, 30.0));
  const double of_state = std::exp(-duration * conductance / parameters.c2);
  return {of_state, (1.0 - of_state) / conductance};
}

/// Context for regressors: how high the overpotential goes, how fast and how long the recording is.
RegressorContext contextOf(const InputSequence& inputs, const Linearization& response,
                           double beta) {
  RegressorContext context;
  context.interval = medianDuration(inputs);
  const std::size_t training = response.first[response.training];
  context.span = std::max(
      1.0, inputs.samples[std::max<std::size_t>(training, 1) - 1].step.time - inputs.first_time);
  context.beta = beta;
  std::vector<double> u(response.overpotential.begin(), response.overpotential.begin() + training);
  const double count = static_cast<double>(u.size());
  const double mean = std::accumulate(u.begin(), u.end(), 0.0) / count;
  double square = 0.0;
  for (const double x : u) square += (x - mean) * (x - mean);
  const auto high = u.begin() + static_cast<std::ptrdiff_t>(kTimesNear * count);
  std::nth_element(u.begin(), high, u.end());
  context.high = *high;
  context.high_width = std::max(0.02, 0.25 * std::sqrt(square / count));
  return context;
}

/// Means of a memory's regressors over the rows.
Eigen::MatrixXd rawRegressors(const InputSequence& inputs, const Linearization& response,
                              RegressorMemory& memory) {
  const Eigen::Index count = memory.regressors().size();
  Eigen::MatrixXd values(response.time.size(), count);
  Eigen::VectorXd now(count), sum(count);
  for (Eigen::Index row = 0; row < response.time.size(); ++row) {
    sum.setZero();
    const auto begin = response.first[row], end = response.first[static_cast<std::size_t>(row) + 1];
    for (std::size_t n = begin; n < end; ++n) {
      const InputStep& step = inputs.samples[n].step;
      memory.advance({step.duration, step.current, step.held, step.gap, response.overpotential[n],
                      step.time - inputs.first_time},
                     now);
      sum += now;
    }
    values.row(row) = sum / static_cast<double>(end - begin);
  }
  return values;
}

}  // namespace

Linearization linearizationOf(const BatteryModel& model, const ModelPoint& start,
                              const InputSequence& inputs, std::size_t training) {
  const BaseParameters parameters = baseParameters(start.parameters);
  const std::size_t per_row = samplesPerRow(inputs), rows = inputs.samples.size() / per_row;
  Simulation simulation(model, start, directionSeeds(start));
  Linearization out;
  out.time = out.error = out.weight = out.yielding = out.resistance = Eigen::VectorXd::Zero(rows);
  out.persistence = Eigen::VectorXd::Ones(rows);
  out.sensitivity = Eigen::MatrixXd::Zero(rows, kBaseDirections);
  out.voltage_controlled.assign(rows, 0);
  out.training = training / per_row;
  out.expected = expectedFrom(start.parameters);
  out.overpotential.reserve(inputs.samples.size());
  for (std::size_t row = 0; row <= rows; ++row) out.first.push_back(row * per_row);
  for (std::size_t row = 0; row < rows; ++row) {
    double measured = 0.0;
    for (std::size_t n = out.first[row]; n < out.first[row + 1]; ++n) {
      const InputSample& sample = inputs.samples[n];
      const double error = simulation.follow(sample), overpotential = simulation.state()[0];
      const ReactionSlope slope = slopeOf(parameters, overpotential, sample.step.duration);
      out.overpotential.push_back(overpotential);
      out.time[row] += sample.step.time;
      out.persistence[row] *= slope.of_state;
      bool counts = sample.count > 0.0;
      if (sample.voltage_controlled) {
        const double resistance =
            ohmicResistance(parameters, sample.step.current) + slope.of_current;
        out.voltage_controlled[row] = 1;
        out.resistance[row] = resistance;
        out.yielding[row] = slope.of_current / resistance;
        counts = counts && sample.step.duration > 0.0;
        if (!counts) continue;
        out.error[row] -= resistance * error;
        out.sensitivity.row(row) += resistance * simulation.currentErrorDerivatives().transpose();
      } else if (counts) {
        out.error[row] += error;
        out.sensitivity.row(row) += simulation.voltageDerivatives().transpose();
      }
      measured += counts;
    }
    out.time[row] /= static_cast<double>(per_row);
    if (!(measured > 0.0)) continue;
    out.error[row] /= measured;
    out.sensitivity.row(row) /= measured;
    out.weight[row] = 1.0;
  }
  return out;
}

Linearization discrepancyLinearizationOf(const BatteryModel& model, const ModelPoint& start,
                                         const InputSequence& inputs, std::size_t training) {
  Linearization response = linearizationOf(model, start, inputs, training);
  for (const Eigen::Index direction :
       {Eigen::Index{kRowC2}, Eigen::Index{kRowBeta}, kBaseDirections - 1}) {
    auto discrepancy = std::make_shared<DiscrepancyModel>();
    discrepancy->context.span = 1.0;
    discrepancy->base_change = Eigen::VectorXd::Unit(kBaseDirections, direction);
    Simulation alone(model, start), moved(withDiscrepancy(model, discrepancy), start);
    for (Eigen::Index row = 0; row < response.time.size(); ++row) {
      const auto begin = response.first[row],
                 end = response.first[static_cast<std::size_t>(row) + 1];
      double sum = 0.0, counted = 0.0;
      for (std::size_t n = begin; n < end; ++n) {
        const InputSample& sample = inputs.samples[n];
        alone.advance(sample.step);
        moved.advance(sample.step);
        if (!(sample.count > 0.0)) continue;
        sum += moved.voltage() - alone.voltage();
        counted += 1.0;
      }
      if (counted > 0.0) response.sensitivity(row, direction) = sum / counted;
    }
  }
  return response;
}

Eigen::VectorXd answered(const Linearization& response, const Eigen::VectorXd& discrepancy) {
  Eigen::VectorXd answer = discrepancy;
  double moved = 0.0;  // d [V]
  for (Eigen::Index row = 0; row < discrepancy.size(); ++row) {
    answer[row] += response.persistence[row] * moved;
    moved = response.persistence[row] * moved - response.yielding[row] * answer[row];
  }
  return answer;
}

DesignMatrix designMatrix(const InputSequence& inputs, const Linearization& response, double beta) {
  DesignMatrix table;
  table.context = contextOf(inputs, response, beta);
  RegressorMemory memory(regressorLibrary(table.context), table.context);
  Eigen::MatrixXd values = rawRegressors(inputs, response, memory);
  const auto training = values.topRows(response.training);
  std::vector<Eigen::Index> moving;
  const Eigen::VectorXd low = training.colwise().minCoeff(), high = training.colwise().maxCoeff();
  Eigen::VectorXd centre = training.colwise().mean();
  Eigen::VectorXd scale = (training.rowwise() - centre.transpose()).colwise().norm() /
                          std::sqrt(static_cast<double>(response.training));
  for (Eigen::Index k = 0; k < values.cols(); ++k) {
    if (!(scale[k] > kFlat * (1.0 + std::max(std::abs(low[k]), std::abs(high[k]))))) continue;
    moving.push_back(k);
    table.regressors.push_back(memory.regressors()[k]);
  }
  table.lower = low(moving);
  table.upper = high(moving);
  table.centre = centre(moving);
  table.scale = scale(moving);
  const Eigen::Index kept_count = moving.size();
  for (Eigen::Index j = 0; j < kept_count; ++j) {  // in place: a regressor's own is never before it
    Eigen::ArrayXd x = values.col(moving[j]).array();
    if (!isUnbounded(table.regressors[j].kind)) x = x.max(table.lower[j]).min(table.upper[j]);
    values.col(j) = answered(response, ((x - table.centre[j]) / table.scale[j]).matrix());
  }
  values.conservativeResize(Eigen::NoChange, kept_count);
  table.values = std::move(values);
  return table;
}

}  // namespace battery_sof
