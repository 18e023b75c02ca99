#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include "prediction/questions.hpp"

/// What holds of every answer, whatever the model, its state and the question. Each function
/// returns the first law that an answer breaks, with its numbers; empty when it keeps them all.
namespace battery_sof::test {

inline constexpr double kMaxVolts = 16.0;    // [V], of a block of six lead-acid cells
inline constexpr double kRestVolts = 12.5;   // [V], likewise
inline constexpr double kMaxStop = 86400.0;  // [s]
inline constexpr double kRounding = 1.0 + 1e-9;

inline double blocksOf(const Fit& fit) {
  return std::max(1.0, std::round(fit.parameters.u_dc / kRestVolts));
}

inline bool isOrdered(const Interval& u) { return u.lower <= u.value && u.value <= u.upper; }
inline bool isFinite(const Interval& u) {
  return std::isfinite(u.lower) && std::isfinite(u.value) && std::isfinite(u.upper);
}

/// Laws of code, message and validity alone.
template <typename Answer>
std::string brokenForm(const Answer& answer, bool has_numbers) {
  if (answer.message.empty()) return "no message";
  if (answer.valid != (answer.code == AnswerCode::kOk)) return "valid does not go with the code";
  const bool is_answered =
      answer.code == AnswerCode::kOk || answer.code == AnswerCode::kExtrapolation;
  return is_answered == has_numbers ? "" : "numbers do not go with the code";
}

inline std::string brokenInterval(const Interval& u) {
  if (!isFinite(u)) return format("not finite: %g [%g, %g]", u.value, u.lower, u.upper);
  return isOrdered(u) ? "" : format("not ordered: %g [%g, %g]", u.value, u.lower, u.upper);
}

inline std::string brokenLaw(const CrankingAnswer& answer, const Fit& fit) {
  const std::string form = brokenForm(answer, answer.u_min.has_value());
  if (!form.empty() || !answer.u_min) return form;
  const Interval& u = *answer.u_min;
  const std::string interval = brokenInterval(u);
  if (!interval.empty() || !answer.valid) return interval;
  const double most = kMaxVolts * blocksOf(fit);
  return u.lower >= 0.0 && u.upper <= most
             ? ""
             : format("a valid crank of %g to %g V, expected 0 to %g V", u.lower, u.upper, most);
}

inline std::string brokenLaw(const StopTimeAnswer& answer, const StopTimeQuery& query,
                             double capacity) {
  const std::string form = brokenForm(answer, answer.t_stop.has_value());
  if (!form.empty() || !answer.t_stop) return form;
  const Interval& t = *answer.t_stop;
  if (std::isnan(t.lower) || std::isnan(t.upper) || !isOrdered(t) || t.lower < 0.0)
    return format("not a stop: %g [%g, %g]", t.value, t.lower, t.upper);
  const bool is_endless = std::isinf(t.value);
  if (is_endless != (answer.outcome == StopTimeOutcome::kAlways))
    return "an endless stop does not go with the outcome";
  if (!is_endless && t.value > kMaxStop)
    return format("a stop of %g s, longer than a day", t.value);
  if ((t.value == 0.0) != (answer.outcome == StopTimeOutcome::kNever))
    return "a stop of nothing does not go with the outcome";
  if (answer.valid && query.i_load < 0.0 && t.lower <= 0.0 &&
      -query.i_load * t.upper / 3600.0 >= capacity)
    return format("a valid stop of %g to %g s, which is all there can be", t.lower, t.upper);
  if (query.i_load < 0.0 && -query.i_load * t.upper / 3600.0 > capacity * kRounding)
    return format("stops up to %g s draw more than %g Ah", t.upper, capacity);
  return "";
}

inline std::string brokenLaw(const ChargeAcceptanceAnswer& answer,
                             const ChargeAcceptanceQuery& query, double capacity) {
  const std::string form = brokenForm(answer, answer.i_boost.has_value());
  if (!form.empty() || !answer.i_boost) return form;
  const Interval& i = *answer.i_boost;
  const std::string interval = brokenInterval(i);
  if (!interval.empty()) return interval;
  if (i.upper > query.i_limit)
    return format("%g A, above the source's %g A", i.upper, query.i_limit);
  if (!answer.valid) return "";
  if (std::abs(i.value) * query.t_sof2 / 3600.0 > capacity * kRounding)
    return format("a valid charge of %g A for %g s is more than %g Ah", i.value, query.t_sof2,
                  capacity);
  return "";
}

inline std::string brokenLaw(const ProfileAnswer& answer, std::size_t samples) {
  const PredictedVoltage& u = answer.predicted;
  const std::string form = brokenForm(answer, !u.voltage.empty());
  if (!form.empty() || u.voltage.empty()) return form;
  if (u.voltage.size() != samples || u.lower.size() != samples || u.upper.size() != samples)
    return "not one voltage a sample";
  for (std::size_t n = 0; n < samples; ++n) {
    const std::string interval = brokenInterval({u.voltage[n], u.lower[n], u.upper[n]});
    if (!interval.empty()) return format("sample %zu: ", n) + interval;
  }
  return "";
}

}  // namespace battery_sof::test
