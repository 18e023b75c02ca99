#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "diagnosis/change.hpp"

namespace battery_sof {

/**
 * @brief A comparison with a reference as JSON of schema battery_sof/change/1; an absent number is
 * JSON null.
 *
 * - schema, program, recordings, references (names), verdict, summary;
 * - changes: a list of id, kind ("parameter", "effect"), mechanism, then, now, unit, interval
 *   ([low, high], 90 %), probability, indistinguishable (ids);
 * - explained: reference_model, changed_model, own_model, each share_percent, current_share_percent,
 *   voltage_share_percent on the last quarter; distance, gain, model_distance,
 *   largest_model_distance [1];
 * - compared: a list of id, unit, then, now, with_change (null but for changed), std_error, spread;
 * - detection_limits: a list of id, strength, unit.
 *
 * @param recordings, references names of the files.
 */
nlohmann::json resultJson(const ChangeDiagnosis& diagnosis,
                          const std::vector<std::string>& recordings,
                          const std::vector<std::string>& references);

/// @return a quantity or a strength as a reader expects it: mOhm for Ohm, % for a share.
std::string changeValueText(double value, const std::string& unit);
std::string changeStrengthText(double value, const std::string& unit);

/// The same as plain text of at most 100 columns, verdict first.
std::string resultText(const ChangeDiagnosis& diagnosis);

}  // namespace battery_sof
