#include "battery_sof/predict/cranking.hpp"

#include <cmath>
#include <cstdarg>
#include <cstdio>

#include "battery_sof/predict/prediction_interval.hpp"
#include "battery_sof/recording/intake.hpp"

namespace battery_sof {
namespace {

constexpr double kLongestStop = 86400.0;                         // [s], a day
constexpr double kLongestCrank = 60.0;                           // [s], no starter survives more
constexpr double kMostCurrent = IntakeLimits{}.max_abs_current;  // [A]
constexpr double kExtrapolation = 1.25;   // of the largest discharge the window held
constexpr double kConstantCharge = 0.01;  // of capacity: paper, section V ("within 1 %")

/// printf into a std::string.
std::string format(const char* pattern, ...) {
  char text[256];
  std::va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(text, sizeof text, pattern, arguments);
  va_end(arguments);
  return text;
}

void addFault(std::string& faults, bool ok, const char* name, double value, const char* expected) {
  if (ok) return;
  if (!faults.empty()) faults += "; ";
  faults += format("%s is %g, expected %s", name, value, expected);
}

/// Why the model should not be trusted for a query; empty when it may.
std::string extrapolation(const FittedModel& model, const CrankingQuery& query, double capacity) {
  std::string reasons;
  if (query.i_cranking < kExtrapolation * model.excited.min_current)
    reasons += format("i_cranking is %g A but the window's largest discharge was %g A; ",
                      query.i_cranking, model.excited.min_current);
  const double charge = -query.i_load * query.t_stop / 3600.0;  // [Ah]
  if (charge > kConstantCharge * capacity)
    reasons += format(
        "the stop takes %.2f Ah, more than 1 %% of %g Ah, and the base model holds "
        "the open-circuit voltage constant; ",
        charge, capacity);
  if (!model.estimates.empty() && !model.estimates[kRowRDischarge].determined)
    reasons += "the window did not determine r_discharge; ";
  return reasons.empty() ? reasons : reasons.substr(0, reasons.size() - 2);
}

}  // namespace

std::string faultsOf(const CrankingQuery& q) {
  std::string faults;
  addFault(faults, q.i_load <= 0.0 && q.i_load >= -kMostCurrent, "i_load [A]", q.i_load,
           "-5000 to 0 (negative: out of the battery)");
  addFault(faults, q.t_stop >= 0.0 && q.t_stop <= kLongestStop, "t_stop [s]", q.t_stop,
           "0 to 86400");
  addFault(faults, q.i_cranking < 0.0 && q.i_cranking >= -kMostCurrent, "i_cranking [A]",
           q.i_cranking, "-5000 to below 0 (negative: out of the battery)");
  addFault(faults, q.t_cranking > 0.0 && q.t_cranking <= kLongestCrank, "t_cranking [s]",
           q.t_cranking, "above 0, up to 60");
  if (q.u_required)
    addFault(faults, *q.u_required >= 0.0 && *q.u_required <= 100.0, "u_required [V]",
             *q.u_required, "0 to 100");
  return faults;
}

CrankingAnswer predictCranking(const FittedModel& model, const CrankingQuery& query,
                               double capacity) {
  CrankingAnswer answer;
  const std::string faults = faultsOf(query);
  if (!faults.empty()) {
    answer.code = AnswerCode::kInvalidQuery;
    answer.message = faults;
    return answer;
  }
  if (!isUsable(model)) {
    answer.code = AnswerCode::kNoModel;
    answer.message = "the model cannot be used: " + model.message;
    return answer;
  }
  const OverpotentialStep step(model.parameters);
  const Overpotential at_stop =
      step.advance(Overpotential{model.state.u_c2, 1.0, 0.0, 0.0}, query.i_load, query.t_stop);
  const Overpotential at_end = step.advance(at_stop, query.i_cranking, query.t_cranking);
  // Monotone under a held current: one end of the crank is the minimum.
  const Overpotential& lowest = at_end.value <= at_stop.value ? at_end : at_stop;
  answer.u_min = voltageInterval(model, query.i_cranking, lowest, model.scores.crank_error_std);
  if (query.u_required) answer.capable = answer.u_min->lower >= *query.u_required;

  const std::string reasons = extrapolation(model, query, capacity);
  answer.valid = reasons.empty();
  answer.code = answer.valid ? AnswerCode::kOk : AnswerCode::kExtrapolation;
  answer.message = format("lowest voltage %.2f V, 90 %% between %.2f and %.2f V",
                          answer.u_min->value, answer.u_min->lower, answer.u_min->upper);
  if (answer.capable)
    answer.message +=
        format(": %s %.2f V", *answer.capable ? "holds" : "may not hold", *query.u_required);
  if (!answer.valid) answer.message += "; not to be relied on: " + reasons;
  return answer;
}

}  // namespace battery_sof
