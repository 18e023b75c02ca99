#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "prediction/charge_acceptance.hpp"
#include "prediction/stop_time.hpp"

namespace battery_sof {

// What messages share: a number that is missing is NaN in them.

inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

inline double orNan(const std::optional<double>& value) { return value.value_or(kNan); }

inline constexpr Interval kNoInterval{kNan, kNan, kNan};

inline std::uint8_t codeOf(AnswerCode code) { return static_cast<std::uint8_t>(code); }

// A service's response and the answer in the status have the same fields (CrankAnswer.msg,
// StopTimeAnswer.msg, ChargeAnswer.msg).

/// What all answers have.
template <typename Message, typename Answer>
void fillVerdict(Message& message, const std::optional<Interval>& number, const Answer& answer) {
  const Interval interval = number.value_or(kNoInterval);
  message.lower = interval.lower;
  message.upper = interval.upper;
  message.valid = answer.valid;
  message.code = codeOf(answer.code);
  message.message = answer.message;
}

template <typename Message>
Message messageAs(const CrankingAnswer& answer) {
  Message message;
  fillVerdict(message, answer.u_min, answer);
  message.u_min = answer.u_min.value_or(kNoInterval).value;
  message.capable = answer.capable.value_or(false);
  return message;
}

template <typename Message>
Message messageAs(const StopTimeAnswer& answer) {
  Message message;
  fillVerdict(message, answer.t_stop, answer);
  message.t_stop = answer.t_stop.value_or(kNoInterval).value;
  if (answer.t_stop) {
    message.outcome = toString(answer.outcome);
    message.monotone = answer.monotone;
  }
  return message;
}

template <typename Message>
Message messageAs(const ChargeAcceptanceAnswer& answer) {
  Message message;
  fillVerdict(message, answer.i_boost, answer);
  message.i_boost = answer.i_boost.value_or(kNoInterval).value;
  return message;
}

}  // namespace battery_sof
