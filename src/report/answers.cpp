#include "report/answers.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "util/text.hpp"

namespace battery_sof {
namespace {

using Json = nlohmann::json;

Json finiteOrNull(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

void putInterval(Json& json, const char* name, const std::optional<Interval>& interval) {
  json[name] = interval ? finiteOrNull(interval->value) : Json(nullptr);
  json["lower"] = interval ? finiteOrNull(interval->lower) : Json(nullptr);
  json["upper"] = interval ? finiteOrNull(interval->upper) : Json(nullptr);
}

template <typename Answer>
void putVerdict(Json& json, const Answer& answer) {
  json["valid"] = answer.valid;
  json["code"] = static_cast<int>(answer.code);
  json["message"] = answer.message;
}

template <typename Answer>
std::string lastLine(const Answer& answer) {
  return toString(answer.code) + ": " + answer.message + "\n";
}

std::string seconds(double duration) {
  return std::isinf(duration) ? "no end" : format("%.1f s", duration);
}

/// One map's answers as arrays, row by row.
template <typename Map, typename Value>
void putAnswers(Json& json, const std::string& name, const Map& map, Value&& value) {
  for (const char* end : {"", "_lower", "_upper", "_code"}) json[name + end] = Json::array();
  for (const auto& answer : map.answers) {
    const std::optional<Interval>& interval = value(answer);
    json[name].push_back(interval ? finiteOrNull(interval->value) : Json(nullptr));
    json[name + "_lower"].push_back(interval ? finiteOrNull(interval->lower) : Json(nullptr));
    json[name + "_upper"].push_back(interval ? finiteOrNull(interval->upper) : Json(nullptr));
    json[name + "_code"].push_back(static_cast<int>(answer.code));
  }
}

template <typename Answer>
std::string cell(const Answer& answer, const std::optional<Interval>& interval, int digits) {
  if (!interval) return format("%25s", "-");
  const std::string text =
      format("%.*f [%.*f, %.*f]%s", digits, interval->value, digits, interval->lower, digits,
             interval->upper, answer.valid ? "" : "*");
  return format("%25s", text.c_str());
}

template <typename Map, typename Value>
std::string table(const std::string& corner, const std::vector<double>& rows,
                  const std::vector<double>& columns, const Map& map, int digits, Value&& value) {
  std::string text = format("%-18s", corner.c_str());
  for (const double column : columns) text += format("%25g", column);
  text += '\n';
  for (std::size_t k = 0; k < map.answers.size(); ++k) {
    if (k % columns.size() == 0) text += format("%-18g", rows[k / columns.size()]);
    text += cell(map.answers[k], value(map.answers[k]), digits);
    if ((k + 1) % columns.size() == 0) text += '\n';
  }
  return text;
}

const std::optional<Interval>& lowestVoltage(const CrankingAnswer& answer) { return answer.u_min; }
const std::optional<Interval>& meanCurrent(const ChargeAcceptanceAnswer& answer) {
  return answer.i_boost;
}

}  // namespace

nlohmann::json stopTimeJson(const StopTimeAnswer& answer) {
  Json json;
  putInterval(json, "t_stop", answer.t_stop);
  json["outcome"] = answer.t_stop ? Json(toString(answer.outcome)) : Json(nullptr);
  json["monotone"] = answer.t_stop ? Json(answer.monotone) : Json(nullptr);
  putVerdict(json, answer);
  return json;
}

nlohmann::json chargeAcceptanceJson(const ChargeAcceptanceAnswer& answer) {
  Json json;
  putInterval(json, "i_boost", answer.i_boost);
  putVerdict(json, answer);
  return json;
}

std::string stopTimeText(const StopTimeQuery& query, const StopTimeAnswer& answer) {
  std::string text =
      format("question  longest stop at %.1f A, then a crank of %.2f s at %.1f A holds %.2f V\n",
             query.i_load, query.t_cranking, query.i_cranking, query.u_required);
  const char* least = answer.outcome == StopTimeOutcome::kAtLeast ? "at least " : "";
  if (answer.t_stop)
    text += format("stop      %s%s, 90 %% between %s and %s: %s%s\n", least,
                   seconds(answer.t_stop->value).c_str(), seconds(answer.t_stop->lower).c_str(),
                   seconds(answer.t_stop->upper).c_str(), toString(answer.outcome).c_str(),
                   answer.monotone ? "" : "; the battery recovers at first");
  return text + lastLine(answer);
}

std::string chargeAcceptanceText(const ChargeAcceptanceQuery& query,
                                 const ChargeAcceptanceAnswer& answer) {
  std::string text = format("question  current over %.1f s at %.2f V, at most %.0f A\n",
                            query.t_sof2, query.u_boost, query.i_limit);
  if (answer.i_boost)
    text += format("mean      %.1f A, 90 %% between %.1f and %.1f A\n", answer.i_boost->value,
                   answer.i_boost->lower, answer.i_boost->upper);
  return text + lastLine(answer);
}

nlohmann::json mapJson(const MapResult& result) {
  Json json = {{"schema", "battery_sof/map/1"}};
  if (result.cranking) {
    json["i_load"] = result.i_load;
    json["t_stop"] = result.t_stop;
    putAnswers(json, "u_min", *result.cranking, lowestVoltage);
    json["capable"] = Json::array();
    for (const CrankingAnswer& answer : result.cranking->answers)
      json["capable"].push_back(answer.capable ? Json(*answer.capable) : Json(nullptr));
  }
  if (result.charge) {
    json["u_boost"] = result.u_boost;
    json["t_sof2"] = result.t_sof2;
    putAnswers(json, "i_boost", *result.charge, meanCurrent);
  }
  const MapVerdict verdict = verdictOf(result.cranking, result.charge);
  json["valid"] = verdict.code == AnswerCode::kOk;
  json["code"] = static_cast<int>(verdict.code);
  json["message"] = verdict.message;
  return json;
}

std::string mapText(const MapResult& result) {
  std::string text;
  if (result.cranking) {
    text += "lowest voltage of the crank [V], 90 % interval; * outside the identified range\n";
    text +=
        table("i_load \\ t_stop", result.i_load, result.t_stop, *result.cranking, 2, lowestVoltage);
  }
  if (result.charge) {
    text += "mean charge current [A], 90 % interval; * outside the identified range\n";
    text +=
        table("u_boost \\ t_sof2", result.u_boost, result.t_sof2, *result.charge, 1, meanCurrent);
  }
  return text + lastLine(verdictOf(result.cranking, result.charge));
}

}  // namespace battery_sof
