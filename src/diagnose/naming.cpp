#include "battery_sof/diagnose/naming.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "battery_sof/diagnose/held_out_blocks.hpp"
#include "battery_sof/diagnose/residual_force.hpp"
#include "battery_sof/diagnose/verdict.hpp"
#include "battery_sof/identify/parallel.hpp"

namespace battery_sof {
namespace {

constexpr double kTolerance = 1e-6;        // of the deviance: far below what decides
constexpr int kMostEffects = 7;
constexpr std::size_t kRefitted = 4;       // hypotheses of the highest scores that are refitted in a step
constexpr std::size_t kMostRefitted = 7;   // with their look-alikes
constexpr double kWorthRefit = 0.05;
constexpr double kUnconverged = 0.7;       // a refit that gains less than this share of its score is searched again
constexpr int kShorterBlocks = 8;          // where the regime of an effect fills one block, the others cannot teach it
constexpr const char* kSecondElectrode = "second_electrode";
constexpr int kMoreStarts = 2;
constexpr int kManyStarts = 5;
constexpr double kPromising = 0.5;           // of the highest score
constexpr int kGivenStarts = 4;             // what is certain to be there is worth a wider search
constexpr std::size_t kJudged = 4;          // of the best whose held-out gain is looked at
constexpr double kLargeShare = 0.3;          // of the held-out RMS error
constexpr double kLeastOfSampling = 0.1;     // of the sampling interval: what is shorter is the filter's before the sampling
constexpr double kDiscrepancy = 0.02;        // of the evidence for a piece of structure: what the true structure may leave beside it
constexpr double kDiscrepancyOfLittle = 0.1; // the same where little of the error goes with it
constexpr double kMuch = 0.5;                // of the held-out RMS error
constexpr double kOmnibusDeviance = 10.0;    // z_O in units of -2 ln likelihood: sqrt(2 k) of some fifty columns
constexpr int kMostExchanges = 3;            // of physics for structure, each with a new search beside it
constexpr const char* kTooSmall = "what it takes out of the error is too small for a name";
constexpr double kRival = 30.0;            // evidence behind the winner's within which a rival is refitted in its place

/// Free parameters of a composition beyond the base model's.
double freedomOf(const WhitenedFit& fit) {
  return static_cast<double>(std::count_if(fit.rows.begin(), fit.rows.end(), [&](Eigen::Index row) {
    return row >= kBaseRows && row < fit.model.parameterCount();
  }));
}

double evidenceOf(const WhitenedFit& nested, const WhitenedFit& larger, double penalty) {
  return nested.deviance - larger.deviance - penalty * (freedomOf(larger) - freedomOf(nested));
}

/// Whether it happens once: the block in which it does cannot be predicted from the others.
bool hasInstant(const std::string& id) {
  const std::vector<ParameterInfo>& parameters = effectInfo(id).parameters;
  return std::any_of(parameters.begin(), parameters.end(), [](const ParameterInfo& info) { return info.instant; });
}

bool isStructure(const std::string& id) { return effectInfo(id).tier() == 'S'; }

struct Weighed {
  Signature signature;
  std::optional<WhitenedFit> fit;
  double evidence = 0.0;
  double share = 0.0;     // of the error on blocks held out of the fit, that it takes out
  bool is_small = false;  // nothing speaks against it but its share of the error
};

// A name takes the least evidence beside the one, the most of what takes much of the error beside the other.
constexpr NameBeside kLeast{1.0, 0.0}, kMost{1.0, std::numeric_limits<double>::infinity()};

bool lists(const std::string& id, const std::string& other) {
  const std::vector<std::string>& alike = effectInfo(id).look_alikes;
  return std::find(alike.begin(), alike.end(), other) != alike.end();
}

bool lookAlike(const std::string& a, const std::string& b) { return lists(a, b) || lists(b, a); }

void consider(std::vector<std::size_t>& list, std::size_t k) {
  if (std::find(list.begin(), list.end(), k) == list.end() && list.size() < kMostRefitted) list.push_back(k);
}

/// The best scores and their look-alikes; what scores a twentieth of the best is not worth a refit.
std::vector<std::size_t> shortlist(const std::vector<Signature>& screened, double significant) {
  double least = significant;
  for (const Signature& signature : screened) least = std::max(least, kWorthRefit * signature.score);
  std::vector<std::size_t> order(screened.size()), list;
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return screened[a].score > screened[b].score; });
  for (const std::size_t k : order)
    if (list.size() < kRefitted && screened[k].score > least) list.push_back(k);
  const std::vector<std::size_t> best = list;
  for (const std::size_t at : best)
    for (std::size_t k = 0; k < screened.size(); ++k)
      if (lookAlike(screened[at].id, screened[k].id) && screened[k].score > 0.5 * significant) consider(list, k);
  return list;
}

class Search {
 public:
  Search(const Drive& drive, const WhitenedFit& base, const NamingOptions& options, Naming so_far)
      : drive_(drive), options_(options), naming_(std::move(so_far)) {
    naming_.extended = base;
    search_.rounds = 2;
    search_.max_iterations = 30;
    search_.every_start = false;
    search_.tolerance = kTolerance;
    search_.least_white = options.least_white;
  }

  Naming run() {
    searchOn();
    for (int k = 0; k < kMostExchanges && exchangeForStructure(); ++k) searchOn();
    compareRivals();
    return std::move(naming_);
  }

 private:
  void tell(const std::string& stage) const {
    if (options_.progress) options_.progress(stage);
  }

  std::vector<Signature> screenNow() const {
    std::vector<std::string> ids;
    for (const std::string& id : addable(naming_.extended.model, options_.hypotheses)) {
      const std::vector<std::string>& twins = effectInfo(id).same_as;
      if (std::none_of(twins.begin(), twins.end(), [&](const std::string& twin) { return isAccepted(twin); })) ids.push_back(id);
    }
    return screen(naming_.extended, drive_, ids, options_.threads);
  }

  void searchOn() {
    while (step()) {
    }
    dropSuperfluous();
  }

  /// A refit that gains much less than its score promised did not converge: it is searched once more, from every start, if
  /// its promise matters beside the best.
  void searchAgain(std::vector<Weighed>& ones, double penalty) const {
    double best = 0.0;
    for (const Weighed& one : ones) best = std::max(best, one.evidence);
    WhitenedSearch wider = search_;
    wider.every_start = true;
    wider.more_starts = kMoreStarts;
    parallelFor(ones.size(), options_.threads, [&](std::size_t k) {
      Weighed& one = ones[k];
      const double promised = kUnconverged * one.signature.score;
      if (naming_.extended.deviance - one.fit->deviance > promised || promised < best) return;
      WhitenedFit again = refit(naming_.extended, drive_, one.signature, wider);
      if (again.deviance >= one.fit->deviance) return;
      one.fit = std::move(again);
      one.evidence = evidenceOf(naming_.extended, *one.fit, penalty);
    });
  }

  /// One effect more, if there is one to be had.
  bool step() {
    tell("weighing what is missing beside " + std::to_string(naming_.accepted.size()) + " effects");
    naming_.last_screen = screenNow();
    if (static_cast<int>(naming_.accepted.size()) >= kMostEffects) return false;
    const std::vector<std::size_t> list = shortlist(naming_.last_screen, options_.thresholds.score);
    if (list.empty()) return false;
    std::vector<Weighed> weighed_ones(list.size());
    const double penalty = penaltyOf(naming_.extended, drive_);
    const double top = naming_.last_screen[list.front()].score;
    parallelFor(list.size(), options_.threads, [&](std::size_t k) {
      Weighed& one = weighed_ones[k];
      one.signature = naming_.last_screen[list[k]];
      const bool has_many_optima = hasInstant(one.signature.id) && one.signature.score > kPromising * top;
      one.fit = refit(naming_.extended, drive_, one.signature, has_many_optima ? searchFor(one.signature.id) : search_);
      fromJoint(one);
      one.evidence = evidenceOf(naming_.extended, *one.fit, penalty);
    });
    searchAgain(weighed_ones, penalty);
    weighStructure(weighed_ones, penalty);
    std::stable_sort(weighed_ones.begin(), weighed_ones.end(),
                     [](const Weighed& a, const Weighed& b) { return a.evidence > b.evidence; });
    putNeededFirst(weighed_ones);
    return takeBest(weighed_ones) || takeSmallStructure(weighed_ones);
  }

  /// Searched from where it was found together with what it needs as well.
  void fromJoint(Weighed& one) const {
    const auto joint = joint_.find(one.signature.id);
    if (joint == joint_.end()) return;
    const CompositionPoint start = embedded(joint->second.model, joint->second.point, one.fit->model);
    WhitenedFit again = fitWhitened(one.fit->model, drive_, {start}, naming_.extended.noise, search_);
    if (again.deviance < one.fit->deviance) one.fit = std::move(again);
  }

  /// What another needs comes before it: what the other adds to it is weighed against all else that could be added, from
  /// where the two were found together.
  void putNeededFirst(std::vector<Weighed>& ones) {
    joint_.clear();
    for (std::size_t k = 0; k < ones.size(); ++k)
      for (const std::string& id : effectInfo(ones[k].signature.id).needs) {
        const auto behind = std::find_if(ones.begin() + static_cast<std::ptrdiff_t>(k), ones.end(), [&](const Weighed& one) { return one.signature.id == id; });
        if (behind == ones.end() || behind->evidence <= needed(id, kMost)) continue;
        joint_.emplace(ones[k].signature.id, *ones[k].fit);
        std::rotate(ones.begin() + static_cast<std::ptrdiff_t>(k), behind, behind + 1);
      }
  }

  /// Before physics is named, every piece of structure is refitted, whatever it scored: a signature of finite strength is a
  /// poor guide to one that is far from linear.
  void weighStructure(std::vector<Weighed>& ones, double penalty) const {
    const auto best = std::max_element(ones.begin(), ones.end(), [](const Weighed& a, const Weighed& b) { return a.evidence < b.evidence; });
    if (isStructure(best->signature.id)) return;
    std::vector<Signature> structure;
    for (const Signature& signature : naming_.last_screen)
      if (isStructure(signature.id)) structure.push_back(signature);
    std::vector<WhitenedFit> fits(structure.size());
    parallelFor(structure.size(), options_.threads, [&](std::size_t k) {
      fits[k] = refit(naming_.extended, drive_, structure[k], searchFor(structure[k].id));
    });
    for (std::size_t k = 0; k < structure.size(); ++k) {
      const double evidence = evidenceOf(naming_.extended, fits[k], penalty);
      Weighed weighed;
      weighed.signature = structure[k];
      weighed.fit = std::move(fits[k]);
      weighed.evidence = evidence;
      const auto known = std::find_if(ones.begin(), ones.end(), [&](const Weighed& one) { return one.signature.id == structure[k].id; });
      if (known == ones.end())
        ones.push_back(weighed);
      else if (evidence > known->evidence)
        *known = weighed;
    }
  }

  /// From more starts where there are many local optima: electrodes that can change places, something that happens at one instant.
  WhitenedSearch searchFor(const std::string& id) const {
    WhitenedSearch search = search_;
    search.every_start = id == kSecondElectrode || hasInstant(id);
    search.more_starts = search.every_start ? kManyStarts : 0;
    return search;
  }

  bool takeBest(std::vector<Weighed>& ones) {
    before_.clear();
    for (std::size_t k = 0; k < ones.size(); ++k) {
      Candidate candidate = candidateOf(ones, k);
      candidate.rejected_because = k < kJudged ? objectionTo(ones[k], candidate) : "others explain more of it";
      note(candidate);
      if (!candidate.rejected_because.empty()) continue;
      accept(ones, k, candidate);
      return true;
    }
    return false;
  }

  /// Where nothing can be named: a piece of structure whose share of the error is small may be in the shadow of something
  /// larger that shows only once it is in. Its share is judged when the search is over.
  bool takeSmallStructure(std::vector<Weighed>& ones) {
    for (std::size_t k = 0; k < ones.size(); ++k) {
      if (!ones[k].is_small || !isStructure(ones[k].signature.id) || wasSmall(ones[k].signature.id)) continue;
      tried_small_.push_back(ones[k].signature.id);
      naming_.unnamed = false;
      const Candidate candidate = candidateOf(ones, k);
      note(candidate);
      accept(ones, k, candidate);
      return true;
    }
    return false;
  }

  /// @return what speaks against naming it; empty when nothing does.
  std::string objectionTo(Weighed& one, Candidate& candidate) {
    one.is_small = false;
    if (one.evidence <= 0.0) return "it is not worth its parameters";
    HeldOutGain gain = heldOutGain(one, kHeldOutBlocks);
    std::string objection = objectionOfBlocks(gain, one.signature.id, kHeldOutBlocks);
    if (!objection.empty() && one.evidence > needed(one.signature.id, kLeast)) {
      gain = heldOutGain(one, kShorterBlocks);
      objection = objectionOfBlocks(gain, one.signature.id, kShorterBlocks);
    }
    one.share = gain.rms_share;
    candidate.holdout_gain_percent = 100.0 * gain.rms_share;
    if (!objection.empty()) return objection;
    if (isBelowSampling(one)) return "it is shorter than the sampling can show";
    naming_.unnamed = true;
    if (!isWorthAName(one)) return "its evidence is below what a name needs";
    const double least = isStructure(one.signature.id) ? options_.thresholds.least_structure_share : options_.thresholds.least_share;
    one.is_small = gain.rms_share < least;
    if (one.is_small) return kTooSmall;
    naming_.unnamed = false;
    return "";
  }

  /// Whether its only strength is a time that is a small part of the sampling interval.
  bool isBelowSampling(const Weighed& one) const {
    const EffectInfo& info = effectInfo(one.signature.id);
    if (!info.acts_at_edges) return false;
    return std::any_of(info.parameters.begin(), info.parameters.end(), [&](const ParameterInfo& parameter) {
      return parameter.vanishes_at && !parameter.held && parameter.unit == "s" &&
             std::abs(one.fit->point.parameters[*one.fit->model.parameterRow(parameter.name)]) < kLeastOfSampling * options_.interval;
    });
  }

  /// What blocks held out of the fit gain by it. The errors without it are kept for the next that asks.
  HeldOutGain heldOutGain(const Weighed& one, int blocks) {
    if (before_.count(blocks) == 0) before_[blocks] = heldOutErrors(naming_.extended, drive_, blocks, options_.threads);
    const HeldOut after = heldOutErrors(*one.fit, drive_, blocks, options_.threads);
    return gainOf(before_[blocks], after, drive_, one.fit->residual - naming_.extended.residual);
  }

  /// A block in which alone an effect shows cannot be predicted without it; a large fall of the error still counts.
  std::string objectionOfBlocks(const HeldOutGain& gain, const std::string& id, int blocks) const {
    if (gain.worse_blocks > blocks / kHeldOutBlocks && gain.rms_share < kLargeShare) return "it makes several of the blocks held out of the fit worse";
    const double large = hasInstant(id) ? options_.thresholds.least_share : kLargeShare;
    if (gain.deviance <= 0.0 && gain.rms_share < large) return "blocks held out of the fit are predicted no better with it";
    return "";
  }

  double needed(const std::string& id, const NameBeside& beside) const { return evidenceNeeded(id, naming_.accepted, options_.thresholds, beside); }

  /// What takes out little may be followed by what explains the rest: that is judged when the search is over.
  bool isWorthAName(const Weighed& one) const {
    const std::string& id = one.signature.id;
    if (one.evidence <= needed(id, {one.share, kLeast.left})) return false;
    return one.share < kMuch || one.evidence > needed(id, kMost) || one.evidence > needed(id, {one.share, leftUnexplained(*one.fit, drive_)});
  }

  Candidate candidateOf(const std::vector<Weighed>& ones, std::size_t k) const {
    double sum = 0.0;
    for (const Weighed& one : ones) sum += std::exp(0.5 * (one.evidence - ones[0].evidence));
    Candidate candidate{ones[k].signature.id, std::sqrt(ones[k].signature.score), ones[k].evidence, std::nullopt,
                        std::exp(0.5 * (ones[k].evidence - ones[0].evidence)) / sum, ""};
    return candidate;
  }

  void note(Candidate candidate) {
    if (!candidate.rejected_because.empty()) candidate.confidence = 0.0;
    for (Candidate& known : naming_.candidates)
      if (known.id == candidate.id) {
        known = candidate;
        return;
      }
    naming_.candidates.push_back(candidate);
  }

  void accept(std::vector<Weighed>& ones, std::size_t taken, const Candidate& candidate) {
    Accepted accepted;
    accepted.id = ones[taken].signature.id;
    accepted.score = candidate.score;
    accepted.evidence = candidate.evidence;
    accepted.confidence = candidate.confidence;
    accepted.share = ones[taken].share;
    for (std::size_t k = 0; k < ones.size(); ++k) {
      if (k == taken) continue;
      if (ones[k].evidence > ones[taken].evidence - kRival) accepted.tied.push_back(ones[k].signature.id);
      Candidate other = candidateOf(ones, k);
      other.rejected_because = "another effect explains more of it";
      if (k > taken) note(other);
    }
    for (const std::string& needed_id : effectInfo(accepted.id).needs)
      if (!isAccepted(needed_id)) naming_.accepted.push_back({needed_id, accepted.score, 0.0, 0.0, {}, accepted.confidence, accepted.share});
    naming_.accepted.push_back(accepted);
    naming_.extended = std::move(*ones[taken].fit);
  }

  bool wasSmall(const std::string& id) const { return std::find(tried_small_.begin(), tried_small_.end(), id) != tried_small_.end(); }

  bool isAccepted(const std::string& id) const {
    return std::any_of(naming_.accepted.begin(), naming_.accepted.end(),
                       [&](const Accepted& accepted) { return accepted.id == id; });
  }

  /// Whether this search may judge it: what another grid shows is judged there.
  bool isOpen(const std::string& id) const {
    return options_.hypotheses.empty() ||
           std::find(options_.hypotheses.begin(), options_.hypotheses.end(), id) != options_.hypotheses.end();
  }

  bool isNeeded(const std::string& id) const {
    for (const Accepted& accepted : naming_.accepted) {
      const std::vector<std::string>& needs = effectInfo(accepted.id).needs;
      if (std::find(needs.begin(), needs.end(), id) != needs.end()) return true;
    }
    return false;
  }

  /// The extended model with `without` taken out and `instead` put in its place, fitted anew.
  WhitenedFit exchanged(const std::string& without, const std::string& instead) const {
    std::vector<std::string> effects;
    for (const std::string& id : naming_.extended.model.effects())
      if (id != without) effects.push_back(id);
    const BatteryModel smaller(effects);
    const CompositionPoint start = embedded(naming_.extended.model, naming_.extended.point, smaller);
    WhitenedFit fit = fitWhitened(smaller, drive_, {start, typicalStart(smaller, drive_)}, naming_.extended.noise, search_);
    if (instead.empty()) return fit;
    return refit(fit, drive_, screen(fit, drive_, {instead}, 1).front(), searchFor(instead));
  }

  /// Physics that was taken in before a piece of structure was seen beside it, and for which that piece does better, gives
  /// way to it. @return whether something did.
  bool exchangeForStructure() {
    std::vector<std::pair<std::size_t, std::string>> pairs;
    for (const std::string& id : addable(naming_.extended.model, options_.hypotheses))
      for (std::size_t k = 0; isStructure(id) && k < naming_.accepted.size(); ++k)
        if (const std::string& known = naming_.accepted[k].id; !isStructure(known) && isOpen(known) && !isNeeded(known)) pairs.push_back({k, id});
    if (pairs.empty()) return false;
    tell("checking that no structure does better than what was named");
    std::vector<WhitenedFit> fits(pairs.size());
    std::vector<double> behind(pairs.size());
    const double penalty = penaltyOf(naming_.extended, drive_);
    parallelFor(pairs.size(), options_.threads, [&](std::size_t p) {
      fits[p] = exchanged(naming_.accepted[pairs[p].first].id, pairs[p].second);
      behind[p] = evidenceOf(fits[p], naming_.extended, penalty);
    });
    behind_.clear();
    const auto best = std::min_element(behind.begin(), behind.end());
    if (*best >= 0.0) {
      for (std::size_t p = 0; p < pairs.size(); ++p) behind_[{naming_.accepted[pairs[p].first].id, pairs[p].second}] = behind[p];
      return false;
    }
    const auto at = static_cast<std::size_t>(best - behind.begin());
    Accepted& one = naming_.accepted[pairs[at].first];
    note({one.id, one.score, one.evidence, std::nullopt, 0.0, pairs[at].second + " does better in its place"});
    note({pairs[at].second, 0.0, one.evidence - *best, std::nullopt, 1.0, ""});
    one = {pairs[at].second, 0.0, one.evidence - *best, 0.0, {}, 1.0};
    naming_.extended = std::move(fits[at]);
    return true;
  }

  /// Backward check: the least worthy effect goes, again and again.
  void dropSuperfluous() {
    while (!naming_.accepted.empty()) {
      tell("checking that every effect is worth its place");
      std::vector<std::optional<WhitenedFit>> without(naming_.accepted.size());
      parallelFor(without.size(), options_.threads, [&](std::size_t k) {
        if (isOpen(naming_.accepted[k].id) && !isNeeded(naming_.accepted[k].id)) without[k] = exchanged(naming_.accepted[k].id, "");
      });
      std::optional<std::size_t> worst;
      double least = 0.0;
      const double left = leftUnexplained(naming_.extended, drive_);
      for (std::size_t k = 0; k < without.size(); ++k) {
        if (!without[k]) continue;
        Accepted& one = naming_.accepted[k];
        one.evidence = evidenceOf(*without[k], naming_.extended, penaltyOf(*without[k], drive_));
        const Eigen::VectorXd adds = without[k]->residual - naming_.extended.residual;
        one.rms = std::sqrt(adds.squaredNorm() / static_cast<double>(adds.size()));
        const bool is_small = wasSmall(one.id) && addedRatio(adds, naming_.extended.residual, drive_) < leastAddedRatio(options_.thresholds.least_structure_share);
        double margin = one.evidence - needed(one.id, {one.share, left});
        if (is_small) margin = std::min(margin, -one.evidence);
        if (margin <= least) {
          least = margin;
          worst = k;
        }
      }
      if (!worst) return;
      const Accepted& gone = naming_.accepted[*worst];
      const bool is_unnamed = gone.evidence > needed(gone.id, {gone.share, left});
      naming_.unnamed = naming_.unnamed || is_unnamed;
      note({gone.id, gone.score, gone.evidence, std::nullopt, 0.0, is_unnamed ? kTooSmall : "the others explain it once they are in"});
      naming_.extended = std::move(*without[*worst]);
      naming_.accepted.erase(naming_.accepted.begin() + static_cast<std::ptrdiff_t>(*worst));
      naming_.last_screen = screenNow();
    }
  }

  /// Keeps of every effect's rivals those that do as well in its place in the final model and would be worth a name there.
  void compareRivals() {
    tell("comparing what could stand in each effect's place");
    const double left = leftUnexplained(naming_.extended, drive_);
    for (std::size_t k = 0; k < naming_.accepted.size(); ++k) {
      Accepted& one = naming_.accepted[k];
      if (!isOpen(one.id)) continue;
      if (isNeeded(one.id)) {
        one.tied.clear();
        one.confidence = 1.0;
        continue;
      }
      std::vector<std::string> rivals;
      for (const std::string& id : one.tied)
        if (!isAccepted(id) && effectInfo(id).needs.empty()) rivals.push_back(id);
      for (const std::string& id : addable(naming_.extended.model, options_.hypotheses))
        if (!isStructure(one.id) && (isStructure(id) || lookAlike(one.id, id)) && effectInfo(id).needs.empty() &&
            std::find(rivals.begin(), rivals.end(), id) == rivals.end())
          rivals.push_back(id);
      std::vector<double> behind(rivals.size());
      parallelFor(rivals.size(), options_.threads, [&](std::size_t r) {
        const auto known = behind_.find({one.id, rivals[r]});
        behind[r] = known != behind_.end() ? known->second
                                           : evidenceOf(exchanged(one.id, rivals[r]), naming_.extended, penaltyOf(naming_.extended, drive_));
      });
      one.tied.clear();
      double sum = 1.0;
      for (std::size_t r = 0; r < rivals.size(); ++r) {
        sum += std::exp(-0.5 * behind[r]);
        const bool is_worth_a_name = one.evidence - behind[r] > needed(rivals[r], {one.share, left});
        if (behind[r] < options_.thresholds.tie_evidence && is_worth_a_name) one.tied.push_back(rivals[r]);
      }
      one.confidence = 1.0 / sum;
    }
  }

  const Drive& drive_;
  const NamingOptions& options_;
  WhitenedSearch search_;
  Naming naming_;
  std::map<std::pair<std::string, std::string>, double> behind_;  // evidence that an exchange loses, by what goes and what comes
  std::vector<std::string> tried_small_;  // structure taken in without its share of the error
  std::map<std::string, WhitenedFit> joint_;  // fits of what came behind what it needs, of the step before
  std::map<int, HeldOut> before_;  // errors of the extended model on so many blocks
};

}  // namespace

double effectiveSamples(const Eigen::VectorXd& residual, const Drive& drive) {
  std::vector<double> e;
  for (std::size_t n = 0; n < drive.samples.size(); ++n)
    if (drive.samples[n].count > 0.0) e.push_back(residual[static_cast<Eigen::Index>(n)]);
  const double n = static_cast<double>(e.size());
  if (e.size() < 3) return n;
  const double mean = std::accumulate(e.begin(), e.end(), 0.0) / n;
  double variance = 0.0;
  for (double& value : e) {
    value -= mean;
    variance += value * value;
  }
  double sum = 0.0;
  for (std::size_t lag = 1; lag < e.size() / 2 && variance > 0.0; ++lag) {
    double product = 0.0;
    for (std::size_t k = lag; k < e.size(); ++k) product += e[k] * e[k - lag];
    if (product <= 0.0) break;
    sum += product / variance;
  }
  return n / (1.0 + 2.0 * sum);
}

double penaltyOf(const WhitenedFit& fit, const Drive& drive) {
  return std::max(std::log(effectiveSamples(fit.residual, drive)), 6.0);
}

double evidenceNeeded(const std::string& id, const std::vector<Accepted>& accepted, const DiagnosisThresholds& thresholds,
                      const NameBeside& beside) {
  if (isStructure(id)) return thresholds.structure_evidence;
  double structure = 0.0;
  for (const Accepted& one : accepted)
    if (isStructure(one.id) && !effectInfo(one.id).acts_at_edges) structure = std::max(structure, one.evidence);
  if (effectInfo(id).acts_at_edges) return std::max(thresholds.name_evidence, kDiscrepancy * structure);
  if (structure == 0.0) return thresholds.name_evidence;
  if (beside.share < kMuch) return std::max({thresholds.name_evidence, kDiscrepancyOfLittle * structure, beside.left});
  return std::max(thresholds.name_evidence, std::min(kDiscrepancy * structure, beside.left));
}

double leftUnexplained(const WhitenedFit& fit, const Drive& drive) { return kOmnibusDeviance * std::max(0.0, omnibusZ(fit, drive)); }

Naming nameEffects(const Drive& drive, const WhitenedFit& start, const NamingOptions& options, Naming so_far) {
  return Search(drive, start, options, std::move(so_far)).run();
}

Naming withEffects(const Drive& drive, const WhitenedFit& start, const std::vector<std::string>& ids,
                   const WhitenedSearch& search, Naming so_far) {
  so_far.extended = start;
  for (const std::string& id : ids) {
    const std::vector<std::string>& there = so_far.extended.model.effects();
    if (std::find(there.begin(), there.end(), id) != there.end()) continue;
    const Signature signature = screen(so_far.extended, drive, {id}, 1).front();
    WhitenedSearch wider = search;
    wider.more_starts = kGivenStarts;
    WhitenedFit larger = refit(so_far.extended, drive, signature, wider);
    Accepted accepted;
    accepted.id = id;
    accepted.score = std::sqrt(signature.score);
    accepted.evidence = evidenceOf(so_far.extended, larger, penaltyOf(so_far.extended, drive));
    const Eigen::VectorXd adds = so_far.extended.residual - larger.residual;
    accepted.rms = std::sqrt(adds.squaredNorm() / static_cast<double>(adds.size()));
    accepted.confidence = 1.0;
    so_far.accepted.push_back(accepted);
    so_far.extended = std::move(larger);
  }
  so_far.last_screen = screen(so_far.extended, drive, addable(so_far.extended.model, {}), 1);
  return so_far;
}

}  // namespace battery_sof
