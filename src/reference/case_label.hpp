#pragma once

#include <string>

#include "reference/case_draft.hpp"

namespace battery_sof_reference {

/**
 * @brief What a case's recording was made from and what may be said to it, as JSON.
 *
 *     {"schema","family","id","seed","duration_s","sample_rate_hz","structure",
 *      "strength":{..},"expected":{"verdicts":[..],"effects":[..],"ties":[..]},
 *      "truth":{"battery","effects","additions","acquisition","profile","voltage_limit_v",...}}
 *
 * Keys and units of truth are those of scenario files; a limit that is not there is null.
 */
std::string labelOf(const CaseKind& kind, const CaseDraft& draft, const Simulation& simulation);

}  // namespace battery_sof_reference
