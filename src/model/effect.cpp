#include "model/effect.hpp"

#include <algorithm>
#include <stdexcept>

#include "effects/effect_definition.hpp"
#include "util/text.hpp"

namespace battery_sof {

#define EFFECT(name) Effect name();
#include "effects/effect_list.inc"
#undef EFFECT

namespace {

std::vector<Effect> buildAll() {
  std::vector<Effect> all;
#define EFFECT(name) all.push_back(name());
#include "effects/effect_list.inc"
#undef EFFECT
  return all;
}

}  // namespace

const std::vector<Effect>& allEffects() {
  static const std::vector<Effect> all = buildAll();
  return all;
}

const std::vector<EffectInfo>& effectCatalogue() {
  static const std::vector<EffectInfo> catalogue = [] {
    std::vector<EffectInfo> infos;
    for (const Effect& effect : allEffects()) infos.push_back(effect.info);
    return infos;
  }();
  return catalogue;
}

std::vector<std::string> inCatalogueOrder(const std::vector<std::string>& ids) {
  std::vector<std::string> ordered;
  for (const EffectInfo& effect : effectCatalogue())
    if (contains(ids, effect.id)) ordered.push_back(effect.id);
  return ordered;
}

const EffectInfo* catalogued(const std::string& id) {
  for (const EffectInfo& info : effectCatalogue())
    if (info.id == id) return &info;
  return nullptr;
}

std::string titleOf(const std::string& id) {
  const EffectInfo* effect = catalogued(id);
  return effect ? effect->title : id;
}

const EffectInfo& effectInfo(const std::string& id) {
  if (const EffectInfo* effect = catalogued(id)) return *effect;
  std::string known;
  for (const EffectInfo& info : effectCatalogue()) known += (known.empty() ? "" : ", ") + info.id;
  throw std::invalid_argument("effect \"" + id + "\" is not known; there are " + known);
}

}  // namespace battery_sof
