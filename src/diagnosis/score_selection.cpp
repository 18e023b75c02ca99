#include "diagnosis/score_selection.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "diagnosis/explanation_fits.hpp"
#include "diagnosis/residuals.hpp"
#include "estimation/depth_physics.hpp"
#include "estimation/fit_window.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr std::size_t kPromising = 4;    // candidates of a step that are scored
constexpr std::size_t kTriedAgain = 10;  // candidates of a step that the next one looks at
constexpr std::size_t kMaxMembers = 5;
constexpr int kFirstSteps = 3;    // of a candidate's fit
constexpr int kFurtherSteps = 8;  // of one that is scored, or that isOfDeep()

using Effects = std::vector<std::string>;

bool holdsAll(const Effects& larger, const Effects& smaller) {
  return std::all_of(smaller.begin(), smaller.end(),
                     [&](const std::string& id) { return contains(larger, id); });
}

/// Without an effect, and without those that need it.
Effects without(const Effects& effects, const std::string& id) {
  Effects others;
  for (const std::string& other : effects)
    if (other != id && !contains(effectInfo(other).needs, id)) others.push_back(other);
  return others;
}

struct ScoredFit {
  FittedModel model;
  BlockScore score;
};

/// An effect added to a composition.
struct Addition {
  std::string id;
  Effects effects;  // with it and what it needs
  Promise promise;
  BlockScore score;
  ScoreGain gain;
};

class Selection {
 public:
  Selection(const Series& series, IndexRange train, const IdentifyOptions& fit,
            const DiagnoseOptions& options)
      : series_(series),
        train_(train),
        fit_(fit),
        options_(options),
        is_deep_(movedCharge(series, train).isDeep(nominalCapacity(options.capacity))),
        most_apart_(fit.source ? kMostApart : HUGE_VAL),
        least_(2.0 * options.relevance.charge_share),
        independent_(0.5 * kIndependentShare * static_cast<double>(train.size())) {
    scoreAll({{}}, nullptr);
  }

  ScoreSelection run(const Effects& ids) {
    Effects members;
    if (!options_.given.empty()) {
      for (const std::string& id : inCatalogueOrder(options_.given)) {
        members = inCatalogueOrder(enlarged(BatteryModel(members), id).effects());
        scoreAll({members}, nullptr);
      }
    } else {
      Effects left = withDeepOnes(ids);
      while (members.size() < kMaxMembers) {
        const std::optional<Addition> best = bestAddition(members, left);
        if (!best) break;
        members = best->effects;
        tell(options_, "testing effects (accepted so far: " + join(members) + ")");
      }
      removeWeak(members);
      weighCycle(ids, members);
    }
    return found(members);
  }

 private:
  /// With what needs a charge that moved far, where it did and all of that is weighed.
  Effects withDeepOnes(Effects ids) const {
    for (const EffectInfo& info : effectCatalogue())
      if (is_deep_ && isOfDeep(info.id) && holdsAll(ids, info.needs) && !contains(ids, info.id) &&
          (!info.on_request || fit_.source))
        ids.push_back(info.id);
    return ids;
  }

  /// Whether an effect has a meaning only where the charge is counted.
  static bool isOfDeep(const std::string& id) {
    return contains(effectInfo(id).needs, kMovedByCharge);
  }

  const ScoredFit& at(const Effects& effects) const { return fits_.at(effects); }

  /// Fits and scores compositions that are not known yet.
  /// @param start in addition, of the one set.
  void scoreAll(const std::vector<Effects>& sets, const CompositionPoint* start) {
    std::vector<Effects> unknown;
    for (const Effects& effects : sets)
      if (!fits_.count(effects) && !contains(unknown, effects)) unknown.push_back(effects);
    std::vector<ScoredFit> scored(unknown.size());
    parallelFor(unknown.size(), options_.threads,
                [&](std::size_t k) { scored[k] = scoredFit(unknown[k], start); });
    for (std::size_t k = 0; k < unknown.size(); ++k)
      fits_.emplace(unknown[k], std::move(scored[k]));
    pulse(options_);
  }

  /// The known composition inside one that has most of its effects; of several the one that predicts
  /// best.
  const ScoredFit* bestInside(const Effects& effects) const {
    const auto rank = [](const auto& one) {
      return std::make_pair(one.first.size(), one.second.score.equations.share());
    };
    const std::pair<const Effects, ScoredFit>* best = nullptr;
    for (const auto& known : fits_)
      if (known.first.size() < effects.size() && holdsAll(effects, known.first) &&
          (!best || rank(known) > rank(*best)))
        best = &known;
    return best ? &best->second : nullptr;
  }

  ScoredFit scoredFit(const Effects& effects, const CompositionPoint* start) const {
    IdentifyOptions fit = fit_;
    fit.effects = effects;
    const BatteryModel model(effects);
    fit.only_starts = true;
    if (start)
      fit.starts = {*start};
    else if (const ScoredFit* inside = bestInside(effects))
      fit.starts =
          startsInLarger(compositionOf(inside->model.fit), optimumOf(inside->model), model);
    FittedModel fitted = identify(series_, train_, fit);
    BlockScore score = scoreBlocks(model, optimumOf(fitted), series_, train_, fit_, kScoreBlocks);
    return {std::move(fitted), std::move(score)};
  }

  ScoreGain gain(const Effects& more, const Effects& less) const {
    return gainOf(at(more).score, at(less).score, most_apart_);
  }

  /// The effects that promise most in addition to some, fitted and scored.
  /// @param ids become those that the next step looks at.
  std::vector<Addition> promisingAdditions(const Effects& members, Effects& ids) {
    std::vector<Addition> additions;
    for (const std::string& id : ids)
      if (!contains(members, id))
        additions.push_back(
            {id, inCatalogueOrder(enlarged(BatteryModel(members), id).effects()), {}, {}, {}});
    const FittedModel& model = at(members).model;
    const FittedCost cost = fittedCost(model, series_, train_, fit_);
    parallelFor(additions.size(), options_.threads, [&](std::size_t k) {
      if (options_.threads == 1) pulse(options_);
      const int steps = isOfDeep(additions[k].id) ? kFurtherSteps : kFirstSteps;
      additions[k].promise =
          promiseOf(model, cost, additions[k].effects, series_, train_, fit_, steps);
    });
    fitAcceptanceToTheEnd(model, cost, additions);
    for (const Addition& one : additions) addWeighed(weighed_, one.id, one.promise.gain);
    std::stable_sort(additions.begin(), additions.end(), [](const Addition& a, const Addition& b) {
      return a.promise.gain > b.promise.gain;
    });
    ids.clear();
    for (const Addition& one : additions)
      if (ids.size() < kTriedAgain || isOfDeep(one.id)) ids.push_back(one.id);
    if (additions.size() > kPromising) additions.resize(kPromising);
    while (!additions.empty() && !(additions.back().promise.gain > 0.0)) additions.pop_back();
    parallelFor(additions.size(), options_.threads, [&](std::size_t k) {
      if (options_.threads == 1) pulse(options_);
      Addition& one = additions[k];
      one.promise = promiseOf(model, cost, one.effects, series_, train_, fit_, kFurtherSteps,
                              &one.promise.point);
      one.score = scoreBlocks(BatteryModel(one.effects), one.promise.point, series_, train_, fit_,
                              kScoreBlocks);
    });
    return additions;
  }

  /// While a charger holds the voltage the circuit's parameters take in what charge acceptance does,
  /// and a few steps from there lead nowhere: until one of its effects is a member they are fitted as
  /// identify() does before it is decided what is scored. Where a tenth of the capacity was moved
  /// that of a charge's end alone is, once the open-circuit voltage's line is the only member, for
  /// the time that these fits take over days.
  void fitAcceptanceToTheEnd(const FittedModel& model, const FittedCost& cost,
                             std::vector<Addition>& additions) const {
    const auto isOfAcceptance = [](const std::string& id) {
      return mechanismOf(id) == Mechanism::kAcceptance;
    };
    if (!fit_.source ||
        std::any_of(model.fit.effects.begin(), model.fit.effects.end(), isOfAcceptance))
      return;
    const bool is_line = model.fit.effects == Effects{kMovedByCharge};
    parallelFor(additions.size(), options_.threads, [&](std::size_t k) {
      Addition& one = additions[k];
      if (!isOfAcceptance(one.id) || (is_deep_ && !(is_line && isOfDeep(one.id)))) return;
      if (options_.threads == 1) pulse(options_);
      IdentifyOptions fit = fit_;
      fit.effects = one.effects;
      fit.starts =
          startsInLarger(compositionOf(model.fit), optimumOf(model), BatteryModel(one.effects));
      const CompositionPoint optimum = optimumOf(identify(series_, train_, fit));
      const Promise promise =
          promiseOf(model, cost, one.effects, series_, train_, fit_, 1, &optimum);
      if (promise.gain > one.promise.gain) one.promise = promise;
    });
  }

  std::optional<Addition> bestAddition(const Effects& members, Effects& ids) {
    std::vector<Addition> additions = promisingAdditions(members, ids);
    const Addition* best = nullptr;
    for (Addition& one : additions) {
      one.gain = gainOf(one.score, at(members).score, most_apart_);
      weighed(one.id).score = one.gain;
      if (one.gain.isAbove(least_) && (!best || one.gain.value > best->gain.value)) best = &one;
    }
    if (!best) return std::nullopt;
    const auto doesAsWell = [&](const Addition& one) {
      return one.gain.isAbove(least_) && !gainOf(best->score, one.score, most_apart_).isAbove(0.0);
    };
    // Of what does as well, the open-circuit voltage is known to have moved: the rest is not needed.
    const auto known = std::find_if(additions.begin(), additions.end(), [&](const Addition& one) {
      return is_deep_ && one.id == kMovedByCharge && doesAsWell(one);
    });
    const bool is_known = known != additions.end();
    if (is_known) best = &*known;
    scoreAll({best->effects}, &best->promise.point);
    if (!gain(best->effects, members).isAbove(least_)) return std::nullopt;
    for (const Addition& other : additions)
      if (!is_known && other.id != best->id && doesAsWell(other))
        alike_[best->id].push_back(other.id);
    return *best;
  }

  void removeWeak(Effects& members) {
    for (const std::string& id : Effects(members)) {
      if (members.size() < 2 || !contains(members, id)) continue;
      if (is_deep_ && id == kMovedByCharge) continue;
      const Effects others = without(members, id);
      scoreAll({others}, nullptr);
      if (!gain(members, others).isAbove(least_)) members = others;
    }
  }

  /// The ends of a charge and of a discharge, and what is between them, are known by each other: one
  /// by one they predict no block. What a cycle calls for is one more composition, scored as a whole.
  void weighCycle(const Effects& ids, Effects& members) {
    const MovedCharge moved = movedCharge(series_, train_);
    if (!moved.isOneCycle()) return;
    Effects cycle = physicsOfDepth(moved, nominalCapacity(options_.capacity),
                                   isVoltageControlled(fit_, train_));
    if (holdsAll(cycle, {kFilledUp, kUsedUp})) cycle.push_back(kLeftByCharge);
    cycle = inCatalogueOrder(cycle);
    if (cycle.empty() || !holdsAll(withDeepOnes(ids), cycle)) return;
    scoreAll({cycle}, nullptr);
    if (gain(cycle, members).isAbove(least_)) members = cycle;
  }

  ScoreSelection found(const Effects& members) {
    ScoreSelection result;
    result.circuit = at({}).model;
    result.circuit_score = at({}).score;
    result.extended = at(members).model;
    result.score = at(members).score;
    for (const std::string& id : members) {
      const Effects others = without(members, id);
      scoreAll({others}, nullptr);
      result.terms.push_back(termOf(id, members, others));
    }
    std::stable_sort(result.terms.begin(), result.terms.end(),
                     [](const SelectedTerm& a, const SelectedTerm& b) { return a.gain > b.gain; });
    result.weighed = weighed_;
    return result;
  }

  /// Gains are ln likelihoods of the left-out rows that count as independent.
  SelectedTerm termOf(const std::string& id, const Effects& with, const Effects& less) const {
    SelectedTerm term{mechanismOf(id), id, independent_ * gain(with, less).value, 0.0, {}, 0.0};
    const Eigen::VectorXd added = equationErrors(at(with).model, series_, train_, fit_) -
                                  equationErrors(at(less).model, series_, train_, fit_);
    term.rms = std::sqrt(added.squaredNorm() / static_cast<double>(added.size()));
    if (const auto known = alike_.find(id); known != alike_.end())
      for (const std::string& other : known->second)
        if (!contains(with, other)) term.indistinguishable.push_back(other);
    const std::vector<double> gains = blockGains(at(with).score, at(less).score, most_apart_);
    const auto ofQuarter = [&](std::size_t quarter) {
      return gains[2 * quarter] + gains[2 * quarter + 1];
    };
    for (std::size_t one = 1; one < kScoreBlocks / 2; ++one)
      for (std::size_t other = 0; other < one; ++other)
        term.half_gains.push_back(0.5 * independent_ * 0.25 * (ofQuarter(one) + ofQuarter(other)));
    return term;
  }

  WeighedMember& weighed(const std::string& id) {
    return *std::find_if(weighed_.begin(), weighed_.end(),
                         [&](const WeighedMember& one) { return one.id == id; });
  }

  const Series& series_;
  const IndexRange train_;
  const IdentifyOptions fit_;
  const DiagnoseOptions& options_;
  const bool is_deep_;        // a tenth of the capacity was moved
  const double most_apart_;   // [1], of a block's gain and the median of all
  const double least_;        // [1], of a ScoreGain
  const double independent_;  // ln likelihood for a ScoreGain of 1
  std::map<Effects, ScoredFit> fits_;
  std::map<std::string, std::vector<std::string>> alike_;
  std::vector<WeighedMember> weighed_;
};

}  // namespace

ScoreSelection selectByScore(const Series& series, IndexRange train, const IdentifyOptions& fit,
                             const std::vector<std::string>& ids, const DiagnoseOptions& options) {
  return Selection(series, train, fit, options).run(ids);
}

}  // namespace battery_sof
