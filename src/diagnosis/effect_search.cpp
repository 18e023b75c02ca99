#include "effect_search.hpp"

#include "estimation/composition_fit.hpp"
#include "model/base_model.hpp"

namespace battery_sof {
namespace {

constexpr double kGridStep = 1.5;  // prior standard deviations between the shapes tried
constexpr int kInstants = 9;       // instants tried over a recording
constexpr int kFirstIterations = 4, kTasteIterations = 2;
// effects that are tried in a step, and the first of every mechanism
constexpr std::size_t kClosest = 5;
// of them, that are fitted to the end where their first steps gain anything
constexpr std::size_t kFittedWell = 2;
constexpr double kClose = 0.8;  // of the best one's gain: fitted to the end, too
// of a grid point's strengths, from where a search begins that went astray
constexpr double kWeak = 0.01;
// of the grid's gain, that a search has to reach to be on its way
constexpr double kPromised = 0.5;
constexpr double kWorthATry = 0.1;  // of the best one's gain on the grid

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

/// Whether double layer or kinetics stand far from where any battery's do.
bool isDistorted(const ExplanationState& state) {
  for (const Eigen::Index row :
       {static_cast<Eigen::Index>(kRowC2), static_cast<Eigen::Index>(kRowBeta)})
    if (std::abs(std::log(state.point.parameters[row] / tableOne()[row].magnitude)) >
        baseDirectionStd(row))
      return true;
  return false;
}

}  // namespace

EffectSearch::EffectSearch(ExplanationFits& fits, const std::vector<std::string>& ids, int threads)
    : fits_(fits), ids_(ids), threads_(threads) {}

void EffectSearch::takeGrid() {
  ExplanationState circuit;
  circuit.point = fits_.base();
  circuit.error = fits_.response().error(fits_.counted());
  grid_ = gridsFor(circuit, ids_);
}

std::optional<ExplanationState> EffectSearch::with(const ExplanationState& state,
                                                   const std::string& id) {
  const std::vector<double> gains = gridGains(state, grid_);
  std::optional<std::size_t> best;
  for (std::size_t g = 0; g < grid_.size(); ++g)
    if (grid_[g].id == id && (!best || gains[g] > gains[*best])) best = g;
  if (!best) return std::nullopt;
  ExplanationState next = withMember(state, grid_[*best], gains[*best]);
  if (!std::isfinite(next.evidence)) return std::nullopt;
  fits_.optimize(next);
  addWeighed(weighed_, id, next.evidence - state.evidence);
  return next;
}

std::vector<double> EffectSearch::gridGains(const ExplanationState& state,
                                            const std::vector<EffectGridPoint>& grid) const {
  const LinearRest rest(fits_, state);
  const double rss = rest.left.squaredNorm(),
               rows = fits_.effectiveSampleFraction() * rest.sums.problem.rows;
  std::vector<double> gains(grid.size(), 0.0);
  parallelFor(grid.size(), threads_, [&](std::size_t g) {
    const Eigen::VectorXd added = fits_.whitened(grid[g].added);
    const double length = rest.lengthOf(added), along = added.dot(rest.left);
    if (!(length > 1e-8 * added.squaredNorm()) || (grid[g].one_sided && along < 0.0)) return;
    const double share = std::min(along * along / length / rss, 1.0 - 1e-9);
    gains[g] =
        -0.5 * rows * std::log1p(-share) -
        0.5 * std::log1p(kWideStrength * kWideStrength * rows * length / (rss * (1.0 - share)));
  });
  return gains;
}

std::map<std::string, double> EffectSearch::bestGains(const ExplanationState& state) const {
  const std::vector<double> gains = gridGains(state, grid_);
  std::map<std::string, double> best;
  for (std::size_t g = 0; g < grid_.size(); ++g)
    best[grid_[g].id] = std::max(best[grid_[g].id], gains[g]);
  return best;
}

ExplanationState EffectSearch::withMember(const ExplanationState& state,
                                          const EffectGridPoint& from, double gain) const {
  const double share = from.added.squaredNorm() > 0.0 ? strengthOf(state, from) : 1.0;
  ExplanationState next = enlargedBy(state, from, share);
  fits_.begin(next, kTasteIterations);
  const auto keepsPromise = [&] { return next.evidence - state.evidence > kPromised * gain; };
  const auto tryFrom = [&](ExplanationState other) {
    fits_.begin(other, kTasteIterations);
    if (other.evidence > next.evidence) next = std::move(other);
  };
  if (!keepsPromise() || isDistorted(state)) {
    // A circuit that has taken the effect up is far from where it belongs: once more from Table I.
    ExplanationState typical = next;
    typical.point.parameters.head(kRowUDc) = BatteryModel().typicalParameters().head(kRowUDc);
    tryFrom(std::move(typical));
  }
  if (!keepsPromise()) {
    // and from where its grid was taken
    ExplanationState again = enlargedBy(state, from, share);
    again.point.parameters.head(kBaseRows) = fits_.base().parameters;
    tryFrom(std::move(again));
  }
  // The linear guess overshot: once more from hardly any of it, added to the fit without.
  if (!keepsPromise()) tryFrom(enlargedBy(state, from, std::copysign(kWeak, share)));
  if (std::isfinite(next.evidence)) fits_.improve(next, kFirstIterations - kTasteIterations);
  return next;
}

std::vector<ExplanationState> EffectSearch::withMembers(const ExplanationState& state,
                                                        std::optional<Mechanism> only) {
  std::vector<std::string> of_mechanism;
  for (const std::string& id : ids_)
    if (only && mechanismOf(id) == *only && !state.has(id)) of_mechanism.push_back(id);
  const std::vector<EffectGridPoint> retaken = gridsFor(state, of_mechanism);
  const std::vector<EffectGridPoint>& grid = only ? retaken : grid_;
  const std::vector<double> gains = gridGains(state, grid);
  std::map<std::string, std::size_t> best;
  for (std::size_t g = 0; g < grid.size(); ++g) {
    const std::string& id = grid[g].id;
    if (state.has(id) || !(gains[g] > 0.0)) continue;
    if (!best.count(id) || gains[g] > gains[best[id]]) best[id] = g;
  }
  std::vector<std::size_t> order;
  for (const auto& one : best) order.push_back(one.second);
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return gains[a] > gains[b]; });
  std::set<Mechanism> seen;
  std::vector<std::size_t> tried;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool first_of_mechanism = seen.insert(mechanismOf(grid[order[k]].id)).second;
    if (k < kClosest || (first_of_mechanism && gains[order[k]] > kWorthATry * gains[order.front()]))
      tried.push_back(order[k]);
  }
  std::vector<ExplanationState> fitted(tried.size());
  parallelFor(tried.size(), threads_, [&](std::size_t k) {
    fitted[k] = withMember(state, grid[tried[k]], gains[tried[k]]);
  });
  const auto best_first = [this](const ExplanationState& a, const ExplanationState& b) {
    return rankOf(a) > rankOf(b);
  };
  std::stable_sort(fitted.begin(), fitted.end(), best_first);
  const double best_gain = fitted.empty() ? 0.0 : fitted.front().evidence - state.evidence;
  parallelFor(fitted.size(), threads_, [&](std::size_t k) {
    if (fitted[k].evidence > state.evidence &&
        (k < kFittedWell || fitted[k].evidence - state.evidence > kClose * best_gain))
      fits_.optimize(fitted[k]);
  });
  std::stable_sort(fitted.begin(), fitted.end(), best_first);
  for (const ExplanationState& one : fitted)
    addWeighed(weighed_, one.members.back(), one.evidence - state.evidence);
  return fitted;
}

std::vector<DetectionLimit> EffectSearch::minStrengths(
    const ExplanationState& state, const std::function<double(Mechanism)>& needed) const {
  std::vector<DetectionLimit> least;
  const LinearRest rest(fits_, state);
  std::map<Mechanism, LinearRest> others;
  for (const Mechanism mechanism : kAllMechanisms)
    if (!state.estimated.count(mechanism))
      others.emplace(mechanism, LinearRest(fits_, withFreeRegressors(fits_, state, mechanism)));
  std::set<std::string> done;
  for (const EffectGridPoint& point : grid_) {
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

double EffectSearch::rankOf(const ExplanationState& state) const {
  const double parts = static_cast<double>(state.estimated.size()) +
                       0.5 * static_cast<double>(state.model.effects().size());
  return state.evidence - kTie * parts;
}

CompositionPoint EffectSearch::magnitudesOf(const BatteryModel& model) const {
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

std::vector<CompositionPoint> EffectSearch::gridOf(const BatteryModel& model) const {
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

std::vector<EffectGridPoint> EffectSearch::gridFor(const ExplanationState& state,
                                                   const std::string& id) const {
  const BatteryModel alone = enlarged(BatteryModel(), id), model = enlarged(state.model, id);
  bool one_sided = true;
  for (const FitCoordinate& c : fits_.coordinatesOf(alone))
    if (c.strength && !c.logarithmic && c.lower < c.zero) one_sided = false;
  std::vector<EffectGridPoint> grid;
  for (const CompositionPoint& point : gridOf(alone)) {
    CompositionPoint there = embedded(state.model, state.point, model);
    for (const ParameterInfo& info : alone.parameters())
      if (!state.model.parameterRow(info.name))
        there.parameters[*model.parameterRow(info.name)] =
            point.parameters[*alone.parameterRow(info.name)];
    beginNewStates(model, there, state.model);
    const Eigen::VectorXd error = fits_.errorsOf(model, there);
    if (error.size() == 0) continue;
    EffectGridPoint one{id, point, one_sided, state.error - error};
    if (one.added.squaredNorm() > 1e-14) grid.push_back(std::move(one));
  }
  return grid;
}

std::vector<EffectGridPoint> EffectSearch::gridsFor(const ExplanationState& state,
                                                    const std::vector<std::string>& ids) const {
  std::vector<std::vector<EffectGridPoint>> grids(ids.size());
  parallelFor(ids.size(), threads_, [&](std::size_t k) { grids[k] = gridFor(state, ids[k]); });
  std::vector<EffectGridPoint> all;
  for (std::vector<EffectGridPoint>& grid : grids)
    std::move(grid.begin(), grid.end(), std::back_inserter(all));
  return all;
}

ExplanationState EffectSearch::enlargedBy(const ExplanationState& state,
                                          const EffectGridPoint& from, double share) const {
  ExplanationState next = state;
  next.model = enlarged(state.model, from.id);
  next.members.push_back(from.id);
  next.coordinates = fits_.coordinatesOf(next.model);
  next.point = embedded(state.model, state.point, next.model);
  const BatteryModel alone = enlarged(BatteryModel(), from.id);
  for (const FitCoordinate& c : next.coordinates) {
    if (c.row < kBaseRows || c.row >= next.model.parameterCount()) continue;
    const ParameterInfo& info = next.model.parameters()[c.row];
    if (state.model.parameterRow(info.name)) continue;
    const double there = from.point.parameters[*alone.parameterRow(info.name)];
    // nearby, but for strengths of wide bounds
    const double most = std::max(3.0, c.std);
    next.point.parameters[c.row] = c.strength && !c.logarithmic
                                       ? c.value(std::clamp(share, -most, most) * c.of(there))
                                       : there;
  }
  beginNewStates(next.model, next.point, state.model);
  return next;
}

double EffectSearch::strengthOf(const ExplanationState& state, const EffectGridPoint& from) const {
  const LinearRest rest(fits_, state);
  const Eigen::VectorXd added = fits_.whitened(from.added);
  const double share = added.dot(rest.left) / rest.lengthOf(added);
  return std::abs(share) < 0.1 ? std::copysign(0.1, share) : share;
}

std::optional<DetectionLimit> EffectSearch::minStrength(const EffectGridPoint& point,
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
