#include "battery_sof/naive/ridge.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include "battery_sof/naive/ridge_fit.hpp"

namespace battery_sof {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::array kTimeConstants = {0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0};  // [s]
constexpr std::array kRecentDischarges = {5.0, 50.0, 500.0};                                           // [As]
constexpr std::size_t kFewestRows = 60;
constexpr std::size_t kMostRows = 20000;
constexpr int kBlocks = 6;
constexpr double kPenaltyUnit = 1e-2;
constexpr int kWeakestPenalty = -3, kStrongestPenalty = 4;  // powers of ten

void requireRanges(const Series& series, IndexRange train, IndexRange test) {
  const bool valid = train.first < train.last && train.last <= series.size() && test.first < test.last && test.last <= series.size() &&
                     train.size() >= kFewestRows;
  if (valid) return;
  throw std::invalid_argument("ridgeVoltage: trained on samples " + std::to_string(train.first) + " to " + std::to_string(train.last) +
                              ", tested on " + std::to_string(test.first) + " to " + std::to_string(test.last) + " of " +
                              std::to_string(series.size()) + "; expected ranges that are not empty, and 60 samples to train on");
}

VectorXd lowPass(const VectorXd& x, const VectorXd& time, double time_constant) {
  VectorXd y(x.size());
  y[0] = x[0];
  for (Index k = 1; k < x.size(); ++k) y[k] = y[k - 1] - std::expm1(-(time[k] - time[k - 1]) / time_constant) * (x[k] - y[k - 1]);
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
  for (Index k = 1; k < time.size(); ++k) charge[k] = charge[k - 1] + current[k] * (time[k] - time[k - 1]);
  return charge;
}

MatrixXd columnsOf(const VectorXd& time, const VectorXd& current, double interval) {
  const VectorXd charging = current.cwiseMax(0.0);
  const auto bent = [](const VectorXd& x, double scale) {
    return VectorXd(x.unaryExpr([scale](double value) { return std::asinh(value / scale); }));
  };
  const auto time_constants = usableTimeConstants(time, interval);
  std::vector<VectorXd> columns;
  for (const VectorXd& drive : {current, charging, bent(current, 5.0), bent(charging, 2.0)}) {
    columns.push_back(drive);
    for (const double tau : time_constants) columns.push_back(lowPass(drive, time, tau));
  }
  columns.push_back(chargeOver(time, current));
  for (const double tau : time_constants) {
    if (tau < 1.0) continue;
    const VectorXd discharged = lowPass((-current).cwiseMax(0.0), time, tau) * tau;
    for (const double scale : kRecentDischarges) {
      columns.push_back(scale / (scale + discharged.array()));
      columns.push_back(columns.back().cwiseProduct(charging));
    }
  }
  MatrixXd x(time.size(), static_cast<Index>(columns.size()));
  for (std::size_t c = 0; c < columns.size(); ++c) x.col(static_cast<Index>(c)) = columns[c];
  return x;
}

struct Rows {
  MatrixXd x;
  VectorXd y;
};

/// Rows of a range of the columns, every k-th of very many.
Rows trainingRows(const MatrixXd& x, const Series& series, IndexRange train, std::size_t first) {
  const std::size_t stride = 1 + (train.size() - 1) / kMostRows;
  const auto count = static_cast<Index>(1 + (train.size() - 1) / stride);
  Rows rows{MatrixXd(count, x.cols()), VectorXd(count)};
  for (Index n = 0; n < count; ++n) {
    const std::size_t k = train.first + static_cast<std::size_t>(n) * stride;
    rows.x.row(n) = x.row(static_cast<Index>(k - first));
    rows.y[n] = series.voltage[k];
  }
  return rows;
}

RidgeOptions options() {
  RidgeOptions options;
  options.blocks = kBlocks;
  options.of_mean = true;
  for (int power = kWeakestPenalty; power <= kStrongestPenalty; ++power) options.penalties.push_back(kPenaltyUnit * std::pow(10.0, power));
  return options;
}

}  // namespace

RidgePrediction ridgeVoltage(const Series& series, IndexRange train, IndexRange test) {
  requireRanges(series, train, test);
  const std::size_t first = std::min(train.first, test.first);
  const auto size = static_cast<Index>(std::max(train.last, test.last) - first);
  const VectorXd time = Eigen::Map<const VectorXd>(series.time.data() + first, size);
  const VectorXd current = Eigen::Map<const VectorXd>(series.current.data() + first, size);
  const MatrixXd x = columnsOf(time, current, medianInterval(series));
  const Rows rows = trainingRows(x, series, train, first);
  VectorXd left_out;
  const RidgeFit fit = fitRidge(rows.x, rows.y, options(), &left_out);
  const VectorXd voltage = fit.ofRows(x.middleRows(static_cast<Index>(test.first - first), static_cast<Index>(test.size())));

  RidgePrediction prediction;
  prediction.columns = static_cast<std::size_t>(x.cols()) + 1;
  prediction.rows = static_cast<std::size_t>(rows.x.rows());
  prediction.penalty = fit.penalty / kPenaltyUnit;
  prediction.held_out_rmse = std::sqrt((rows.y - left_out).squaredNorm() / static_cast<double>(rows.y.size()));
  prediction.voltage.assign(voltage.data(), voltage.data() + voltage.size());
  return prediction;
}

}  // namespace battery_sof
