#include "battery_sof/diagnose/naming.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "battery_sof/diagnose/held_out_blocks.hpp"
#include "battery_sof/identify/parallel.hpp"

namespace battery_sof {
namespace {

constexpr int kMostEffects = 7;
constexpr std::size_t kRefitted = 5;       // hypotheses of the highest scores that are refitted in a step
constexpr std::size_t kMostRefitted = 9;   // with their look-alikes
constexpr double kUnconverged = 0.7;       // a refit that gains less than this share of its score is searched again
constexpr int kBlocks = 4;
constexpr double kRival = 30.0;            // evidence behind the winner's within which a rival is refitted in its place

double penaltyOf(const WhitenedFit& fit, const Drive& drive) {
  return std::max(std::log(effectiveSamples(fit.residual, drive)), 6.0);
}

/// Free parameters of a composition beyond the base model's.
double freedomOf(const WhitenedFit& fit) {
  return static_cast<double>(std::count_if(fit.rows.begin(), fit.rows.end(), [&](Eigen::Index row) {
    return row >= kBaseRows && row < fit.model.parameterCount();
  }));
}

double evidenceOf(const WhitenedFit& nested, const WhitenedFit& larger, double penalty) {
  return nested.deviance - larger.deviance - penalty * (freedomOf(larger) - freedomOf(nested));
}

bool isStructure(const std::string& id) { return effectInfo(id).tier() == 'S'; }

struct Weighed {
  Signature signature;
  std::optional<WhitenedFit> fit;
  double evidence = 0.0;
};

void consider(std::vector<std::size_t>& list, std::size_t k) {
  if (std::find(list.begin(), list.end(), k) == list.end() && list.size() < kMostRefitted) list.push_back(k);
}

/// The best scores and their look-alikes.
std::vector<std::size_t> shortlist(const std::vector<Signature>& screened, double least) {
  std::vector<std::size_t> order(screened.size()), list;
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return screened[a].score > screened[b].score; });
  for (const std::size_t k : order)
    if (list.size() < kRefitted && screened[k].score > least) list.push_back(k);
  const std::vector<std::size_t> best = list;
  for (const std::size_t at : best)
    for (const std::string& id : effectInfo(screened[at].id).look_alikes)
      for (std::size_t k = 0; k < screened.size(); ++k)
        if (screened[k].id == id && screened[k].score > 0.5 * least) consider(list, k);
  return list;
}

class Search {
 public:
  Search(const Drive& drive, const WhitenedFit& base, const NamingOptions& options)
      : drive_(drive), options_(options), naming_{base, base, {}, {}, {}, {}, false} {
    search_.rounds = 2;
    search_.max_iterations = 30;
    search_.least_white = options.least_white;
  }

  Naming run() {
    while (static_cast<int>(naming_.accepted.size()) < kMostEffects && step()) {
    }
    if (naming_.last_screen.empty()) naming_.last_screen = screenNow();
    dropSuperfluous();
    compareRivals();
    return std::move(naming_);
  }

 private:
  void tell(const std::string& stage) const {
    if (options_.progress) options_.progress(stage);
  }

  std::vector<Signature> screenNow() const {
    return screen(naming_.extended, drive_, addable(naming_.extended.model, options_.hypotheses), options_.threads);
  }

  WhitenedFit weighed(const WhitenedFit& nested, const Signature& signature) const {
    WhitenedFit fit = refit(nested, drive_, signature, search_);
    if (nested.deviance - fit.deviance > kUnconverged * signature.score) return fit;
    WhitenedSearch wider = search_;
    wider.more_starts = 3;
    WhitenedFit again = refit(nested, drive_, signature, wider);
    return again.deviance < fit.deviance ? again : fit;
  }

  /// One effect more, if there is one to be had.
  bool step() {
    tell("weighing what is missing beside " + std::to_string(naming_.accepted.size()) + " effects");
    naming_.last_screen = screenNow();
    if (naming_.first_screen.empty()) naming_.first_screen = naming_.last_screen;
    const std::vector<std::size_t> list = shortlist(naming_.last_screen, options_.thresholds.score);
    if (list.empty()) return false;
    std::vector<Weighed> weighed_ones(list.size());
    const double penalty = penaltyOf(naming_.extended, drive_);
    parallelFor(list.size(), options_.threads, [&](std::size_t k) {
      Weighed& one = weighed_ones[k];
      one.signature = naming_.last_screen[list[k]];
      one.fit = weighed(naming_.extended, one.signature);
      one.evidence = evidenceOf(naming_.extended, *one.fit, penalty);
    });
    std::stable_sort(weighed_ones.begin(), weighed_ones.end(),
                     [](const Weighed& a, const Weighed& b) { return a.evidence > b.evidence; });
    return takeBest(weighed_ones);
  }

  bool takeBest(std::vector<Weighed>& ones) {
    const std::vector<BlockError> before = heldOutErrors(naming_.extended, drive_, kBlocks, options_.threads);
    std::optional<std::size_t> taken;
    for (std::size_t k = 0; k < ones.size() && k < 3 && !taken; ++k) {
      Candidate candidate = candidateOf(ones, k);
      if (ones[k].evidence <= needed(ones[k].signature.id)) {
        candidate.rejected_because = "its evidence is below what a name needs";
        naming_.unnamed = naming_.unnamed || ones[k].evidence > 0.0;
      } else {
        candidate.rejected_because = judgeHeldOut(before, *ones[k].fit, candidate);
        if (candidate.rejected_because.empty()) taken = k;
      }
      if (!taken) note(candidate);
    }
    if (!taken) return false;
    accept(ones, *taken, before);
    return true;
  }

  double needed(const std::string& id) const { return isStructure(id) ? 0.0 : options_.thresholds.name_evidence; }

  Candidate candidateOf(const std::vector<Weighed>& ones, std::size_t k) const {
    double sum = 0.0;
    for (const Weighed& one : ones) sum += std::exp(0.5 * (one.evidence - ones[0].evidence));
    Candidate candidate{ones[k].signature.id, std::sqrt(ones[k].signature.score), ones[k].evidence, std::nullopt,
                        std::exp(0.5 * (ones[k].evidence - ones[0].evidence)) / sum, ""};
    return candidate;
  }

  void note(const Candidate& candidate) {
    for (Candidate& known : naming_.candidates)
      if (known.id == candidate.id) {
        known = candidate;
        return;
      }
    naming_.candidates.push_back(candidate);
  }

  /// @return why the held-out blocks speak against it; empty when they do not.
  std::string judgeHeldOut(const std::vector<BlockError>& before, const WhitenedFit& fit, Candidate& candidate) const {
    const std::vector<BlockError> after = heldOutErrors(fit, drive_, kBlocks, options_.threads);
    double gain = 0.0, square_before = 0.0, square_after = 0.0;
    int better = 0;
    for (std::size_t b = 0; b < before.size(); ++b) {
      const double by = before[b].deviance - after[b].deviance;
      gain += by;
      better += by > -1.0;
      square_before += before[b].square;
      square_after += after[b].square;
    }
    candidate.holdout_gain_percent = 100.0 * (1.0 - std::sqrt(square_after / std::max(square_before, 1e-300)));
    if (gain <= 0.0) return "blocks held out of the fit are predicted no better with it";
    if (better < kBlocks - 1) return "it helps in too few of the blocks held out of the fit";
    return "";
  }

  void accept(std::vector<Weighed>& ones, std::size_t taken, const std::vector<BlockError>& before) {
    (void)before;
    Accepted accepted;
    accepted.id = ones[taken].signature.id;
    accepted.score = std::sqrt(ones[taken].signature.score);
    accepted.evidence = ones[taken].evidence;
    for (std::size_t k = 0; k < ones.size(); ++k) {
      Candidate candidate = candidateOf(ones, k);
      if (k != taken && ones[k].evidence > ones[taken].evidence - kRival) accepted.tied.push_back(candidate.id);
      if (k != taken) candidate.rejected_because = "another effect explains more of it";
      if (k == taken) accepted.confidence = candidate.confidence;
      if (k == taken) {
        const Candidate known = candidate;
        judgeHeldOut(before, *ones[k].fit, candidate);
      }
      note(candidate);
    }
    for (const std::string& needed_id : effectInfo(accepted.id).needs)
      if (!isAccepted(needed_id)) naming_.accepted.push_back({needed_id, accepted.score, 0.0, 0.0, {}, accepted.confidence});
    naming_.accepted.push_back(accepted);
    naming_.extended = std::move(*ones[taken].fit);
  }

  bool isAccepted(const std::string& id) const {
    return std::any_of(naming_.accepted.begin(), naming_.accepted.end(),
                       [&](const Accepted& accepted) { return accepted.id == id; });
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
    WhitenedSearch search = search_;
    const CompositionPoint start = embedded(naming_.extended.model, naming_.extended.point, smaller);
    WhitenedFit fit = fitWhitened(smaller, drive_, {start, embedded(naming_.base.model, naming_.base.point, smaller)},
                                  naming_.extended.noise, search);
    if (instead.empty()) return fit;
    const std::vector<Signature> one = screen(fit, drive_, {instead}, 1);
    return weighed(fit, one.front());
  }

  /// Backward check: the least worthy effect goes, again and again.
  void dropSuperfluous() {
    while (!naming_.accepted.empty()) {
      tell("checking that every effect is worth its place");
      std::vector<std::optional<WhitenedFit>> without(naming_.accepted.size());
      parallelFor(without.size(), options_.threads, [&](std::size_t k) {
        if (!isNeeded(naming_.accepted[k].id)) without[k] = exchanged(naming_.accepted[k].id, "");
      });
      std::optional<std::size_t> worst;
      double least = 0.0;
      for (std::size_t k = 0; k < without.size(); ++k) {
        if (!without[k]) continue;
        Accepted& one = naming_.accepted[k];
        one.evidence = evidenceOf(*without[k], naming_.extended, penaltyOf(*without[k], drive_));
        const double margin = one.evidence - needed(one.id);
        if (margin <= least) {
          least = margin;
          worst = k;
        }
      }
      if (!worst) return;
      Candidate gone{naming_.accepted[*worst].id, naming_.accepted[*worst].score, naming_.accepted[*worst].evidence,
                     std::nullopt, 0.0, "the others explain it once they are in"};
      note(gone);
      naming_.extended = std::move(*without[*worst]);
      naming_.accepted.erase(naming_.accepted.begin() + static_cast<std::ptrdiff_t>(*worst));
      naming_.last_screen = screenNow();
    }
  }

  /// Keeps of every effect's rivals those that do as well in its place in the final model.
  void compareRivals() {
    tell("comparing what could stand in each effect's place");
    for (std::size_t k = 0; k < naming_.accepted.size(); ++k) {
      Accepted& one = naming_.accepted[k];
      std::vector<std::string> rivals;
      for (const std::string& id : one.tied)
        if (!isAccepted(id) && effectInfo(id).needs.empty()) rivals.push_back(id);
      std::vector<double> behind(rivals.size());
      parallelFor(rivals.size(), options_.threads, [&](std::size_t r) {
        const WhitenedFit fit = exchanged(one.id, rivals[r]);
        const double penalty = penaltyOf(naming_.extended, drive_);
        behind[r] = fit.deviance - naming_.extended.deviance +
                    penalty * (freedomOf(fit) - freedomOf(naming_.extended));
      });
      one.tied.clear();
      double sum = 1.0;
      for (std::size_t r = 0; r < rivals.size(); ++r) {
        sum += std::exp(-0.5 * behind[r]);
        if (behind[r] < options_.thresholds.tie_evidence) one.tied.push_back(rivals[r]);
      }
      one.confidence = 1.0 / sum;
    }
  }

  const Drive& drive_;
  const NamingOptions& options_;
  WhitenedSearch search_;
  Naming naming_;
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

Naming nameEffects(const Drive& drive, const WhitenedFit& base, const NamingOptions& options) {
  return Search(drive, base, options).run();
}

}  // namespace battery_sof
