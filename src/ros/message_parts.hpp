#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "battery_sof/predict/cranking.hpp"

namespace battery_sof {

// What messages share: a number that is missing is NaN in them.

inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

inline double orNan(const std::optional<double>& value) { return value.value_or(kNan); }

inline constexpr Interval kNoInterval{kNan, kNan, kNan};

inline std::uint8_t codeOf(AnswerCode code) { return static_cast<std::uint8_t>(code); }

/// The fields that a service's response and the standing answer of the status share.
template <typename Message>
void fillAnswer(Message& message, const CrankingAnswer& answer) {
  const Interval u_min = answer.u_min.value_or(kNoInterval);
  message.u_min = u_min.value;
  message.lower = u_min.lower;
  message.upper = u_min.upper;
  message.capable = answer.capable.value_or(false);
  message.valid = answer.valid;
  message.code = codeOf(answer.code);
  message.message = answer.message;
}

}  // namespace battery_sof
