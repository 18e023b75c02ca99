#pragma once

#include <boost/preprocessor/seq/for_each.hpp>
#include <boost/preprocessor/variadic/to_seq.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace battery_sof {

// A result is described once (descriptions.hpp): describe(visit, result) calls
//
//     visit(FIELD(rmse), result.rmse, "v")       field, value, unit
//
// for each of its numbers; DESCRIBED(Result, MEMBERS("v", rmse, max_abs), ...) writes those calls. JSON has the name with the unit behind it as key, JSON null for what is
// missing or not finite. A message has a field of that name or leaves the number out; NaN is what is
// missing. What no message has is named by its text alone.

/// A name, and the access to the field of that name in whatever has one.
template <typename Access>
struct Field {
  const char* name;
  Access access;
};
template <typename Access>
Field(const char*, Access) -> Field<Access>;

#define FIELD(name) FIELD_AS(#name, name)
/// The same where JSON has another name than the message.
#define FIELD_AS(name, field)                                                \
  battery_sof::Field {                                                       \
    name, [](auto& owner) -> decltype((owner.field)) { return owner.field; } \
  }

/// Members of a result that go by their own names, all in one unit.
#define MEMBERS(unit, ...) \
  (BOOST_PP_SEQ_FOR_EACH(DESCRIBED_MEMBER, unit, BOOST_PP_VARIADIC_TO_SEQ(__VA_ARGS__)) void())
#define DESCRIBED_MEMBER(_, unit, name) visit(FIELD(name), of.name, unit),
/// describe() of a result `of`: MEMBERS(), and visit() of what has another name.
#define DESCRIBED(Result, ...)                    \
  template <typename Visit>                       \
  void describe(Visit& visit, const Result& of) { \
    __VA_ARGS__;                                  \
  }

template <typename Part>
nlohmann::json jsonOf(const Part& part);

/// Makes a description JSON.
class JsonFields {
 public:
  template <typename Value>
  void operator()(const std::string& name, const Value& value, const std::string& unit = "") {
    json[unit.empty() ? name : name + "_" + unit] = jsonOf(value);
  }
  template <typename Access, typename Value>
  void operator()(const Field<Access>& field, const Value& value, const std::string& unit = "") {
    (*this)(field.name, value, unit);
  }
  nlohmann::json json = nlohmann::json::object();
};

template <typename>
struct IsOptional : std::false_type {};
template <typename Value>
struct IsOptional<std::optional<Value>> : std::true_type {};

template <typename>
struct IsVector : std::false_type {};
template <typename Value>
struct IsVector<std::vector<Value>> : std::true_type {};

/// @return a number, text or list as it is; what is described as an object; what is called with
/// JsonFields as the object that it makes.
template <typename Part>
nlohmann::json jsonOf(const Part& part) {
  if constexpr (std::is_floating_point_v<Part>) {
    return std::isfinite(part) ? nlohmann::json(part) : nlohmann::json(nullptr);
  } else if constexpr (IsOptional<Part>::value) {
    return part ? jsonOf(*part) : nlohmann::json(nullptr);
  } else if constexpr (IsVector<Part>::value) {
    nlohmann::json list = nlohmann::json::array();
    for (const auto& each : part) list.push_back(jsonOf(each));
    return list;
  } else if constexpr (std::is_arithmetic_v<Part> || std::is_convertible_v<Part, std::string> ||
                       std::is_same_v<Part, nlohmann::json>) {
    return part;
  } else {
    JsonFields fields;
    if constexpr (std::is_invocable_v<const Part&, JsonFields&>)
      part(fields);
    else
      describe(fields, part);
    return fields.json;
  }
}

}  // namespace battery_sof
