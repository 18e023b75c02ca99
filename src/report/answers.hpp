#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "prediction/charge_acceptance.hpp"
#include "prediction/maps.hpp"
#include "prediction/stop_time.hpp"

namespace battery_sof {

// JSON of `sof stop-time` and `sof charge`: the fields of the services' responses. Absent numbers
// are JSON null, and so are infinite ones, which JSON does not have: outcome says "always" then.
nlohmann::json stopTimeJson(const StopTimeAnswer& answer);
nlohmann::json chargeAcceptanceJson(const ChargeAcceptanceAnswer& answer);

// The same for a reader.
std::string stopTimeText(const StopTimeQuery& query, const StopTimeAnswer& answer);
std::string chargeAcceptanceText(const ChargeAcceptanceQuery& query,
                                 const ChargeAcceptanceAnswer& answer);

/// What `sof map` was asked and got; a map that was not asked has no answers.
struct MapResult {
  std::vector<double> i_load, t_stop;  ///< [A], [s]
  std::optional<CrankingMap> cranking;
  std::vector<double> u_boost, t_sof2;  ///< [V], [s]
  std::optional<ChargeAcceptanceMap> charge;
};

/// JSON of `sof map`: the fields of PredictMap.srv, lists and answers, those of a map that was not
/// asked left out.
nlohmann::json mapJson(const MapResult& result);
/// Two tables at most, value with bounds in each cell; * marks an answer that is not valid.
std::string mapText(const MapResult& result);

}  // namespace battery_sof
