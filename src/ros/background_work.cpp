#include "ros/background_work.hpp"

#include <algorithm>

#include "model/discrepancy_model.hpp"
#include "model/effect.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

bool isInstrument(const std::string& id) {
  return id != kDiscrepancyEffect && effectInfo(id).tier() == 'I';
}

/// Instruments marked.
std::string marked(std::vector<std::string> ids) {
  for (std::string& id : ids)
    if (isInstrument(id)) id += " (instrument)";
  return join(ids);
}

}  // namespace

Adoption adoptionOf(const Diagnosis& diagnosis, bool allowed) {
  const bool names =
      diagnosis.verdict == Verdict::kEffect || diagnosis.verdict == Verdict::kSeveral;
  const std::vector<std::string>& effects = diagnosis.extended.fit.effects;
  if (!allowed) return {{}, "not asked for: parameter use_diagnosis is false"};
  if (!names && !diagnosis.extended.fit.discrepancy)
    return {{}, "nothing to adopt: the verdict is " + toString(diagnosis.verdict)};
  if (diagnosis.withheld_rmse)
    return {{},
            "nothing to adopt: what was found predicts the part that was held out worse than the "
            "base model"};
  if (std::all_of(effects.begin(), effects.end(), isInstrument))
    return {
        {},
        "nothing to adopt: instruments are to be repaired, not modelled (" + marked(effects) + ")"};
  return {effects,
          "runs with the base model and answers while its error is smaller: " + marked(effects),
          diagnosis.extended.fit.discrepancy};
}

}  // namespace battery_sof
