#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "battery_sof/series.hpp"
#include "model/effect.hpp"
#include "prediction/questions.hpp"
#include "prediction/scores.hpp"
#include "recording/checks.hpp"
#include "recording/control_mode.hpp"
#include "state/fitted_model.hpp"

namespace battery_sof {

struct ChargeAcceptanceAnswer;
struct ChargeAcceptanceQuery;
struct Diagnosis;
struct MapResult;

// The JSON of the commands (docs/cli.md). That of a question is jsonOf() of its answer
// (descriptions.hpp), with the fields of the service's response; absent numbers are JSON null, and
// so are infinite ones, which JSON does not have: the outcome of a stop time says "always" then. A
// map that was not asked is left out.
nlohmann::json resultJson(const FittedModel& model);
nlohmann::json resultJson(const PredictionReport& report);
nlohmann::json resultJson(const Diagnosis& diagnosis);

/// @return JSON as text; what is not UTF-8 in it (names of files) is replaced. @param indent of a
/// level; -1: all on one line.
std::string jsonText(const nlohmann::json& json, int indent = -1);

// The same for a reader.
/// Table of parameters with errors, scores, and the sentence that says how it ended.
/// @param mode of the recording that it was fitted to, as sof check and sof diagnose report it.
std::string resultText(const FittedModel& model, const ControlModeOverview& mode = {});
std::string resultText(const PredictionReport& report);
std::string resultText(const CrankingQuery& query, const CrankingAnswer& answer);
std::string resultText(const StopTimeQuery& query, const StopTimeAnswer& answer);
std::string resultText(const ChargeAcceptanceQuery& query, const ChargeAcceptanceAnswer& answer);
/// Two tables at most, value with bounds in each cell; * marks an answer that is not valid.
std::string resultText(const MapResult& result);
/// Plain text of at most 100 columns to read or to paste into a mail, verdict first.
std::string resultText(const Diagnosis& diagnosis);

/// @return whether and where what was estimated is used, as a sentence. @param diagnosis one with
/// Diagnosis::discrepancy.
std::string useOfDiscrepancy(const Diagnosis& diagnosis);

/**
 * @brief The lint as plain text of at most 100 columns: what the recording holds, what happens in
 * it, who controls current and voltage, what was found and what that means, and what could not be
 * judged.
 *
 * @param report checkRecording's answer for recording.
 */
std::string checkReportText(const Recording& recording, const CheckReport& report);

/**
 * @brief The same as JSON of schema battery_sof/check/1; an absent number is JSON null.
 *
 * - schema, recording, samples, offered, from_s, to_s, median_interval_s, largest_step_back_s;
 * - rejected: missing_value, not_finite, duplicate_stamp, clock_step_back, out_of_range;
 * - voltage_lsb_v, current_lsb_a: steps of quantisation;
 * - voltage_range_v, current_range_a, temperature_range_c: [low, high];
 * - events: crank, discharge, charge and rest, each with count and duration_s; charge_in_ah,
 *   charge_out_ah (negative), longest_charge_s, charges_over_10_s, charge_voltage_range_v;
 * - crank_current_a: what counts as an engine start; crank_current_from: "given", "recording",
 *   "usual";
 * - source: seen, share (of samples whose voltage is controlled), min_current_a (JSON null when
 * none is seen), charges_begin_with,
 *   stretches (count), reasons (a list of reason, mode, stretches, samples), summary;
 * - findings: a list of id, severity, what, meaning, value, unit, samples, at_s;
 * - not_judged: a list of sentences.
 */
nlohmann::json checkReportJson(const Recording& recording, const CheckReport& report);

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
