#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "explanation_fits.hpp"

// Fits to some of the rows: without a block, and to halves.
namespace battery_sof {
namespace {

constexpr std::size_t kLeftOutBlocks = 8;

/// A problem's sums over some of its rows.
LinearProblem ofRows(const ExplanationSums& sums, IndexRange rows) {
  const Eigen::MatrixXd columns = sums.columns.ofRows(rows);
  const Eigen::VectorXd targets = sums.targets(rowsOf(rows));
  LinearProblem some = sums.problem;
  some.products = columns.transpose() * columns;
  some.targets = columns.transpose() * targets;
  some.square = targets.squaredNorm();
  some.rows = static_cast<double>(rows.size());
  return some;
}

/// A problem's sums with other rows' times a factor.
LinearProblem with(LinearProblem problem, double factor, const LinearProblem& rows) {
  problem.products += factor * rows.products;
  problem.targets += factor * rows.targets;
  problem.square += factor * rows.square;
  problem.rows += factor * rows.rows;
  return problem;
}

LinearProblem without(const ExplanationSums& sums, IndexRange rows) {
  return with(sums.problem, -1.0, ofRows(sums, rows));
}

/// Rows of some of the blocks that are left out.
IndexRange blocks(const ExplanationSums& sums, std::size_t first, std::size_t last) {
  const std::size_t rows = sums.targets.size();
  return {rows * first / kLeftOutBlocks, rows * last / kLeftOutBlocks};
}

}  // namespace

std::vector<LinearProblem> ExplanationFits::halfSamples(const ExplanationSums& sums) const {
  std::vector<LinearProblem> quarters, halves;
  for (std::size_t block = 0; block < kLeftOutBlocks; block += 2) {
    const LinearProblem quarter = ofRows(sums, blocks(sums, block, block + 2));
    for (const LinearProblem& other : quarters) halves.push_back(with(quarter, 1.0, other));
    quarters.push_back(quarter);
  }
  return halves;
}

std::vector<double> ExplanationFits::halfSampleGains(const ExplanationState& more,
                                                     const ExplanationState& less) const {
  const std::vector<LinearProblem> of_more = halfSamples(sumsOf(more, false)),
                                   of_less = halfSamples(sumsOf(less, false));
  std::vector<double> gains;
  for (std::size_t half = 0; half < of_more.size(); ++half)
    gains.push_back(fitOf(of_more[half]).evidence - fitOf(of_less[half]).evidence);
  return gains;
}

LinearProblem ExplanationFits::restricted(const LinearProblem& all,
                                          const std::set<Mechanism>& mechanisms) const {
  LinearProblem some = all;
  some.group.clear();
  std::vector<Eigen::Index> used(all.known());
  std::iota(used.begin(), used.end(), Eigen::Index{0});
  for (std::size_t k = 0; k < all.group.size(); ++k) {
    if (k < table_.regressors.size() && !mechanisms.count(table_.regressors[k].mechanism)) continue;
    used.push_back(all.known() + static_cast<Eigen::Index>(k));
    some.group.push_back(all.group[k]);
  }
  some.products = all.products(used, used);
  some.targets = all.targets(used);
  return some;
}

double ExplanationFits::leastGain(const ExplanationState& more,
                                  const ExplanationState& less) const {
  double least = std::numeric_limits<double>::infinity();
  const ExplanationSums of_more = sumsOf(more, false), of_less = sumsOf(less, false);
  for (std::size_t block = 0; block + 2 <= kLeftOutBlocks; ++block) {
    const IndexRange out = blocks(of_more, block, block + 2);
    least = std::min(least,
                     fitOf(without(of_more, out)).evidence - fitOf(without(of_less, out)).evidence);
  }
  return least;
}

}  // namespace battery_sof
