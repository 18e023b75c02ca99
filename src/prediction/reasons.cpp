#include "prediction/reasons.hpp"

#include "util/constants.hpp"
#include "util/text.hpp"

namespace battery_sof {

std::string toString(const Reason& reason, double series_blocks) {
  const auto& [a, b, c, d, e] = reason.numbers;
  const double n = series_blocks;
  switch (reason.kind) {
    case ReasonKind::kMissedVoltage:
      return format(
          "the model misses the present voltage by %+.2f V, more than the %.2f V of its interval",
          n * a, n * b);
    case ReasonKind::kMissedCrank:
      return format("the last crank reached %.2f V, outside the predicted %.2f to %.2f V", n * a,
                    n * b, n * c);
    case ReasonKind::kDischarge:
      return format("it draws %.0f A but the window's largest discharge was %.0f A", a, b);
    case ReasonKind::kCharge:
      return format("it charges with %.0f A but the window's largest charge was %.0f A", a, b);
    case ReasonKind::kProfile:
      return format("the profile spans %.1f to %.1f A but the window only %.1f to %.1f A", a, b, c,
                    d);
    case ReasonKind::kVoltage:
      return format("it goes to %.2f V but the window's highest voltage was %.2f V", n * a, n * b);
    case ReasonKind::kCapacity:
      return format("it moves %.0f Ah, more than the battery's %g Ah", a, b);
    case ReasonKind::kMovedCharge:
      return format(
          "it moves %.2f Ah but the model supports at most %.2f Ah (%.0f %% of %g Ah, or what the "
          "window moved if it determined how the open-circuit voltage follows the charge)",
          a, b, c, d);
    case ReasonKind::kNoVoltage:
      return format("its result is %.2f V, expected 0 to %.0f V for such a battery", n * a, n * b);
    case ReasonKind::kWideVoltage:
      return format(
          "its 90 %% interval of %.2f to %.2f V is of no use, expected inside 0 to %.0f V and "
          "narrower than %.0f V",
          n * a, n * b, n * c, n * d);
    case ReasonKind::kWideSample:
      return format("sample %.0f: ", e) +
             toString({ReasonKind::kWideVoltage, reason.numbers}, series_blocks);
    case ReasonKind::kWideCurrent:
    case ReasonKind::kWideStop: {
      const char* unit = reason.kind == ReasonKind::kWideCurrent ? "A" : "s";
      return format(
                 "its 90 %% interval of %.1f to %.1f %s is of no use, expected narrower than "
                 "%.1f %s, ",
                 a, b, unit, c, unit) +
             reason.subject;
    }
    case ReasonKind::kUselessCurrent:
      return format("its 90 %% interval is %.1f A wide, but at most %.1f A is useful", a, b);
    case ReasonKind::kHeldDiscrepancy:
      return format(
          "the discrepancy is held at the end of its range, %.0f mV from its extrapolated value",
          1e3 * n * a);
    case ReasonKind::kTemperature:
      return format("the battery is at %.0f degC but in the window it was at %.0f degC",
                    a - kZeroCelsius, b - kZeroCelsius);
    case ReasonKind::kNoWindow: return "no window has been fitted yet, and charges need one";
    case ReasonKind::kNoAcceptance:
      return "the model lacks a limit of charge acceptance (effect charge_acceptance)";
    case ReasonKind::kShortCharges:
      return format("the window's longest charge lasted %.1f s, but at least %.0f s are needed", a,
                    b);
    case ReasonKind::kMissedCranks:
      return format(
          "it misses the lowest voltages of the window's %.0f cranks by %.0f mV RMS, the baseline "
          "by %.0f mV",
          a, 1e3 * n * b, 1e3 * n * c);
    case ReasonKind::kWindowQuality:
      return format("the window quality is %.2f, but at least %.2f is needed", a, b);
    case ReasonKind::kUndetermined: return "the window did not determine " + reason.subject;
  }
  return {};
}

std::string toString(const Reasons& reasons, double series_blocks) {
  std::vector<std::string> clauses;
  for (const Reason& reason : reasons) clauses.push_back(toString(reason, series_blocks));
  return join(clauses, "; ");
}

}  // namespace battery_sof
