#include "diagnosis/explanation.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "diagnosis/residuals.hpp"
#include "effect_search.hpp"
#include "model/effect.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr int kFirstIterations = 4;
constexpr double kSettled = 0.1;  // ln evidence
constexpr int kMaxTerms = 5;
constexpr int kSwaps = 3;  // rounds in which places may be taken by what does better

class StepwiseSelection {
 public:
  StepwiseSelection(ExplanationFits& fits, const std::vector<std::string>& ids,
                    const DiagnoseOptions& options)
      : options_(options),
        given_(inCatalogueOrder(options.given)),
        fits_(fits),
        search_(fits_, options.given.empty() ? ids : options.given, options.threads) {}

  Explanation run() {
    ExplanationState start = circuit();
    tell(options_, "testing the effects of the catalogue");
    search_.takeGrid();
    tell(options_, "comparing mechanisms");
    ExplanationState now = start;
    const auto effects = search_.bestGains(now);
    for (const LinearProblem& half : fits_.halfSamples(fits_.sumsOf(now, true)))
      found_.mechanisms.push_back(evidenceFrom(half, effects));
    for (const std::string& id : given_) take(now, id);
    while (given_.empty() &&
           static_cast<int>(now.members.size() + now.estimated.size()) < kMaxTerms && extend(now)) {
      tell(options_, "comparing mechanisms (accepted so far: " + takenIn(now) + ")");
      weighAgain(now);
      fits_.takeEffectiveSampleFraction(now);
      fits_.evaluateEvidence(now);
    }
    finish(now, start);
    return std::move(found_);
  }

  /// The rows linearised where a composition was fitted in another way: what the regressors say of
  /// mechanisms in addition to the circuit, and the residual of the composition.
  Explanation around(const CompositionPoint& circuit, const BatteryModel& model,
                     const CompositionPoint& point) {
    ExplanationState start = fits_.baseState();
    moveTo(BatteryModel(), circuit, start);
    for (const LinearProblem& half : fits_.halfSamples(fits_.sumsOf(start, true)))
      found_.mechanisms.push_back(evidenceFrom(half, {}));
    ExplanationState state = start;
    moveTo(model, point, state);
    found_.model = model;
    found_.point = point;
    takeRest(state);
    return std::move(found_);
  }

  MechanismEvidence mechanisms() {
    const ExplanationState start = circuit();
    search_.takeGrid();
    return evidenceFrom(fits_.sumsOf(start, true).problem, search_.bestGains(start));
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

  /// The base circuit where it fits best.
  ExplanationState circuit() {
    ExplanationState start = fits_.baseState();
    ExplanationState typical = start;
    typical.point.parameters.head(kRowUDc) = BatteryModel().typicalParameters().head(kRowUDc);
    fits_.begin(start, kFirstIterations);
    fits_.begin(typical, kFirstIterations);
    if (typical.evidence > start.evidence) start = std::move(typical);
    fits_.optimize(start);
    return start;
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

  static std::string takenIn(const ExplanationState& state) {
    std::vector<std::string> names = state.members;
    if (!state.estimated.empty()) names.push_back("what no equation represents");
    return join(names);
  }

  /// Takes in what is known to be there.
  void take(ExplanationState& state, const std::string& id) {
    if (state.has(id)) return;
    std::optional<ExplanationState> with = search_.with(state, id);
    if (!with) return;
    state = std::move(*with);
    fits_.takeEffectiveSampleFraction(state);
    fits_.evaluateEvidence(state);
  }

  /// What the effects of a mechanism that a state has explain [V].
  static double explainedBy(Mechanism mechanism, const ExplanationState& state) {
    const bool named =
        std::any_of(state.members.begin(), state.members.end(),
                    [&](const std::string& id) { return mechanismOf(id) == mechanism; });
    return named && state.explained.count(mechanism) ? state.explained.at(mechanism) : 0.0;
  }

  /// Whether effects represent their mechanism's regressors: as evident, or these add nothing above
  /// the relevance threshold, or no more than a battery's own law differs from the catalogue's.
  /// @param without the mechanism.
  bool doesAsWell(const ExplanationState& member, const ExplanationState& regressors,
                  Mechanism mechanism, const ExplanationState& without) const {
    if (member.evidence > regressors.evidence - kTie) return true;
    const ExplanationState both = fits_.withRegressors(member, mechanism);
    if (both.evidence - member.evidence < kMinGain) return true;
    const double mechanism_brings =
        std::hypot(ExplanationFits::beyond(both, without), explainedBy(mechanism, without));
    return ExplanationFits::beyond(both, member) <
           std::max(fits_.relevanceLimit(both), kCatalogueTolerance * mechanism_brings);
  }

  /// What represents a mechanism in addition to a state: the best of its effects where that does as
  /// well as its regressors, else those.
  ExplanationState standingFor(Mechanism mechanism, const ExplanationState& without,
                               const std::vector<ExplanationState>& members) const {
    ExplanationState estimated = fits_.withRegressors(without, mechanism);
    for (const ExplanationState& member : members)
      if (mechanismOf(member.members.back()) == mechanism)
        return doesAsWell(member, estimated, mechanism, without) ? member : estimated;
    return estimated;
  }

  /// The same once a mechanism is chosen: its effects one after the other, while each is worth it,
  /// until they do as well as its regressors.
  ExplanationState membersFor(Mechanism mechanism, const ExplanationState& without,
                              ExplanationState regressors) {
    ExplanationState best = without;
    for (int count = 0; count < kMaxTerms; ++count) {
      const std::vector<ExplanationState> members = search_.withMembers(best, mechanism);
      if (members.empty() || members.front().evidence - best.evidence < kMinGain ||
          !isRelevant(members.front(), best))
        break;
      best = members.front();
      if (doesAsWell(best, regressors, mechanism, without)) return best;
    }
    return regressors;
  }

  /// Whether a part exceeds the relevance threshold: of all rows, or while cranking.
  bool isRelevant(const ExplanationState& with, const ExplanationState& without) const {
    const Eigen::VectorXd part = fits_.beyondBase(fits_.modelled(with) - fits_.modelled(without));
    return ExplanationFits::rms(part) >= fits_.relevanceLimit(with) ||
           fits_.crankOf(part) >= std::max(options_.relevance.crank, 0.5 * with.fit.noise);
  }

  /// Gain of ln evidence that a mechanism must bring. A battery's own structure is never quite the
  /// catalogue's: the residual of it is no physics.
  double needed(const ExplanationState& state, Mechanism mechanism) const {
    const bool physics = mechanism != Mechanism::kStructure && mechanism != Mechanism::kInstrument;
    return physics ? std::max(kMinGain, kCatalogueTolerance * state.structure_gain) : kMinGain;
  }

  /// Whether regressors are no more than what the effects named of their mechanism may leave of it.
  bool isRestOfNamed(const ExplanationState& regressors, const ExplanationState& state,
                     Mechanism mechanism) const {
    if (regressors.estimated.size() == state.estimated.size()) return false;
    return ExplanationFits::beyond(regressors, state) <
           kCatalogueTolerance * std::hypot(ExplanationFits::beyond(regressors, state),
                                            explainedBy(mechanism, state));
  }

  static std::set<std::string> partsOf(const ExplanationState& state) {
    std::set<std::string> parts(state.members.begin(), state.members.end());
    for (const Mechanism mechanism : state.estimated) parts.insert(mechanismId(mechanism));
    return parts;
  }

  /// Takes in the mechanism of greatest evidence. The same parts get the same mechanism once: what
  /// was taken and let go does not come again and again. @return whether one was worth it.
  bool extend(ExplanationState& state) {
    const std::vector<ExplanationState> members = search_.withMembers(state, std::nullopt);
    ExplanationState best = state;
    std::optional<Mechanism> chosen;
    const std::set<std::string> parts = partsOf(state);
    for (const Mechanism mechanism : kAllMechanisms) {
      if (state.estimated.count(mechanism) || tried_.count({parts, mechanism})) continue;
      const ExplanationState of_mechanism = standingFor(mechanism, state, members);
      if (of_mechanism.evidence - state.evidence < needed(state, mechanism)) continue;
      if (!(search_.rankOf(of_mechanism) > search_.rankOf(best)) ||
          !isRelevant(of_mechanism, state) || isRestOfNamed(of_mechanism, state, mechanism))
        continue;
      best = of_mechanism;
      chosen = mechanism;
    }
    if (!chosen) return false;
    tried_.insert({parts, *chosen});
    if (best.estimated.size() > state.estimated.size()) best = membersFor(*chosen, state, best);
    best.explained[*chosen] =
        std::hypot(explainedBy(*chosen, state), ExplanationFits::beyond(best, state));
    if (*chosen == Mechanism::kStructure)
      best.structure_gain = std::max(state.structure_gain, best.evidence - state.evidence);
    state = std::move(best);
    fits_.optimize(state);
    return true;
  }

  /// What its effects of structure are worth together: of two that share it each is worth less.
  void takeStructureGain(ExplanationState& state) {
    std::set<std::string> structure;
    for (const std::string& id : state.members)
      if (mechanismOf(id) == Mechanism::kStructure) structure.insert(id);
    if (structure.empty()) return;
    const ExplanationState without = fits_.withoutMembers(state, structure);
    state.structure_gain = std::max(state.structure_gain, state.evidence - without.evidence);
  }

  /// Each part once more with the others: regressors give way to an effect that does as well, what
  /// is not worth its place goes.
  void weighAgain(ExplanationState& state) {
    if (state.members.size() + state.estimated.size() < 2) return;
    for (const Mechanism mechanism : std::set<Mechanism>(state.estimated)) {
      ExplanationState without = fits_.withoutRegressors(state, mechanism);
      if (state.evidence - without.evidence < kMinGain || !isRelevant(state, without)) {
        state = std::move(without);
        continue;
      }
      const std::vector<ExplanationState> members = search_.withMembers(without, mechanism);
      if (!members.empty() && doesAsWell(members.front(), state, mechanism, without))
        state = members.front();
    }
    takeStructureGain(state);
    for (const std::string& id : std::vector<std::string>(state.members)) {
      if (state.members.size() + state.estimated.size() < 2) return;
      ExplanationState without = fits_.withoutMembers(state, {id});
      const double gain = state.evidence - without.evidence;
      if (gain < needed(state, mechanismOf(id)) || !isRelevant(state, without))
        state = std::move(without);
    }
  }

  /// What shows in one event alone has nothing that it could be held against: in a short recording
  /// the rest must speak for a term without any one quarter, too.
  void removeWhatShowsOnce(ExplanationState& state) {
    for (const std::string& id : std::vector<std::string>(state.members)) {
      ExplanationState without = fits_.withoutMembers(state, {id});
      if (!(fits_.leastGain(state, without) > 0.0)) state = std::move(without);
    }
    for (const Mechanism mechanism : std::set<Mechanism>(state.estimated)) {
      ExplanationState without = fits_.withoutRegressors(state, mechanism);
      if (!(fits_.leastGain(state, without) > 0.0)) state = std::move(without);
    }
  }

  void finish(ExplanationState& state, ExplanationState& start) {
    fits_.refine(state);
    if (given_.empty() && fits_.isShort()) {
      removeWhatShowsOnce(state);
      fits_.refine(state);
    }
    fits_.evaluateEvidence(start);
    found_.base_evidence = start.evidence;
    takePlaces(state);
    std::stable_sort(found_.terms.begin(), found_.terms.end(),
                     [](const SelectedTerm& a, const SelectedTerm& b) { return a.gain > b.gain; });
    takeRest(state);
  }

  /// Every part's place. Where another does better in one, it is taken and the places are weighed
  /// once more.
  void takePlaces(ExplanationState& state) {
    for (int round = 0; round < kSwaps; ++round) {
      found_.terms.clear();
      better_.reset();
      for (const std::string& id : std::vector<std::string>(state.members))
        takePlace(state, fits_.withoutMembers(state, {id}), mechanismOf(id), id);
      for (const Mechanism mechanism : std::set<Mechanism>(state.estimated)) {
        ExplanationState without = fits_.withoutRegressors(state, mechanism);
        takePlace(state, without, mechanism, "");
      }
      if (!better_ || !given_.empty() || round + 1 == kSwaps) break;
      state = std::move(*better_);
      fits_.optimize(state);
    }
    found_.evidence = state.evidence;
    found_.model = state.model;
    found_.point = state.point;
  }

  void weighRival(const ExplanationState& rival, const ExplanationState& state) {
    if (search_.rankOf(rival) > std::max(search_.rankOf(state), better_ ? search_.rankOf(*better_)
                                                                        : search_.rankOf(state)) +
                                    kSettled)
      better_ = rival;
  }

  /// What a part is worth, what it adds, and what could stand in its place.
  void takePlace(const ExplanationState& state, const ExplanationState& without,
                 Mechanism mechanism, const std::string& id) {
    SelectedTerm one{mechanism, id, state.evidence - without.evidence, 0.0, {}, 0.0};
    one.half_gains = fits_.halfSampleGains(state, without);
    one.rms =
        ExplanationFits::rms(fits_.beyondBase(fits_.modelled(state) - fits_.modelled(without)));
    const std::vector<ExplanationState> members = search_.withMembers(without, std::nullopt);
    for (const ExplanationState& member : members) {
      if (!std::isfinite(member.evidence)) continue;
      const double gain = member.evidence - without.evidence;
      const std::string& other = member.members.back();
      // An effect that holds this one is as good as it alone: it adds nothing.
      if (!id.empty() && other != id && gain > one.gain - kTie &&
          !contains(effectInfo(other).needs, id))
        one.indistinguishable.push_back(other);
      if (mechanismOf(other) == mechanism) weighRival(member, state);
    }
    if (!id.empty())
      for (const std::string& alike : effectInfo(id).same_as)
        if (!state.has(alike) && !contains(one.indistinguishable, alike))
          one.indistinguishable.push_back(alike);
    if (id.empty() && !better_)
      for (const ExplanationState& member : members)
        if (mechanismOf(member.members.back()) == mechanism &&
            doesAsWell(member, state, mechanism, without)) {
          better_ = member;
          break;
        }
    for (const Mechanism other : kAllMechanisms) {
      if (without.estimated.count(other) || other == mechanism) continue;
      weighRival(standingFor(other, without, members), state);
    }
    found_.terms.push_back(one);
  }

  /// What the library would still take.
  void takeRest(const ExplanationState& state) {
    const Eigen::VectorXd left = fits_.beyondBase(fits_.unexplainedPart(state));
    found_.unexplained = {ExplanationFits::rms(left), fits_.crankOf(left),
                          fits_.chargeShareOf(left), options_.relevance, state.fit.noise};
    found_.unexplained.limits.rmse = fits_.relevanceLimit(state);
    found_.effective_sample_fraction = fits_.effectiveSampleFraction();
    found_.edge_jitter = fits_.timingJitterNoise().jitter();
    found_.weighed = search_.weighed();
    found_.detection_limits = search_.minStrengths(state, [&](Mechanism mechanism) {
      return std::max(needed(state, mechanism), leastNamed(found_.terms, mechanism));
    });
  }

  const DiagnoseOptions& options_;
  std::vector<std::string> given_;
  ExplanationFits& fits_;
  EffectSearch search_;
  // mechanisms tried with these parts
  std::set<std::pair<std::set<std::string>, Mechanism>> tried_;
  // than the state, by what could stand in a place
  std::optional<ExplanationState> better_;
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
  return StepwiseSelection(fits, ids, options).mechanisms();
}

Explanation explanationAround(ExplanationFits& fits, const CompositionPoint& circuit,
                              const BatteryModel& model, const CompositionPoint& point,
                              const DiagnoseOptions& options) {
  return StepwiseSelection(fits, model.effects(), options).around(circuit, model, point);
}

Explanation explain(ExplanationFits& fits, const std::vector<std::string>& ids,
                    const DiagnoseOptions& options) {
  return StepwiseSelection(fits, ids, options).run();
}

}  // namespace battery_sof
