#pragma once

#include <boost/preprocessor/seq/for_each.hpp>
#include <boost/preprocessor/variadic/to_seq.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "diagnosis/diagnosis.hpp"
#include "model/effect.hpp"
#include "prediction/event_corrections.hpp"
#include "prediction/questions.hpp"

namespace battery_sof {

// A result is described once, for JSON and messages alike: describe(visit, result) calls
//
//     visit(FIELD(rmse), result.rmse, "v")       field, value, unit
//
// for each of its numbers; DESCRIBED(Result, MEMBERS("v", rmse, max_abs), ...) writes those calls.
// JSON has the name with the unit behind it as key, JSON null for what is missing or not finite. A
// message has a field of that name or leaves the number out; NaN is what is missing. What no message
// has is named by its text alone.

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

/// @return a number, text or list as it is; what is described as an object.
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
    describe(fields, part);
    return fields.json;
  }
}

// ---------------------------------------------------------------------------------------------
// answers

/// An interval's value or one of its ends.
inline std::optional<double> partOf(const std::optional<Interval>& interval,
                                    double Interval::*part) {
  return interval ? std::optional<double>(*interval.*part) : std::nullopt;
}

template <typename Visit, typename Access>
void describeInterval(Visit& visit, const Field<Access>& name,
                      const std::optional<Interval>& interval) {
  visit(name, partOf(interval, &Interval::value));
  visit(FIELD(lower), partOf(interval, &Interval::lower));
  visit(FIELD(upper), partOf(interval, &Interval::upper));
}

template <typename Visit>
void describeCode(Visit& visit, bool valid, AnswerCode code, const std::string& message) {
  visit(FIELD(valid), valid);
  visit(FIELD(code), static_cast<int>(code));
  visit(FIELD(message), message);
}

DESCRIBED(CrankingAnswer, describeInterval(visit, FIELD(u_min), of.u_min), MEMBERS("", capable),
          describeCode(visit, of.valid, of.code, of.message))

DESCRIBED(StopTimeAnswer, describeInterval(visit, FIELD(t_stop), of.t_stop),
          visit(FIELD(outcome), of.t_stop ? std::optional(toString(of.outcome)) : std::nullopt),
          visit(FIELD(monotone), of.t_stop ? std::optional<bool>(of.monotone) : std::nullopt),
          describeCode(visit, of.valid, of.code, of.message))

DESCRIBED(ChargeAcceptanceAnswer, describeInterval(visit, FIELD(i_boost), of.i_boost),
          describeCode(visit, of.valid, of.code, of.message))

DESCRIBED(ProfileAnswer, visit(FIELD(voltage), of.predicted.voltage),
          visit(FIELD(lower), of.predicted.lower), visit(FIELD(upper), of.predicted.upper),
          describeCode(visit, of.valid, of.code, of.message))

/// What `sof map` and ~predict_map were asked and got; a map that was not asked has no answers.
struct MapResult {
  std::vector<double> i_load, t_stop;  ///< [A], [s]
  std::optional<CrankingMap> cranking;
  std::vector<double> u_boost, t_sof2;  ///< [V], [s]
  std::optional<ChargeAcceptanceMap> charge;
};

/// @return what `of` finds in each answer of a map, row by row.
template <typename Answers, typename Of>
auto columnOf(const Answers& answers, Of&& of) {
  std::vector<std::decay_t<decltype(of(answers.front()))>> column;
  for (const auto& answer : answers) column.push_back(of(answer));
  return column;
}

template <typename Visit>
void describe(Visit& visit, const MapResult& result) {
  const auto code_of = [](const auto& answer) { return static_cast<int>(answer.code); };
  visit("schema", "battery_sof/map/1");
  if (result.cranking) {
    const auto& answers = result.cranking->answers;
    const auto u_min = [&](double Interval::*part) {
      return columnOf(answers, [part](const auto& answer) { return partOf(answer.u_min, part); });
    };
    visit(FIELD(i_load), result.i_load);
    visit(FIELD(t_stop), result.t_stop);
    visit(FIELD(u_min), u_min(&Interval::value));
    visit(FIELD(u_min_lower), u_min(&Interval::lower));
    visit(FIELD(u_min_upper), u_min(&Interval::upper));
    visit(FIELD(u_min_code), columnOf(answers, code_of));
    visit(FIELD(capable), columnOf(answers, [](const auto& answer) { return answer.capable; }));
  }
  if (result.charge) {
    const auto& answers = result.charge->answers;
    const auto i_boost = [&](double Interval::*part) {
      return columnOf(answers, [part](const auto& answer) { return partOf(answer.i_boost, part); });
    };
    visit(FIELD(u_boost), result.u_boost);
    visit(FIELD(t_sof2), result.t_sof2);
    visit(FIELD(i_boost), i_boost(&Interval::value));
    visit(FIELD(i_boost_lower), i_boost(&Interval::lower));
    visit(FIELD(i_boost_upper), i_boost(&Interval::upper));
    visit(FIELD(i_boost_code), columnOf(answers, code_of));
  }
  const MapVerdict verdict = verdictOf(result.cranking, result.charge);
  describeCode(visit, verdict.code == AnswerCode::kOk, verdict.code, verdict.message);
}

/// A crank or a charge with what was expected of it.
template <typename Visit>
void describe(Visit& visit, const EventComparison& of) {
  const bool is_charge = of.kind == PastEvent::Kind::kCharge;
  const char* unit = is_charge ? "a" : "v";
  visit(FIELD(time), of.time, "s");
  if (is_charge)
    visit(FIELD(duration), of.duration, "s");
  else
    visit("current", of.current, "a");
  visit(FIELD_AS(is_charge ? "measured" : "measured_min", measured), of.measured, unit);
  visit(FIELD_AS(is_charge ? "predicted" : "predicted_min", expected), of.expected.value, unit);
  visit(FIELD(lower), of.expected.lower, unit);
  visit(FIELD(upper), of.expected.upper, unit);
}

// ---------------------------------------------------------------------------------------------
// models

DESCRIBED(ParameterEstimate, MEMBERS("", name, value, unit, held, at_bound, determined),
          visit(FIELD_AS("std_error", std), of.std))

DESCRIBED(FitWindow, MEMBERS("s", from, to))

/// What `sof identify` and ~model report of an identification.
DESCRIBED(FittedModel, visit(FIELD(effects), of.fit.effects),
          visit(FIELD(status), toString(of.fit.status)), visit(FIELD(message), of.fit.message),
          visit(FIELD(q_dyn_percent), of.fit.scores.q_dyn_percent),
          visit(FIELD(rmse), of.fit.scores.rmse, "v"),
          visit(FIELD(window_quality), of.fit.window_quality),
          visit(FIELD(fit_ms), of.provenance.fit_ms))

// ---------------------------------------------------------------------------------------------
// diagnoses

DESCRIBED(DiagnosedParameter, MEMBERS("", name, value, std, unit, lower, upper, at_bound))

DESCRIBED(NamedEffect, MEMBERS("", id, mechanism, probability, confidence, parameters, evidence),
          MEMBERS("", indistinguishable_from), MEMBERS("v", voltage_rms),
          MEMBERS("", biased_parameters), visit("title", titleOf(of.id)))

DESCRIBED(Candidate, MEMBERS("", id, mechanism, holdout_gain_percent, evidence, confidence),
          MEMBERS("", rejected_because), visit("title", titleOf(of.id)))

DESCRIBED(MismatchSegment, visit(FIELD_AS("from", from_time), of.from, "s"), MEMBERS("s", to),
          MEMBERS("", regime, p_value), MEMBERS("v", mean_error, peak_error))

DESCRIBED(ErrorMetrics, MEMBERS("v", rmse, max_abs, crank_mae, charge_bias),
          MEMBERS("a", charge_current_error), MEMBERS("", q_dyn_percent, cranks, share_percent),
          MEMBERS("", current_share_percent, voltage_share_percent, equations_share_percent))

DESCRIBED(ControlModeTotals, MEMBERS("", reason, stretches, samples),
          visit("mode", toString(of.mode)))

inline std::optional<std::string> idOf(const std::optional<Mechanism>& mechanism) {
  return mechanism ? std::optional(mechanismId(*mechanism)) : std::nullopt;
}

/// What JSON and ~diagnosis have at their top.
DESCRIBED(Diagnosis,
          MEMBERS("", summary, effects, candidates, mismatch, next_experiment, instrument),
          visit(FIELD(verdict), toString(of.verdict)), visit(FIELD(mechanism), idOf(of.mechanism)),
          visit(FIELD(unobservable), of.outside))

}  // namespace battery_sof
