#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "estimation/fitted_model.hpp"
#include "prediction/cranking.hpp"
#include "prediction/range_prediction.hpp"

namespace battery_sof {

/// JSON of `sof identify`, schema battery_sof/model/1.
nlohmann::json identifyJson(const FittedModel& model);
/// The same for a reader: table of parameters with errors, scores, and the sentence that says how
/// it ended.
std::string identifyText(const FittedModel& model);

/// JSON of `sof predict`, schema battery_sof/prediction/1.
nlohmann::json predictionJson(const PredictionReport& report);
std::string predictionText(const PredictionReport& report);

/// JSON of `sof crank`: the fields of the service's response; absent numbers are JSON null.
nlohmann::json crankingJson(const CrankingAnswer& answer);
std::string crankingText(const CrankingQuery& query, const CrankingAnswer& answer);

}  // namespace battery_sof
