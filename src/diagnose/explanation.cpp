#include "battery_sof/diagnose/explanation.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>

#include "battery_sof/diagnose/hypotheses.hpp"
#include "battery_sof/diagnose/unseen_current.hpp"
#include "battery_sof/model/effect.hpp"

namespace battery_sof {
namespace {

constexpr double kGridStep = 1.5;      // prior standard deviations between the shapes tried
constexpr int kInstants = 9;           // instants tried over a recording
constexpr int kIterations = 12, kFirstIterations = 4, kTasteIterations = 2;
constexpr double kSettled = 0.1;       // nats
constexpr double kLeastTemper = 0.02;  // instruments' errors hang together for seconds, what lasts longer is physics
constexpr double kWideShape = 0.7;     // standard deviation of a shape's logarithm where the catalogue has none
constexpr double kWideStrength = 2.0;  // magnitudes
constexpr double kCrankCurrent = -100.0, kChargeCurrent = 5.0, kTypicalCharge = 30.0;  // [A]
constexpr int kNoiseRounds = 4;        // in which noise and what the sampling cannot know are told apart
constexpr int kWander = 24;            // steps of a voltage channel's random walk over the training part
constexpr double kMostWander = 0.0012; // [V] a root minute, of a voltage channel
constexpr std::size_t kClosest = 5;    // effects that are tried in a step, and the first of every family
constexpr std::size_t kFittedWell = 2;  // of them, that are fitted to the end
constexpr double kDiscrepancy = 0.1;   // of the structure's gain, that physics beside it must bring
constexpr double kBudget = 4e6;        // rows simulated with the derivatives of a usual composition; then what stands is told
constexpr double kUsualCoordinates = 9.0;  // of the base circuit with an effect
constexpr int kSwaps = 3;              // rounds in which places may be taken by what does better
constexpr double kClose = 0.8;         // of the best one's gain: fitted to the end, too
constexpr double kWeak = 0.01;         // of a grid point's strengths, from where a search begins that went astray
constexpr double kPromised = 0.5;      // of the grid's gain, that a search has to reach to be on its way
constexpr double kWorthATry = 0.1;     // of the best one's gain on the grid

/// A parameter or first state as it is searched: its logarithm, or the multiple of its magnitude from where it vanishes.
struct Coordinate {
  Eigen::Index row = 0;  // of (parameters, states)
  bool logarithmic = false, strength = false, instant = false;
  double zero = 0.0, unit = 1.0, centre = 0.0, std = 1.0, lower = -1e300, upper = 1e300;

  double of(double value) const { return logarithmic ? std::log(value) : (value - zero) / unit; }
  double value(double x) const { return std::clamp(logarithmic ? std::exp(x) : zero + unit * x, lower, upper); }
  double slope(double value) const { return logarithmic ? value : unit; }  // d value / d x
};

Coordinate effectCoordinate(const ParameterInfo& info, Eigen::Index row, double span) {
  Coordinate c;
  c.row = row;
  c.logarithmic = info.logarithmic;
  c.strength = info.vanishes_at.has_value();
  c.instant = info.instant;
  c.lower = info.lower;
  c.upper = info.upper;
  const double gone = info.vanishes_at.value_or(0.0);
  if (info.instant) {
    c.unit = 0.1 * span;
    c.upper = std::min(info.upper, span);
    c.std = 3.0;
    c.centre = 5.0;
    return c;
  }
  // A process that lasts longer than a third of the recording is charge counted or drift: other effects are for that.
  if (info.unit == "s") c.upper = std::max(std::min(info.upper, span / 3.0), 2.0 * info.lower);
  if (info.logarithmic) {
    c.std = c.strength ? kWideStrength : info.prior_std.value_or(kWideShape);
    c.centre = c.strength ? std::log(gone) : std::log(info.magnitude);
    return c;
  }
  c.zero = c.strength ? gone : 0.0;
  c.unit = std::max(std::abs(info.magnitude - c.zero), 1e-12);
  if (c.strength && c.unit < 1e-9 * (std::abs(info.upper) + std::abs(gone))) c.unit = 0.25 * (info.upper - gone);
  const double reach = 0.25 * std::max(std::abs(info.upper - c.zero), std::abs(info.lower - c.zero)) / c.unit;
  c.std = c.strength ? std::max(kWideStrength, reach) : info.prior_std.value_or(kWideShape * c.unit) / c.unit;
  c.centre = c.strength ? 0.0 : info.magnitude / c.unit;
  return c;
}

Coordinate baseCoordinate(const ParameterInfo& info, Eigen::Index row, double start) {
  Coordinate c;
  c.row = row;
  c.lower = info.lower;
  c.upper = info.upper;
  c.std = baseDirectionStd(row);
  c.logarithmic = row == kRowC2 || row == kRowBeta;
  c.centre = row == kRowUDc ? start : c.of(info.magnitude);
  return c;
}

Coordinate stateCoordinate(const StateInfo& info, Eigen::Index row, double start) {
  Coordinate c;
  c.row = row;
  c.unit = *info.initial_std;
  c.lower = info.lower;
  c.upper = info.upper;
  c.centre = c.of(info.begins_as_u_c2 ? start : info.rest);
  return c;
}

/// A composition somewhere, with what it leaves of the counted rows, and the families whose columns stand beside it.
struct State {
  BatteryModel model = BatteryModel();
  CompositionPoint point;
  std::vector<Coordinate> coordinates;
  Eigen::VectorXd error;
  Eigen::MatrixXd sensitivity;
  Eigen::VectorXd unseen;  // [V^2], of the rows' errors by what the sampling cannot know; empty: nothing
  Eigen::VectorXd trust;   // s / sqrt(s^2 + unseen) [1]; empty: ones
  std::set<Family> learnt;
  std::vector<std::string> members;  // named ones, without what they need
  LinearFit fit;
  double evidence = -std::numeric_limits<double>::infinity();
  double structure_gain = 0.0;     // of ln evidence, by the structure taken in
  std::map<Family, double> explained;  // [V], by the families taken in
};

/// What an effect adds to the base circuit at one point of its grid.
struct GridPoint {
  std::string id;
  CompositionPoint point;  // of the base circuit with it
  bool one_sided;
  Eigen::VectorXd added;   // counted rows [V]
};

class Explainer {
 public:
  Explainer(const Drive& drive, std::size_t training, const ForceTable& table, const CompositionPoint& base,
            const std::vector<std::string>& ids, const std::vector<std::string>& given, const ExplanationRules& rules)
      : drive_(drive), table_(table), rules_(rules), ids_(given.empty() ? ids : given), given_(given), base_(base),
        response_(baseResponse(BatteryModel(), {base.parameters, base.state, drive.first_time, drive.first_time}, drive, training)),
        rows_(drive, response_, base) {
    for (Eigen::Index row = 0; row < response_.training; ++row)
      if (response_.weight[row] > 0.0) counted_.push_back(row);
    free_.resize(static_cast<Eigen::Index>(counted_.size()), table.values.cols() + kWander);
    free_.leftCols(table.values.cols()) = table.values(counted_, Eigen::all);
    free_.rightCols(kWander) = wander();
    free_products_ = free_.transpose() * free_;
    takeRelevance();
  }

  /// What an RMS has to be to matter: of a voltage as it is, of a current that a source draws out its share of the current.
  void takeRelevance() {
    double square = 0.0, currents = 0.0, imposed = 0.0;
    for (const Eigen::Index row : counted_) {
      if (!response_.voltage_drives[static_cast<std::size_t>(row)]) continue;
      square += std::pow(rows_.currentOf(row) * response_.resistance[row], 2);
      imposed += 1.0;
    }
    if (imposed > 0.0) currents = rules_.relevance.charge_share * std::sqrt(square / imposed);
    const double share = imposed / static_cast<double>(counted_.size()), rmse = rules_.relevance.rmse;
    relevant_ = std::sqrt((1.0 - share) * rmse * rmse + share * std::pow(std::max(rmse, currents), 2));
  }

  Explanation run(const std::function<void(const std::string&)>& progress) {
    const auto tell = [&](const std::string& what) {
      if (progress) progress(what);
    };
    State start;
    start.point = base_;
    start.coordinates = coordinatesOf(start.model);
    if (!place(start)) throw std::invalid_argument("explain: the base circuit has no finite voltage where it begins");
    takeTemper(start);
    State typical = start;
    for (Eigen::Index j = 0; j < kRowUDc; ++j) typical.point.parameters[j] = tableOne()[static_cast<std::size_t>(j)].magnitude;
    begin(start, kFirstIterations);
    begin(typical, kFirstIterations);
    if (typical.evidence > start.evidence) start = std::move(typical);
    improve(start);
    tell("trying the catalogue's effects");
    takeGrid();
    tell("weighing families");
    State now = start;
    for (const std::string& id : given_) take(now, id);
    while (given_.empty() && static_cast<int>(now.members.size() + now.learnt.size()) < rules_.most_components && extend(now)) {
      weighAgain(now);
      takeTemper(now);
      weigh(now);
    }
    finish(now, start);
    return std::move(found_);
  }

 private:
  /// A voltage channel's random walk: ramps one after the other, each of a random height.
  Eigen::MatrixXd wander() {
    const double from = response_.time[counted_.front()], length = (response_.time[counted_.back()] - from) / kWander;
    Eigen::MatrixXd ramps(static_cast<Eigen::Index>(counted_.size()), kWander);
    for (std::size_t n = 0; n < counted_.size(); ++n)
      for (int k = 0; k < kWander; ++k)
        ramps(static_cast<Eigen::Index>(n), k) = std::clamp((response_.time[counted_[n]] - from) / length - k, 0.0, 1.0);
    most_wander_ = kMostWander * std::sqrt(length / 60.0);
    return ramps;
  }

  /// Takes in what is known to be there, from where it fits best.
  void take(State& state, const std::string& id) {
    if (isUsed(id, state)) return;
    const std::vector<double> gains = gridGains(state, grid_);
    std::optional<std::size_t> best;
    for (std::size_t g = 0; g < grid_.size(); ++g)
      if (grid_[g].id == id && (!best || gains[g] > gains[*best])) best = g;
    if (!best) return;
    State with = withMember(state, grid_[*best], gains[*best]);
    if (!std::isfinite(with.evidence)) return;
    improve(with);
    found_.weighed.push_back({id, with.evidence - state.evidence});
    state = with;
    takeTemper(state);
    weigh(state);
  }

  std::vector<Coordinate> coordinatesOf(const BatteryModel& model) const {
    std::vector<Coordinate> all;
    for (Eigen::Index j = 0; j < model.parameterCount(); ++j) {
      const ParameterInfo& info = model.parameters()[static_cast<std::size_t>(j)];
      if (info.held) continue;
      all.push_back(j < kBaseRows ? baseCoordinate(info, j, base_.parameters[kRowUDc]) : effectCoordinate(info, j, table_.context.span));
    }
    for (Eigen::Index k = 0; k < model.stateCount(); ++k) {
      const StateInfo& info = model.states()[static_cast<std::size_t>(k)];
      if (k == 0) {
        Coordinate c;
        c.row = model.parameterCount();
        c.centre = base_.state[0];
        c.std = baseDirectionStd(kBaseDirections - 1);
        all.push_back(c);
      } else if (info.initial_std) {
        all.push_back(stateCoordinate(info, model.parameterCount() + k, base_.state[0]));
      }
    }
    return all;
  }

  static double& at(CompositionPoint& point, Eigen::Index row) {
    return row < point.parameters.size() ? point.parameters[row] : point.state[row - point.parameters.size()];
  }

  /// Simulates a state where it stands. @return whether the model has a voltage there.
  bool place(State& state) const {
    spent_ += static_cast<double>(counted_.size()) * static_cast<double>(state.coordinates.size()) / kUsualCoordinates;
    Eigen::MatrixXd seeds = Eigen::MatrixXd::Zero(state.model.parameterCount() + state.model.stateCount(), static_cast<Eigen::Index>(state.coordinates.size()));
    for (std::size_t j = 0; j < state.coordinates.size(); ++j) {
      const Coordinate& c = state.coordinates[j];
      seeds(c.row, static_cast<Eigen::Index>(j)) = c.slope(at(state.point, c.row));
    }
    const RowErrors errors = rows_.errors(state.model, state.point, seeds);
    if (errors.error.size() == 0) return false;
    state.error = errors.error(counted_);
    state.sensitivity = errors.sensitivity(counted_, Eigen::all);
    const Eigen::VectorXd unseen = unseenVariance(drive_, response_, state.model, state.point);
    state.unseen = unseen.size() > 0 ? Eigen::VectorXd(unseen(counted_)) : Eigen::VectorXd();
    if (state.unseen.size() == 0) state.trust.resize(0);
    return true;
  }

  struct Sums {
    LinearProblem problem;
    Eigen::MatrixXd columns;  // times the rows' trust
    Eigen::VectorXd targets;  // likewise
  };

  Sums sumsOf(const State& state, bool all) const {
    Sums sums;
    const auto known = static_cast<Eigen::Index>(state.coordinates.size());
    LinearProblem& problem = sums.problem;
    Eigen::VectorXd expected(known);  // prior means from where the state stands
    problem.known_std.resize(known);
    CompositionPoint point = state.point;
    for (Eigen::Index j = 0; j < known; ++j) {
      const Coordinate& c = state.coordinates[static_cast<std::size_t>(j)];
      expected[j] = c.centre - c.of(at(point, c.row));
      problem.known_std[j] = c.std;
    }
    std::vector<Eigen::Index> used;
    for (std::size_t k = 0; k < table_.columns.size(); ++k)
      if (all || state.learnt.count(table_.columns[k].family)) {
        used.push_back(static_cast<Eigen::Index>(k));
        problem.group.push_back(static_cast<int>(groupOf(table_.columns[k].kind)));
      }
    problem.group.insert(problem.group.end(), kWander, kForceGroups);
    problem.groups = kForceGroups + 1;
    problem.most.assign(kForceGroups + 1, GroupPrior().most);
    problem.most.back() = most_wander_;
    for (int k = 0; k < kWander; ++k) used.push_back(static_cast<Eigen::Index>(table_.columns.size()) + k);
    const auto free = static_cast<Eigen::Index>(used.size());
    sums.columns.resize(state.error.size(), known + free);
    sums.columns.leftCols(known) = state.sensitivity;
    for (Eigen::Index j = 0; j < free; ++j) sums.columns.col(known + j) = free_.col(used[static_cast<std::size_t>(j)]);
    sums.targets = state.error - state.sensitivity * expected;
    if (state.trust.size() > 0) {
      sums.columns = state.trust.asDiagonal() * sums.columns;
      sums.targets = state.trust.cwiseProduct(sums.targets);
      problem.products = sums.columns.transpose() * sums.columns;
    } else {
      problem.products.resize(known + free, known + free);
      problem.products.leftCols(known) = sums.columns.transpose() * state.sensitivity;
      problem.products.topRightCorner(known, free) = problem.products.bottomLeftCorner(free, known).transpose();
      problem.products.bottomRightCorner(free, free) = free_products_(used, used);
    }
    problem.targets = sums.columns.transpose() * sums.targets;
    problem.square = sums.targets.squaredNorm();
    problem.rows = static_cast<double>(counted_.size());
    return sums;
  }

  LinearFit fitOf(const Sums& sums) const {
    std::vector<char> active(kForceGroups + 1, 0);
    for (const int group : sums.problem.group) active[static_cast<std::size_t>(group)] = 1;
    return fitSomeGroups(sums.problem, found_.temper, active);
  }

  void weigh(State& state) const {
    weighOnce(state);
    for (int round = 0; round < kNoiseRounds && state.unseen.size() > 0; ++round) {
      State next = state;
      next.trust = trustAt(state.fit.noise, state.unseen);
      weighOnce(next);
      if (!(next.evidence > state.evidence)) return;
      state = std::move(next);
    }
  }

  void weighOnce(State& state) const {
    state.fit = fitOf(sumsOf(state, false));
    state.evidence = state.fit.evidence;
    if (state.trust.size() > 0) state.evidence += found_.temper * state.trust.array().log().sum();
  }

  static Eigen::VectorXd trustAt(double noise, const Eigen::VectorXd& unseen) {
    return (1.0 + unseen.array() / (noise * noise)).rsqrt().matrix();
  }

  static Eigen::VectorXd trusted(const State& state, const Eigen::VectorXd& rows) {
    return state.trust.size() > 0 ? Eigen::VectorXd(state.trust.cwiseProduct(rows)) : rows;
  }

  /// Gauss-Newton steps in all coordinates, the columns solved along, while ln evidence grows.
  void improve(State& state, int iterations = kIterations) const {
    weigh(state);
    for (int round = 0; round < iterations; ++round) {
      const double before = state.evidence;
      bool moved = false;
      for (double step = 1.0; step > 0.05 && !moved; step *= 0.35) {
        State next = state;
        for (std::size_t j = 0; j < next.coordinates.size(); ++j) {
          const Coordinate& c = next.coordinates[j];
          double& value = at(next.point, c.row);
          const double x = c.of(value), target = c.centre + state.fit.z[static_cast<Eigen::Index>(j)];
          value = c.value(x + step * (target - x));
        }
        if (!place(next)) continue;
        weigh(next);
        if (!(next.evidence > state.evidence)) continue;
        state = std::move(next);
        moved = true;
      }
      if (!moved || state.evidence - before < kSettled) return;
    }
  }

  void takeTemper(const State& state) {
    if (found_.temper == 1.0) found_.temper = 0.05;
    const Sums sums = sumsOf(state, true);
    LinearFit fit;
    for (int pass = 0; pass < 3; ++pass) {
      fit = pass == 0 ? fitGroups(sums.problem, found_.temper) : fitGroupsFrom(sums.problem, found_.temper, fit);
      found_.temper = std::max(kLeastTemper, independentShare(sums.targets - sums.columns * fit.z));
    }
  }

  /// The base circuit with an effect at its magnitudes.
  CompositionPoint magnitudesOf(const BatteryModel& model) const {
    CompositionPoint point = embedded(BatteryModel(), base_, model);
    for (const Coordinate& c : coordinatesOf(model)) {
      if (c.row < kBaseRows || c.row >= model.parameterCount()) continue;
      const ParameterInfo& info = model.parameters()[static_cast<std::size_t>(c.row)];
      double value = info.magnitude;
      if (c.strength && std::abs(value - *info.vanishes_at) < 1e-9 * (std::abs(info.upper) + std::abs(*info.vanishes_at)))
        value = c.logarithmic ? 2.0 * *info.vanishes_at : c.value(1.0);
      point.parameters[c.row] = std::clamp(value, info.lower, info.upper);
    }
    for (Eigen::Index k = 1; k < model.stateCount(); ++k)
      if (model.states()[static_cast<std::size_t>(k)].begins_as_u_c2) point.state[k] = point.state[0];
    return point;
  }

  /// States that a model has beyond another begin as u_c2 where they stand for a part of it; the other's keep what was fitted.
  static void beginNewStates(const BatteryModel& model, CompositionPoint& point, const BatteryModel& nested) {
    const auto isNew = [&](const StateInfo& info) {
      return std::none_of(nested.states().begin(), nested.states().end(), [&](const StateInfo& old) { return old.name == info.name; });
    };
    for (Eigen::Index k = 1; k < model.stateCount(); ++k) {
      const StateInfo& info = model.states()[static_cast<std::size_t>(k)];
      if (info.begins_as_u_c2 && isNew(info)) point.state[k] = point.state[0];
    }
  }

  std::vector<CompositionPoint> gridOf(const BatteryModel& model) const {
    const CompositionPoint typical = magnitudesOf(model);
    std::vector<CompositionPoint> points = {typical};
    for (const Coordinate& c : coordinatesOf(model)) {
      if (c.row < kBaseRows || c.row >= model.parameterCount() || c.strength) continue;
      const double x = c.of(typical.parameters[c.row]);
      std::vector<double> tried;
      for (const double by : {-2.0, -1.0, 1.0, 2.0}) tried.push_back(x + by * kGridStep * c.std);
      if (c.instant) {
        tried.clear();
        points.clear();
        for (int k = 0; k < kInstants; ++k) tried.push_back(10.0 * (k + 0.5) / kInstants);
      }
      for (const double to : tried) {
        points.push_back(typical);
        points.back().parameters[c.row] = c.value(to);
      }
    }
    return points;
  }

  void takeGrid() {
    State circuit;
    circuit.point = base_;
    circuit.error = response_.error(counted_);
    for (const std::string& id : ids_)
      for (GridPoint& point : gridBeside(circuit, id)) grid_.push_back(std::move(point));
  }

  /// What an effect adds to a state at the points of its grid.
  std::vector<GridPoint> gridBeside(const State& state, const std::string& id) const {
    const BatteryModel alone = enlarged(BatteryModel(), id), model = enlarged(state.model, id);
    bool one_sided = true;
    for (const Coordinate& c : coordinatesOf(alone))
      if (c.strength && !c.logarithmic && c.lower < c.zero) one_sided = false;
    std::vector<GridPoint> grid;
    for (const CompositionPoint& point : gridOf(alone)) {
      CompositionPoint there = embedded(state.model, state.point, model);
      for (const ParameterInfo& info : alone.parameters())
        if (!state.model.parameterRow(info.name)) there.parameters[*model.parameterRow(info.name)] = point.parameters[*alone.parameterRow(info.name)];
      beginNewStates(model, there, state.model);
      const RowErrors with = rows_.errors(model, there);
      if (with.error.size() == 0) continue;
      GridPoint one{id, point, one_sided, state.error - with.error(counted_)};
      if (one.added.squaredNorm() > 1e-14) grid.push_back(std::move(one));
    }
    return grid;
  }

  /// Factors of the columns' products with their priors, in units of the tempered noise.
  Eigen::LDLT<Eigen::MatrixXd> penalised(const Sums& sums, const State& state) const {
    Eigen::MatrixXd H = sums.problem.products;
    for (Eigen::Index k = 0; k < H.rows(); ++k) {
      const double s = k < sums.problem.known() ? sums.problem.known_std[k]
                                                : std::max(state.fit.strength[static_cast<std::size_t>(sums.problem.group[static_cast<std::size_t>(k - sums.problem.known())])], 1e-6);
      H(k, k) += state.fit.noise * state.fit.noise / (found_.temper * s * s);
    }
    return Eigen::LDLT<Eigen::MatrixXd>(H);
  }

  /// Gain of ln evidence by each grid point beside a state, noise taken anew, any multiple of it allowed.
  std::vector<double> gridGains(const State& state, const std::vector<GridPoint>& grid) const {
    const Sums sums = sumsOf(state, false);
    const Eigen::VectorXd left = sums.targets - sums.columns * state.fit.z;
    const Eigen::LDLT<Eigen::MatrixXd> factor = penalised(sums, state);
    const double rss = left.squaredNorm(), rows = found_.temper * sums.problem.rows;
    std::vector<double> gains;
    for (const GridPoint& point : grid) {
      const Eigen::VectorXd added = trusted(state, point.added), cross = sums.columns.transpose() * added;
      const double length = added.squaredNorm() - cross.dot(factor.solve(cross)), along = added.dot(left);
      gains.push_back(0.0);
      if (!(length > 1e-8 * added.squaredNorm()) || (point.one_sided && along < 0.0)) continue;
      const double share = std::min(along * along / length / rss, 1.0 - 1e-9);
      gains.back() = -0.5 * rows * std::log1p(-share) - 0.5 * std::log1p(kWideStrength * kWideStrength * rows * length / (rss * (1.0 - share)));
    }
    return gains;
  }

  /// A state with one effect more, from a point of its grid; the first steps of its fit. @param gain that the grid promises.
  State withMember(const State& state, const GridPoint& from, double gain) const {
    const double share = from.added.squaredNorm() > 0.0 ? strengthOf(state, from) : 1.0;
    State next = enlargedBy(state, from, share);
    begin(next, kTasteIterations);
    const auto keepsPromise = [&] { return next.evidence - state.evidence > kPromised * gain; };
    if (!keepsPromise() || isDistorted(state)) {
      // A circuit that has taken the effect up is far from where it belongs: once more from Table I.
      State typical = next;
      for (Eigen::Index j = 0; j < kRowUDc; ++j) typical.point.parameters[j] = tableOne()[static_cast<std::size_t>(j)].magnitude;
      begin(typical, kTasteIterations);
      if (typical.evidence > next.evidence) next = std::move(typical);
    }
    if (!keepsPromise()) {
      // The linear guess overshot: once more from hardly any of it, beside what fits without.
      State weak = enlargedBy(state, from, std::copysign(kWeak, share));
      begin(weak, kTasteIterations);
      if (weak.evidence > next.evidence) next = std::move(weak);
    }
    if (std::isfinite(next.evidence)) improve(next, kFirstIterations - kTasteIterations);
    return next;
  }

  /// A state with one effect more at a multiple of a grid point's strengths; not placed.
  State enlargedBy(const State& state, const GridPoint& from, double share) const {
    State next = state;
    next.model = enlarged(state.model, from.id);
    next.members.push_back(from.id);
    next.coordinates = coordinatesOf(next.model);
    next.point = embedded(state.model, state.point, next.model);
    const BatteryModel alone = enlarged(BatteryModel(), from.id);
    for (const Coordinate& c : next.coordinates) {
      if (c.row < kBaseRows || c.row >= next.model.parameterCount()) continue;
      const ParameterInfo& info = next.model.parameters()[static_cast<std::size_t>(c.row)];
      if (state.model.parameterRow(info.name)) continue;
      const double there = from.point.parameters[*alone.parameterRow(info.name)];
      next.point.parameters[c.row] = c.strength && !c.logarithmic ? c.value(std::clamp(share, -most(c), most(c)) * c.of(there)) : there;
    }
    beginNewStates(next.model, next.point, state.model);
    return next;
  }

  /// Whether double layer or kinetics stand far from where any battery's do.
  static bool isDistorted(const State& state) {
    for (const Eigen::Index row : {static_cast<Eigen::Index>(kRowC2), static_cast<Eigen::Index>(kRowBeta)})
      if (std::abs(std::log(state.point.parameters[row] / tableOne()[static_cast<std::size_t>(row)].magnitude)) > baseDirectionStd(row)) return true;
    return false;
  }

  /// The first steps of a search.
  void begin(State& state, int iterations) const {
    if (place(state))
      improve(state, iterations);
    else
      state.evidence = -std::numeric_limits<double>::infinity();
  }

  /// Multiple of its magnitude at which a strength's search may begin: nearby, but for strengths of wide bounds.
  static double most(const Coordinate& c) { return std::max(3.0, c.std); }

  /// Multiple of a grid point that a state's errors ask for; at least a tenth.
  double strengthOf(const State& state, const GridPoint& from) const {
    const Sums sums = sumsOf(state, false);
    const Eigen::VectorXd added = trusted(state, from.added), cross = sums.columns.transpose() * added;
    const double length = added.squaredNorm() - cross.dot(penalised(sums, state).solve(cross));
    const double share = added.dot(sums.targets - sums.columns * state.fit.z) / std::max(length, 1e-300);
    return std::abs(share) < 0.1 ? std::copysign(0.1, share) : share;
  }

  /// A state with a family's columns beside it; the circuit moves along once they are taken.
  State withColumns(const State& state, Family family) const {
    State next = state;
    next.learnt.insert(family);
    weigh(next);
    return next;
  }

  bool isSpent() const { return spent_ > kBudget; }

  /// The likeliest effects beside a state, each fitted; best first. @param only of one family, its grid taken anew beside the
  /// state: a side reaction shows where the circuit with its acceptance lets the voltage rise, and not where the circuit alone does.
  std::vector<State> withMembers(const State& state, std::optional<Family> only) {
    if (isSpent()) return {};
    std::vector<GridPoint> anew;
    if (only)
      for (const std::string& id : ids_)
        if (familyOf(id) == *only && !isUsed(id, state))
          for (GridPoint& point : gridBeside(state, id)) anew.push_back(std::move(point));
    const std::vector<GridPoint>& grid = only ? anew : grid_;
    const std::vector<double> gains = gridGains(state, grid);
    std::map<std::string, std::size_t> best;
    for (std::size_t g = 0; g < grid.size(); ++g) {
      const std::string& id = grid[g].id;
      if (isUsed(id, state) || !(gains[g] > 0.0)) continue;
      if (!best.count(id) || gains[g] > gains[best[id]]) best[id] = g;
    }
    std::vector<std::size_t> order;
    for (const auto& one : best) order.push_back(one.second);
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return gains[a] > gains[b]; });
    std::set<Family> seen;
    std::vector<State> fitted;
    for (std::size_t k = 0; k < order.size(); ++k) {
      const bool first_of_family = seen.insert(familyOf(grid[order[k]].id)).second;
      if (k >= kClosest && !(first_of_family && gains[order[k]] > kWorthATry * gains[order.front()])) continue;
      fitted.push_back(withMember(state, grid[order[k]], gains[order[k]]));
    }
    const auto best_first = [this](const State& a, const State& b) { return rankOf(a) > rankOf(b); };
    std::stable_sort(fitted.begin(), fitted.end(), best_first);
    const double best_gain = fitted.empty() ? 0.0 : fitted.front().evidence - state.evidence;
    for (std::size_t k = 0; k < fitted.size(); ++k)
      if (k < kFittedWell || fitted[k].evidence - state.evidence > kClose * best_gain)
        if (std::isfinite(fitted[k].evidence)) improve(fitted[k]);
    std::stable_sort(fitted.begin(), fitted.end(), best_first);
    for (const State& one : fitted) found_.weighed.push_back({one.members.back(), one.evidence - state.evidence});
    return fitted;
  }

  static bool isUsed(const std::string& id, const State& state) {
    const auto& there = state.model.effects();
    return std::find(there.begin(), there.end(), id) != there.end();
  }

  /// What the fit of a state explains beyond that of another [V].
  static double beyond(const State& more, const State& less) {
    return std::sqrt(std::max(0.0, std::pow(less.fit.noise, 2) - std::pow(more.fit.noise, 2)));
  }

  /// What the effects of a family that a state has explain [V].
  static double explainedBy(Family family, const State& state) {
    const bool named = std::any_of(state.members.begin(), state.members.end(), [&](const std::string& id) { return familyOf(id) == family; });
    return named && state.explained.count(family) ? state.explained.at(family) : 0.0;
  }

  /// Whether effects stand for their family's columns: as evident, or these find nothing beside them that matters, or no more
  /// than a battery's own law differs from the catalogue's. @param without the family.
  bool doesAsWell(const State& member, const State& columns, Family family, const State& without) const {
    if (member.evidence > columns.evidence - rules_.tie) return true;
    const State beside = withColumns(member, family);
    if (beside.evidence - member.evidence < rules_.least_gain) return true;
    const double family_brings = std::hypot(beyond(beside, without), explainedBy(family, without));
    return beyond(beside, member) < std::max({relevant_, 0.5 * beside.fit.noise, kDiscrepancy * family_brings});
  }

  /// By what one explanation is taken before another: of two that are as good the one with fewer effects, an equation before columns.
  double rankOf(const State& state) const {
    const double parts = static_cast<double>(state.learnt.size()) + 0.5 * static_cast<double>(state.model.effects().size());
    return state.evidence - rules_.tie * parts;
  }

  /// What stands for a family beside a state: the best of its effects where that does as well as its columns, else those.
  State standingFor(Family family, const State& beside, const std::vector<State>& members) const {
    State learnt = withColumns(beside, family);
    for (const State& member : members)
      if (familyOf(member.members.back()) == family) return doesAsWell(member, learnt, family, beside) ? member : learnt;
    return learnt;
  }

  /// The same once a family is chosen: its effects one after the other, while each is worth it, until they do as well as its columns.
  State membersFor(Family family, const State& beside, State columns) {
    State best = beside;
    for (int count = 0; count < rules_.most_components; ++count) {
      const std::vector<State> members = withMembers(best, family);
      if (members.empty() || members.front().evidence - best.evidence < rules_.least_gain || !matters(members.front(), best)) break;
      best = members.front();
      if (doesAsWell(best, columns, family, beside)) return best;
    }
    return columns;
  }

  /// Whether a part moves the voltage by enough to matter.
  bool matters(const State& with, const State& without) const {
    return rmsBesideBase(modelled(with) - modelled(without)) >= std::max(relevant_, 0.5 * with.fit.noise);
  }

  /// Nats that a family must bring. A battery's own structure is never quite the catalogue's: what is left of it is no physics.
  double needed(const State& state, Family family) const {
    const bool physics = family != Family::kStructure && family != Family::kInstrument;
    return physics ? std::max(rules_.least_gain, kDiscrepancy * state.structure_gain) : rules_.least_gain;
  }

  /// Whether columns are no more than what the effects named of their family may leave of it.
  bool isRestOfNamed(const State& columns, const State& state, Family family) const {
    if (columns.learnt.size() == state.learnt.size()) return false;
    return beyond(columns, state) < kDiscrepancy * std::hypot(beyond(columns, state), explainedBy(family, state));
  }

  /// Whether physics beside an effect of structure is no more than the structure's columns hold: another circuit than the catalogue's.
  bool isHeldByStructure(const State& with, const State& without, Family family) const {
    if (family == Family::kStructure || family == Family::kInstrument || !(explainedBy(Family::kStructure, without) > 0.0)) return false;
    return withColumns(with, Family::kStructure).evidence - withColumns(without, Family::kStructure).evidence < rules_.least_gain;
  }

  static std::set<std::string> partsOf(const State& state) {
    std::set<std::string> parts(state.members.begin(), state.members.end());
    for (const Family family : state.learnt) parts.insert(familyId(family));
    return parts;
  }

  /// Takes in the family of greatest evidence. The same parts get the same family once: what was taken and let go does not come
  /// again and again. @return whether one was worth it.
  bool extend(State& state) {
    const std::vector<State> members = withMembers(state, std::nullopt);
    State best = state;
    std::optional<Family> chosen;
    const std::set<std::string> parts = partsOf(state);
    for (const Family family : kAllFamilies) {
      if (state.learnt.count(family) || tried_.count({parts, family})) continue;
      const State of_family = standingFor(family, state, members);
      if (of_family.evidence - state.evidence < needed(state, family) || isHeldByStructure(of_family, state, family)) continue;
      if (!(rankOf(of_family) > rankOf(best)) || !matters(of_family, state) || isRestOfNamed(of_family, state, family)) continue;
      best = of_family;
      chosen = family;
    }
    if (!chosen) return false;
    tried_.insert({parts, *chosen});
    if (best.learnt.size() > state.learnt.size()) best = membersFor(*chosen, state, best);
    best.explained[*chosen] = std::hypot(explainedBy(*chosen, state), beyond(best, state));
    if (*chosen == Family::kStructure) best.structure_gain = std::max(state.structure_gain, best.evidence - state.evidence);
    state = std::move(best);
    improve(state);
    return true;
  }

  /// Each part once more beside the others: columns give way to an effect that does as well, what is not worth its place goes.
  void weighAgain(State& state) {
    if (state.members.size() + state.learnt.size() < 2) return;
    for (const Family family : std::set<Family>(state.learnt)) {
      State without = state;
      without.learnt.erase(family);
      improve(without);
      if (state.evidence - without.evidence < rules_.least_gain || !matters(state, without)) {
        state = std::move(without);
        continue;
      }
      const std::vector<State> members = withMembers(without, family);
      if (!members.empty() && doesAsWell(members.front(), state, family, without)) state = members.front();
    }
    for (const std::string& id : state.members)
      if (familyOf(id) == Family::kStructure)
        state.structure_gain = std::max(state.structure_gain, state.evidence - withoutMember(state, id).evidence);
    for (const std::string& id : std::vector<std::string>(state.members)) {
      if (state.members.size() + state.learnt.size() < 2) return;
      State without = withoutMember(state, id);
      if (state.evidence - without.evidence < needed(state, familyOf(id)) || !matters(state, without) || isHeldByStructure(state, without, familyOf(id)))
        state = std::move(without);
    }
  }

  State withoutMember(const State& state, const std::string& id) const {
    State next = state;
    next.members.erase(std::find(next.members.begin(), next.members.end(), id));
    next.model = BatteryModel();
    for (const std::string& other : next.members)
      if (!isUsed(other, next)) next.model = enlarged(next.model, other);
    next.coordinates = coordinatesOf(next.model);
    next.point = embedded(BatteryModel(), base_, next.model);
    for (Eigen::Index j = 0; j < next.model.parameterCount(); ++j)
      next.point.parameters[j] = state.point.parameters[*state.model.parameterRow(next.model.parameters()[static_cast<std::size_t>(j)].name)];
    for (Eigen::Index k = 0; k < next.model.stateCount(); ++k)
      for (Eigen::Index m = 0; m < state.model.stateCount(); ++m)
        if (next.model.states()[static_cast<std::size_t>(k)].name == state.model.states()[static_cast<std::size_t>(m)].name)
          next.point.state[k] = state.point.state[m];
    if (place(next)) improve(next);
    return next;
  }

  void finish(State& state, State& start) {
    weigh(start);
    found_.evidence = state.evidence;
    found_.base_evidence = start.evidence;
    found_.model = state.model;
    found_.point = state.point;
    takePlaces(state);
    std::stable_sort(found_.components.begin(), found_.components.end(), [](const Component& a, const Component& b) { return a.gain > b.gain; });
    takeRest(state);
  }

  /// Every part's place. Where another does better in one, it is taken and the places are weighed once more.
  void takePlaces(State& state) {
    for (int round = 0; round < kSwaps; ++round) {
      found_.components.clear();
      better_.reset();
      for (const std::string& id : state.members) takePlace(state, withoutMember(state, id), familyOf(id), id);
      for (const Family family : state.learnt) {
        State without = state;
        without.learnt.erase(family);
        improve(without);
        takePlace(state, without, family, "");
      }
      if (!better_ || !given_.empty() || round + 1 == kSwaps || isSpent()) break;
      state = std::move(*better_);
      improve(state);
    }
    found_.evidence = state.evidence;
    found_.model = state.model;
    found_.point = state.point;
  }

  /// Whether an effect holds another: as good as that alone, it adds nothing.
  static bool needs(const std::string& id, const std::string& other) {
    const std::vector<std::string>& ids = effectInfo(id).needs;
    return std::find(ids.begin(), ids.end(), other) != ids.end();
  }

  void weighRival(const State& rival, const State& state) {
    if (rankOf(rival) > std::max(rankOf(state), better_ ? rankOf(*better_) : rankOf(state)) + kSettled) better_ = rival;
  }

  /// What a part is worth, what it adds, and what could stand in its place.
  void takePlace(const State& state, const State& without, Family family, const std::string& id) {
    Component one{family, id, state.evidence - without.evidence, 0.0, {}, 1.0};
    one.rms = rmsBesideBase(modelled(state) - modelled(without));
    std::map<Family, double> rivals = {{family, one.gain}};
    const std::vector<State> members = withMembers(without, std::nullopt);
    for (const State& member : members) {
      if (!std::isfinite(member.evidence)) continue;
      const double gain = member.evidence - without.evidence;
      const Family of = familyOf(member.members.back());
      if (!id.empty() && member.members.back() != id && gain > one.gain - rules_.tie && !needs(member.members.back(), id))
        one.tied.push_back(member.members.back());
      if (of == family) weighRival(member, state);
      if (!rivals.count(of) || gain > rivals[of]) rivals[of] = gain;
    }
    if (!id.empty())
      for (const std::string& alike : effectInfo(id).same_as)
        if (!isUsed(alike, state) && std::find(one.tied.begin(), one.tied.end(), alike) == one.tied.end()) one.tied.push_back(alike);
    if (id.empty() && !better_)
      for (const State& member : members)
        if (familyOf(member.members.back()) == family && doesAsWell(member, state, family, without)) {
          better_ = member;
          break;
        }
    for (const Family other : kAllFamilies) {
      if (without.learnt.count(other) || other == family) continue;
      const State standing = standingFor(other, without, members);
      weighRival(standing, state);
      const double gain = standing.evidence - without.evidence;
      if (!rivals.count(other) || gain > rivals[other]) rivals[other] = gain;
    }
    double sum = 0.0;
    for (const auto& rival : rivals) sum += std::exp(rival.second - rivals[family]);
    one.probability = 1.0 / sum;
    found_.components.push_back(one);
  }

  /// What a state says of the counted rows, up to what is common to all [V].
  Eigen::VectorXd modelled(const State& state) const {
    const auto known = static_cast<Eigen::Index>(state.coordinates.size());
    Eigen::VectorXd said = -state.error;
    Eigen::Index j = known;
    for (std::size_t k = 0; k < table_.columns.size(); ++k)
      if (state.learnt.count(table_.columns[k].family)) said += free_.col(static_cast<Eigen::Index>(k)) * state.fit.z[j++];
    return said;
  }

  double rmsBesideBase(const Eigen::VectorXd& part) const {
    const Eigen::MatrixXd J = response_.sensitivity(counted_, Eigen::all);
    Eigen::MatrixXd H = J.transpose() * J;
    H.diagonal().array() += 1e-9 * H.diagonal().array();
    const Eigen::VectorXd left = part - J * H.ldlt().solve(J.transpose() * part);
    return std::sqrt(left.squaredNorm() / static_cast<double>(part.size()));
  }

  /// What the library would still take.
  void takeRest(const State& state) {
    const Sums sums = sumsOf(state, true);
    const LinearFit all = fitOf(sums);
    found_.left_gain = all.evidence - state.fit.evidence;
    Eigen::VectorXd part = Eigen::VectorXd::Zero(free_.rows());
    for (std::size_t k = 0; k < table_.columns.size(); ++k)
      if (!state.learnt.count(table_.columns[k].family))
        part += free_.col(static_cast<Eigen::Index>(k)) * all.z[static_cast<Eigen::Index>(state.coordinates.size() + k)];
    found_.left_rms = rmsBesideBase(part);
    found_.noise = state.fit.noise;
    found_.relevant = std::max(relevant_, 0.5 * state.fit.noise);
    takeLeft(part);
    takeLeastStrengths(state);
    double most = rules_.least_gain;
    for (const Family family : kAllFamilies) {
      if (state.learnt.count(family)) continue;
      const double gain = withColumns(state, family).evidence - state.evidence;
      if (gain <= most) continue;
      most = gain;
      found_.left_family = family;
    }
  }

  /// What is left, as a crank and a charge see it.
  void takeLeft(const Eigen::VectorXd& part) {
    double crank = 0.0, cranks = 0.0, charge = 0.0, currents = 0.0;
    for (std::size_t n = 0; n < counted_.size(); ++n) {
      const double current = rows_.currentOf(counted_[n]), by = std::abs(part[static_cast<Eigen::Index>(n)]);
      if (current < kCrankCurrent) {
        crank += by;
        cranks += 1.0;
      } else if (current > kChargeCurrent) {
        charge += by;
        currents += current;
      }
    }
    const double resistance = base_.parameters[kRowRCharge] + 2.0 / base_.parameters[kRowBeta] / kTypicalCharge;
    found_.left_crank = cranks > 0.0 ? crank / cranks : 0.0;
    found_.left_charge_share = currents > 0.0 ? charge / resistance / currents : 0.0;
  }

  /// From the information that the typical strength's signature holds, linearly.
  void takeLeastStrengths(const State& state) {
    const Sums sums = sumsOf(state, false);
    const Eigen::LDLT<Eigen::MatrixXd> factor = penalised(sums, state);
    std::set<std::string> done;
    for (const GridPoint& point : grid_) {
      if (isUsed(point.id, state) || !done.insert(point.id).second) continue;
      const Eigen::VectorXd added = trusted(state, point.added), cross = sums.columns.transpose() * added;
      const double length = std::max(1e-300, added.squaredNorm() - cross.dot(factor.solve(cross)));
      const double information = found_.temper * length / (state.fit.noise * state.fit.noise);
      const double evident = std::sqrt(2.0 * (rules_.least_gain + 0.5 * std::log1p(kWideStrength * kWideStrength * information)) / information);
      const double matters = std::max(relevant_, 0.5 * state.fit.noise) / std::sqrt(length / static_cast<double>(counted_.size()));
      found_.least.push_back(leastStrength(point, std::max(evident, matters)));
    }
  }

  /// @param times a typical strength.
  LeastStrength leastStrength(const GridPoint& point, double times) const {
    const BatteryModel model = enlarged(BatteryModel(), point.id);
    for (const ParameterInfo& own : effectInfo(point.id).parameters)
      for (const Coordinate& c : coordinatesOf(model)) {
        if (c.row >= model.parameterCount() || !c.strength || model.parameters()[static_cast<std::size_t>(c.row)].name != own.name) continue;
        const double typical = point.point.parameters[c.row];
        LeastStrength least{point.id, own.name, own.unit, std::nullopt, typical};
        const double wanted = c.centre + times * (c.of(typical) - c.centre);
        const double value = c.logarithmic ? std::exp(std::min(wanted, 300.0)) : c.zero + c.unit * wanted;
        if (value >= c.lower && value <= c.upper) least.strength = value;
        return least;
      }
    return {point.id, "", "", std::nullopt, 0.0};
  }

  const Drive& drive_;
  const ForceTable& table_;
  ExplanationRules rules_;
  std::vector<std::string> ids_, given_;
  CompositionPoint base_;
  BaseResponse response_;
  RowSimulation rows_;
  std::vector<Eigen::Index> counted_;
  Eigen::MatrixXd free_, free_products_;  // the table's columns and the wander's ramps
  double most_wander_ = 0.0, relevant_ = 0.0;  // [V]
  std::vector<GridPoint> grid_;
  std::set<std::pair<std::set<std::string>, Family>> tried_;  // families taken beside these parts
  mutable double spent_ = 0.0;   // rows simulated with derivatives
  std::optional<State> better_;  // than the state, by what could stand in a place
  Explanation found_;
};

}  // namespace

Explanation explain(const Drive& drive, std::size_t training, const ForceTable& table, const CompositionPoint& base,
                    const std::vector<std::string>& ids, const std::vector<std::string>& given, const ExplanationRules& rules,
                    const std::function<void(const std::string&)>& progress) {
  return Explainer(drive, training, table, base, ids, given, rules).run(progress);
}

}  // namespace battery_sof
