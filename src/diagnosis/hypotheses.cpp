#include "diagnosis/hypotheses.hpp"

#include <algorithm>

#include "model/effect.hpp"
#include "util/text.hpp"

namespace battery_sof {

BatteryModel enlarged(const BatteryModel& model, const std::string& id) {
  std::vector<std::string> effects = model.effects();
  const auto add = [&](const std::string& one) {
    if (!contains(effects, one)) effects.push_back(one);
  };
  for (const std::string& needed : effectInfo(id).needs) add(needed);
  add(id);
  return BatteryModel(effects);
}

std::vector<std::string> hypothesesOf(const std::vector<std::string>& asked,
                                      bool voltage_controlled) {
  if (!asked.empty()) return asked;
  std::vector<std::string> ids;
  for (const EffectInfo& info : effectCatalogue())
    if (!info.on_request || voltage_controlled) ids.push_back(info.id);
  return ids;
}

}  // namespace battery_sof
