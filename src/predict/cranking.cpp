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
constexpr int kCrankSteps = 100;          // 100 Hz for a crank of a second
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

/// Moves on under a held current.
void hold(Simulation& simulation, double current, double duration) {
  DriveStep step;
  step.duration = duration;
  step.time = simulation.time() + duration;
  step.held = step.current = current;
  simulation.advance(step);
}

/// Lowest voltage of a crank that begins now. The base model's state moves monotonically under a held current, so its
/// minimum stands at one end; effects may dip in between.
Interval lowestDuring(Simulation& simulation, const FittedModel& model, const CrankingQuery& query) {
  const int steps = model.effects.empty() ? 1 : kCrankSteps;
  hold(simulation, query.i_cranking, 0.0);
  Interval lowest = voltageInterval(simulation, model.scores.crank_error_std);
  for (int k = 0; k < steps; ++k) {
    hold(simulation, query.i_cranking, query.t_cranking / steps);
    const Interval now = voltageInterval(simulation, model.scores.crank_error_std);
    if (now.value <= lowest.value) lowest = now;
  }
  return lowest;
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
  Simulation simulation = uncertainSimulationOf(model);
  hold(simulation, query.i_load, query.t_stop);
  answer.u_min = lowestDuring(simulation, model, query);
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
