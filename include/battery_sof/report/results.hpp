#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "battery_sof/identify/fitted_model.hpp"
#include "battery_sof/predict/cranking.hpp"
#include "battery_sof/predict/both_ways.hpp"
#include "battery_sof/predict/scores.hpp"

namespace battery_sof {

/// JSON of `sof identify`, schema battery_sof/model/1.
nlohmann::json identifyJson(const FittedModel& model);
/// The same for a reader: table of parameters with errors, scores, and the sentence that says how it ended.
std::string identifyText(const FittedModel& model);

/// What `sof predict` found, in every direction and beside what needs no physics.
struct PredictionReport {
  PredictionScores from_current;                ///< as the paper has it; its cranks are those of both_ways where that is
  std::optional<BothWaysScores> both_ways;      ///< none when the current drives throughout
  BothWaysScores naive;
  std::optional<PredictionScores> naive_from_current;  ///< of the naive line; none without one
};

/// JSON of `sof predict`, schema battery_sof/prediction/1.
nlohmann::json predictionJson(const PredictionReport& report);
std::string predictionText(const PredictionReport& report);

/// JSON of `sof crank`: the fields of the service's response; absent numbers are null.
nlohmann::json crankingJson(const CrankingAnswer& answer);
std::string crankingText(const CrankingQuery& query, const CrankingAnswer& answer);

}  // namespace battery_sof
