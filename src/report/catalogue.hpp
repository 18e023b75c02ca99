#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "model/effect.hpp"

namespace battery_sof {

/// @return every effect as one reads a catalogue: structure, physics, instruments, each by number.
std::vector<EffectInfo> effectsByTier();

/// One line an effect: id, code, mechanism, title.
std::string catalogueText(const std::vector<EffectInfo>& effects);

/// Everything an EffectInfo states.
std::string effectText(const EffectInfo& effect);

/**
 * {"schema": "battery_sof/effects/1", "effects": [...], "mechanisms":
 * [{"id","sentence","members"}]}; what is not stated is JSON null. Mechanisms are all of them, with
 * the faults of sampling that are no effects (namesOf()); an effect has its own under "mechanism",
 * its tier is its code's first letter.
 */
nlohmann::json catalogueJson(const std::vector<EffectInfo>& effects);

/// The generated part of docs/effects.md.
std::string catalogueMarkdown(const std::vector<EffectInfo>& effects);

}  // namespace battery_sof
