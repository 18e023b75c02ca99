#include "regression/discrepancy_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

namespace battery_sof {
namespace {

constexpr int kMaxRegressors = 12;
constexpr double kFirstSampleFraction = 0.05;
constexpr int kPasses = 3;
const std::array<double, kBaseDirections> kDirectionStd = {0.01, 0.01, 1.5, 0.7, 0.5, 0.2};

/// Everything a fit of rows needs. The columns, six directions and those of the table that are
/// used, stay where they are.
struct Rows {
  const Eigen::MatrixXd& directions;
  const Eigen::MatrixXd& table;
  std::vector<Eigen::Index> used;     // regressors of the table
  std::vector<Mechanism> mechanism;   // of these
  std::vector<Eigen::Index> counted;  // rows that are estimated from
  Eigen::VectorXd targets;            // of these
  LinearProblem problem;

  /// @return the columns times z, of every row.
  Eigen::VectorXd times(const Eigen::VectorXd& z) const {
    return directions * z.head(kBaseDirections) + free(z.tail(z.size() - kBaseDirections));
  }
  /// @return the same of the table's regressors alone.
  Eigen::VectorXd free(const Eigen::VectorXd& weight) const {
    Eigen::VectorXd all = Eigen::VectorXd::Zero(table.cols());
    all(used) = weight;
    return table * all;
  }
  /// @return what z leaves of the rows that are estimated from.
  Eigen::VectorXd left(const Eigen::VectorXd& z) const { return targets - times(z)(counted); }
};

/// Sums of the counted rows, block by block: a copy of them all would be as large as the table.
void takeSums(Rows& rows) {
  constexpr std::size_t kBlock = 4096;
  const Eigen::Index known = kBaseDirections,
                     all = known + static_cast<Eigen::Index>(rows.used.size());
  LinearProblem& problem = rows.problem;
  problem.products.setZero(all, all);
  problem.targets.setZero(all);
  for (std::size_t begin = 0; begin < rows.counted.size(); begin += kBlock) {
    const std::size_t end = std::min(rows.counted.size(), begin + kBlock);
    const std::vector<Eigen::Index> some(rows.counted.begin() + begin, rows.counted.begin() + end);
    Eigen::MatrixXd block(some.size(), all);
    block << rows.directions(some, Eigen::all), rows.table(some, rows.used);
    problem.products.selfadjointView<Eigen::Lower>().rankUpdate(block.transpose());
    problem.targets += block.transpose() * rows.targets.segment(begin, block.rows());
  }
  problem.products.triangularView<Eigen::StrictlyUpper>() = problem.products.transpose();
}

Rows rowsOf(const Linearization& response, const DesignMatrix& table,
            const RegressorFilter& wanted) {
  Rows rows{response.sensitivity, table.values, {}, {}, {}, {}, {}};
  for (Eigen::Index k = 0; k < table.values.cols(); ++k) {
    const Regressor& regressor = table.regressors[k];
    if (wanted && !wanted(regressor)) continue;
    rows.used.push_back(k);
    rows.mechanism.push_back(regressor.mechanism);
    rows.problem.group.push_back(static_cast<int>(groupOf(regressor.kind)));
  }
  for (Eigen::Index row = 0; row < response.training; ++row)
    if (response.weight[row] > 0.0) rows.counted.push_back(row);
  rows.targets = response.error(rows.counted) -
                 response.sensitivity(rows.counted, Eigen::all) * response.expected;
  takeSums(rows);
  LinearProblem& problem = rows.problem;
  problem.square = rows.targets.squaredNorm();
  problem.rows = static_cast<double>(rows.counted.size());
  problem.known_std = Eigen::Map<const Eigen::VectorXd>(kDirectionStd.data(), kBaseDirections);
  problem.groups = kRegressorGroups;
  return rows;
}

/// The base circuit alone.
LinearFit withoutDiscrepancy(const Rows& rows, double effective_sample_fraction) {
  const std::vector<char> none(kRegressorGroups, 0);
  return fitSomeGroups(rows.problem, effective_sample_fraction, none);
}

/// RMS of a part of the discrepancy over the training rows, less what the base circuit takes up of
/// it.
double rmsBeyondBase(const Rows& rows, const Eigen::VectorXd& z, Eigen::Index known) {
  const Eigen::VectorXd part = rows.free(z)(rows.counted);
  const Eigen::MatrixXd base = rows.directions(rows.counted, Eigen::all);
  const Eigen::VectorXd taken =
      rows.problem.products.topLeftCorner(known, known).ldlt().solve(base.transpose() * part);
  return std::sqrt((part - base * taken).squaredNorm() / rows.problem.rows);
}

/// Which of the free regressors belong to a mechanism, 1 each.
Eigen::VectorXd ofMechanism(const Rows& rows, Mechanism mechanism) {
  Eigen::VectorXd own(rows.used.size());
  for (Eigen::Index k = 0; k < own.size(); ++k) own[k] = rows.mechanism[k] == mechanism ? 1.0 : 0.0;
  return own;
}

/// One factor a mechanism that moves anything: how well its part is known along itself.
std::vector<DiscrepancyModel::Part> partsOf(const Rows& rows, const Eigen::MatrixXd& covariance,
                                            const Eigen::VectorXd& weight) {
  std::vector<DiscrepancyModel::Part> parts;
  const Eigen::Index free = weight.size();
  for (const Mechanism mechanism : kAllMechanisms) {
    const Eigen::VectorXd own = ofMechanism(rows, mechanism);
    if (own.maxCoeff() <= 0.0) continue;
    const Eigen::VectorXd part = weight.cwiseProduct(own);
    const Eigen::VectorXd along = rows.problem.products.bottomRightCorner(free, free) * part;
    const double square = part.dot(along);
    const Eigen::VectorXd direction = along.cwiseProduct(own) / std::max(square, 1e-300);
    const double variance = direction.dot(covariance * direction);
    parts.push_back(
        {mechanism, square > 0.0 ? std::min(1.0, std::sqrt(std::max(0.0, variance))) : 1.0});
  }
  return parts;
}

std::vector<MechanismWeight> mechanismsOf(const Rows& rows, const SparseFit& sparse,
                                          const Eigen::VectorXd& weight) {
  std::array<double, kMechanisms> gain{};
  for (const SparseStep& step : sparse.path)
    gain[static_cast<std::size_t>(rows.mechanism[step.column])] += step.gain;
  std::vector<MechanismWeight> mechanisms;
  const Eigen::Index known = rows.problem.known();
  for (const Mechanism mechanism : kAllMechanisms) {
    const Eigen::VectorXd own = weight.cwiseProduct(ofMechanism(rows, mechanism));
    if (gain[static_cast<std::size_t>(mechanism)] > 0.0)
      mechanisms.push_back(
          {mechanism, gain[static_cast<std::size_t>(mechanism)], rmsBeyondBase(rows, own, known)});
  }
  std::stable_sort(mechanisms.begin(), mechanisms.end(),
                   [](const MechanismWeight& one, const MechanismWeight& other) {
                     return one.gain > other.gain;
                   });
  return mechanisms;
}

/// Strengths by groups, at the effective sample fraction of their residual.
struct GroupedFit {
  LinearFit fit;
  double effective_sample_fraction;
};

GroupedFit groupedFit(const Rows& rows) {
  GroupedFit grouped{fitGroups(rows.problem, kFirstSampleFraction), kFirstSampleFraction};
  for (int pass = 1; pass < kPasses; ++pass) {
    grouped.effective_sample_fraction = independentShare(rows.left(grouped.fit.z));
    grouped.fit = fitGroupsFrom(rows.problem, grouped.effective_sample_fraction, grouped.fit);
  }
  return grouped;
}

/// The same by few regressors.
SparseFit sparseFit(const Rows& rows) {
  double effective_sample_fraction = kFirstSampleFraction;
  SparseFit sparse;
  for (int pass = 0; pass < kPasses; ++pass) {
    sparse = fitSparse(rows.problem, effective_sample_fraction, kMaxRegressors);
    effective_sample_fraction = independentShare(rows.left(sparse.fit.z));
  }
  return sparse;
}

/// Gain of ln evidence over the base circuit `alone`, at the sample fraction of its residual.
double gainOver(const Rows& rows, const Eigen::VectorXd& alone, const LinearFit& grouped) {
  const double own = independentShare(rows.left(alone));
  return fitGroupsFrom(rows.problem, own, grouped).evidence -
         withoutDiscrepancy(rows, own).evidence;
}

/// The discrepancy with weights z of all regressors. @return its base_change is for the caller.
DiscrepancyModel discrepancyOf(const Rows& rows, const DesignMatrix& table,
                               const GroupedFit& grouped, const Eigen::VectorXd& z) {
  const Eigen::Index free = z.size() - rows.problem.known();
  DiscrepancyModel discrepancy;
  for (const Eigen::Index k : rows.used) discrepancy.regressors.push_back(table.regressors[k]);
  discrepancy.context = table.context;
  discrepancy.lower = table.lower(rows.used);
  discrepancy.upper = table.upper(rows.used);
  discrepancy.centre = table.centre(rows.used);
  discrepancy.scale = table.scale(rows.used);
  discrepancy.weight = z.tail(free);
  discrepancy.covariance =
      covarianceOf(rows.problem, grouped.effective_sample_fraction, grouped.fit)
          .bottomRightCorner(free, free);
  discrepancy.parts = partsOf(rows, discrepancy.covariance, discrepancy.weight);
  return discrepancy;
}

}  // namespace

double baseDirectionStd(Eigen::Index direction) { return kDirectionStd[direction]; }

BatteryModel withDiscrepancy(const BatteryModel& model,
                             std::shared_ptr<const DiscrepancyModel> discrepancy) {
  std::vector<std::string> effects = model.effects();
  effects.push_back(kDiscrepancyEffect);
  return BatteryModel(effects, std::move(discrepancy));
}

Eigen::VectorXd withFactors(const BatteryModel& with_discrepancy,
                            const Eigen::VectorXd& parameters) {
  Eigen::VectorXd all = with_discrepancy.typicalParameters();
  all.head(parameters.size()) = parameters;
  return all;
}

DiscrepancyFit fitDiscrepancy(const Linearization& response, const DesignMatrix& table,
                              const RegressorFilter& wanted) {
  const Rows rows = rowsOf(response, table, wanted);
  const Eigen::Index known = rows.problem.known();
  const Eigen::VectorXd alone = withoutDiscrepancy(rows, 1.0).z;
  const GroupedFit grouped = groupedFit(rows);
  const SparseFit sparse = sparseFit(rows);
  const Eigen::VectorXd z = 0.5 * (grouped.fit.z + sparse.fit.z);
  DiscrepancyFit fit;
  fit.gain = gainOver(rows, alone, grouped.fit);
  fit.discrepancy = discrepancyOf(rows, table, grouped, z);
  fit.discrepancy.base_change = response.expected + z.head(kBaseDirections);
  fit.mechanisms = mechanismsOf(rows, sparse, fit.discrepancy.weight);
  fit.noise = std::sqrt(rows.left(z).squaredNorm() / rows.problem.rows);
  fit.rms = rmsBeyondBase(rows, fit.discrepancy.weight, known);
  const Eigen::VectorXd from = response.sensitivity * response.expected;
  fit.predicted = from + rows.times(z);
  fit.base = from + response.sensitivity * alone.head(known);
  return fit;
}

LeftOutErrors leftOutErrors(const Linearization& response, const DesignMatrix& table, int blocks,
                            const RegressorFilter& wanted) {
  double base = 0.0, discrepancy = 0.0, in_sample = 0.0, counted = 0.0;
  for (int block = 0; block < blocks; ++block) {
    const Eigen::Index begin = response.training * block / blocks,
                       end = response.training * (block + 1) / blocks;
    Linearization rest = response;
    rest.weight.segment(begin, end - begin).setZero();
    // What the first state was shows in the first block alone: without it nothing is known of it.
    if (begin == 0) rest.sensitivity.col(kBaseDirections - 1).setZero();
    const DiscrepancyFit fit = fitDiscrepancy(rest, table, wanted);
    for (Eigen::Index row = begin; row < end; ++row) {
      if (!(response.weight[row] > 0.0)) continue;
      base += std::pow(response.error[row] - fit.base[row], 2);
      discrepancy += std::pow(response.error[row] - fit.predicted[row], 2);
      in_sample += std::pow(response.error[row], 2);
      counted += 1.0;
    }
  }
  counted = std::max(counted, 1.0);
  return {std::sqrt(base / counted), std::sqrt(discrepancy / counted),
          std::sqrt(in_sample / counted)};
}

bool isTimeless(const Regressor& regressor) {
  return groupOf(regressor.kind) != RegressorGroup::kTime;
}

}  // namespace battery_sof
