#include "battery_sof/learn/force_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>


namespace battery_sof {
namespace {

constexpr double kFast = 0.06;        // [s]; sampled faster, samples are averaged
constexpr double kRow = 0.1;          // [s]
constexpr double kFlat = 1e-9;        // [1], of a column's range: it does not move
constexpr double kTimesNear = 0.9;    // quantile of the overpotential above which side reactions are looked for
constexpr int kMostColumns = 12;
constexpr double kLongestAnswer = 43200.0;  // [s]; a recording with a gap of years would ask for years
constexpr double kFirstTemper = 0.05;
constexpr int kPasses = 3;
const std::array<double, kBaseDirections> kDirectionStd = {0.01, 0.01, 1.5, 0.7, 0.5, 0.2};

double medianDuration(const Drive& drive) {
  std::vector<double> durations;
  for (std::size_t n = 1; n < drive.samples.size(); ++n) durations.push_back(drive.samples[n].step.duration);
  if (durations.empty()) return 1.0;
  const auto middle = durations.begin() + static_cast<std::ptrdiff_t>(durations.size() / 2);
  std::nth_element(durations.begin(), middle, durations.end());
  return std::max(*middle, 1e-6);
}

std::size_t samplesPerRow(const Drive& drive) {
  const double interval = medianDuration(drive);
  return interval < kFast ? static_cast<std::size_t>(std::max(1.0, std::round(kRow / interval))) : 1;
}

/// Directions as columns of seeds: resistances, u_dc and u_c2 themselves, c2 and beta by their logarithms.
Eigen::MatrixXd directionSeeds(const ModelPoint& at) {
  Eigen::MatrixXd seeds = Eigen::MatrixXd::Zero(at.parameters.size() + at.state.size(), kBaseDirections);
  for (Eigen::Index k = 0; k < kBaseRows; ++k) seeds(k, k) = k == kRowC2 || k == kRowBeta ? at.parameters[k] : 1.0;
  seeds(at.parameters.size(), kBaseDirections - 1) = 1.0;
  return seeds;
}

/// Table I's magnitudes from a base circuit; u_dc and the first u_c2 are the circuit's own.
Eigen::VectorXd expectedFrom(const Eigen::VectorXd& parameters) {
  const std::array<ParameterInfo, 4>& known = tableOne();
  Eigen::VectorXd expected = Eigen::VectorXd::Zero(kBaseDirections);
  for (Eigen::Index k = 0; k < 2; ++k) expected[k] = known[static_cast<std::size_t>(k)].magnitude - parameters[k];
  for (Eigen::Index k = 2; k < 4; ++k) expected[k] = std::log(known[static_cast<std::size_t>(k)].magnitude / parameters[k]);
  return expected;
}

/// How u_c2 goes on from one sample to the next with small changes: A of what it was, B of the current [1], [Ohm].
struct Slope {
  double of_state, of_current;
};

Slope slopeOf(const BaseParameters& parameters, double overpotential, double duration) {
  const double half = 0.5 * parameters.beta * std::clamp(overpotential, -1.0, 1.0);
  const double conductance = parameters.i0 * parameters.beta * std::cosh(std::clamp(half, -30.0, 30.0));
  const double of_state = std::exp(-duration * conductance / parameters.c2);
  return {of_state, (1.0 - of_state) / conductance};
}

class Responder {
 public:
  Responder(const BatteryModel& model, const ModelPoint& base, const Drive& drive, std::size_t training)
      : drive_(drive), parameters_(baseParameters(base.parameters)), per_row_(samplesPerRow(drive)),
        simulation_(model, base, directionSeeds(base)) {
    const auto rows = static_cast<Eigen::Index>(drive.samples.size() / per_row_);
    out_.time = out_.error = out_.weight = out_.yielding = out_.resistance = Eigen::VectorXd::Zero(rows);
    out_.persistence = Eigen::VectorXd::Ones(rows);
    out_.sensitivity = Eigen::MatrixXd::Zero(rows, kBaseDirections);
    out_.voltage_drives.assign(static_cast<std::size_t>(rows), 0);
    out_.training = static_cast<Eigen::Index>(training / per_row_);
    for (std::size_t row = 0; row <= static_cast<std::size_t>(rows); ++row) out_.first.push_back(row * per_row_);
    out_.expected = expectedFrom(base.parameters);
    out_.overpotential.reserve(drive.samples.size());
  }

  BaseResponse run() {
    for (Eigen::Index row = 0; row < out_.time.size(); ++row) {
      const auto begin = out_.first[static_cast<std::size_t>(row)], end = out_.first[static_cast<std::size_t>(row) + 1];
      double measured = 0.0;
      for (std::size_t n = begin; n < end; ++n) measured += take(row, drive_.samples[n]);
      out_.time[row] /= static_cast<double>(end - begin);
      if (!(measured > 0.0)) continue;
      out_.error[row] /= measured;
      out_.sensitivity.row(row) /= measured;
      out_.weight[row] = 1.0;
    }
    return std::move(out_);
  }

 private:
  /// @return 1 for a measurement.
  double take(Eigen::Index row, const DriveSample& sample) {
    const double error = simulation_.follow(sample);
    const double overpotential = simulation_.state()[0];
    out_.overpotential.push_back(overpotential);
    out_.time[row] += sample.step.time;
    const Slope slope = slopeOf(parameters_, overpotential, sample.step.duration);
    out_.persistence[row] *= slope.of_state;
    if (sample.voltage_drives) {
      const double resistance = ohmicResistance(parameters_, sample.step.current) + slope.of_current;
      out_.voltage_drives[static_cast<std::size_t>(row)] = 1;
      out_.resistance[row] = resistance;
      out_.yielding[row] = slope.of_current / resistance;
      if (!(sample.count > 0.0) || sample.step.duration <= 0.0) return 0.0;
      out_.error[row] -= resistance * error;
      out_.sensitivity.row(row) += resistance * simulation_.currentErrorDerivatives().transpose();
      return 1.0;
    }
    if (!(sample.count > 0.0)) return 0.0;
    out_.error[row] += error;
    out_.sensitivity.row(row) += simulation_.voltageDerivatives().transpose();
    return 1.0;
  }

  const Drive& drive_;
  BaseParameters parameters_;
  std::size_t per_row_;
  Simulation simulation_;
  BaseResponse out_;
};

/// Context for columns: how high the overpotential goes, how fast and how long the drive is.
ForceContext contextOf(const Drive& drive, const BaseResponse& response, double beta) {
  ForceContext context;
  context.interval = medianDuration(drive);
  const std::size_t training = response.first[static_cast<std::size_t>(response.training)];
  context.span = std::max(1.0, drive.samples[std::max<std::size_t>(training, 1) - 1].step.time - drive.first_time);
  context.beta = beta;
  std::vector<double> u(response.overpotential.begin(), response.overpotential.begin() + static_cast<std::ptrdiff_t>(training));
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

/// Means of a memory's columns over the rows.
Eigen::MatrixXd rawColumns(const Drive& drive, const BaseResponse& response, ForceMemory& memory) {
  const auto columns = static_cast<Eigen::Index>(memory.columns().size());
  Eigen::MatrixXd values = Eigen::MatrixXd::Zero(columns, response.time.size());  // a column a row: contiguous
  Eigen::VectorXd now(columns);
  for (Eigen::Index row = 0; row < response.time.size(); ++row) {
    const auto begin = response.first[static_cast<std::size_t>(row)], end = response.first[static_cast<std::size_t>(row) + 1];
    for (std::size_t n = begin; n < end; ++n) {
      const DriveStep& step = drive.samples[n].step;
      memory.advance({step.duration, step.current, step.held, step.gap, response.overpotential[n], step.time - drive.first_time}, now);
      values.col(row) += now;
    }
    values.col(row) /= static_cast<double>(end - begin);
  }
  return values.transpose();
}

template <typename T>
std::vector<T> kept(const std::vector<T>& all, const std::vector<Eigen::Index>& which) {
  std::vector<T> some;
  for (const Eigen::Index k : which) some.push_back(all[static_cast<std::size_t>(k)]);
  return some;
}

/// Everything a fit of rows needs, the rows that do not count left out.
struct Rows {
  Eigen::MatrixXd columns;  // all rows: six directions, the table's
  Eigen::MatrixXd training; // those of them that are learnt from
  Eigen::VectorXd targets;
  LinearProblem problem;
  std::vector<Eigen::Index> used;  // columns of the table
};

Rows rowsOf(const BaseResponse& response, const ForceTable& table, const ColumnFilter& wanted) {
  Rows rows;
  for (Eigen::Index k = 0; k < table.values.cols(); ++k)
    if (!wanted || wanted(table.columns[static_cast<std::size_t>(k)])) rows.used.push_back(k);
  const Eigen::Index known = kBaseDirections, free = static_cast<Eigen::Index>(rows.used.size());
  rows.columns.resize(response.error.size(), known + free);
  rows.columns.leftCols(kBaseDirections) = response.sensitivity;
  rows.columns.rightCols(free) = table.values(Eigen::all, rows.used);
  std::vector<Eigen::Index> counted;
  for (Eigen::Index row = 0; row < response.training; ++row)
    if (response.weight[row] > 0.0) counted.push_back(row);
  rows.training = rows.columns(counted, Eigen::all);
  rows.targets = response.error(counted) - response.sensitivity(counted, Eigen::all) * response.expected;
  LinearProblem& problem = rows.problem;
  problem.products = rows.training.transpose() * rows.training;
  problem.targets = rows.training.transpose() * rows.targets;
  problem.square = rows.targets.squaredNorm();
  problem.rows = static_cast<double>(counted.size());
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
  const Eigen::VectorXd part = rows.training.rightCols(z.size()) * z;
  const auto base = rows.training.leftCols(known);
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
std::vector<LearnedForce::Part> partsOf(const Rows& rows, const ForceTable& table, const LinearFit& grouped, const Eigen::VectorXd& weight) {
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
    gain[static_cast<std::size_t>(table.columns[static_cast<std::size_t>(rows.used[static_cast<std::size_t>(step.column)])].family)] += step.gain;
  std::vector<FamilyWeight> families;
  const Eigen::Index known = rows.problem.known();
  for (const Family family : kAllFamilies) {
    const Eigen::VectorXd own = weight.cwiseProduct(ofFamily(rows, table, family));
    if (gain[static_cast<std::size_t>(family)] > 0.0)
      families.push_back({family, gain[static_cast<std::size_t>(family)], rmsBesideBase(rows, own, known)});
  }
  std::stable_sort(families.begin(), families.end(), [](const FamilyWeight& one, const FamilyWeight& other) { return one.gain > other.gain; });
  return families;
}

}  // namespace

double baseDirectionStd(Eigen::Index direction) { return kDirectionStd[static_cast<std::size_t>(direction)]; }

BaseResponse baseResponse(const BatteryModel& model, const ModelPoint& start, const Drive& drive, std::size_t training) {
  return Responder(model, start, drive, training).run();
}

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

void takeForceDirections(BaseResponse& response, const BatteryModel& model, const ModelPoint& start, const Drive& drive) {
  for (const Eigen::Index direction : {Eigen::Index{kRowC2}, Eigen::Index{kRowBeta}, kBaseDirections - 1}) {
    auto force = std::make_shared<LearnedForce>();
    force->context.span = 1.0;
    force->base_change = Eigen::VectorXd::Unit(kBaseDirections, direction);
    Simulation alone(model, start), moved(withForce(model, force), start);
    for (Eigen::Index row = 0; row < response.time.size(); ++row) {
      const auto begin = response.first[static_cast<std::size_t>(row)], end = response.first[static_cast<std::size_t>(row) + 1];
      double sum = 0.0, counted = 0.0;
      for (std::size_t n = begin; n < end; ++n) {
        const DriveSample& sample = drive.samples[n];
        alone.advance(sample.step);
        moved.advance(sample.step);
        if (!(sample.count > 0.0)) continue;
        sum += moved.voltage() - alone.voltage();
        counted += 1.0;
      }
      if (counted > 0.0) response.sensitivity(row, direction) = sum / counted;
    }
  }
}

Eigen::VectorXd answered(const BaseResponse& response, const Eigen::VectorXd& force) {
  Eigen::VectorXd answer = force;
  double moved = 0.0;  // d [V]
  for (Eigen::Index row = 0; row < force.size(); ++row) {
    answer[row] += response.persistence[row] * moved;
    moved = response.persistence[row] * moved - response.yielding[row] * answer[row];
  }
  return answer;
}

ForceTable forceTable(const Drive& drive, const BaseResponse& response, double beta) {
  ForceTable table;
  table.context = contextOf(drive, response, beta);
  ForceMemory memory(forceLibrary(table.context), table.context);
  Eigen::MatrixXd values = rawColumns(drive, response, memory);
  const auto training = values.topRows(response.training);
  std::vector<Eigen::Index> moving;
  const Eigen::VectorXd low = training.colwise().minCoeff(), high = training.colwise().maxCoeff();
  Eigen::VectorXd centre = training.colwise().mean();
  Eigen::VectorXd scale = (training.rowwise() - centre.transpose()).colwise().norm() / std::sqrt(static_cast<double>(response.training));
  for (Eigen::Index k = 0; k < values.cols(); ++k)
    if (scale[k] > kFlat * (1.0 + std::max(std::abs(low[k]), std::abs(high[k])))) moving.push_back(k);
  table.columns = kept(memory.columns(), moving);
  table.lower = low(moving);
  table.upper = high(moving);
  table.centre = centre(moving);
  table.scale = scale(moving);
  table.values.resize(values.rows(), static_cast<Eigen::Index>(moving.size()));
  for (Eigen::Index j = 0; j < table.values.cols(); ++j) {
    Eigen::ArrayXd x = values.col(moving[static_cast<std::size_t>(j)]).array();
    if (!isUnbounded(table.columns[static_cast<std::size_t>(j)].kind)) x = x.max(table.lower[j]).min(table.upper[j]);
    table.values.col(j) = answered(response, ((x - table.centre[j]) / table.scale[j]).matrix());
  }
  return table;
}

ForceFit learnForce(const BaseResponse& response, const ForceTable& table, const ColumnFilter& wanted) {
  const Rows rows = rowsOf(response, table, wanted);
  const Eigen::Index known = rows.problem.known(), free = rows.problem.products.cols() - known;
  const Eigen::VectorXd alone = withoutForce(rows);
  const Eigen::VectorXd left = rows.targets - rows.training * alone;
  ForceFit fit;
  LearnedForce& force = fit.force;

  double temper = kFirstTemper;
  LinearFit grouped;
  for (int pass = 0; pass < kPasses; ++pass) {
    grouped = pass == 0 ? fitGroups(rows.problem, temper) : fitGroupsFrom(rows.problem, temper, grouped);
    temper = independentShare(rows.targets - rows.training * grouped.z);
  }
  temper = kFirstTemper;
  SparseFit sparse;
  for (int pass = 0; pass < kPasses; ++pass) {
    sparse = fitSparse(rows.problem, temper, kMostColumns);
    temper = independentShare(rows.targets - rows.training * sparse.fit.z);
  }
  const Eigen::VectorXd z = 0.5 * (grouped.z + sparse.fit.z);
  const double own = independentShare(left);
  const std::vector<char> none(kForceGroups, 0);
  fit.gain = fitGroupsFrom(rows.problem, own, grouped).evidence - fitSomeGroups(rows.problem, own, none).evidence;
  force.columns = kept(table.columns, rows.used);
  force.context = table.context;
  force.lower = table.lower(rows.used);
  force.upper = table.upper(rows.used);
  force.centre = table.centre(rows.used);
  force.scale = table.scale(rows.used);
  force.weight = z.tail(free);
  force.covariance = grouped.covariance.bottomRightCorner(free, free);
  force.base_change = response.expected + z.head(kBaseDirections);
  force.parts = partsOf(rows, table, grouped, force.weight);
  fit.families = familiesOf(rows, table, sparse, force.weight);
  fit.noise = std::sqrt((rows.targets - rows.training * z).squaredNorm() / rows.problem.rows);
  fit.rms = rmsBesideBase(rows, force.weight, known);
  const Eigen::VectorXd from = response.sensitivity * response.expected;
  fit.predicted = from + rows.columns * z;
  fit.base = from + rows.columns.leftCols(known) * alone.head(known);
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

namespace {

/// The force's sum over columns as they stand.
double summed(const LearnedForce& force, const Eigen::VectorXd& values) {
  double sum = 0.0;
  for (Eigen::Index k = 0; k < force.weight.size(); ++k) {
    const bool free = isUnbounded(force.columns[static_cast<std::size_t>(k)].kind);
    const double x = free ? values[k] : std::clamp(values[k], force.lower[k], force.upper[k]);
    sum += force.weight[k] * (x - force.centre[k]) / force.scale[k];
  }
  return sum;
}

}  // namespace

namespace {

/// Standard deviation of a force's change from some columns' values to others.
std::optional<double> changeStd(const LearnedForce& force, const Eigen::VectorXd& from, const Eigen::VectorXd& to) {
  if (force.covariance.rows() != force.weight.size()) return std::nullopt;
  Eigen::VectorXd change = to - from;
  for (Eigen::Index k = 0; k < change.size(); ++k)
    if (!isUnbounded(force.columns[static_cast<std::size_t>(k)].kind))
      change[k] = std::clamp(to[k], force.lower[k], force.upper[k]) - std::clamp(from[k], force.lower[k], force.upper[k]);
  change.array() /= force.scale.array();
  return std::sqrt(std::max(change.dot(force.covariance * change), 0.0));
}

}  // namespace

std::vector<ForceAnswer> answersOf(const LearnedForce& force, double current, double longest) {
  const double step = std::max(0.1, force.context.interval);
  Eigen::VectorXd rest(static_cast<Eigen::Index>(force.columns.size())), up = rest, down = rest;
  ForceMemory rested(force.columns, force.context);
  rested.advance({0.0, 0.0, 0.0, false, 0.0, 0.0}, rest);
  ForceMemory charged = rested, discharged = rested, resting = rested;
  std::vector<ForceAnswer> answers;
  double next = step;
  const double end = std::min({longest, kLongestAnswer, force.context.span / 3.0});
  for (double time = step; time <= end; time += step) {
    const double u = 2.0 / force.context.beta * std::asinh(0.5 * current);  // the settled double layer
    resting.advance({step, 0.0, 0.0, false, 0.0, 0.0}, rest);
    charged.advance({step, current, current, false, u, 0.0}, up);
    discharged.advance({step, -current, -current, false, -u, 0.0}, down);
    if (time + 1e-9 < next) continue;
    const double unmoved = summed(force, rest);
    answers.push_back({time, summed(force, up) - unmoved, summed(force, down) - unmoved, changeStd(force, rest, up), changeStd(force, rest, down)});
    next *= 1.5;
  }
  return answers;
}

}  // namespace battery_sof
