#pragma once

#include <optional>

#include "battery_sof/identify/fitted_model.hpp"
#include "battery_sof/predict/online_session.hpp"
#include "battery_sof/ros/messages.hpp"

namespace battery_sof {

/// @return the query; an u_required of NaN is none. Nothing is judged here: see faultsOf().
CrankingQuery queryOf(const PredictCranking::Request& request);

/// @return the response; absent numbers are NaN.
PredictCranking::Response responseOf(const CrankingAnswer& answer);

/// @return the response; absent arrays are empty.
SimulateProfile::Response responseOf(const ProfileAnswer& answer);

/// @return the message with header.stamp where the model's state stands; absent numbers are NaN.
IdentifiedModel messageOf(const FittedModel& model);

/// @return the response to ~identify; code REFUSED unless accepted.
Identify::Response responseOf(const IdentificationOutcome& outcome);

/// What a status message is made of.
struct StatusContents {
  SessionStatus session;
  StreamCounts counts;
  CrankingQuery standing_query;
  CrankingAnswer standing_answer;
  std::optional<CrankComparison> last_crank;
  std::size_t cranks = 0;
};

/// @return the message without its header; absent numbers are NaN.
SofStatus messageOf(const StatusContents& contents);

}  // namespace battery_sof
