#pragma once

#include <limits>
#include <optional>
#include <type_traits>

#include "report/descriptions.hpp"

namespace battery_sof {

// Messages read a result's description (report/fields.hpp): each field of a message that the
// description names gets its number, all others stay. A number that is missing is NaN.

inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

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

}  // namespace battery_sof
