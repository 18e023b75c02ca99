#pragma once

#include <string>

#include "simulator/case_draft.hpp"

namespace battery_sof_reference {

/**
 * @brief What a case's recording was made from and what may be said to it, as JSON.
 *
 *     {"schema","family","id","seed","duration_s","sample_rate_hz","quiet","structure",
 *      "strength":{..,"scale":[..]},"regime_from_s","expected":{"verdicts":[..],"effects":[..],"ties":[..]},
 *      "truth":{"battery","effects","additions","acquisition","profile","voltage_limit_v",...}}
 *
 * A porous block's truth has "porous" in place of battery, effects and additions.
 * "regime_from_s" is there when a draft has it. Noise in truth.acquisition is the case's own; when
 * "quiet" the recording is without it. Keys and units of truth are those of scenario files; a limit
 * that is not there is null.
 */
std::string labelOf(const CaseKind& kind, const CaseDraft& draft, const Simulation& simulation);

}  // namespace battery_sof_reference
