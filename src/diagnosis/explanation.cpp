#include "diagnosis/explanation.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>

#include "diagnosis/effect_grid.hpp"
#include "diagnosis/residuals.hpp"
#include "model/effect.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr std::size_t kMaxTerms = 5;
// effects that are fitted in a step, and the first of every mechanism
constexpr std::size_t kClosest = 5;
constexpr double kWorthATry = 0.1;  // of the best one's gain on the grid

using Effects = std::vector<std::string>;

BatteryModel composedOf(const Effects& members) {
  BatteryModel model;
  for (const std::string& id : members)
    if (!contains(model.effects(), id)) model = enlarged(model, id);
  return model;
}

std::size_t partsIn(const ExplanationState& state) {
  return state.members.size() + state.estimated.size();
}

/// By what one explanation is taken before another: of two that are as good the one with fewer
/// effects, an equation before regressors.
double rankOf(const ExplanationState& state) {
  return state.evidence - kTie * (static_cast<double>(state.estimated.size()) +
                                  0.5 * static_cast<double>(state.model.effects().size()));
}

/// The mechanism of what a state has in addition to another.
Mechanism addedTo(const ExplanationState& less, const ExplanationState& more) {
  for (const Mechanism mechanism : more.estimated)
    if (!less.estimated.count(mechanism)) return mechanism;
  return mechanismOf(more.members.back());
}

std::string namesOf(const ExplanationState& state) {
  Effects names = state.members;
  if (!state.estimated.empty()) names.push_back("what no equation represents");
  return join(names);
}

class Selection {
 public:
  /// @param ids effects of the grid.
  Selection(ExplanationFits& fits, const Effects& ids, const DiagnoseOptions& options,
            FitComposition fit)
      : options_(options),
        given_(inCatalogueOrder(options.given)),
        fits_(fits),
        fit_(std::move(fit)),
        grid_(fits_, ids, options.threads) {}

  Explanation run() {
    ExplanationState start = fits_.baseState();
    fits_.evaluateEvidence(start);
    takeMechanisms(start, grid_.bestGains(start));
    tell(options_, "comparing mechanisms");
    circuit_ = start;
    ExplanationState now = start;
    for (const std::string& id : given_) {
      std::vector<ExplanationState> with = withEffects(now, {id});
      if (!with.empty()) now = std::move(with.front());
    }
    while (given_.empty() && partsIn(now) < kMaxTerms) {
      std::optional<ExplanationState> next = bestAddition(now);
      if (!next) break;
      if (addedTo(now, *next) == Mechanism::kStructure)
        structure_gain_ += next->evidence - now.evidence;
      now = std::move(*next);
      takeNoise(now);
      tell(options_, "comparing mechanisms (accepted so far: " + namesOf(now) + ")");
    }
    if (given_.empty()) removeWeak(now);
    takeNoise(now);
    fits_.evaluateEvidence(start);
    found_.base_evidence = start.evidence;
    takeTerms(now);
    takeRest(now);
    return std::move(found_);
  }

  /// The rows linearised where a composition was fitted in another way: what the regressors say of
  /// mechanisms in addition to the circuit, and the residual of the composition.
  Explanation around(const CompositionPoint& circuit, const BatteryModel& model,
                     const CompositionPoint& point) {
    ExplanationState start = fits_.baseState();
    moveTo(BatteryModel(), circuit, start);
    takeMechanisms(start, {});
    ExplanationState state = start;
    moveTo(model, point, state);
    found_.model = model;
    found_.point = point;
    takeRest(state);
    return std::move(found_);
  }

  MechanismEvidence mechanisms() {
    ExplanationState start = fits_.baseState();
    fits_.evaluateEvidence(start);
    return evidenceFrom(fits_.sumsOf(start, true).problem, grid_.bestGains(start));
  }

 private:
  /// Puts a state where another fit ended; it stays where the rows have no finite voltage there.
  void moveTo(const BatteryModel& model, const CompositionPoint& point, ExplanationState& state) {
    ExplanationState there = state;
    there.model = model;
    there.members = model.effects();
    there.point = point;
    there.coordinates = fits_.coordinatesOf(model);
    if (!fits_.linearize(there)) return;
    state = std::move(there);
    fits_.takeEffectiveSampleFraction(state);
    fits_.evaluateEvidence(state);
  }

  void takeNoise(ExplanationState& state) {
    fits_.takeNoise(state);
    fits_.evaluateEvidence(state);
  }

  void takeMechanisms(const ExplanationState& start, const std::map<std::string, double>& effects) {
    for (const LinearProblem& half : fits_.halfSamples(fits_.sumsOf(start, true)))
      found_.mechanisms.push_back(evidenceFrom(half, effects));
  }

  /// What rows say for each mechanism in addition to a state: linear fits of its regressors alone,
  /// of all, and of all but its own; its effects on their grids.
  /// @param rows the state's sums with all regressors.  @param effects gains of ln evidence.
  MechanismEvidence evidenceFrom(const LinearProblem& rows,
                                 const std::map<std::string, double>& effects) const {
    const LinearFit full = fits_.fitOf(rows);
    LinearFit start = full;
    for (double& strength : start.strength) strength = std::max(strength, GroupPrior::kFirst);
    const auto of = [&](const std::set<Mechanism>& mechanisms) {
      return fits_.fitOf(fits_.restricted(rows, mechanisms)).evidence;
    };
    const double none = of({});
    MechanismEvidence found;
    for (std::size_t k = 0; k < kMechanisms; ++k) {
      std::set<Mechanism> others(kAllMechanisms.begin(), kAllMechanisms.end());
      others.erase(kAllMechanisms[k]);
      const LinearFit without =
          fitGroupsFrom(fits_.restricted(rows, others), fits_.effectiveSampleFraction(), start);
      found[k] = {of({kAllMechanisms[k]}) - none, full.evidence - without.evidence, 0.0};
    }
    for (const auto& [id, gain] : effects) {
      double& best = found[static_cast<std::size_t>(mechanismOf(id))].effect;
      best = std::max(best, gain);
    }
    return found;
  }

  /// Effects linearised at a point, with regressors beside them.
  /// @return none where the rows have no finite voltage or derivative there.
  std::optional<ExplanationState> placed(const Effects& members,
                                         const std::set<Mechanism>& estimated,
                                         const CompositionPoint& point) const {
    ExplanationState state;
    state.model = composedOf(members);
    state.members = members;
    state.estimated = estimated;
    state.point = point;
    state.coordinates = fits_.coordinatesOf(state.model);
    if (!fits_.linearize(state)) return std::nullopt;
    fits_.evaluateEvidence(state);
    return state;
  }

  /// The same where the effects fit best.
  std::optional<ExplanationState> composed(const Effects& members,
                                           const std::set<Mechanism>& estimated,
                                           const std::vector<CompositionPoint>& starts) const {
    const std::optional<CompositionPoint> point = fit_(composedOf(members), starts);
    return point ? placed(members, estimated, *point) : std::nullopt;
  }

  /// A state with one effect more: from where it stands, from where the grid promises most, and from
  /// there with the circuit at its typical values, as a circuit that has taken the effect up is far
  /// from where it belongs.
  std::optional<ExplanationState> withEffect(const ExplanationState& state,
                                             const EffectGridPoint& from, double strength) const {
    const BatteryModel larger = enlarged(state.model, from.id);
    const CompositionPoint promising = grid_.startOf(state, larger, from, strength);
    CompositionPoint typical = promising;
    typical.parameters.head(kRowUDc) = BatteryModel().typicalParameters().head(kRowUDc);
    Effects members = state.members;
    members.push_back(from.id);
    return composed(members, state.estimated,
                    {embedded(state.model, state.point, larger), promising, typical});
  }

  /// Points of the grid to try in addition to a state, one an effect: the most promising, and the
  /// first of every mechanism. @param only these effects, whatever they promise; empty: all.
  std::vector<std::size_t> promisingPoints(const ExplanationState& state,
                                           const std::vector<GridGain>& gains,
                                           const Effects& only) const {
    const std::vector<EffectGridPoint>& points = grid_.points();
    std::map<std::string, std::size_t> best;
    for (std::size_t g = 0; g < points.size(); ++g) {
      const std::string& id = points[g].id;
      if (state.has(id) || !(only.empty() ? gains[g].value > 0.0 : contains(only, id))) continue;
      if (!best.count(id) || gains[g].value > gains[best[id]].value) best[id] = g;
    }
    std::vector<std::size_t> order, tried;
    for (const auto& one : best) order.push_back(one.second);
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return gains[a].value > gains[b].value; });
    std::set<Mechanism> seen;
    for (const std::size_t g : order) {
      const bool is_first = seen.insert(mechanismOf(points[g].id)).second;
      if (tried.size() < kClosest ||
          (is_first && gains[g].value > kWorthATry * gains[order.front()].value))
        tried.push_back(g);
    }
    return tried;
  }

  /// A state with each of these, best first. @param only as of promisingPoints().
  std::vector<ExplanationState> withEffects(const ExplanationState& state, const Effects& only) {
    const std::vector<GridGain> gains = grid_.gainsOf(state);
    const std::vector<std::size_t> tried = promisingPoints(state, gains, only);
    std::vector<std::optional<ExplanationState>> fitted(tried.size());
    parallelFor(tried.size(), options_.threads, [&](std::size_t k) {
      fitted[k] = withEffect(state, grid_.points()[tried[k]], gains[tried[k]].strength);
    });
    std::vector<ExplanationState> all;
    for (std::optional<ExplanationState>& one : fitted)
      if (one && std::isfinite(one->evidence)) all.push_back(std::move(*one));
    for (const ExplanationState& one : all)
      addWeighed(found_.weighed, one.members.back(), one.evidence - state.evidence);
    std::stable_sort(
        all.begin(), all.end(),
        [](const ExplanationState& a, const ExplanationState& b) { return rankOf(a) > rankOf(b); });
    return all;
  }

  /// Whether a part exceeds the relevance threshold: of all rows, or while cranking.
  bool isRelevant(const ExplanationState& with, const ExplanationState& without) const {
    const Eigen::VectorXd part = fits_.beyondBase(fits_.modelled(with) - fits_.modelled(without));
    return ExplanationFits::rms(part) >= fits_.relevanceLimit(with) ||
           fits_.crankOf(part) >= std::max(options_.relevance.crank, 0.5 * with.fit.noise);
  }

  /// Gain of ln evidence that a mechanism must bring. A battery's own structure is never quite the
  /// catalogue's: the residual of it is no physics.
  double needed(Mechanism mechanism) const {
    const bool is_physics =
        mechanism != Mechanism::kStructure && mechanism != Mechanism::kInstrument;
    return is_physics ? std::max(kMinGain, kCatalogueTolerance * structure_gain_) : kMinGain;
  }

  bool isWorth(const ExplanationState& with, const ExplanationState& without,
               Mechanism mechanism) const {
    return with.evidence - without.evidence >= needed(mechanism) && isRelevant(with, without);
  }
  /// The same of a state's last effect.
  bool isWorth(const ExplanationState& with, const ExplanationState& without) const {
    return isWorth(with, without, mechanismOf(with.members.back()));
  }

  /// Whether an effect represents its mechanism's regressors: as evident, or these add nothing above
  /// the relevance threshold, or no more than a battery's own law differs from the catalogue's.
  /// @param without the mechanism.
  bool doesAsWell(const ExplanationState& effect, const ExplanationState& regressors,
                  Mechanism mechanism, const ExplanationState& without) const {
    if (effect.evidence > regressors.evidence - kTie) return true;
    const ExplanationState both = fits_.withRegressors(effect, mechanism);
    if (both.evidence - effect.evidence < kMinGain) return true;
    return ExplanationFits::beyond(both, effect) <
           std::max(fits_.relevanceLimit(both),
                    kCatalogueTolerance * ExplanationFits::beyond(both, without));
  }

  /// Whether regressors are no more than what the effects named of their mechanism may leave of it.
  bool isRestOfNamed(const ExplanationState& regressors, const ExplanationState& now,
                     Mechanism mechanism) const {
    const bool is_named = std::any_of(now.members.begin(), now.members.end(),
                                      [&](const auto& id) { return mechanismOf(id) == mechanism; });
    return is_named && ExplanationFits::beyond(regressors, now) <
                           kCatalogueTolerance * ExplanationFits::beyond(regressors, circuit_);
  }

  /// Notes what would do as well in the place of the last effect of a state.
  /// @param effects that were fitted beside it, in addition to `now`.
  void takeAlike(const ExplanationState& best, const std::vector<ExplanationState>& effects,
                 const ExplanationState& now) {
    const std::string id = best.members.back();
    for (const ExplanationState& one : effects) {
      const std::string& other = one.members.back();
      // An effect that holds this one is as good as it alone: it adds nothing.
      if (other != id && isWorth(one, now) && one.evidence > best.evidence - kTie &&
          !contains(effectInfo(other).needs, id) && !contains(alike_[id], other))
        alike_[id].push_back(other);
    }
  }

  /// Effects of a mechanism in place of its regressors: one after the other while each is worth it,
  /// until they do as well. None where they never do.
  std::optional<ExplanationState> effectsFor(Mechanism mechanism, const ExplanationState& now,
                                             const ExplanationState& regressors) {
    ExplanationState best = now;
    while (partsIn(best) < kMaxTerms) {
      const std::vector<ExplanationState> effects = withEffects(best, {});
      const auto next =
          std::find_if(effects.begin(), effects.end(), [&](const ExplanationState& one) {
            return mechanismOf(one.members.back()) == mechanism && isWorth(one, best);
          });
      if (next == effects.end()) break;
      takeAlike(*next, effects, best);
      best = *next;
      if (doesAsWell(best, regressors, mechanism, now)) return best;
    }
    return std::nullopt;
  }

  /// The effect or the mechanism's regressors of greatest evidence in addition to a state; its
  /// effects in place of a mechanism's regressors where they do as well. None where none is worth it.
  std::optional<ExplanationState> bestAddition(const ExplanationState& now) {
    const std::vector<ExplanationState> effects = withEffects(now, {});
    const ExplanationState* best = nullptr;
    for (const ExplanationState& one : effects)
      if (!best && isWorth(one, now)) best = &one;
    std::optional<ExplanationState> regressors;
    std::optional<Mechanism> mechanism;
    for (const Mechanism one : kAllMechanisms) {
      if (now.estimated.count(one)) continue;
      ExplanationState with = fits_.withRegressors(now, one);
      const ExplanationState& so_far = regressors ? *regressors : best ? *best : now;
      if (!(rankOf(with) > rankOf(so_far)) || !isWorth(with, now, one) ||
          isRestOfNamed(with, now, one))
        continue;
      regressors = std::move(with);
      mechanism = one;
    }
    if (regressors) {
      std::optional<ExplanationState> effects_of = effectsFor(*mechanism, now, *regressors);
      return effects_of ? effects_of : regressors;
    }
    if (!best) return std::nullopt;
    takeAlike(*best, effects, now);
    return *best;
  }

  /// A state without one of its effects, and those that need it, fitted again; at the circuit where
  /// the rows cannot be linearised at that fit.
  ExplanationState without(const ExplanationState& state, const std::string& id) const {
    Effects others;
    for (const std::string& one : state.members)
      if (one != id && !contains(effectInfo(one).needs, id)) others.push_back(one);
    const BatteryModel model = composedOf(others);
    const CompositionPoint fresh = embedded(BatteryModel(), fits_.base(), model);
    CompositionPoint kept = fresh;
    takeShared(state.model, state.point, model, kept);
    std::optional<ExplanationState> less = composed(others, state.estimated, {kept, fresh});
    if (!less) less = placed(others, state.estimated, fresh);
    if (!less) throw std::invalid_argument("explain: the base circuit has no finite voltage");
    return *less;
  }

  ExplanationState without(const ExplanationState& state, Mechanism mechanism) const {
    ExplanationState less = state;
    less.estimated.erase(mechanism);
    fits_.evaluateEvidence(less);
    return less;
  }

  /// Whether a part stays: worth its place with the others; in a short recording, where what shows
  /// in one event alone has nothing that it could be held against, without any one quarter, too.
  bool stays(const ExplanationState& state, const ExplanationState& less,
             Mechanism mechanism) const {
    if (fits_.isShort())
      return isWorth(state, less, mechanism) && fits_.leastGain(state, less) >= kMinGain;
    return partsIn(state) < 2 || isWorth(state, less, mechanism);
  }

  void removeWeak(ExplanationState& state) const {
    for (const std::string& id : Effects(state.members)) {
      if (!contains(state.members, id)) continue;  // went with what it needs
      const ExplanationState less = without(state, id);
      if (!stays(state, less, mechanismOf(id))) state = less;
    }
    for (const Mechanism mechanism : std::set<Mechanism>(state.estimated)) {
      const ExplanationState less = without(state, mechanism);
      if (!stays(state, less, mechanism)) state = less;
    }
  }

  /// What a part is worth, what it adds, and what could stand in its place.
  void takeTerm(const ExplanationState& state, const ExplanationState& less, Mechanism mechanism,
                const std::string& id) {
    SelectedTerm term{mechanism, id, state.evidence - less.evidence, 0.0, {}, 0.0};
    term.half_gains = fits_.halfSampleGains(state, less);
    term.rms = ExplanationFits::rms(fits_.beyondBase(fits_.modelled(state) - fits_.modelled(less)));
    Effects alike = id.empty() ? Effects() : alike_[id];
    if (!id.empty())
      for (const std::string& same : effectInfo(id).same_as) alike.push_back(same);
    for (const std::string& other : alike)
      if (!state.has(other) && !contains(term.indistinguishable, other))
        term.indistinguishable.push_back(other);
    found_.terms.push_back(std::move(term));
  }

  void takeTerms(const ExplanationState& state) {
    for (const std::string& id : state.members)
      takeTerm(state, without(state, id), mechanismOf(id), id);
    for (const Mechanism mechanism : state.estimated)
      takeTerm(state, without(state, mechanism), mechanism, "");
    std::stable_sort(found_.terms.begin(), found_.terms.end(),
                     [](const SelectedTerm& a, const SelectedTerm& b) { return a.gain > b.gain; });
    found_.evidence = state.evidence;
    found_.model = state.model;
    found_.point = state.point;
  }

  /// What the library would still take.
  void takeRest(const ExplanationState& state) {
    const Eigen::VectorXd left = fits_.beyondBase(fits_.unexplainedPart(state));
    found_.unexplained = {ExplanationFits::rms(left), fits_.crankOf(left),
                          fits_.chargeShareOf(left), options_.relevance, state.fit.noise};
    found_.unexplained.limits.rmse = fits_.relevanceLimit(state);
    found_.effective_sample_fraction = fits_.effectiveSampleFraction();
    found_.edge_jitter = fits_.timingJitterNoise().jitter();
    found_.detection_limits = grid_.minStrengths(state, [&](Mechanism mechanism) {
      return std::max(needed(mechanism), leastNamed(found_.terms, mechanism));
    });
  }

  const DiagnoseOptions& options_;
  const Effects given_;
  ExplanationFits& fits_;
  const FitComposition fit_;
  const EffectGrid grid_;
  ExplanationState circuit_;
  std::map<std::string, Effects> alike_;  // of an effect, in the step that took it
  double structure_gain_ = 0.0;           // of ln evidence, by what was taken of it
  Explanation found_;
};

}  // namespace

void addWeighed(std::vector<WeighedMember>& weighed, const std::string& id, double gain) {
  for (WeighedMember& known : weighed)
    if (known.id == id) {
      known.gain = std::max(known.gain, gain);
      return;
    }
  weighed.push_back({id, gain});
}

MechanismEvidence mechanismEvidence(ExplanationFits& fits, const std::vector<std::string>& ids) {
  const DiagnoseOptions options;
  return Selection(fits, ids, options, {}).mechanisms();
}

Explanation explanationAround(ExplanationFits& fits, const CompositionPoint& circuit,
                              const BatteryModel& model, const CompositionPoint& point,
                              const DiagnoseOptions& options) {
  return Selection(fits, {}, options, {}).around(circuit, model, point);
}

Explanation explain(ExplanationFits& fits, const std::vector<std::string>& ids,
                    const DiagnoseOptions& options, const FitComposition& fit) {
  tell(options, "testing the effects of the catalogue");
  return Selection(fits, options.given.empty() ? ids : options.given, options, fit).run();
}

}  // namespace battery_sof
