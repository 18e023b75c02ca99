#include "diagnosis/parameter_bias.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace battery_sof {
namespace {

// of a cost in variances: less could not be taken for a mismatch
constexpr double kMismatch = 12.0;

constexpr double kMinShare = 0.01;
constexpr double kMaxRelative = 1.0;  // standard error of a change that is still worth telling
constexpr double kMaxLevel = 0.5;     // [V], the same of u_dc
constexpr std::array<const char*, 3> kThirds{"first third", "middle third", "last third"};
constexpr std::size_t kParts = kRegimes + kThirds.size();

std::string partName(std::size_t part) {
  return part < kRegimes ? regimeName(static_cast<Regime>(part)) : kThirds[part - kRegimes];
}

std::size_t thirdOf(const InputSequence& inputs, double time) {
  const double first = inputs.samples.front().step.time,
               span = inputs.samples.back().step.time - first;
  return span > 0.0
             ? std::min<std::size_t>(2, static_cast<std::size_t>(3.0 * (time - first) / span))
             : 0;
}

/// Coordinates that move base parameters.
std::vector<Eigen::Index> baseCoordinates(const WhitenedFit& fit) {
  std::vector<Eigen::Index> coordinates;
  for (std::size_t k = 0; k < fit.rows.size(); ++k)
    if (fit.rows[k] < kBaseRows) coordinates.push_back(k);
  return coordinates;
}

/// A coordinate's change of one as a change of its parameter: relative, of u_dc in V.
double unitOf(const WhitenedFit& fit, Eigen::Index coordinate) {
  const Eigen::Index row = fit.rows[coordinate];
  const ParameterInfo& info = fit.model.parameters()[row];
  if (info.logarithmic) return 1.0;
  return row == kRowUDc ? std::abs(info.magnitude)
                        : std::abs(info.magnitude) / fit.point.parameters[row];
}

/// A linear change as far as the parameter can take it: its value stays inside its bounds.
double possible(const WhitenedFit& fit, Eigen::Index row, double change) {
  if (row == kRowUDc) return change;
  const ParameterInfo& info = fit.model.parameters()[row];
  const double value = fit.point.parameters[row];
  return std::clamp(value * (1.0 + change), std::min(info.lower, value),
                    std::max(info.upper, value)) /
             value -
         1.0;
}

/// The Jacobian's columns of some coordinates, a copy for every part with zeros outside it; parts
/// run fastest.
Eigen::MatrixXd cutColumns(const WhitenedFit& fit, const InputSequence& inputs,
                           const std::vector<Regime>& regimes,
                           const std::vector<Eigen::Index>& coordinates) {
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(fit.jacobian.rows(), kParts * coordinates.size());
  for (std::size_t n = 0; n < regimes.size(); ++n) {
    const std::size_t third = kRegimes + thirdOf(inputs, inputs.samples[n].step.time);
    for (std::size_t j = 0; j < coordinates.size(); ++j)
      for (const std::size_t part : {static_cast<std::size_t>(regimes[n]), third})
        columns(n, j * kParts + part) = fit.jacobian(n, coordinates[j]);
  }
  return columns;
}

/// max(1, mean of v^2) over what was measured: never below what the noise model says, and not
/// lessened by what a test explains.
double innovationVariance(const WhitenedFit& fit, const InputSequence& inputs) {
  const auto measured = std::count_if(inputs.samples.begin(), inputs.samples.end(),
                                      [](const InputSample& sample) { return sample.count > 0.0; });
  return std::max(1.0, fit.innovation.squaredNorm() / std::max(1.0, static_cast<double>(measured)));
}

double costOf(const WhitenedFit& fit, const CompositionPoint& point, const InputSequence& inputs) {
  Eigen::VectorXd error = -simulatedVoltage(fit.model, point, inputs);
  for (Eigen::Index n = 0; n < error.size(); ++n) error[n] += inputs.samples[n].voltage;
  const Eigen::VectorXd innovation = whitened(fit, inputs, error);
  return innovation.squaredNorm();
}

}  // namespace

std::vector<ParameterBias> parameterBiases(const WhitenedFit& fit, const InputSequence& inputs,
                                           const std::vector<Regime>& regimes) {
  requireOneSize("parameterBiases", inputs, regimes, fit.residual.size());
  const std::vector<Eigen::Index> coordinates = baseCoordinates(fit);
  const Signatures signatures =
      signaturesOf(fit, inputs, cutColumns(fit, inputs, regimes, coordinates));
  const double std = std::sqrt(innovationVariance(fit, inputs));
  std::vector<ParameterBias> map;
  for (std::size_t j = 0; j < coordinates.size(); ++j) {
    const double unit = unitOf(fit, coordinates[j]);
    const Eigen::Index row = fit.rows[coordinates[j]];
    for (std::size_t part = 0; part < kParts; ++part) {
      const auto column = static_cast<Eigen::Index>(j * kParts + part);
      const double length = signatures.columns.col(column).norm();
      if (length <= 0.0 || length / signatures.length[column] <= kMinShare) continue;
      if (unit * std / length > (row == kRowUDc ? kMaxLevel : kMaxRelative)) continue;
      const double along = signatures.columns.col(column).dot(fit.innovation) / length;
      map.push_back({fit.model.parameters()[row].name, partName(part), along / std,
                     possible(fit, row, unit * along / length)});
    }
  }
  return map;
}

bool optimiserFailed(const InputSequence& part, const WhitenedFit& own,
                     const Eigen::VectorXd& other) {
  return costOf(own, own.point, part) - costOf(own, {other, own.point.state}, part) > kMismatch;
}

}  // namespace battery_sof
