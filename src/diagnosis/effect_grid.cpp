#include "effect_grid.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "estimation/composition_fit.hpp"
#include "model/base_model.hpp"

namespace battery_sof {
namespace {

constexpr double kGridStep = 1.5;       // prior standard deviations between the shapes tried
constexpr int kInstants = 9;            // instants tried over a recording
constexpr double kLeastStrength = 0.1;  // of a grid point, where a fit begins
// effects that are tried, and the first of every mechanism
constexpr std::size_t kClosest = 5;
constexpr double kWorthATry = 0.1;  // of the best one's gain

/// What the linear fit of a state leaves.
struct LinearRest {
  LinearRest(const ExplanationFits& fits, const ExplanationState& state)
      : sums(fits.sumsOf(state, false)),
        factor(fits.penalised(sums, state)),
        left(sums.targets - sums.columns.times(state.fit.z)) {}

  /// Square of what it cannot take up of something added to the rows [V^2].
  double lengthOf(const Eigen::VectorXd& added) const {
    const Eigen::VectorXd cross = sums.columns.along(added);
    return std::max(1e-300, added.squaredNorm() - cross.dot(factor.solve(cross)));
  }

  ExplanationSums sums;
  Eigen::LDLT<Eigen::MatrixXd> factor;
  Eigen::VectorXd left;
};

/// A state with a mechanism's regressors as strong as they may be: what these can take up of an
/// effect counts as their mechanism's.
ExplanationState withFreeRegressors(const ExplanationFits& fits, const ExplanationState& state,
                                    Mechanism mechanism) {
  ExplanationState next = fits.withRegressors(state, mechanism);
  std::fill_n(next.fit.strength.begin(), kRegressorGroups, GroupPrior::kMost);
  return next;
}

/// States that a model has beyond another begin as u_c2 where they represent a part of it; the
/// other's keep what was fitted.
void beginNewStates(const BatteryModel& model, CompositionPoint& point,
                    const BatteryModel& nested) {
  const auto isNew = [&](const StateInfo& info) {
    return std::none_of(nested.states().begin(), nested.states().end(),
                        [&](const StateInfo& old) { return old.name == info.name; });
  };
  for (Eigen::Index k = 1; k < model.stateCount(); ++k) {
    const StateInfo& info = model.states()[k];
    if (info.begins_as_u_c2 && isNew(info)) point.state[k] = point.state[0];
  }
}

}  // namespace

EffectGrid::EffectGrid(const ExplanationFits& fits, const ExplanationState& state,
                       const std::vector<std::string>& ids, int threads)
    : fits_(fits), threads_(threads) {
  std::vector<std::vector<EffectGridPoint>> grids(ids.size());
  parallelFor(ids.size(), threads_, [&](std::size_t k) {
    if (!state.has(ids[k])) grids[k] = pointsOf(state, ids[k]);
  });
  for (std::vector<EffectGridPoint>& grid : grids)
    std::move(grid.begin(), grid.end(), std::back_inserter(points_));
}

std::vector<GridGain> EffectGrid::gainsOf(const ExplanationState& state) const {
  const LinearRest rest(fits_, state);
  const double rss = rest.left.squaredNorm(),
               rows = fits_.effectiveSampleFraction() * rest.sums.problem.rows;
  std::vector<GridGain> gains(points_.size());
  parallelFor(points_.size(), threads_, [&](std::size_t g) {
    const Eigen::VectorXd added = fits_.whitened(points_[g].added);
    const double length = rest.lengthOf(added), along = added.dot(rest.left);
    gains[g].strength = std::copysign(std::max(std::abs(along / length), kLeastStrength), along);
    if (!(length > 1e-8 * added.squaredNorm()) || (points_[g].one_sided && along < 0.0)) return;
    const double share = std::min(along * along / length / rss, 1.0 - 1e-9);
    gains[g].value =
        -0.5 * rows * std::log1p(-share) -
        0.5 * std::log1p(kWideStrength * kWideStrength * rows * length / (rss * (1.0 - share)));
  });
  return gains;
}

std::map<std::string, double> EffectGrid::bestGains(const ExplanationState& state) const {
  const std::vector<GridGain> gains = gainsOf(state);
  std::map<std::string, double> best;
  for (std::size_t g = 0; g < points_.size(); ++g)
    best[points_[g].id] = std::max(best[points_[g].id], gains[g].value);
  return best;
}

std::vector<std::size_t> EffectGrid::promising(const std::vector<GridGain>& gains,
                                               const std::vector<std::string>& only) const {
  std::map<std::string, std::size_t> best;
  for (std::size_t g = 0; g < points_.size(); ++g) {
    const std::string& id = points_[g].id;
    if (!(only.empty() ? gains[g].value > 0.0 : contains(only, id))) continue;
    if (!best.count(id) || gains[g].value > gains[best[id]].value) best[id] = g;
  }
  std::vector<std::size_t> order, tried;
  for (const auto& one : best) order.push_back(one.second);
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return gains[a].value > gains[b].value; });
  std::set<Mechanism> seen;
  for (const std::size_t g : order) {
    const bool is_first = seen.insert(mechanismOf(points_[g].id)).second;
    if (tried.size() < kClosest ||
        (is_first && gains[g].value > kWorthATry * gains[order.front()].value))
      tried.push_back(g);
  }
  return tried;
}

CompositionPoint EffectGrid::startOf(const ExplanationState& state, const BatteryModel& larger,
                                     const EffectGridPoint& from, double strength) const {
  CompositionPoint start = embedded(state.model, state.point, larger);
  const BatteryModel alone = enlarged(BatteryModel(), from.id);
  for (const FitCoordinate& c : fits_.coordinatesOf(larger)) {
    if (c.row < kBaseRows || c.row >= larger.parameterCount()) continue;
    const ParameterInfo& info = larger.parameters()[c.row];
    if (state.model.parameterRow(info.name)) continue;
    const double there = from.point.parameters[*alone.parameterRow(info.name)];
    // nearby, but for strengths of wide bounds
    const double most = std::max(3.0, c.std);
    start.parameters[c.row] = c.strength && !c.logarithmic
                                  ? c.value(std::clamp(strength, -most, most) * c.of(there))
                                  : there;
  }
  beginNewStates(larger, start, state.model);
  return start;
}

std::vector<DetectionLimit> EffectGrid::minStrengths(
    const ExplanationState& state, const std::function<double(Mechanism)>& needed) const {
  std::vector<DetectionLimit> least;
  const LinearRest rest(fits_, state);
  std::map<Mechanism, LinearRest> others;
  for (const Mechanism mechanism : kAllMechanisms)
    if (!state.estimated.count(mechanism))
      others.emplace(mechanism, LinearRest(fits_, withFreeRegressors(fits_, state, mechanism)));
  std::set<std::string> done;
  for (const EffectGridPoint& point : points_) {
    if (state.has(point.id) || !done.insert(point.id).second) continue;
    const Mechanism own = mechanismOf(point.id);
    const Eigen::VectorXd added = fits_.whitened(point.added);
    const double length = rest.lengthOf(added);
    double min_length = length;
    for (const auto& other : others)
      if (other.first != own) min_length = std::min(min_length, other.second.lengthOf(added));
    const double information =
        fits_.effectiveSampleFraction() * min_length / (state.fit.noise * state.fit.noise);
    const double evident = std::sqrt(
        2.0 * (needed(own) + 0.5 * std::log1p(kWideStrength * kWideStrength * information)) /
        information);
    const double relevant = fits_.relevanceLimit(state) /
                            std::sqrt(length / static_cast<double>(fits_.counted().size()));
    const double times = std::max(evident + std::abs(added.dot(rest.left)) / length, relevant);
    if (const auto one = minStrength(point, times)) least.push_back(*one);
  }
  return least;
}

CompositionPoint EffectGrid::magnitudesOf(const BatteryModel& model) const {
  CompositionPoint point = embedded(BatteryModel(), fits_.base(), model);
  for (const FitCoordinate& c : fits_.coordinatesOf(model)) {
    if (c.row < kBaseRows || c.row >= model.parameterCount()) continue;
    const ParameterInfo& info = model.parameters()[c.row];
    double value = info.magnitude;
    if (c.strength && std::abs(value - *info.vanishes_at) <
                          1e-9 * (std::abs(info.upper) + std::abs(*info.vanishes_at)))
      value = c.logarithmic ? 2.0 * *info.vanishes_at : c.value(1.0);
    point.parameters[c.row] = std::clamp(value, info.lower, info.upper);
  }
  beginNewStates(model, point, BatteryModel());
  return point;
}

std::vector<CompositionPoint> EffectGrid::shapesOf(const BatteryModel& model) const {
  const CompositionPoint typical = magnitudesOf(model);
  std::vector<CompositionPoint> points = {typical};
  for (const FitCoordinate& c : fits_.coordinatesOf(model)) {
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

std::vector<EffectGridPoint> EffectGrid::pointsOf(const ExplanationState& state,
                                                  const std::string& id) const {
  const BatteryModel alone = enlarged(BatteryModel(), id), model = enlarged(state.model, id);
  bool one_sided = true;
  for (const FitCoordinate& c : fits_.coordinatesOf(alone))
    if (c.strength && !c.logarithmic && c.lower < c.zero) one_sided = false;
  std::vector<EffectGridPoint> points;
  for (const CompositionPoint& point : shapesOf(alone)) {
    CompositionPoint there = embedded(state.model, state.point, model);
    for (const ParameterInfo& info : alone.parameters())
      if (!state.model.parameterRow(info.name))
        there.parameters[*model.parameterRow(info.name)] =
            point.parameters[*alone.parameterRow(info.name)];
    beginNewStates(model, there, state.model);
    const Eigen::VectorXd error = fits_.errorsOf(model, there);
    if (error.size() == 0) continue;
    EffectGridPoint one{id, point, one_sided, state.error - error};
    if (one.added.squaredNorm() > 1e-14) points.push_back(std::move(one));
  }
  return points;
}

std::optional<DetectionLimit> EffectGrid::minStrength(const EffectGridPoint& point,
                                                      double times) const {
  const BatteryModel model = enlarged(BatteryModel(), point.id);
  for (const ParameterInfo& own : effectInfo(point.id).parameters)
    for (const FitCoordinate& c : fits_.coordinatesOf(model)) {
      if (!c.strength || model.parameterRow(own.name) != c.row) continue;
      const double typical = point.point.parameters[c.row];
      DetectionLimit least{point.id, own.name, own.unit, std::nullopt, typical};
      const double wanted = c.centre + times * (c.of(typical) - c.centre);
      const double value =
          c.logarithmic ? std::exp(std::min(wanted, 300.0)) : c.zero + c.unit * wanted;
      if (value >= c.lower && value <= c.upper) least.strength = value;
      return least;
    }
  return std::nullopt;
}

}  // namespace battery_sof
