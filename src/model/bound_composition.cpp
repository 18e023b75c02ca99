#include "bound_composition.hpp"

#include <algorithm>
#include <numeric>

#include "util/text.hpp"

namespace battery_sof {
namespace {

/// Whether what an effect owns can have a say in the double layer's movement.
bool reachesLayer(const BoundComposition::Member& member) {
  const EffectHooks& hooks = member.effect->hooks;
  return hooks.sense || member.adapts || hooks.side_current || hooks.activity || hooks.is_ladder ||
         hooks.steps_finely;
}

bool isNeeded(const std::string& id, const std::vector<std::string>& effects) {
  return std::any_of(effects.begin(), effects.end(), [&](const std::string& other) {
    return other != kDiscrepancyEffect && contains(effectInfo(other).needs, id);
  });
}

}  // namespace

BoundComposition::BoundComposition(const BatteryModel& composed) : model(composed) {
  for (std::size_t k = 0; k < model.effects().size(); ++k) {
    const std::string& id = model.effects()[k];
    const int parameter = static_cast<int>(model.firstParameter(k));
    if (id == kDiscrepancyEffect) discrepancy_parameter = parameter;
    for (const Effect& effect : allEffects())
      if (effect.info.id == id)
        members.push_back({&effect, parameter, static_cast<int>(model.firstState(k))});
  }
  for (Member& member : members) {
    const EffectHooks& hooks = member.effect->hooks;
    member.adapts = hooks.adapt &&
                    (!hooks.adapts_for_others || isNeeded(member.effect->info.id, model.effects()));
    if (hooks.activity) activity_state = member.state;
    if (hooks.is_ladder) ladder_state = member.state;
    if (hooks.steps_finely) steps_finely = true;
    if (hooks.limits_reaction) limits_reaction = true;
    if (hooks.longest_piece > 0.0 && (longest_piece == 0.0 || hooks.longest_piece < longest_piece))
      longest_piece = hooks.longest_piece;
    if (member.adapts) adapts = true;
  }
}

std::vector<int> BoundComposition::tangentOrder(
    const Eigen::Ref<const Eigen::MatrixXd>& seeds) const {
  std::vector<Eigen::Index> rows = {kRowC2, kRowBeta, model.parameterCount()};
  // An effect that adapts the base model may read all of it.
  if (adapts || steps_finely) rows.insert(rows.end(), {kRowRDischarge, kRowRCharge, kRowUDc});
  for (const Member& member : members) {
    if (!reachesLayer(member)) continue;
    // A side reaction goes with the electrode's voltage against its own equilibrium, not with u_c2
    // alone.
    if (member.effect->hooks.side_current) rows.push_back(kRowUDc);
    const EffectInfo& info = member.effect->info;
    for (std::size_t j = 0; j < info.parameters.size(); ++j)
      rows.push_back(member.parameter + static_cast<Eigen::Index>(j));
    for (std::size_t j = 0; j < info.states.size(); ++j)
      rows.push_back(model.parameterCount() + member.state + static_cast<Eigen::Index>(j));
  }
  std::vector<int> order(seeds.cols());
  std::iota(order.begin(), order.end(), 0);
  std::stable_partition(order.begin(), order.end(),
                        [&](int k) { return (seeds.col(k)(rows).array() != 0.0).any(); });
  return order;
}

}  // namespace battery_sof
