#pragma once

#include <string>

#include "simulator/out_of_model_case.hpp"

namespace battery_sof_reference {

/**
 * @brief What is true of an out-of-model case's case, as JSON.
 *
 *     {"schema","kind","mechanism","form","drive","seed","duration_s","sample_rate_hz","attempt",
 *      "strength","scale","rms_v":{"training","holdout"},"visible_rms_v":{"training","holdout"},
 *      "crank_v","noise":{...},"base":{...},"voltage_limit_v","recorder":{...}}
 *
 * mechanism and form are null of nulls, recorder of all but imperfect nulls.
 */
std::string labelOf(const OutOfModelCase& one);

}  // namespace battery_sof_reference
