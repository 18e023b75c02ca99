#pragma once

#include <string>

#include "simulator/generator/catalogue_draft.hpp"
#include "simulator/generator/law_scenario.hpp"

namespace battery_sof_simulator {

/**
 * @brief What a scenario's recording was made from, as JSON (docs/validation.md).
 *
 * All: {"schema","kind","id","seed","duration_s","sample_rate_hz"}. Of catalogue kinds:
 *
 *     {"quiet","structure","strength":{..,"scale":[..]},"regime_from_s",
 *      "expected":{"verdicts":[..],"effects":[..],"ties":[..]},
 *      "truth":{"battery","effects","additions","acquisition","profile","voltage_limit_v",...}}
 *
 * A porous block's truth has "porous" in place of battery, effects and additions. "regime_from_s"
 * is there when a draft has it. Noise in truth.acquisition is the scenario's own; when "quiet" the
 * recording is without it. Keys and units of truth are those of scenario files; a limit that is not
 * there is null.
 */
std::string labelOf(const CatalogueDraft& draft, const Simulation& simulation);

/**
 * @brief The label of a law, or of a control:
 *
 *     {"mechanism","drive","attempt","strength","scale","rms_v":{"training","holdout"},"visible_rms_v":{"training","holdout"},
 *      "crank_v","noise":{..},"base":{..},"voltage_limit_v","recorder":{..}}
 *
 * id and mechanism are null of controls, recorder of all but control_with_recorder.
 */
std::string labelOf(const LawScenario& one);

}  // namespace battery_sof_simulator
