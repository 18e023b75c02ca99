#pragma once

#include <nlohmann/json_fwd.hpp>

#include <string>

#include "battery_sof/series.hpp"
#include "recording/checks.hpp"

namespace battery_sof {

/**
 * @brief The lint as plain text of at most 100 columns: what the recording holds, what happens in
 * it, who controls current and voltage, what was found and what that means, and what could not be
 * judged.
 *
 * @param name what the reader calls the recording.
 * @param report checkRecording's answer for recording.
 */
std::string checkReportText(const std::string& name, const Recording& recording,
                            const CheckReport& report);

/**
 * @brief The same as JSON of schema battery_sof/check/1; an absent number is JSON null.
 *
 * - schema, recording, samples, offered, from_s, to_s, median_interval_s, largest_step_back_s;
 * - rejected: missing_value, not_finite, duplicate_stamp, clock_step_back, out_of_range;
 * - voltage_lsb_v, current_lsb_a: steps of quantisation;
 * - voltage_range_v, current_range_a, temperature_range_c: [low, high];
 * - events: crank, discharge, charge and rest, each with count and duration_s; charge_in_ah,
 *   charge_out_ah (negative), longest_charge_s, charges_over_10_s, charge_voltage_range_v;
 * - source: seen, share (of samples whose voltage is controlled), min_current_a (JSON null when
 * none is seen), charges_begin_with,
 *   stretches (count), reasons (a list of reason, controlled, stretches, samples), summary;
 * - findings: a list of id, severity, what, meaning, value, unit, samples, at_s;
 * - not_judged: a list of sentences.
 */
nlohmann::json checkReportJson(const std::string& name, const Recording& recording,
                               const CheckReport& report);

}  // namespace battery_sof
