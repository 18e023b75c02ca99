#include "diagnosis/explanation.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
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
constexpr int kExchanges = 3;     // rounds in which parts may be taken by what does better
constexpr double kSettled = 0.1;  // ln evidence

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
        ids_(ids),
        fits_(fits),
        fit_(std::move(fit)),
        circuit_(fits.baseState()),
        of_circuit_(fits, circuit_, ids, options.threads) {}

  Explanation run() {
    ExplanationState start = fits_.baseState();
    fits_.evaluateEvidence(start);
    takeMechanisms(start, of_circuit_.bestGains(start));
    tell(options_, "comparing mechanisms");
    circuit_ = start;
    ExplanationState now = start;
    for (const std::string& id : given_) {
      std::vector<ExplanationState> with = withEffects(now, {id});
      if (!with.empty()) now = std::move(with.front());
    }
    if (given_.empty()) now = selected(start);
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
    return evidenceFrom(fits_.sumsOf(start, true).problem, of_circuit_.bestGains(start));
  }

 private:
  /// The better of two searches: regressors take part from the beginning, or once no effect is worth
  /// its place, as they take up what several effects together do better. Without regressors the two
  /// are one.
  ExplanationState selected(const ExplanationState& start) {
    ExplanationState mechanisms_first = start, effects_first = start;
    extend(mechanisms_first, &Selection::bestAddition);
    weighAgain(mechanisms_first);
    if (mechanisms_first.estimated.empty()) return mechanisms_first;
    const double structure_gain = std::exchange(structure_gain_, 0.0);
    extend(effects_first, &Selection::bestEffect);
    extend(effects_first, &Selection::bestAddition);
    weighAgain(effects_first);
    takeNoise(effects_first);
    fits_.evaluateEvidence(mechanisms_first);
    if (rankOf(effects_first) > rankOf(mechanisms_first)) return effects_first;
    structure_gain_ = structure_gain;
    return mechanisms_first;
  }

  /// Takes in one part after the other. @param best the next, if any is worth its place.
  void extend(ExplanationState& now,
              std::optional<ExplanationState> (Selection::*best)(const ExplanationState&)) {
    while (partsIn(now) < kMaxTerms) {
      std::optional<ExplanationState> next = (this->*best)(now);
      if (!next) return;
      if (addedTo(now, *next) == Mechanism::kStructure)
        structure_gain_ += next->evidence - now.evidence;
      now = std::move(*next);
      takeNoise(now);
      tell(options_, "comparing mechanisms (accepted so far: " + namesOf(now) + ")");
    }
  }

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
    state.model = composedOf(inCatalogueOrder(members));
    state.members = members;
    state.estimated = estimated;
    state.point = point;
    state.coordinates = fits_.coordinatesOf(state.model);
    if (!fits_.linearize(state)) return std::nullopt;
    fits_.evaluateEvidence(state);
    return state;
  }

  /// Where a composition fits best: of every one once. Called by several threads at once.
  std::optional<CompositionPoint> fitOf(const Effects& members,
                                        const std::vector<CompositionPoint>& starts) {
    const Effects key = inCatalogueOrder(members);
    {
      const std::lock_guard<std::mutex> lock(fitted_mutex_);
      if (const auto known = fitted_.find(key); known != fitted_.end()) return known->second;
    }
    const std::optional<CompositionPoint> point = fit_(composedOf(key), starts);
    const std::lock_guard<std::mutex> lock(fitted_mutex_);
    return fitted_.emplace(key, point).first->second;
  }

  /// The same where the effects fit best.
  std::optional<ExplanationState> composed(const Effects& members,
                                           const std::set<Mechanism>& estimated,
                                           const std::vector<CompositionPoint>& starts) {
    const std::optional<CompositionPoint> point = fitOf(members, starts);
    return point ? placed(members, estimated, *point) : std::nullopt;
  }

  /// A state with one effect more: from where it stands, from where the grid promises most, and from
  /// there with the circuit at its typical values, as a circuit that has taken the effect up is far
  /// from where it belongs.
  std::optional<ExplanationState> withEffect(const ExplanationState& state, const EffectGrid& grid,
                                             const EffectGridPoint& from, double strength) {
    Effects members = state.members;
    members.push_back(from.id);
    const BatteryModel larger = composedOf(inCatalogueOrder(members));
    const CompositionPoint promising = grid.startOf(state, larger, from, strength);
    CompositionPoint typical = promising;
    typical.parameters.head(kRowUDc) = BatteryModel().typicalParameters().head(kRowUDc);
    return composed(members, state.estimated,
                    {embedded(state.model, state.point, larger), promising, typical});
  }

  /// A state with each of these, best first. @param only as of EffectGrid::promising().
  std::vector<ExplanationState> withEffects(const ExplanationState& state, const Effects& only) {
    const EffectGrid grid(fits_, state, ids_, options_.threads);
    const std::vector<GridGain> gains = grid.gainsOf(state);
    const std::vector<std::size_t> tried = grid.promising(gains, only);
    std::vector<std::optional<ExplanationState>> fitted(tried.size());
    parallelFor(tried.size(), options_.threads, [&](std::size_t k) {
      fitted[k] = withEffect(state, grid, grid.points()[tried[k]], gains[tried[k]].strength);
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
      best = *next;
      if (doesAsWell(best, regressors, mechanism, now)) return best;
    }
    return std::nullopt;
  }

  /// The effect of greatest evidence in addition to a state; none where none is worth it.
  std::optional<ExplanationState> bestEffect(const ExplanationState& now) {
    for (const ExplanationState& one : withEffects(now, {}))
      if (isWorth(one, now)) return one;
    return std::nullopt;
  }

  /// The effect or the mechanism's regressors of greatest evidence in addition to a state; its
  /// effects in place of a mechanism's regressors where they do as well. None where none is worth it.
  std::optional<ExplanationState> bestAddition(const ExplanationState& now) {
    const std::optional<ExplanationState> best = bestEffect(now);
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
    return best;
  }

  /// A state without one of its effects, and those that need it, fitted again; at the circuit where
  /// the rows cannot be linearised at that fit.
  ExplanationState without(const ExplanationState& state, const std::string& id) {
    Effects others;
    for (const std::string& one : state.members)
      if (one != id && !contains(effectInfo(one).needs, id)) others.push_back(one);
    const BatteryModel model = composedOf(inCatalogueOrder(others));
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

  /// Takes what does better in a part's place, where there is another part; else lets it go where it
  /// is not worth its place. @param less the state without it.  @return whether either was so.
  bool changePlace(ExplanationState& state, const ExplanationState& less, Mechanism mechanism) {
    if (partsIn(less) > 0) {
      std::optional<ExplanationState> other = bestAddition(less);
      if (other && rankOf(*other) > rankOf(state) + kSettled) {
        state = std::move(*other);
        return true;
      }
    }
    if (stays(state, less, mechanism)) return false;
    state = less;
    return true;
  }

  /// Each part once more with the others, as a later one can make it superfluous.
  void weighAgain(ExplanationState& state) {
    bool changes = true;
    for (int round = 0; round < kExchanges && changes; ++round) {
      takeNoise(state);
      changes = false;
      for (const std::string& id : Effects(state.members))
        if (contains(state.members, id))  // else it went with what it needs
          changes |= changePlace(state, without(state, id), mechanismOf(id));
      for (const Mechanism mechanism : std::set<Mechanism>(state.estimated))
        if (state.estimated.count(mechanism))
          changes |= changePlace(state, without(state, mechanism), mechanism);
    }
  }

  /// Effects that do as well as one in its place. @param less the state without it.
  Effects alike(const ExplanationState& state, const ExplanationState& less,
                const std::string& id) {
    Effects others;
    for (const ExplanationState& one : withEffects(less, {})) {
      const std::string& other = one.members.back();
      // An effect that holds this one is as good as it alone: it adds nothing.
      if (other != id && isWorth(one, less) && one.evidence > state.evidence - kTie &&
          !contains(effectInfo(other).needs, id))
        others.push_back(other);
    }
    for (const std::string& same : effectInfo(id).same_as)
      if (!state.has(same) && !contains(others, same)) others.push_back(same);
    return others;
  }

  /// What a part is worth, and what it adds.
  SelectedTerm termOf(const ExplanationState& state, const ExplanationState& less,
                      Mechanism mechanism, const std::string& id) const {
    SelectedTerm term{mechanism, id, state.evidence - less.evidence, 0.0, {}, 0.0};
    term.half_gains = fits_.halfSampleGains(state, less);
    term.rms = ExplanationFits::rms(fits_.beyondBase(fits_.modelled(state) - fits_.modelled(less)));
    return term;
  }

  void takeTerms(const ExplanationState& state) {
    std::vector<std::pair<SelectedTerm, ExplanationState>> parts;  // and the state without it
    for (const std::string& id : state.members) {
      ExplanationState less = without(state, id);
      parts.emplace_back(termOf(state, less, mechanismOf(id), id), std::move(less));
      if (given_.empty())
        parts.back().first.indistinguishable = alike(state, parts.back().second, id);
    }
    for (const Mechanism mechanism : state.estimated) {
      ExplanationState less = without(state, mechanism);
      parts.emplace_back(termOf(state, less, mechanism, ""), std::move(less));
    }
    std::stable_sort(parts.begin(), parts.end(),
                     [](const auto& a, const auto& b) { return a.first.gain > b.first.gain; });
    for (auto& [term, less] : parts) {
      const Mechanism first = parts.front().first.mechanism;
      if (term.mechanism != first)
        term.is_rest = fits_.withRegressors(state, first).evidence -
                           fits_.withRegressors(less, first).evidence <
                       needed(term.mechanism);
      found_.terms.push_back(term);
    }
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
    found_.detection_limits =
        of_circuit_.minStrengths(state, [&](Mechanism mechanism) { return needed(mechanism); });
  }

  const DiagnoseOptions& options_;
  const Effects given_, ids_;
  ExplanationFits& fits_;
  const FitComposition fit_;
  ExplanationState circuit_;
  const EffectGrid of_circuit_;
  std::mutex fitted_mutex_;
  std::map<Effects, std::optional<CompositionPoint>>
      fitted_;                   // none where no start has a finite cost
  double structure_gain_ = 0.0;  // of ln evidence, by what was taken of it
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

void markRests(std::vector<SelectedTerm>& terms) {
  for (SelectedTerm& term : terms)
    term.is_rest = term.mechanism != terms.front().mechanism &&
                   term.gain < kCatalogueTolerance * terms.front().gain;
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
