#pragma once

#include <optional>
#include <string>
#include <type_traits>

#include "prediction/online_session.hpp"
#include "report/descriptions.hpp"
#include "ros/background_work.hpp"
#include "ros/node_options.hpp"
#include "ros/node_statistics.hpp"
#include "state/fitted_model.hpp"
#include "util/constants.hpp"

// The package's messages, services and actions. ROS puts them into the core's namespace: the message
// IdentifiedModel is the core's FittedModel on the wire. A Diagnosis and a StopTimeAnswer are both:
// the messages go by the names DiagnosisMessage and StopTimeMessage here.
#define Diagnosis DiagnosisMessage
#define StopTimeAnswer StopTimeMessage
#include <battery_sof/DiagnoseAction.h>
#include <battery_sof/Diagnosis.h>
#include <battery_sof/SofStatus.h>
#undef Diagnosis
#undef StopTimeAnswer
#include <battery_sof/IdentifiedModel.h>
#include <battery_sof/IdentifyAction.h>
#include <battery_sof/PredictChargeAcceptance.h>
#include <battery_sof/PredictCranking.h>
#include <battery_sof/PredictMap.h>
#include <battery_sof/PredictStopTime.h>
#include <battery_sof/SetStandingQuery.h>
#include <battery_sof/SimulateProfile.h>
#include <sensor_msgs/BatteryState.h>

namespace battery_sof {

// Messages read a result's description (report/descriptions.hpp): each field of a message that the
// description names gets its number, all others stay. A number that is missing is NaN.

/// @return current [A], voltage [V], temperature [K] of a message, as a bag's: see
/// bag/battery_state_sample.hpp.
RawSample rawSampleOf(const sensor_msgs::BatteryState& message);

/// @throws std::invalid_argument for a time [s] that stampOf() refuses.
ros::Time rosTime(double time);

inline double orNan(const std::optional<double>& value) { return value.value_or(kNan); }

template <typename To, typename Value>
void put(To& to, const Value& value);

template <typename Message>
class MessageFields {
 public:
  explicit MessageFields(Message& message) : message_(message) {}

  template <typename Value>
  void operator()(const char*, const Value&, const char* = "") {}
  template <typename Access, typename Value>
  void operator()(const Field<Access>& field, const Value& value, const char* = "") {
    if constexpr (std::is_invocable_v<const Access&, Message&>) put(field.access(message_), value);
  }

 private:
  Message& message_;
};

/// Puts a number, a text, a list, or what is described into a field or a message.
template <typename To, typename Value>
void put(To& to, const Value& value) {
  if constexpr (IsOptional<Value>::value) {
    if (value)
      put(to, *value);
    else if constexpr (std::is_same_v<To, double>)
      to = kNan;
  } else if constexpr (std::is_convertible_v<const Value&, To>) {
    to = static_cast<To>(value);
  } else if constexpr (IsVector<Value>::value) {
    for (const auto& each : value) put(to.emplace_back(), each);
  } else {
    MessageFields<To> fields(to);
    describe(fields, value);
  }
}

template <typename Message, typename Result>
Message messageAs(const Result& result) {
  Message message;
  put(message, result);
  return message;
}

// The queries of requests: what was left out (askedFor()) is not asked, or its default. Nothing is
// judged here: see faultsOf().
CrankingQuery queryOf(const PredictCranking::Request& request);
StopTimeQuery queryOf(const PredictStopTime::Request& request);
ChargeAcceptanceQuery queryOf(const PredictChargeAcceptance::Request& request);

/// @return both maps of a request, those with lists, asked of a model. @param watch see
/// mapCranking().
MapResult mapsOf(const ModelSnapshot& model, const PredictMap::Request& request,
                 const WorkWatch& watch = nullptr);

/**
 * @brief The standing questions with what a request changes. NaN keeps what there is, and so does 0
 * where zero has no meaning (askedFor()): of all but i_load and t_stop.
 * @throws NodeOptionsError for values outside the ranges of the parameters standing_query/..., one
 * line each.
 */
StandingQueries changedBy(const SetStandingQuery::Request& request, const StandingQueries& present);

/// @return the standing questions as they stay; u_required is NaN when it is not asked. @param
/// lately see StandingQueries::chargeAt(). @param faults of a change that was refused, one a line:
/// code INVALID_QUERY; none: OK.
SetStandingQuery::Response responseOf(StandingQueries standing, const std::optional<double>& lately,
                                      const std::string& faults = "");

/// @return the message with header.stamp where the model's state stands; absent numbers are NaN.
IdentifiedModel messageOf(const FittedModel& model);

/// @return the result of ~identify; code REFUSED unless accepted.
IdentifyResult resultOf(const IdentificationOutcome& outcome);

/// @return the message of a finished diagnosis with header.stamp at the recording's end; absent
/// numbers are NaN.
DiagnosisMessage messageOf(const FinishedDiagnosis& report, const Adoption& adoption);

/// @return the result of ~diagnose; code OK or FAILED.
DiagnoseResult resultOf(const FinishedDiagnosis& report, const Adoption& adoption);

/// @return the feedback of an action: what begins; how far it is, is not known.
template <typename Feedback>
Feedback feedbackOf(const std::string& stage) {
  Feedback feedback;
  feedback.stage = stage;
  feedback.progress = kNan;
  return feedback;
}

/// What a status message is made of.
struct StatusContents {
  SessionStatus session;
  StreamCounts counts;
  StandingQueries standing;  ///< as they are asked: charge.u_boost is the voltage of this answer
  EventTallies events;
  std::optional<ModelSnapshot> model;  ///< that answers the standing queries; none: no answers
};

/// @return the message without its header; absent numbers are NaN.
SofStatus messageOf(const StatusContents& contents);

}  // namespace battery_sof
