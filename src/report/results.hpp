#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "prediction/cranking.hpp"
#include "prediction/scores.hpp"
#include "prediction/stop_time.hpp"
#include "state/fitted_model.hpp"

namespace battery_sof {

struct ChargeAcceptanceAnswer;
struct ChargeAcceptanceQuery;
struct CombinedDiagnosis;
struct Diagnosis;
struct MapResult;

// The JSON of the commands (docs/cli.md). Of a question it has the fields of the service's response;
// absent numbers are JSON null, and so are infinite ones, which JSON does not have: the outcome of a
// stop time says "always" then. A map that was not asked is left out.
nlohmann::json resultJson(const FittedModel& model);
nlohmann::json resultJson(const PredictionReport& report);
nlohmann::json resultJson(const CrankingAnswer& answer);
nlohmann::json resultJson(const StopTimeAnswer& answer);
nlohmann::json resultJson(const ChargeAcceptanceAnswer& answer);
nlohmann::json resultJson(const MapResult& result);
nlohmann::json resultJson(const Diagnosis& diagnosis);
nlohmann::json resultJson(const CombinedDiagnosis& combined,
                          const std::vector<Diagnosis>& recordings);

// The same for a reader.
/// Table of parameters with errors, scores, and the sentence that says how it ended.
std::string resultText(const FittedModel& model);
std::string resultText(const PredictionReport& report);
std::string resultText(const CrankingQuery& query, const CrankingAnswer& answer);
std::string resultText(const StopTimeQuery& query, const StopTimeAnswer& answer);
std::string resultText(const ChargeAcceptanceQuery& query, const ChargeAcceptanceAnswer& answer);
/// Two tables at most, value with bounds in each cell; * marks an answer that is not valid.
std::string resultText(const MapResult& result);
/// Plain text of at most 100 columns to read or to paste into a mail, verdict first.
std::string resultText(const Diagnosis& diagnosis);
std::string resultText(const CombinedDiagnosis& combined, const std::vector<Diagnosis>& recordings);

/// @return whether and where what was estimated is used, as a sentence. @param diagnosis one with
/// Diagnosis::discrepancy.
std::string useOfDiscrepancy(const Diagnosis& diagnosis);

}  // namespace battery_sof
