#include "battery_sof/diagnose/explanation.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "battery_sof/diagnose/hypotheses.hpp"
#include "battery_sof/model/effect.hpp"
#include "battery_sof/recording/words.hpp"
#include "effect_search.hpp"
#include "explanation_fits.hpp"

namespace battery_sof {
namespace {

constexpr int kFirstIterations = 4;
constexpr double kSettled = 0.1;  // nats
constexpr int kSwaps = 3;         // rounds in which places may be taken by what does better

/// Ids in the catalogue's order: what is given is one set, however it was written.
std::vector<std::string> inOrder(const std::vector<std::string>& given) {
  std::vector<std::string> ids;
  for (const EffectInfo& effect : effectCatalogue())
    if (contains(given, effect.id)) ids.push_back(effect.id);
  return ids;
}

class Explainer {
 public:
  Explainer(const Drive& drive, std::size_t training, ForceTable& table, const CompositionPoint& base, const std::vector<std::string>& ids,
            const std::vector<std::string>& given, const ExplanationRules& rules)
      : rules_(rules),
        given_(inOrder(given)),
        fits_(drive, training, table, base, rules),
        search_(fits_, given.empty() ? ids : given, rules) {}

  Explanation run(const std::function<void(const std::string&)>& progress) {
    const auto tell = [&](const std::string& what) {
      if (progress) progress(what);
    };
    ExplanationState start = fits_.baseState();
    fits_.takeNoise(start);
    ExplanationState typical = start;
    for (Eigen::Index j = 0; j < kRowUDc; ++j) typical.point.parameters[j] = tableOne()[static_cast<std::size_t>(j)].magnitude;
    fits_.begin(start, kFirstIterations);
    fits_.begin(typical, kFirstIterations);
    if (typical.evidence > start.evidence) start = std::move(typical);
    fits_.settle(start);
    tell("trying the catalogue's effects");
    search_.takeGrid();
    tell("weighing families");
    ExplanationState now = start;
    for (const std::string& id : given_) take(now, id);
    while (given_.empty() && static_cast<int>(now.members.size() + now.learnt.size()) < rules_.most_components && extend(now)) {
      tell("weighing families (taken in so far: " + takenIn(now) + ")");
      weighAgain(now);
      fits_.takeTemper(now);
      fits_.weigh(now);
    }
    finish(now, start);
    return std::move(found_);
  }

 private:
  static std::string takenIn(const ExplanationState& state) {
    std::vector<std::string> names = state.members;
    if (!state.learnt.empty()) names.push_back("what no equation stands for");
    return listed(names);
  }

  /// Takes in what is known to be there.
  void take(ExplanationState& state, const std::string& id) {
    if (ExplanationFits::isUsed(id, state)) return;
    std::optional<ExplanationState> with = search_.with(state, id);
    if (!with) return;
    state = std::move(*with);
    fits_.takeTemper(state);
    fits_.weigh(state);
  }

  /// What the effects of a family that a state has explain [V].
  static double explainedBy(Family family, const ExplanationState& state) {
    const bool named =
        std::any_of(state.members.begin(), state.members.end(), [&](const std::string& id) { return familyOf(id) == family; });
    return named && state.explained.count(family) ? state.explained.at(family) : 0.0;
  }

  /// Whether effects stand for their family's columns: as evident, or these find nothing beside them that matters, or no more
  /// than a battery's own law differs from the catalogue's. @param without the family.
  bool doesAsWell(const ExplanationState& member, const ExplanationState& columns, Family family, const ExplanationState& without) const {
    if (member.evidence > columns.evidence - rules_.tie) return true;
    const ExplanationState beside = fits_.withColumns(member, family);
    if (beside.evidence - member.evidence < rules_.least_gain) return true;
    const double family_brings = std::hypot(ExplanationFits::beyond(beside, without), explainedBy(family, without));
    return ExplanationFits::beyond(beside, member) < std::max(fits_.relevantBeside(beside), kDiscrepancy * family_brings);
  }

  /// What stands for a family beside a state: the best of its effects where that does as well as its columns, else those.
  ExplanationState standingFor(Family family, const ExplanationState& beside, const std::vector<ExplanationState>& members) const {
    ExplanationState learnt = fits_.withColumns(beside, family);
    for (const ExplanationState& member : members)
      if (familyOf(member.members.back()) == family) return doesAsWell(member, learnt, family, beside) ? member : learnt;
    return learnt;
  }

  /// The same once a family is chosen: its effects one after the other, while each is worth it, until they do as well as its columns.
  ExplanationState membersFor(Family family, const ExplanationState& beside, ExplanationState columns) {
    ExplanationState best = beside;
    for (int count = 0; count < rules_.most_components; ++count) {
      const std::vector<ExplanationState> members = search_.withMembers(best, family);
      if (members.empty() || members.front().evidence - best.evidence < rules_.least_gain || !matters(members.front(), best)) break;
      best = members.front();
      if (doesAsWell(best, columns, family, beside)) return best;
    }
    return columns;
  }

  /// Whether a part moves the voltage by enough to matter: of all rows, or while cranking.
  bool matters(const ExplanationState& with, const ExplanationState& without) const {
    const Eigen::VectorXd part = fits_.besideBase(fits_.modelled(with) - fits_.modelled(without));
    return ExplanationFits::rms(part) >= fits_.relevantBeside(with) ||
           fits_.crankOf(part) >= std::max(rules_.relevance.crank, 0.5 * with.fit.noise);
  }

  /// Nats that a family must bring. A battery's own structure is never quite the catalogue's: what is left of it is no physics.
  double needed(const ExplanationState& state, Family family) const {
    const bool physics = family != Family::kStructure && family != Family::kInstrument;
    return physics ? std::max(rules_.least_gain, kDiscrepancy * state.structure_gain) : rules_.least_gain;
  }

  /// Whether columns are no more than what the effects named of their family may leave of it.
  bool isRestOfNamed(const ExplanationState& columns, const ExplanationState& state, Family family) const {
    if (columns.learnt.size() == state.learnt.size()) return false;
    return ExplanationFits::beyond(columns, state) <
           kDiscrepancy * std::hypot(ExplanationFits::beyond(columns, state), explainedBy(family, state));
  }

  /// Whether physics beside an effect of structure is no more than the structure's columns hold: another circuit than the catalogue's.
  bool isHeldByStructure(const ExplanationState& with, const ExplanationState& without, Family family) const {
    if (family == Family::kStructure || family == Family::kInstrument || !(explainedBy(Family::kStructure, without) > 0.0)) return false;
    return fits_.withColumns(with, Family::kStructure).evidence - fits_.withColumns(without, Family::kStructure).evidence <
           rules_.least_gain;
  }

  static std::set<std::string> partsOf(const ExplanationState& state) {
    std::set<std::string> parts(state.members.begin(), state.members.end());
    for (const Family family : state.learnt) parts.insert(familyId(family));
    return parts;
  }

  /// Takes in the family of greatest evidence. The same parts get the same family once: what was taken and let go does not come
  /// again and again. @return whether one was worth it.
  bool extend(ExplanationState& state) {
    const std::vector<ExplanationState> members = search_.withMembers(state, std::nullopt);
    ExplanationState best = state;
    std::optional<Family> chosen;
    const std::set<std::string> parts = partsOf(state);
    for (const Family family : kAllFamilies) {
      if (state.learnt.count(family) || tried_.count({parts, family})) continue;
      const ExplanationState of_family = standingFor(family, state, members);
      if (of_family.evidence - state.evidence < needed(state, family) || isHeldByStructure(of_family, state, family)) continue;
      if (!(search_.rankOf(of_family) > search_.rankOf(best)) || !matters(of_family, state) || isRestOfNamed(of_family, state, family))
        continue;
      best = of_family;
      chosen = family;
    }
    if (!chosen) return false;
    tried_.insert({parts, *chosen});
    if (best.learnt.size() > state.learnt.size()) best = membersFor(*chosen, state, best);
    best.explained[*chosen] = std::hypot(explainedBy(*chosen, state), ExplanationFits::beyond(best, state));
    if (*chosen == Family::kStructure) best.structure_gain = std::max(state.structure_gain, best.evidence - state.evidence);
    state = std::move(best);
    fits_.settle(state);
    return true;
  }

  /// Each part once more beside the others: columns give way to an effect that does as well, what is not worth its place goes.
  void weighAgain(ExplanationState& state) {
    if (state.members.size() + state.learnt.size() < 2) return;
    for (const Family family : std::set<Family>(state.learnt)) {
      ExplanationState without = state;
      without.learnt.erase(family);
      fits_.settle(without);
      if (state.evidence - without.evidence < rules_.least_gain || !matters(state, without)) {
        state = std::move(without);
        continue;
      }
      const std::vector<ExplanationState> members = search_.withMembers(without, family);
      if (!members.empty() && doesAsWell(members.front(), state, family, without)) state = members.front();
    }
    for (const std::string& id : state.members)
      if (familyOf(id) == Family::kStructure)
        state.structure_gain = std::max(state.structure_gain, state.evidence - fits_.withoutMember(state, id).evidence);
    for (const std::string& id : std::vector<std::string>(state.members)) {
      if (state.members.size() + state.learnt.size() < 2) return;
      ExplanationState without = fits_.withoutMember(state, id);
      if (state.evidence - without.evidence < needed(state, familyOf(id)) || !matters(state, without) ||
          isHeldByStructure(state, without, familyOf(id)))
        state = std::move(without);
    }
  }

  void finish(ExplanationState& state, ExplanationState& start) {
    fits_.polish(state);
    fits_.weigh(start);
    found_.evidence = state.evidence;
    found_.base_evidence = start.evidence;
    found_.model = state.model;
    found_.point = state.point;
    takePlaces(state);
    std::stable_sort(found_.components.begin(), found_.components.end(),
                     [](const Component& a, const Component& b) { return a.gain > b.gain; });
    takeRest(state);
  }

  /// Every part's place. Where another does better in one, it is taken and the places are weighed once more.
  void takePlaces(ExplanationState& state) {
    for (int round = 0; round < kSwaps; ++round) {
      found_.components.clear();
      better_.reset();
      for (const std::string& id : state.members) takePlace(state, fits_.withoutMember(state, id), familyOf(id), id);
      for (const Family family : state.learnt) {
        ExplanationState without = state;
        without.learnt.erase(family);
        fits_.settle(without);
        takePlace(state, without, family, "");
      }
      if (!better_ || !given_.empty() || round + 1 == kSwaps) break;
      state = std::move(*better_);
      fits_.settle(state);
    }
    found_.evidence = state.evidence;
    found_.model = state.model;
    found_.point = state.point;
  }

  /// Whether an effect holds another: as good as that alone, it adds nothing.
  static bool needs(const std::string& id, const std::string& other) {
    const std::vector<std::string>& ids = effectInfo(id).needs;
    return contains(ids, other);
  }

  void weighRival(const ExplanationState& rival, const ExplanationState& state) {
    if (search_.rankOf(rival) > std::max(search_.rankOf(state), better_ ? search_.rankOf(*better_) : search_.rankOf(state)) + kSettled)
      better_ = rival;
  }

  /// What a part is worth, what it adds, and what could stand in its place.
  void takePlace(const ExplanationState& state, const ExplanationState& without, Family family, const std::string& id) {
    Component one{family, id, state.evidence - without.evidence, 0.0, {}, 1.0};
    one.rms = ExplanationFits::rms(fits_.besideBase(fits_.modelled(state) - fits_.modelled(without)));
    std::map<Family, double> rivals = {{family, one.gain}};
    const std::vector<ExplanationState> members = search_.withMembers(without, std::nullopt);
    for (const ExplanationState& member : members) {
      if (!std::isfinite(member.evidence)) continue;
      const double gain = member.evidence - without.evidence;
      const Family of = familyOf(member.members.back());
      if (!id.empty() && member.members.back() != id && gain > one.gain - rules_.tie && !needs(member.members.back(), id))
        one.tied.push_back(member.members.back());
      if (of == family) weighRival(member, state);
      if (!rivals.count(of) || gain > rivals[of]) rivals[of] = gain;
    }
    if (!id.empty())
      for (const std::string& alike : effectInfo(id).same_as)
        if (!ExplanationFits::isUsed(alike, state) && !contains(one.tied, alike)) one.tied.push_back(alike);
    if (id.empty() && !better_)
      for (const ExplanationState& member : members)
        if (familyOf(member.members.back()) == family && doesAsWell(member, state, family, without)) {
          better_ = member;
          break;
        }
    for (const Family other : kAllFamilies) {
      if (without.learnt.count(other) || other == family) continue;
      const ExplanationState standing = standingFor(other, without, members);
      weighRival(standing, state);
      const double gain = standing.evidence - without.evidence;
      if (!rivals.count(other) || gain > rivals[other]) rivals[other] = gain;
    }
    double sum = 0.0;
    for (const auto& rival : rivals) sum += std::exp(rival.second - rivals[family]);
    one.probability = 1.0 / sum;
    found_.components.push_back(one);
  }

  /// What the library would still take.
  void takeRest(const ExplanationState& state) {
    const Eigen::VectorXd left = fits_.besideBase(fits_.leftToLearn(state));
    found_.left_rms = ExplanationFits::rms(left);
    found_.left_crank = fits_.crankOf(left);
    found_.left_charge_share = fits_.chargeShareOf(left);
    found_.noise = state.fit.noise;
    found_.relevant = fits_.relevantBeside(state);
    found_.temper = fits_.temper();
    found_.edge_jitter = fits_.edgeNoise().jitter();
    found_.weighed = search_.weighed();
    found_.least = search_.leastStrengths(state, [&](Family family) { return needed(state, family); });
    double most = rules_.least_gain;
    for (const Family family : kAllFamilies) {
      if (state.learnt.count(family)) continue;
      const double gain = fits_.withColumns(state, family).evidence - state.evidence;
      if (gain <= most) continue;
      most = gain;
      found_.left_family = family;
    }
  }

  ExplanationRules rules_;
  std::vector<std::string> given_;
  ExplanationFits fits_;
  EffectSearch search_;
  std::set<std::pair<std::set<std::string>, Family>> tried_;  // families taken beside these parts
  std::optional<ExplanationState> better_;                    // than the state, by what could stand in a place
  Explanation found_;
};

}  // namespace

double leastError(const Drive& drive, std::size_t training, const ForceTable& table, const CompositionPoint& base,
                  const ExplanationRules& rules) {
  ForceTable taken = table;
  return ExplanationFits(drive, training, taken, base, rules).leastError();
}

Explanation explain(Drive drive, std::size_t training, ForceTable table, const CompositionPoint& base, const std::vector<std::string>& ids,
                    const std::vector<std::string>& given, const ExplanationRules& rules,
                    const std::function<void(const std::string&)>& progress) {
  Explainer explainer(drive, training, table, base, ids, given, rules);
  // The fits have made their rows of it: a quarter of a gigabyte of ten hours at 100 Hz.
  std::vector<DriveSample>().swap(drive.samples);
  return explainer.run(progress);
}

}  // namespace battery_sof
