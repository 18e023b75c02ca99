#include <cmath>

#include "descriptions.hpp"
#include "report/results.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

template <typename Answer>
std::string lastLine(const Answer& answer) {
  return toString(answer.code) + ": " + answer.message + "\n";
}

std::string seconds(double duration) {
  return std::isinf(duration) ? "no end" : format("%.1f s", duration);
}

template <typename Answer>
std::string cell(const Answer& answer, const std::optional<Interval>& interval, int digits) {
  if (!interval) return format("%25s", "-");
  const std::string text =
      format("%.*f [%.*f, %.*f]%s", digits, interval->value, digits, interval->lower, digits,
             interval->upper, answer.valid ? "" : "*");
  return format("%25s", text.c_str());
}

template <typename Answer>
std::string table(const std::string& corner, const std::vector<double>& rows,
                  const std::vector<double>& columns, const std::vector<Answer>& answers,
                  std::optional<Interval> Answer::*value, int digits) {
  std::string text = format("%-18s", corner.c_str());
  for (const double column : columns) text += format("%25g", column);
  text += '\n';
  for (std::size_t k = 0; k < answers.size(); ++k) {
    if (k % columns.size() == 0) text += format("%-18g", rows[k / columns.size()]);
    text += cell(answers[k], answers[k].*value, digits);
    if ((k + 1) % columns.size() == 0) text += '\n';
  }
  return text;
}

}  // namespace

nlohmann::json resultJson(const CrankingAnswer& answer) { return jsonOf(answer); }
nlohmann::json resultJson(const StopTimeAnswer& answer) { return jsonOf(answer); }
nlohmann::json resultJson(const ChargeAcceptanceAnswer& answer) { return jsonOf(answer); }
nlohmann::json resultJson(const MapResult& result) { return jsonOf(result); }

std::string resultText(const CrankingQuery& query, const CrankingAnswer& answer) {
  std::string text = query.load.empty()
                         ? format("stop      %.1f s at %.1f A\n", query.t_stop, query.i_load)
                         : format("stop      %.1f s of the given profile\n", query.load.duration());
  text += query.crank.empty()
              ? format("crank     %.2f s at %.1f A\n", query.t_cranking, query.i_cranking)
              : format("crank     %.2f s of the given profile\n", query.crank.duration());
  text += answer.u_min ? format("lowest    %.3f V, 90 %% between %.3f and %.3f V\n",
                                answer.u_min->value, answer.u_min->lower, answer.u_min->upper)
                       : "lowest    -\n";
  if (answer.capable && !answer.valid) text += "verdict   not supported\n";
  if (answer.capable && answer.valid)
    text += format("verdict   %s %.2f V\n", *answer.capable ? "holds" : "may not hold",
                   query.u_required.value_or(0.0));
  return text + lastLine(answer);
}

std::string resultText(const StopTimeQuery& query, const StopTimeAnswer& answer) {
  std::string text =
      format("question  longest stop at %.1f A, then a crank of %.2f s at %.1f A holds %.2f V\n",
             query.i_load, query.t_cranking, query.i_cranking, query.u_required);
  const char* recovers = answer.monotone ? "" : "; the battery recovers at first";
  if (answer.t_stop && answer.outcome == StopTimeOutcome::kAtLeast)
    text += format(
        "stop      at least %s, the longest that the model supports; 90 %% lower end %s%s\n",
        seconds(answer.t_stop->value).c_str(), seconds(answer.t_stop->lower).c_str(), recovers);
  else if (answer.t_stop)
    text +=
        format("stop      %s, 90 %% between %s and %s: %s%s\n",
               seconds(answer.t_stop->value).c_str(), seconds(answer.t_stop->lower).c_str(),
               seconds(answer.t_stop->upper).c_str(), toString(answer.outcome).c_str(), recovers);
  return text + lastLine(answer);
}

std::string resultText(const ChargeAcceptanceQuery& query, const ChargeAcceptanceAnswer& answer) {
  std::string text = format("question  current over %.1f s at %.2f V, at most %.0f A\n",
                            query.t_sof2, query.u_boost, query.i_limit);
  if (answer.i_boost)
    text += format("mean      %.1f A, 90 %% between %.1f and %.1f A\n", answer.i_boost->value,
                   answer.i_boost->lower, answer.i_boost->upper);
  return text + lastLine(answer);
}

std::string resultText(const MapResult& result) {
  std::string text;
  if (result.cranking) {
    text += "lowest voltage of the crank [V], 90 % interval; * outside the identified range\n";
    text += table("i_load \\ t_stop", result.i_load, result.t_stop, result.cranking->answers,
                  &CrankingAnswer::u_min, 2);
  }
  if (result.charge) {
    text += "mean charge current [A], 90 % interval; * outside the identified range\n";
    text += table("u_boost \\ t_sof2", result.u_boost, result.t_sof2, result.charge->answers,
                  &ChargeAcceptanceAnswer::i_boost, 1);
  }
  return text + lastLine(verdictOf(result.cranking, result.charge));
}

}  // namespace battery_sof
