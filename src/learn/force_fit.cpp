#include "battery_sof/learn/force_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

namespace battery_sof {
namespace {

constexpr int kMostColumns = 12;
constexpr double kFirstTemper = 0.05;
constexpr int kPasses = 3;
const std::array<double, kBaseDirections> kDirectionStd = {0.01, 0.01, 1.5, 0.7, 0.5, 0.2};

/// Everything a fit of rows needs. The columns, six directions and those of the table that are used, stay where they are.
struct Rows {
  const Eigen::MatrixXd& directions;
  const Eigen::MatrixXd& table;
  std::vector<Eigen::Index> used;     // columns of the table
  std::vector<Eigen::Index> counted;  // rows that are learnt from
  Eigen::VectorXd targets;            // of these
  LinearProblem problem;

  /// @return the columns times z, of every row.
  Eigen::VectorXd times(const Eigen::VectorXd& z) const {
    return directions * z.head(kBaseDirections) + free(z.tail(z.size() - kBaseDirections));
  }
  /// @return the same of the table's columns alone.
  Eigen::VectorXd free(const Eigen::VectorXd& weight) const {
    Eigen::VectorXd all = Eigen::VectorXd::Zero(table.cols());
    all(used) = weight;
    return table * all;
  }
  /// @return what z leaves of the rows that are learnt from.
  Eigen::VectorXd left(const Eigen::VectorXd& z) const { return targets - times(z)(counted); }
};

/// Sums of the counted rows, block by block: a copy of them all would be as large as the table.
void takeSums(Rows& rows) {
  constexpr std::size_t kBlock = 4096;
  const Eigen::Index known = kBaseDirections, all = known + static_cast<Eigen::Index>(rows.used.size());
  LinearProblem& problem = rows.problem;
  problem.products.setZero(all, all);
  problem.targets.setZero(all);
  for (std::size_t begin = 0; begin < rows.counted.size(); begin += kBlock) {
    const std::size_t end = std::min(rows.counted.size(), begin + kBlock);
    const std::vector<Eigen::Index> some(rows.counted.begin() + static_cast<std::ptrdiff_t>(begin),
                                         rows.counted.begin() + static_cast<std::ptrdiff_t>(end));
    Eigen::MatrixXd block(some.size(), all);
    block << rows.directions(some, Eigen::all), rows.table(some, rows.used);
    problem.products.selfadjointView<Eigen::Lower>().rankUpdate(block.transpose());
    problem.targets += block.transpose() * rows.targets.segment(static_cast<Eigen::Index>(begin), block.rows());
  }
  problem.products.triangularView<Eigen::StrictlyUpper>() = problem.products.transpose();
}

Rows rowsOf(const BaseResponse& response, const ForceTable& table, const ColumnFilter& wanted) {
  Rows rows{response.sensitivity, table.values, {}, {}, {}, {}};
  for (Eigen::Index k = 0; k < table.values.cols(); ++k)
    if (!wanted || wanted(table.columns[static_cast<std::size_t>(k)])) rows.used.push_back(k);
  for (Eigen::Index row = 0; row < response.training; ++row)
    if (response.weight[row] > 0.0) rows.counted.push_back(row);
  rows.targets = response.error(rows.counted) - response.sensitivity(rows.counted, Eigen::all) * response.expected;
  takeSums(rows);
  LinearProblem& problem = rows.problem;
  problem.square = rows.targets.squaredNorm();
  problem.rows = static_cast<double>(rows.counted.size());
  problem.known_std = Eigen::Map<const Eigen::VectorXd>(kDirectionStd.data(), kBaseDirections);
  for (const Eigen::Index k : rows.used)
    problem.group.push_back(static_cast<int>(groupOf(table.columns[static_cast<std::size_t>(k)].kind)));
  problem.groups = kForceGroups;
  return rows;
}

/// The base circuit alone, as good as it gets.
Eigen::VectorXd withoutForce(const Rows& rows) {
  const std::vector<char> none(kForceGroups, 0);
  return fitSomeGroups(rows.problem, 1.0, none).z;
}

/// RMS of a part of the force over the training rows, what the base circuit can take up of it left out.
double rmsBesideBase(const Rows& rows, const Eigen::VectorXd& z, Eigen::Index known) {
  const Eigen::VectorXd part = rows.free(z)(rows.counted);
  const Eigen::MatrixXd base = rows.directions(rows.counted, Eigen::all);
  const Eigen::VectorXd taken = rows.problem.products.topLeftCorner(known, known).ldlt().solve(base.transpose() * part);
  return std::sqrt((part - base * taken).squaredNorm() / rows.problem.rows);
}

/// Which of the free columns belong to a family, 1 each.
Eigen::VectorXd ofFamily(const Rows& rows, const ForceTable& table, Family family) {
  Eigen::VectorXd own(static_cast<Eigen::Index>(rows.used.size()));
  for (Eigen::Index k = 0; k < own.size(); ++k)
    own[k] = table.columns[static_cast<std::size_t>(rows.used[static_cast<std::size_t>(k)])].family == family ? 1.0 : 0.0;
  return own;
}

/// One factor a family that moves anything: how well its part is known along itself.
std::vector<LearnedForce::Part> partsOf(const Rows& rows, const ForceTable& table, const LinearFit& grouped,
                                        const Eigen::VectorXd& weight) {
  std::vector<LearnedForce::Part> parts;
  const Eigen::Index known = rows.problem.known(), free = weight.size();
  for (const Family family : kAllFamilies) {
    const Eigen::VectorXd own = ofFamily(rows, table, family);
    if (own.maxCoeff() <= 0.0) continue;
    const Eigen::VectorXd part = weight.cwiseProduct(own);
    const Eigen::VectorXd along = rows.problem.products.bottomRightCorner(free, free) * part;
    const double square = part.dot(along);
    const Eigen::VectorXd direction = along.cwiseProduct(own) / std::max(square, 1e-300);
    const double variance = direction.dot(grouped.covariance.block(known, known, free, free) * direction);
    parts.push_back({family, square > 0.0 ? std::min(1.0, std::sqrt(std::max(0.0, variance))) : 1.0});
  }
  return parts;
}

std::vector<FamilyWeight> familiesOf(const Rows& rows, const ForceTable& table, const SparseFit& sparse, const Eigen::VectorXd& weight) {
  std::array<double, kFamilies> gain{};
  for (const SparseStep& step : sparse.path)
    gain[static_cast<std::size_t>(table.columns[static_cast<std::size_t>(rows.used[static_cast<std::size_t>(step.column)])].family)] +=
        step.gain;
  std::vector<FamilyWeight> families;
  const Eigen::Index known = rows.problem.known();
  for (const Family family : kAllFamilies) {
    const Eigen::VectorXd own = weight.cwiseProduct(ofFamily(rows, table, family));
    if (gain[static_cast<std::size_t>(family)] > 0.0)
      families.push_back({family, gain[static_cast<std::size_t>(family)], rmsBesideBase(rows, own, known)});
  }
  std::stable_sort(families.begin(), families.end(),
                   [](const FamilyWeight& one, const FamilyWeight& other) { return one.gain > other.gain; });
  return families;
}

/// Strengths by groups, at the temper that what they leave asks for.
LinearFit groupedFit(const Rows& rows) {
  double temper = kFirstTemper;
  LinearFit grouped;
  for (int pass = 0; pass < kPasses; ++pass) {
    grouped = pass == 0 ? fitGroups(rows.problem, temper) : fitGroupsFrom(rows.problem, temper, grouped);
    temper = independentShare(rows.left(grouped.z));
  }
  return grouped;
}

/// The same by few columns.
SparseFit sparseFit(const Rows& rows) {
  double temper = kFirstTemper;
  SparseFit sparse;
  for (int pass = 0; pass < kPasses; ++pass) {
    sparse = fitSparse(rows.problem, temper, kMostColumns);
    temper = independentShare(rows.left(sparse.fit.z));
  }
  return sparse;
}

/// Gain of ln evidence over the base circuit `alone`, at the temper of what that leaves.
double gainOver(const Rows& rows, const Eigen::VectorXd& alone, const LinearFit& grouped) {
  const Eigen::VectorXd left = rows.left(alone);
  const double own = independentShare(left);
  const std::vector<char> none(kForceGroups, 0);
  return fitGroupsFrom(rows.problem, own, grouped).evidence - fitSomeGroups(rows.problem, own, none).evidence;
}

/// The force that weights z of all columns make. @return its base_change is left to the caller.
LearnedForce forceOf(const Rows& rows, const ForceTable& table, const LinearFit& grouped, const Eigen::VectorXd& z) {
  const Eigen::Index free = z.size() - rows.problem.known();
  LearnedForce force;
  for (const Eigen::Index k : rows.used) force.columns.push_back(table.columns[static_cast<std::size_t>(k)]);
  force.context = table.context;
  force.lower = table.lower(rows.used);
  force.upper = table.upper(rows.used);
  force.centre = table.centre(rows.used);
  force.scale = table.scale(rows.used);
  force.weight = z.tail(free);
  force.covariance = grouped.covariance.bottomRightCorner(free, free);
  force.parts = partsOf(rows, table, grouped, force.weight);
  return force;
}

}  // namespace

double baseDirectionStd(Eigen::Index direction) { return kDirectionStd[static_cast<std::size_t>(direction)]; }

BatteryModel withForce(const BatteryModel& model, std::shared_ptr<const LearnedForce> force) {
  std::vector<std::string> effects = model.effects();
  effects.push_back(kLearnedEffect);
  return BatteryModel(effects, std::move(force));
}

Eigen::VectorXd withFactors(const BatteryModel& with_force, const Eigen::VectorXd& parameters) {
  Eigen::VectorXd all = with_force.typicalParameters();
  all.head(parameters.size()) = parameters;
  return all;
}

ForceFit learnForce(const BaseResponse& response, const ForceTable& table, const ColumnFilter& wanted) {
  const Rows rows = rowsOf(response, table, wanted);
  const Eigen::Index known = rows.problem.known();
  const Eigen::VectorXd alone = withoutForce(rows);
  const LinearFit grouped = groupedFit(rows);
  const SparseFit sparse = sparseFit(rows);
  const Eigen::VectorXd z = 0.5 * (grouped.z + sparse.fit.z);
  ForceFit fit;
  fit.gain = gainOver(rows, alone, grouped);
  fit.force = forceOf(rows, table, grouped, z);
  fit.force.base_change = response.expected + z.head(kBaseDirections);
  fit.families = familiesOf(rows, table, sparse, fit.force.weight);
  fit.noise = std::sqrt(rows.left(z).squaredNorm() / rows.problem.rows);
  fit.rms = rmsBesideBase(rows, fit.force.weight, known);
  const Eigen::VectorXd from = response.sensitivity * response.expected;
  fit.predicted = from + rows.times(z);
  fit.base = from + response.sensitivity * alone.head(known);
  return fit;
}

LeftOutErrors leftOutErrors(const BaseResponse& response, const ForceTable& table, int blocks, const ColumnFilter& wanted) {
  double base = 0.0, force = 0.0, counted = 0.0;
  for (int block = 0; block < blocks; ++block) {
    const Eigen::Index begin = response.training * block / blocks, end = response.training * (block + 1) / blocks;
    BaseResponse rest = response;
    rest.weight.segment(begin, end - begin).setZero();
    // What the first state was shows in the first block alone: without it nothing is known of it.
    if (begin == 0) rest.sensitivity.col(kBaseDirections - 1).setZero();
    const ForceFit fit = learnForce(rest, table, wanted);
    for (Eigen::Index row = begin; row < end; ++row) {
      if (!(response.weight[row] > 0.0)) continue;
      base += std::pow(response.error[row] - fit.base[row], 2);
      force += std::pow(response.error[row] - fit.predicted[row], 2);
      counted += 1.0;
    }
  }
  counted = std::max(counted, 1.0);
  return {std::sqrt(base / counted), std::sqrt(force / counted)};
}

bool isTimeless(const ForceColumn& column) { return groupOf(column.kind) != ForceGroup::kTime; }

}  // namespace battery_sof
