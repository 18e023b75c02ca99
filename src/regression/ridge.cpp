#include "regression/ridge.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr double kNeverMoves = 1e-6;  // a column's deviation below it is rounding

/// Consecutive rows with their normal equations.
struct Block {
  Eigen::Index first, count;
  Eigen::MatrixXd products;  // Z'Z
  Eigen::VectorXd targets;   // Z'y
};

Block blockOf(const Eigen::MatrixXd& Z, const Eigen::VectorXd& y, Eigen::Index first,
              Eigen::Index last) {
  const auto rows = Z.middleRows(first, last - first);
  return {first, last - first, rows.transpose() * rows,
          rows.transpose() * y.segment(first, last - first)};
}

/// @param rows that the products are summed over.
Eigen::VectorXd solved(Eigen::MatrixXd products, const Eigen::VectorXd& targets, double penalty,
                       Eigen::Index rows, const RidgeOptions& options) {
  if (options.of_mean) penalty *= static_cast<double>(rows);
  products.diagonal().array() += penalty;
  products(0, 0) += penalty * (options.constant_penalty - 1.0);
  return products.ldlt().solve(targets);
}

void requireSound(const Eigen::MatrixXd& X, const Eigen::VectorXd& y, const RidgeOptions& options) {
  if (X.rows() != y.size())
    throw std::invalid_argument(format("fitRidge: %td rows for %td values", X.rows(), y.size()));
  if (X.rows() < 2L * options.blocks || options.blocks < 2)
    throw std::invalid_argument(
        format("fitRidge: %td rows for %d blocks, expected two a block", X.rows(), options.blocks));
  if (options.penalties.empty()) throw std::invalid_argument("fitRidge: no penalty is given");
}

/// Columns of mean 0 and deviation 1 behind one of ones; 0 where a column never moves. @param fit
/// takes centre and scale.
Eigen::MatrixXd standardised(const Eigen::MatrixXd& X, RidgeFit& fit) {
  fit.centre = X.colwise().mean();
  fit.scale = ((X.rowwise() - fit.centre.transpose()).array().square().colwise().mean()).sqrt();
  Eigen::MatrixXd Z(X.rows(), X.cols() + 1);
  Z.col(0).setOnes();
  for (Eigen::Index j = 0; j < X.cols(); ++j) {
    const bool moves = fit.scale[j] > kNeverMoves;
    if (!moves) fit.scale[j] = 1.0;
    Z.col(j + 1) = (X.col(j).array() - fit.centre[j]) * (moves ? 1.0 / fit.scale[j] : 0.0);
  }
  return Z;
}

/// Every block as the others predict it, under the penalty that does so best. @param fit takes the
/// penalty.
Eigen::VectorXd leftOut(const Eigen::MatrixXd& Z, const Eigen::VectorXd& y, const Block& all,
                        const RidgeOptions& options, RidgeFit& fit) {
  std::vector<Block> blocks;
  for (int b = 0; b < options.blocks; ++b)
    blocks.push_back(
        blockOf(Z, y, Z.rows() * b / options.blocks, Z.rows() * (b + 1) / options.blocks));
  double least = std::numeric_limits<double>::infinity();
  Eigen::VectorXd best;
  for (const double penalty : options.penalties) {
    Eigen::VectorXd without(y.size());
    for (const Block& block : blocks)
      without.segment(block.first, block.count) =
          Z.middleRows(block.first, block.count) * solved(all.products - block.products,
                                                          all.targets - block.targets, penalty,
                                                          y.size() - block.count, options);
    const double error = (y - without).squaredNorm();
    if (!(error < least)) continue;
    least = error;
    fit.penalty = penalty;
    best = without;
  }
  return best;
}

}  // namespace

double RidgeFit::at(const Eigen::Ref<const Eigen::VectorXd>& columns) const {
  if (empty()) return 0.0;
  Eigen::ArrayXd x = columns.array();
  if (lower.size() > 0) x = x.max(lower.array()).min(upper.array());
  return constant + (weight.array() * (x - centre.array()) / scale.array()).sum();
}

Eigen::VectorXd RidgeFit::ofColumn(Eigen::Index j,
                                   const Eigen::Ref<const Eigen::VectorXd>& values) const {
  Eigen::ArrayXd x = values.array();
  if (lower.size() > 0) x = x.max(lower[j]).min(upper[j]);
  return weight[j] / scale[j] * (x - centre[j]);
}

RidgeFit fitRidge(const Eigen::MatrixXd& X, const Eigen::VectorXd& y, const RidgeOptions& options,
                  Eigen::VectorXd* left_out) {
  requireSound(X, y, options);
  RidgeFit fit;
  const Eigen::MatrixXd Z = standardised(X, fit);
  const Block all = blockOf(Z, y, 0, Z.rows());
  const Eigen::VectorXd best = leftOut(Z, y, all, options, fit);
  double share = 1.0;
  if (options.shrunk)
    share = std::clamp(y.dot(best) / std::max(best.squaredNorm(), 1e-12), 0.0, 1.0);
  fit.gain = 1.0 - (y - share * best).squaredNorm() / std::max(y.squaredNorm(), 1e-300);
  if (left_out) *left_out = share * best;
  if (options.shrunk && !(fit.gain > 0.0)) {
    if (left_out) left_out->setZero();
    return RidgeFit();
  }
  const Eigen::VectorXd w =
      share * solved(all.products, all.targets, fit.penalty, y.size(), options);
  fit.constant = w[0];
  fit.weight = w.tail(X.cols());
  if (options.clipped) {
    fit.lower = X.colwise().minCoeff();
    fit.upper = X.colwise().maxCoeff();
  }
  return fit;
}

}  // namespace battery_sof
