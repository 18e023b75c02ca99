#include "baseline/ridge.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include "regression/ridge.hpp"

namespace battery_sof {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// [s]
constexpr std::array kTimeConstants = {0.1,  0.3,   1.0,   3.0,    10.0,
                                       30.0, 100.0, 300.0, 1000.0, 3000.0};
// [As]
constexpr std::array kRecentDischarges = {5.0, 50.0, 500.0};
constexpr std::size_t kFewestRows = 60;
constexpr std::size_t kMaxRows = 20000;
constexpr int kBlocks = 6;
constexpr double kPenaltyUnit = 1e-2;
constexpr int kWeakestPenalty = -3, kStrongestPenalty = 4;  // powers of ten

void requireRanges(const Series& series, IndexRange train, IndexRange test) {
  const bool valid = train.first < train.last && train.last <= series.size() &&
                     test.first < test.last && test.last <= series.size() &&
                     train.size() >= kFewestRows;
  if (valid) return;
  throw std::invalid_argument("ridgeVoltage: trained on samples " + std::to_string(train.first) +
                              " to " + std::to_string(train.last) + ", tested on " +
                              std::to_string(test.first) + " to " + std::to_string(test.last) +
                              " of " + std::to_string(series.size()) +
                              "; expected ranges that are not empty, and 60 samples to train on");
}

VectorXd lowPass(const VectorXd& x, const VectorXd& time, double time_constant) {
  VectorXd y(x.size());
  y[0] = x[0];
  for (Index k = 1; k < x.size(); ++k)
    y[k] = y[k - 1] - std::expm1(-(time[k] - time[k - 1]) / time_constant) * (x[k] - y[k - 1]);
  return y;
}

std::vector<double> usableTimeConstants(const VectorXd& time, double interval) {
  const double span = time[time.size() - 1] - time[0];
  std::vector<double> usable;
  for (const double tau : kTimeConstants)
    if (tau >= 0.9 * interval && tau < span / 3.0) usable.push_back(tau);
  return usable;
}

VectorXd chargeOver(const VectorXd& time, const VectorXd& current) {
  VectorXd charge = VectorXd::Zero(time.size());
  for (Index k = 1; k < time.size(); ++k)
    charge[k] = charge[k - 1] + current[k] * (time[k] - time[k - 1]);
  return charge;
}

/// Hands out the columns one by one, so that a long recording needs room for one of them. @param
/// take void(const VectorXd&).
template <typename Take>
void forEachColumn(const VectorXd& time, const VectorXd& current, double interval, Take take) {
  const VectorXd charging = current.cwiseMax(0.0);
  const auto bent = [](const VectorXd& x, double scale) {
    return VectorXd(x.unaryExpr([scale](double value) { return std::asinh(value / scale); }));
  };
  const auto time_constants = usableTimeConstants(time, interval);
  for (const VectorXd& inputs : {current, charging, bent(current, 5.0), bent(charging, 2.0)}) {
    take(inputs);
    for (const double tau : time_constants) take(lowPass(inputs, time, tau));
  }
  take(chargeOver(time, current));
  for (const double tau : time_constants) {
    if (tau < 1.0) continue;
    const VectorXd discharged = lowPass((-current).cwiseMax(0.0), time, tau) * tau;
    for (const double scale : kRecentDischarges) {
      const VectorXd accepted = scale / (scale + discharged.array());
      take(accepted);
      take(VectorXd(accepted.cwiseProduct(charging)));
    }
  }
}

struct Rows {
  MatrixXd x;
  VectorXd y;
};

/// The columns of a range of the samples, every k-th of very many. @param first sample of time and
/// current.
Rows trainingRows(const VectorXd& time, const VectorXd& current, const Series& series,
                  IndexRange train, std::size_t first) {
  const std::size_t stride = 1 + (train.size() - 1) / kMaxRows;
  const auto count = static_cast<Index>(1 + (train.size() - 1) / stride);
  const auto sample = [&](Index n) { return train.first + static_cast<std::size_t>(n) * stride; };
  std::vector<VectorXd> columns;
  forEachColumn(time, current, medianInterval(series), [&](const VectorXd& column) {
    VectorXd& taken = columns.emplace_back(count);
    for (Index n = 0; n < count; ++n) taken[n] = column[static_cast<Index>(sample(n) - first)];
  });
  Rows rows{MatrixXd(count, static_cast<Index>(columns.size())), VectorXd(count)};
  for (std::size_t c = 0; c < columns.size(); ++c) rows.x.col(static_cast<Index>(c)) = columns[c];
  for (Index n = 0; n < count; ++n) rows.y[n] = series.voltage[sample(n)];
  return rows;
}

/// What a fit says of `count` samples from `begin` of time and current on.
VectorXd predicted(const RidgeFit& fit, const VectorXd& time, const VectorXd& current,
                   double interval, Index begin, Index count) {
  VectorXd voltage = VectorXd::Constant(count, fit.constant);
  Index at = 0;
  forEachColumn(time, current, interval, [&](const VectorXd& column) {
    voltage += fit.ofColumn(at++, column.segment(begin, count));
  });
  return voltage;
}

RidgeOptions options() {
  RidgeOptions options;
  options.blocks = kBlocks;
  options.of_mean = true;
  for (int power = kWeakestPenalty; power <= kStrongestPenalty; ++power)
    options.penalties.push_back(kPenaltyUnit * std::pow(10.0, power));
  return options;
}

}  // namespace

std::vector<double> ridgeVoltage(const Series& series, IndexRange train, IndexRange test) {
  requireRanges(series, train, test);
  const std::size_t first = std::min(train.first, test.first);
  const auto size = static_cast<Index>(std::max(train.last, test.last) - first);
  const VectorXd time = Eigen::Map<const VectorXd>(series.time.data() + first, size);
  const VectorXd current = Eigen::Map<const VectorXd>(series.current.data() + first, size);
  const Rows rows = trainingRows(time, current, series, train, first);
  const VectorXd voltage =
      predicted(fitRidge(rows.x, rows.y, options()), time, current, medianInterval(series),
                static_cast<Index>(test.first - first), static_cast<Index>(test.size()));
  return {voltage.data(), voltage.data() + voltage.size()};
}

}  // namespace battery_sof
