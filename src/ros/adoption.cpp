#include "battery_sof/ros/adoption.hpp"

#include <algorithm>

#include "battery_sof/model/effect.hpp"
#include "battery_sof/model/learned_force.hpp"
#include "battery_sof/recording/words.hpp"

namespace battery_sof {
namespace {

bool isInstrument(const std::string& id) { return id != kLearnedEffect && effectInfo(id).tier() == 'I'; }

/// Instruments marked.
std::string told(std::vector<std::string> ids) {
  for (std::string& id : ids)
    if (isInstrument(id)) id += " (instrument)";
  return listed(ids);
}

}  // namespace

Adoption adoptionOf(const Diagnosis& diagnosis, bool allowed) {
  const bool names = diagnosis.verdict == Verdict::kNamed || diagnosis.verdict == Verdict::kSeveral;
  const std::vector<std::string>& effects = diagnosis.extended.fit.effects;
  if (!allowed) return {{}, "not asked for: parameter adopt_diagnosis is false"};
  if (!names && !diagnosis.extended.fit.force) return {{}, "nothing to adopt: the verdict is " + describe(diagnosis.verdict)};
  if (diagnosis.withheld_rmse)
    return {{}, "nothing to adopt: what was found predicts the part that was held out worse than the base model"};
  if (std::all_of(effects.begin(), effects.end(), isInstrument))
    return {{}, "nothing to adopt: instruments are to be repaired, not modelled (" + told(effects) + ")"};
  return {effects, "runs beside the base model and answers while it errs less: " + told(effects), diagnosis.extended.fit.force};
}

}  // namespace battery_sof
