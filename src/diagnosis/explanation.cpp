#include "diagnosis/explanation.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "diagnosis/hypotheses.hpp"
#include "effect_search.hpp"
#include "explanation_fits.hpp"
#include "model/effect.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr int kFirstIterations = 4;

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
  bool doesAsWell(const ExplanationState& effects, const std::vector<Mechanism>& likely) const {
    ExplanationState both = effects;
    both.estimated.insert(likely.begin(), likely.end());
    fits_.evaluateEvidence(both);
    ExplanationState without = *start_;
    without.estimated = both.estimated;
    fits_.evaluateEvidence(without);
    return both.evidence - effects.evidence < rules_.min_gain ||
           ExplanationFits::beyond(both, effects) <
               std::max(fits_.relevanceLimit(both),
                        kCatalogueTolerance * ExplanationFits::beyond(without, *start_));
  }

  /// Effects of the likely mechanisms one after the other, the best first, while each is worth it
  /// and until they do as well as the regressors. Where they do not, or none is of the likeliest
  /// mechanism, its regressors represent it.
  void search(ExplanationState& state, const std::function<void(const std::string&)>& tell) {
    std::vector<Mechanism> likely;
    for (const MechanismProbability& one : likelyMechanisms(found_.mechanisms)) {
      likely.push_back(one.mechanism);
      probability_[one.mechanism] = one.probability;
    }
    bool is_done = false;
    while (static_cast<int>(state.members.size()) < rules_.max_terms && !is_done) {
      std::vector<ExplanationState> members = search_.withMembers(state, likely);
      const auto best = std::find_if(members.begin(), members.end(),
                                     [&](const auto& one) { return isWorth(one, state); });
      if (best == members.end()) break;
      state = std::move(*best);
      fits_.optimize(state);
      dropIdle(state);
      is_done = doesAsWell(state, likely);
      tell("weighing mechanisms (taken in so far: " + join(state.members) + ")");
    }
    const bool has_likeliest =
        std::any_of(state.members.begin(), state.members.end(),
                    [&](const std::string& id) { return mechanismOf(id) == likely.front(); });
    if (has_likeliest && (is_done || doesAsWell(state, likely))) return;
    for (const MechanismProbability& one : mechanismProbabilities(found_.mechanisms)) {
      ExplanationState regressors = fits_.withRegressors(*start_, one.mechanism);
      if (!isWorth(regressors, *start_)) continue;
      probability_[one.mechanism] = one.probability;
      state = std::move(regressors);
      fits_.optimize(state);
      return;
    }
  }

  /// Gain of ln evidence that one more part must bring.
  double neededBeyond(const ExplanationState& state) const {
    return std::max(rules_.min_gain, kCatalogueTolerance * (state.evidence - start_->evidence));
  }

  /// Whether a part has enough evidence and exceeds the relevance threshold. A battery's own law is
  /// never quite the catalogue's: what explains a small share of what is explained is no physics.
  bool isWorth(const ExplanationState& with, const ExplanationState& without) const {
    return with.evidence - without.evidence >= neededBeyond(without) && isRelevant(with, without);
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
      if (state.evidence - without.evidence < rules_.min_gain || !isRelevant(state, without))
        state = std::move(without);
    }
  }

  void finish(ExplanationState& state, ExplanationState& start) {
    fits_.refine(state);
    fits_.evaluateEvidence(start);
    found_.evidence = state.evidence;
    found_.base_evidence = start.evidence;
    found_.model = state.model;
    found_.point = state.point;
    for (const std::string& id : state.members)
      takePlace(state, fits_.withoutMember(state, id), mechanismOf(id), id);
    for (const Mechanism mechanism : state.estimated) {
      ExplanationState without = state;
      without.estimated.erase(mechanism);
      fits_.optimize(without);
      takePlace(state, without, mechanism, "");
    }
    takeRest(state);
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
    if (given_.empty()) one.probability = probability_[mechanism];
    one.rms =
        ExplanationFits::rms(fits_.beyondBase(fits_.modelled(state) - fits_.modelled(without)));
    if (!id.empty()) {
      for (const ExplanationState& member :
           search_.withMembers(without, {kAllMechanisms.begin(), kAllMechanisms.end()})) {
        const std::string& other = member.members.back();
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
    found_.detection_limits = search_.minStrengths(state, neededBeyond(state));
  }

  ExplanationRules rules_;
  std::vector<std::string> given_;
  ExplanationFits fits_;
  EffectSearch search_;
  std::optional<ExplanationState> start_;    // the base circuit alone
  std::map<Mechanism, double> probability_;  // of the likely ones
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
