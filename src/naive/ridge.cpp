#include "battery_sof/naive/ridge.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

namespace battery_sof {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::array kTimeConstants = {0.1,  0.3,   1.0,   3.0,    10.0,
                                       30.0, 100.0, 300.0, 1000.0, 3000.0};  // [s]
constexpr std::array kRecentDischarges = {5.0, 50.0, 500.0};                 // [As]
constexpr std::size_t kFewestRows = 60;
constexpr std::size_t kMostRows = 20000;
constexpr int kBlocks = 6;
constexpr double kPenaltyUnit = 1e-2;
constexpr int kWeakestPenalty = -3, kStrongestPenalty = 4;  // powers of ten
constexpr double kNoSpread = 1e-12;

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
  MatrixXd x(time.size(), static_cast<Index>(columns.size()) + 1);
  x.col(0).setOnes();
  for (std::size_t c = 0; c < columns.size(); ++c) x.col(static_cast<Index>(c) + 1) = columns[c];
  return x;
}

struct Rows {
  MatrixXd x;
  VectorXd y;
};

/// Normal equations of some rows, added and taken off as blocks are held out.
struct NormalEquations {
  MatrixXd squares;
  VectorXd products;
  double count = 0.0;

  static NormalEquations of(const MatrixXd& x, const VectorXd& y) {
    NormalEquations equations;
    equations.squares = MatrixXd::Zero(x.cols(), x.cols());
    equations.squares.selfadjointView<Eigen::Lower>().rankUpdate(x.transpose());
    equations.products = x.transpose() * y;
    equations.count = static_cast<double>(x.rows());
    return equations;
  }

  NormalEquations without(const NormalEquations& block) const {
    return {squares - block.squares, products - block.products, count - block.count};
  }

  VectorXd solve(double penalty) const {
    MatrixXd damped = squares / count;
    damped.diagonal().tail(damped.rows() - 1).array() += kPenaltyUnit * penalty;
    return damped.selfadjointView<Eigen::Lower>().ldlt().solve(products / count);
  }
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

/// Mean 0 and standard deviation 1 over the training rows, the constant excepted.
void standardise(Rows& rows, MatrixXd& x) {
  for (Index c = 1; c < x.cols(); ++c) {
    const double mean = rows.x.col(c).mean();
    const double std = std::sqrt((rows.x.col(c).array() - mean).square().mean()) + kNoSpread;
    rows.x.col(c) = (rows.x.col(c).array() - mean) / std;
    x.col(c) = (x.col(c).array() - mean) / std;
  }
}

struct Block {
  Index first, size;
  NormalEquations equations;
};

std::vector<Block> blocksOf(const Rows& rows) {
  std::vector<Block> blocks;
  for (Index b = 0; b < kBlocks; ++b) {
    const Index first = b * rows.x.rows() / kBlocks, last = (b + 1) * rows.x.rows() / kBlocks;
    blocks.push_back({first, last - first,
                      NormalEquations::of(rows.x.middleRows(first, last - first),
                                          rows.y.segment(first, last - first))});
  }
  return blocks;
}

double heldOutSquares(const Rows& rows, const NormalEquations& all,
                      const std::vector<Block>& blocks, double penalty) {
  double squares = 0.0;
  for (const Block& block : blocks) {
    const VectorXd weights = all.without(block.equations).solve(penalty);
    squares += (rows.x.middleRows(block.first, block.size) * weights -
                rows.y.segment(block.first, block.size))
                   .squaredNorm();
  }
  return squares;
}

}  // namespace

RidgePrediction ridgeVoltage(const Series& series, IndexRange train, IndexRange test) {
  requireRanges(series, train, test);
  const std::size_t first = std::min(train.first, test.first);
  const auto size = static_cast<Index>(std::max(train.last, test.last) - first);
  const VectorXd time = Eigen::Map<const VectorXd>(series.time.data() + first, size);
  const VectorXd current = Eigen::Map<const VectorXd>(series.current.data() + first, size);
  MatrixXd x = columnsOf(time, current, medianInterval(series));
  Rows rows = trainingRows(x, series, train, first);
  standardise(rows, x);
  const auto blocks = blocksOf(rows);
  const auto all = NormalEquations::of(rows.x, rows.y);

  RidgePrediction prediction;
  prediction.columns = static_cast<std::size_t>(x.cols());
  prediction.rows = static_cast<std::size_t>(rows.x.rows());
  double least = 0.0;
  for (int power = kWeakestPenalty; power <= kStrongestPenalty; ++power) {
    const double penalty = std::pow(10.0, power);
    const double squares = heldOutSquares(rows, all, blocks, penalty);
    if (power > kWeakestPenalty && !(squares < least)) continue;
    least = squares;
    prediction.penalty = penalty;
  }
  prediction.held_out_rmse = std::sqrt(least / static_cast<double>(rows.y.size()));
  const VectorXd voltage =
      x.middleRows(static_cast<Index>(test.first - first), static_cast<Index>(test.size())) *
      all.solve(prediction.penalty);
  prediction.voltage.assign(voltage.data(), voltage.data() + voltage.size());
  return prediction;
}

}  // namespace battery_sof
