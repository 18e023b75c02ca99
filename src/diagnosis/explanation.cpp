#include "diagnosis/explanation.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "diagnosis/hypotheses.hpp"
#include "effect_search.hpp"
#include "explanation_fits.hpp"
#include "model/effect.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr int kFirstIterations = 4;
constexpr double kSettled = 0.1;  // ln evidence
constexpr int kSwaps = 2;         // rounds in which places may be taken by what does better

/// Ids in the catalogue's order: what is given is one set, however it was written.
std::vector<std::string> inOrder(const std::vector<std::string>& given) {
  std::vector<std::string> ids;
  for (const EffectInfo& effect : effectCatalogue())
    if (contains(given, effect.id)) ids.push_back(effect.id);
  return ids;
}

class StepwiseSelection {
 public:
  StepwiseSelection(const InputSequence& inputs, std::size_t training, DesignMatrix& table,
                    const CompositionPoint& base, const std::vector<std::string>& ids,
                    const std::vector<std::string>& given, const ExplanationRules& rules)
      : rules_(rules),
        given_(inOrder(given)),
        fits_(inputs, training, table, base, rules),
        search_(fits_, given.empty() ? ids : given, rules) {}

  Explanation run(const std::function<void(const std::string&)>& progress) {
    const auto tell = [&](const std::string& what) {
      if (progress) progress(what);
    };
    ExplanationState start = circuit();
    tell("trying the catalogue's effects");
    search_.takeGrid();
    tell("weighing mechanisms");
    ExplanationState now = start;
    start_ = start;
    for (const std::string& id : given_) take(now, id);
    found_.mechanisms = rules_.mechanisms ? *rules_.mechanisms : evidenceFrom(start);
    found_.mechanisms += rules_.other_recordings;
    if (given_.empty()) search(now, tell);
    finish(now, start);
    return std::move(found_);
  }

  MechanismEvidence mechanisms() {
    const ExplanationState start = circuit();
    search_.takeGrid();
    return evidenceFrom(start);
  }

 private:
  /// The base circuit where it fits best.
  ExplanationState circuit() {
    ExplanationState start = fits_.baseState();
    fits_.takeNoise(start);
    ExplanationState typical = start;
    for (Eigen::Index j = 0; j < kRowUDc; ++j)
      typical.point.parameters[j] = tableOne()[static_cast<std::size_t>(j)].magnitude;
    fits_.begin(start, kFirstIterations);
    fits_.begin(typical, kFirstIterations);
    if (typical.evidence > start.evidence) start = std::move(typical);
    fits_.optimize(start);
    return start;
  }

  /// What the rows say for each mechanism in addition to a state: a linear fit of its regressors
  /// alone, of all, and of all but its own.
  MechanismEvidence evidenceFrom(const ExplanationState& state) const {
    ExplanationState full = state;
    full.estimated.insert(kAllMechanisms.begin(), kAllMechanisms.end());
    fits_.evaluateEvidence(full);
    MechanismEvidence found;
    for (std::size_t k = 0; k < kMechanisms; ++k) {
      ExplanationState without = full;
      without.estimated.erase(kAllMechanisms[k]);
      fits_.evaluateEvidence(without);
      found[k] = {fits_.withRegressors(state, kAllMechanisms[k]).evidence - state.evidence,
                  full.evidence - without.evidence, 0.0};
    }
    for (const auto& [id, gain] : search_.bestGains(state)) {
      double& best = found[static_cast<std::size_t>(mechanismOf(id))].effect;
      best = std::max(best, gain);
    }
    return found;
  }

  /// Takes in what is known to be there.
  void take(ExplanationState& state, const std::string& id) {
    if (ExplanationFits::isUsed(id, state)) return;
    std::optional<ExplanationState> with = search_.with(state, id);
    if (!with) return;
    state = std::move(*with);
    fits_.takeEffectiveSampleFraction(state);
    fits_.evaluateEvidence(state);
  }

  /// Whether effects represent mechanisms: their regressors add nothing to them, nothing above the
  /// relevance threshold, or no more than a battery's own law differs from the catalogue's.
  bool doesAsWell(const ExplanationState& effects, const std::set<Mechanism>& mechanisms) const {
    ExplanationState both = effects;
    both.estimated.insert(mechanisms.begin(), mechanisms.end());
    fits_.evaluateEvidence(both);
    ExplanationState without = *start_;
    without.estimated = both.estimated;
    fits_.evaluateEvidence(without);
    return both.evidence - effects.evidence < rules_.min_gain ||
           ExplanationFits::beyond(both, effects) <
               std::max(fits_.relevanceLimit(both),
                        kCatalogueTolerance * ExplanationFits::beyond(without, *start_));
  }

  static std::set<Mechanism> mechanismsOf(const ExplanationState& state) {
    std::set<Mechanism> mechanisms;
    for (const std::string& id : state.members) mechanisms.insert(mechanismOf(id));
    return mechanisms;
  }

  /// A state with the mechanism's regressors that add most to it, where they are worth it.
  std::optional<ExplanationState> withMostLeft(const ExplanationState& state) const {
    std::optional<ExplanationState> most;
    for (const Mechanism mechanism : kAllMechanisms) {
      ExplanationState with = fits_.withRegressors(state, mechanism);
      if ((!most || with.evidence > most->evidence) && isWorth(with, state, mechanism))
        most = std::move(with);
    }
    return most;
  }

  /// The best effect to add to a state; more than what the effects of its mechanism that are there
  /// may leave. @param only of one mechanism (EffectSearch::withMembers()).
  std::optional<ExplanationState> bestAdded(const ExplanationState& state,
                                            std::optional<Mechanism> only) {
    for (ExplanationState& with : search_.withMembers(state, only)) {
      const Mechanism mechanism = mechanismOf(with.members.back());
      if (!isWorth(with, state, mechanism)) continue;
      const double adds = ExplanationFits::beyond(with, state);
      double& explained = with.explained[mechanism];
      explained = std::hypot(explained, adds);
      if (adds < kCatalogueTolerance * explained) continue;
      return std::move(with);
    }
    return std::nullopt;
  }

  /// Effects one after the other, the best first, while each is worth it; of all mechanisms, then
  /// of the one of which most is left. Those stand that do as well as the regressors of their
  /// mechanisms. Where none does, the regressors of the likeliest mechanism stand that is worth it.
  void search(ExplanationState& state, const std::function<void(const std::string&)>& tell) {
    for (int round = 0;
         round < rules_.max_terms && static_cast<int>(state.members.size()) < rules_.max_terms;
         ++round) {
      std::optional<ExplanationState> next = bestAdded(state, std::nullopt);
      if (!next && !state.members.empty())
        if (const std::optional<ExplanationState> left = withMostLeft(state))
          next = bestAdded(state, *left->estimated.begin());
      if (!next) break;
      if (mechanismOf(next->members.back()) == Mechanism::kStructure)
        next->structure_gain = std::max(state.structure_gain, next->evidence - state.evidence);
      state = std::move(*next);
      fits_.optimize(state);
      dropIdle(state);
      fits_.takeEffectiveSampleFraction(state);
      fits_.evaluateEvidence(state);
      tell("weighing mechanisms (taken in so far: " + join(state.members) + ")");
    }
    fits_.evaluateEvidence(*start_);
    if (!state.members.empty() && doesAsWell(state, mechanismsOf(state))) {
      if (std::optional<ExplanationState> rest = withMostLeft(state);
          rest && !doesAsWell(state, rest->estimated)) {
        state = std::move(*rest);
        fits_.optimize(state);
      }
      return;
    }
    state = *start_;
    for (const MechanismProbability& one : mechanismProbabilities(found_.mechanisms)) {
      ExplanationState regressors = fits_.withRegressors(state, one.mechanism);
      if (!isWorth(regressors, state, one.mechanism)) continue;
      state = std::move(regressors);
      fits_.optimize(state);
      return;
    }
  }

  /// Gain of ln evidence that one more part must bring. A battery's own structure is never quite
  /// the catalogue's: the residual of it is no physics.
  double needed(const ExplanationState& state, Mechanism mechanism) const {
    const bool physics = mechanism != Mechanism::kStructure && mechanism != Mechanism::kInstrument;
    return physics ? std::max(rules_.min_gain, kCatalogueTolerance * state.structure_gain)
                   : rules_.min_gain;
  }

  /// Whether a part has enough evidence and exceeds the relevance threshold; and is no physics that the regressors of structure
  /// hold beside an effect of structure: another circuit than the catalogue's.
  bool isWorth(const ExplanationState& with, const ExplanationState& without,
               Mechanism mechanism) const {
    if (with.evidence - without.evidence < needed(without, mechanism) || !isRelevant(with, without))
      return false;
    if (mechanism == Mechanism::kStructure || mechanism == Mechanism::kInstrument ||
        !(without.structure_gain > 0.0))
      return true;
    return fits_.withRegressors(with, Mechanism::kStructure).evidence -
               fits_.withRegressors(without, Mechanism::kStructure).evidence >=
           rules_.min_gain;
  }

  /// Whether a part exceeds the relevance threshold: of all rows, or while cranking.
  bool isRelevant(const ExplanationState& with, const ExplanationState& without) const {
    const Eigen::VectorXd part = fits_.beyondBase(fits_.modelled(with) - fits_.modelled(without));
    return ExplanationFits::rms(part) >= fits_.relevanceLimit(with) ||
           fits_.crankOf(part) >= std::max(rules_.relevance.crank, 0.5 * with.fit.noise);
  }

  /// Effects that are not worth their place with the others go.
  void dropIdle(ExplanationState& state) {
    for (const std::string& id : std::vector<std::string>(state.members)) {
      if (state.members.size() < 2) return;
      ExplanationState without = fits_.withoutMember(state, id);
      if (mechanismOf(id) == Mechanism::kStructure)
        state.structure_gain = std::max(state.structure_gain, state.evidence - without.evidence);
      if (!isWorth(state, without, mechanismOf(id))) state = std::move(without);
    }
  }

  void finish(ExplanationState& state, ExplanationState& start) {
    fits_.refine(state);
    fits_.evaluateEvidence(start);
    found_.base_evidence = start.evidence;
    takePlaces(state);
    found_.evidence = state.evidence;
    found_.model = state.model;
    found_.point = state.point;
    std::stable_sort(found_.terms.begin(), found_.terms.end(),
                     [](const SelectedTerm& a, const SelectedTerm& b) { return a.gain > b.gain; });
    takeRest(state);
  }

  /// Every part's place. Where another effect does better in one, it is taken and the places are
  /// weighed once more.
  void takePlaces(ExplanationState& state) {
    for (int round = 0; round <= kSwaps; ++round) {
      if (better_) state = *std::exchange(better_, std::nullopt);
      found_.terms.clear();
      for (const std::string& id : state.members)
        takePlace(state, fits_.withoutMember(state, id), mechanismOf(id), id);
      for (const Mechanism mechanism : state.estimated) {
        ExplanationState without = state;
        without.estimated.erase(mechanism);
        fits_.optimize(without);
        takePlace(state, without, mechanism, "");
      }
      if (!better_ || !given_.empty()) return;
      fits_.optimize(*better_);
      dropIdle(*better_);
    }
  }

  /// Whether an effect holds another: as good as that alone, it adds nothing.
  static bool needs(const std::string& id, const std::string& other) {
    const std::vector<std::string>& ids = effectInfo(id).needs;
    return contains(ids, other);
  }

  /// What a part is worth, what it adds, and what could stand in its place.
  void takePlace(const ExplanationState& state, const ExplanationState& without,
                 Mechanism mechanism, const std::string& id) {
    SelectedTerm one{mechanism, id, state.evidence - without.evidence, 0.0, {}, 1.0};
    if (given_.empty())
      for (const MechanismProbability& likely : mechanismProbabilities(found_.mechanisms))
        if (likely.mechanism == mechanism) one.probability = likely.probability;
    one.rms =
        ExplanationFits::rms(fits_.beyondBase(fits_.modelled(state) - fits_.modelled(without)));
    if (!id.empty()) {
      for (const ExplanationState& member : search_.withMembers(without, std::nullopt)) {
        const std::string& other = member.members.back();
        if (search_.rankOf(member) > search_.rankOf(better_ ? *better_ : state) + kSettled)
          better_ = member;
        if (other != id && member.evidence - without.evidence > one.gain - rules_.tie &&
            !needs(other, id))
          one.indistinguishable.push_back(other);
      }
      for (const std::string& alike : effectInfo(id).same_as)
        if (!ExplanationFits::isUsed(alike, state) && !contains(one.indistinguishable, alike))
          one.indistinguishable.push_back(alike);
    }
    found_.terms.push_back(one);
  }

  /// What the library would still take.
  void takeRest(const ExplanationState& state) {
    const Eigen::VectorXd left = fits_.beyondBase(fits_.unexplainedPart(state));
    found_.unexplained_rms = ExplanationFits::rms(left);
    found_.unexplained_crank = fits_.crankOf(left);
    found_.unexplained_charge_share = fits_.chargeShareOf(left);
    found_.noise = state.fit.noise;
    found_.relevant = fits_.relevanceLimit(state);
    found_.effective_sample_fraction = fits_.effective_sample_fraction();
    found_.edge_jitter = fits_.timingJitterNoise().jitter();
    found_.weighed = search_.weighed();
    found_.detection_limits =
        search_.minStrengths(state, [&](Mechanism mechanism) { return needed(state, mechanism); });
  }

  ExplanationRules rules_;
  std::vector<std::string> given_;
  ExplanationFits fits_;
  EffectSearch search_;
  std::optional<ExplanationState> start_;   // the base circuit alone
  std::optional<ExplanationState> better_;  // than the state, with another effect in a place
  Explanation found_;
};

}  // namespace

MechanismEvidence mechanismEvidence(const InputSequence& inputs, DesignMatrix table,
                                    const CompositionPoint& base,
                                    const std::vector<std::string>& ids,
                                    const ExplanationRules& rules) {
  return StepwiseSelection(inputs, inputs.samples.size(), table, base, ids, {}, rules).mechanisms();
}

double minError(const InputSequence& inputs, std::size_t training, const DesignMatrix& table,
                const CompositionPoint& base, const ExplanationRules& rules) {
  DesignMatrix taken = table;
  return ExplanationFits(inputs, training, taken, base, rules).minError();
}

Explanation explain(InputSequence inputs, std::size_t training, DesignMatrix table,
                    const CompositionPoint& base, const std::vector<std::string>& ids,
                    const std::vector<std::string>& given, const ExplanationRules& rules,
                    const std::function<void(const std::string&)>& progress) {
  StepwiseSelection selection(inputs, training, table, base, ids, given, rules);
  // The fits have made their rows of it: a quarter of a gigabyte of ten hours at 100 Hz.
  std::vector<InputSample>().swap(inputs.samples);
  return selection.run(progress);
}

}  // namespace battery_sof
