#include "prediction/pipeline.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "battery_sof/intake.hpp"
#include "estimation/moved_charge.hpp"
#include "model/input_sequence.hpp"
#include "recording/series_blocks.hpp"
#include "state/posterior.hpp"
#include "util/constants.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr double kVoltageReach = 0.3;  // [V] a block above the window's highest
// [V], of a discrepancy model held at its range's end: relevant to a crank
constexpr double kDiscrepancyReach = 0.010;
constexpr double kConstantCharge = 0.01;  // of capacity: paper, section V ("within 1 %")
constexpr double kSlopedCharge = 0.02;    // of capacity, with the slope of any battery
constexpr double kUsualSlope = 1.2, kSlopeSpread = 0.4;  // [V] of a block, of the whole capacity
// [V] of a block for a unit of state of charge (docs/physics.md#ocv_soc)
constexpr double kMinSlope = 0.8;
constexpr double kMaxSlope = 1.8;
constexpr double kMaxOfBlock = 16.0;  // [V], of six lead-acid cells, above any charger's
// Widest interval of a charge's current that is of use: [A], and of the window's largest charge.
constexpr double kUsefulWidth = 10.0, kUsefulShare = 0.5;
constexpr double kSpanOfBlock = 10.0;  // [V], from 1 V a cell, empty under load, up to kMaxOfBlock
constexpr std::size_t kCranksThatSupport = 3;  // as of a charge (ChargeEvidence)
// windowQuality() of an error of 1 V, about a crank's whole drop of voltage
constexpr double kUsefulQuality = 0.05;
// [s]: depletion builds up over 5 to 40 s (docs/physics.md#charge_acceptance)
constexpr double kShortCharge = 10.0;

constexpr double kKeepsMissing = 8.0;  // [s], as the present level's memory

// Of an IntervalCalibration, see update().
constexpr double kRate = 0.25;      // eta: an outlier widens by a quarter
constexpr double kMissShare = 0.1;  // of a 90 % interval
constexpr double kLeast = 0.1, kMost = 50.0;

/// Half of the 90 % interval [V].
double halfWidthOf(const ErrorForecast& error) {
  return kNinetyPercent * std::sqrt(error.variance);
}

/// Whether it keeps missing the voltage of the present load by more than the whole interval in which
/// that was expected. A crank's own error is MissedAnswer's.
std::string presentlyMissed(const FittedModel& model) {
  const PresentError& present = model.state.residual_state.present;
  if (!present.current || present.since < kKeepsMissing) return "";
  const ErrorForecast expected = expectedPresentError(model);
  const double missed = present.level - expected.mean, width = 2.0 * halfWidthOf(expected);
  if (std::abs(missed) <= width) return "";
  return format(
      "the model misses the present voltage by %+.2f V, more than the %.2f V of its "
      "interval",
      model.fit.series_blocks * missed, model.fit.series_blocks * width);
}

const ParameterEstimate* estimateOf(const Fit& fit, const char* name) {
  const auto found = std::find_if(fit.estimates.begin(), fit.estimates.end(),
                                  [&](const auto& estimate) { return estimate.name == name; });
  return found == fit.estimates.end() ? nullptr : &*found;
}

/// Whether the window determined how the open-circuit voltage follows the charge, and as a
/// battery's does.
bool knowsOpenCircuitSlope(const Fit& fit, double capacity) {
  const ParameterEstimate* slope = estimateOf(fit, "ocv_slope");
  if (!slope || !slope->determined || slope->held) return false;
  const double of_block = slope->value * capacity / seriesBlocksAt(fit.parameters.u_dc);
  return of_block >= kMinSlope && of_block <= kMaxSlope;
}

/// Blocks in series: those that were given, times those that the voltage shows.
double blocksOf(const Fit& fit) { return fit.series_blocks * seriesBlocksAt(fit.parameters.u_dc); }

/// Why the equations are no description of the window's own cranks; empty when they are.
std::string missesItsCranks(const Fit& fit) {
  const auto& line = fit.baseline.cranks;
  if (fit.scores.cranks < static_cast<int>(kCranksThatSupport) || !line) return "";
  const double of_line = 0.5 * (line->error.upper - line->error.lower) / kNinetyPercent;
  if (!(fit.scores.crank_error_std > of_line)) return "";
  return format(
      "it misses the lowest voltages of the window's %d cranks by %.0f mV RMS, the baseline "
      "by %.0f mV",
      fit.scores.cranks, 1e3 * fit.scores.crank_error_std, 1e3 * of_line);
}

/// The voltage above which no battery of as many blocks is [V].
double maxVoltage(const Fit& fit) { return kMaxOfBlock * blocksOf(fit); }

/// Why so much charge is too much; empty when it is not.
std::string excessiveCharge(const Fit& fit, const QueryRange& range, double capacity) {
  const double moved = range.charge_moved;
  if (moved > capacity)
    return format("it moves %.0f Ah, more than the battery's %g Ah", moved, capacity);
  const double supported = supportedCharge(fit, capacity, range.charges);
  if (moved <= supported) return "";
  return format(
      "it moves %.2f Ah but the model supports at most %.2f Ah (%d %% of %g Ah, or what the window "
      "moved if it determined how the open-circuit voltage follows the charge)",
      moved, supported, range.charges ? 1 : 2, capacity);
}

void addCharging(std::string& reasons, const Fit& fit, const QueryRange& range) {
  const ExcitedRange& seen = fit.excited;
  const ChargeEvidence& evidence = range.evidence;
  if (evidence.is_supported || !range.charges) return;
  if (fit.window.samples == 0)
    addReason(reasons, "no window has been fitted yet, and charges need one");
  if (fit.source) {
    const double enough = std::max(kUsefulWidth, kUsefulShare * seen.max_current);
    const double width = range.answered_current->upper - range.answered_current->lower;
    if (width > enough)
      addReason(reasons, format("its 90 %% interval is %.1f A wide, but at most %.1f A is useful",
                                width, enough));
    return;
  }
  if (!range.charge_duration || *range.charge_duration <= kShortCharge) return;
  if (!contains(fit.effects, "charge_acceptance"))
    addReason(reasons, "the model lacks a limit of charge acceptance (effect charge_acceptance)");
  if (seen.longest_charge < kShortCharge)
    addReason(reasons,
              format("the window's longest charge lasted %.1f s, but at least %.0f s are needed",
                     seen.longest_charge, kShortCharge));
}

/// Whether a window held one load: what it determined is the voltage under that load.
bool holdsOneLoad(const Fit& fit) {
  return contains(fit.effects, kUsedUp) &&
         isOneLoad(fit.excited.min_current, fit.excited.max_current);
}

/// Whether a query is of the load that the window held.
bool isOfHeldLoad(const Fit& fit, const QueryRange& range) {
  const double load = fit.excited.min_current;
  return holdsOneLoad(fit) && range.min_current &&
         isOneLoad(std::min(load, *range.min_current), std::max(load, *range.min_current));
}

/// Six significant digits, more where another number has the same six: a value beyond a limit never
/// reads as the limit.
std::string exactly(double value) {
  std::string text;
  for (int digits = 6; digits <= std::numeric_limits<double>::max_digits10; ++digits) {
    text = format("%.*g", digits, value);
    if (numberOf(text) == value) break;
  }
  return std::isnan(value) ? "nan" : text;
}

}  // namespace

std::optional<double> askedFor(std::optional<double> given) {
  return given && (*given == 0.0 || std::isnan(*given)) ? std::nullopt : given;
}

void addReason(std::string& reasons, const std::string& reason) {
  if (!reason.empty()) reasons += (reasons.empty() ? "" : "; ") + reason;
}

void addReason(std::string& reasons, bool ok, const char* name, double value,
               const char* expected) {
  if (!ok)
    addReason(reasons, format("%s is %s, expected %s", name, exactly(value).c_str(), expected));
}

std::string faultOf(const std::vector<double>& time, const std::vector<double>& current,
                    const char* name, std::size_t most) {
  if (time.size() != current.size())
    return format("%s has %zu times and %zu currents, expected as many", name, time.size(),
                  current.size());
  if (time.size() > most)
    return format("%s has %zu points, expected at most %zu", name, time.size(), most);
  for (std::size_t n = 0; n < time.size(); ++n) {
    const double t = time[n], i = current[n];
    if (!(t >= 0.0 && t <= kLongestQuery))
      return format("%s time[%zu] is %s s, expected 0 to 86400", name, n, exactly(t).c_str());
    if (n > 0 && !(t > time[n - 1]))
      return format("%s time[%zu] is %s s, expected more than the one before", name, n,
                    exactly(t).c_str());
    const double step = n > 0 ? t - time[n - 1] : t;
    if (step > 0.0 && step < kShortestStep)
      return format("%s time[%zu] is %s s after the one before, expected at least %g s", name, n,
                    exactly(step).c_str(), kShortestStep);
    if (!(std::abs(i) <= kMaxCurrent))
      return format("%s current[%zu] is %s A, expected -5000 to 5000", name, n, exactly(i).c_str());
  }
  return "";
}

double supportedCharge(const Fit& fit, double capacity, bool charges) {
  const double usual = (charges ? kConstantCharge : kSlopedCharge) * capacity;
  return knowsOpenCircuitSlope(fit, capacity)
             ? contains(fit.effects, kUsedUp) && !charges
                   ? capacity
                   : std::clamp(fit.excited.charge_swing, usual, capacity)
             : usual;
}

ErrorForecast openCircuitFall(const Fit& fit, double drawn, double capacity) {
  const double beyond = drawn / capacity - kConstantCharge;
  if (beyond <= 0.0 || knowsOpenCircuitSlope(fit, capacity)) return {};
  const double share = beyond * seriesBlocksAt(fit.parameters.u_dc);
  return {-kUsualSlope * share, std::pow(kSlopeSpread * share, 2)};
}

std::string denialOf(const FittedModel& model) {
  std::string reasons = presentlyMissed(model);
  if (const auto& missed = model.intervals.missed_answer) {
    const double blocks = model.fit.series_blocks;
    addReason(reasons,
              format("the last crank reached %.2f V, outside the predicted %.2f to %.2f V",
                     blocks * missed->measured, blocks * missed->lower, blocks * missed->upper));
  }
  return reasons;
}

std::string extrapolationOf(const FittedModel& model, const QueryRange& range, double capacity) {
  const Fit& fit = model.fit;
  const ExcitedRange& seen = fit.excited;
  std::string reasons;
  if (range.min_current && *range.min_current < kCurrentReach * std::min(seen.min_current, 0.0))
    addReason(reasons, format("it draws %.0f A but the window's largest discharge was %.0f A",
                              *range.min_current, seen.min_current));
  if (range.max_current && !range.evidence.is_supported &&
      *range.max_current > kCurrentReach * std::max(seen.max_current, 0.0))
    addReason(reasons, format("it charges with %.0f A but the window's largest charge was %.0f A",
                              *range.max_current, seen.max_current));
  if (range.max_voltage &&
      *range.max_voltage > fit.series_blocks * seen.max_voltage + blocksOf(fit) * kVoltageReach)
    addReason(reasons, format("it goes to %.2f V but the window's highest voltage was %.2f V",
                              *range.max_voltage, fit.series_blocks * seen.max_voltage));
  addReason(reasons, excessiveCharge(fit, range, capacity));
  if (const auto u = range.answered_voltage) {
    const bool is_possible = u->value >= 0.0 && u->value <= maxVoltage(fit);
    addReason(reasons, is_possible
                           ? voltageSaysNothing(fit, *u)
                           : format("its result is %.2f V, expected 0 to %.0f V for such a battery",
                                    u->value, maxVoltage(fit)));
  }
  addReason(reasons, range.says_nothing);
  addReason(reasons, denialOf(model));
  if (range.beyond_identified > kDiscrepancyReach)
    addReason(
        reasons,
        format(
            "the discrepancy is held at the end of its range, %.0f mV from its extrapolated value",
            1e3 * fit.series_blocks * range.beyond_identified));
  const auto temperature = range.temperature ? range.temperature : model.state.temperature;
  if (temperature && seen.temperature &&
      std::abs(*temperature - *seen.temperature) > kTemperatureReach)
    addReason(reasons, format("the battery is at %.0f degC but in the window it was at %.0f degC",
                              *temperature - kZeroCelsius, *seen.temperature - kZeroCelsius));
  addCharging(reasons, fit, range);
  if (range.charges && range.evidence.is_supported) return reasons;
  // With fresh_sulphate one resistance serves both signs.
  const bool of_charging = range.charges && !contains(fit.effects, "fresh_sulphate");
  const std::size_t past_cranks = model.intervals.event_history.cranks.size();
  if (!range.charges && past_cranks >= kCranksThatSupport) return reasons;
  if (isOfHeldLoad(fit, range)) return reasons;
  if (!range.charges) addReason(reasons, missesItsCranks(fit));
  // With a source it is a share of explained variation, and the node's first model has none.
  if (!range.charges && !fit.source && fit.window.samples > 0 &&
      fit.window_quality < kUsefulQuality)
    addReason(reasons, format("the window quality is %.2f, but at least %.2f is needed",
                              fit.window_quality, kUsefulQuality));
  std::vector<const char*> needed = {of_charging ? "r_charge" : "r_discharge"};
  if (!range.charges) needed.push_back("u_dc");
  for (const char* name : needed) {
    const ParameterEstimate* estimate = estimateOf(fit, name);
    if (estimate && !estimate->determined)
      addReason(reasons, format("the window did not determine %s", name));
  }
  return reasons;
}

std::string whyNoCrank(const FittedModel& model) {
  QueryRange range;
  if (holdsOneLoad(model.fit)) range.min_current = model.fit.excited.min_current;
  return extrapolationOf(model, range, 1.0);
}

std::string voltageSaysNothing(const Fit& fit, const Interval& u) {
  const double width = kSpanOfBlock * blocksOf(fit);
  if (u.lower >= 0.0 && u.upper <= maxVoltage(fit) && u.upper - u.lower < width) return "";
  return format(
      "its 90 %% interval of %.2f to %.2f V is of no use, expected inside 0 to %.0f V and narrower "
      "than %.0f V",
      u.lower, u.upper, maxVoltage(fit), width);
}

std::string widthSaysNothing(const Interval& answer, double width, const char* unit,
                             const std::string& whose) {
  if (answer.upper - answer.lower < width) return "";
  return format(
             "its 90 %% interval of %.1f to %.1f %s is of no use, expected narrower than %.1f %s, ",
             answer.lower, answer.upper, unit, width, unit) +
         whose;
}

bool areNumbers(const Interval& answer) {
  return std::isfinite(answer.value) && std::isfinite(answer.lower) && std::isfinite(answer.upper);
}

Interval voltageAnswer(const Simulation& simulation, const ErrorForecast& error, double own,
                       const IntervalCalibration& scale) {
  const double variance = simulation.voltageDerivatives().squaredNorm() + error.variance +
                          own * own + std::pow(simulation.beyondIdentified(), 2);
  return ninetyPercent(simulation.voltage() + error.mean, std::sqrt(variance), scale.factor);
}

Interval beginAtPresent(const FittedModel& model, const Interval& modelled, double equations,
                        double current, double ahead) {
  const PresentForecast present = forecastOf(model, current, ahead);
  const double half = 0.5 * (modelled.upper - modelled.lower);
  if (present.share <= 0.0 || !(half > 0.0) || !areNumbers(modelled)) return modelled;
  const ErrorForecast expected = expectedPresentError(model);
  const double excess =
      std::max(0.0, std::abs(present.level - expected.mean) - halfWidthOf(expected));
  const double own = std::pow(half / kNinetyPercent, 2), share = present.share * present.share;
  // What both say may differ by their variances; what is beyond their interval is the model's.
  const double apart = equations + present.level - modelled.value;
  const double beyond = std::pow(apart / kNinetyPercent, 2) - own / share - present.variance;
  const double prior = own + excess * excess + std::max(0.0, beyond);
  const double weight = share * prior / (prior + share * present.variance);
  const double value = modelled.value + weight * apart,
               factor = std::sqrt((1.0 - weight) * (prior + weight * apart * apart) / own);
  return {value, value - factor * (modelled.value - modelled.lower),
          value + factor * (modelled.upper - modelled.value)};
}

Interval crankAnswer(const FittedModel& model, double current, const LowestVoltage& lowest,
                     const ErrorForecast& fall) {
  const Interval u = beginAtPresent(model, correctCrankPrediction(model, current, lowest.by_model),
                                    lowest.equations, current, lowest.ahead);
  const double more = kNinetyPercent * std::sqrt(fall.variance), value = u.value + fall.mean;
  return ofSeries({value, value - std::hypot(u.value - u.lower, more),
                   value + std::hypot(u.upper - u.value, more)},
                  model.fit.series_blocks);
}

Interval chargeAnswer(const FittedModel& model, const ChargeBeginning& charge,
                      const Interval& modelled, double i_limit) {
  Interval i = modelled;
  if (modelled.value < i_limit) i = correctChargePrediction(model, charge, modelled);
  if (!areNumbers(i)) return i;
  for (double* current : {&i.value, &i.lower, &i.upper}) *current = std::min(*current, i_limit);
  return i;
}

void update(IntervalCalibration& scale, double measured, const Interval& expected) {
  const bool inside = measured >= expected.lower && measured <= expected.upper;
  ++scale.events;
  if (inside) ++scale.inside;
  const double step = inside ? -kMissShare : 1.0 - kMissShare;
  scale.factor = std::clamp(scale.factor * std::exp(kRate * step), kLeast, kMost);
}

std::string toString(AnswerCode code) {
  constexpr std::array kNames = {"ok", "invalid_query", "no_model", "extrapolation"};
  return kNames.at(static_cast<std::size_t>(code));
}

std::string toString(Assurance assurance) {
  constexpr std::array kNames = {"holds", "not assured", "not valid"};
  return kNames.at(static_cast<std::size_t>(assurance));
}

/// @param holds what was asked for keeps its limit with the unfavourable end of the interval; none
/// where no limit was asked for.
template <typename Answer>
static std::optional<Assurance> assuranceBy(const Answer& answer,
                                            const std::optional<bool>& holds) {
  if (answer.code == AnswerCode::kExtrapolation) return Assurance::kNotValid;
  if (answer.code != AnswerCode::kOk || !holds) return std::nullopt;
  return *holds ? Assurance::kHolds : Assurance::kNotAssured;
}

std::optional<Assurance> assuranceOf(const CrankingAnswer& answer) {
  return assuranceBy(answer, answer.capable);
}

std::optional<Assurance> assuranceOf(const StopTimeAnswer& answer) {
  return assuranceBy(answer, answer.t_stop && answer.t_stop->lower > 0.0);
}

std::optional<Assurance> assuranceOf(const ChargeAcceptanceAnswer& answer) {
  return assuranceBy(answer, answer.i_boost && answer.i_boost->lower > 0.0);
}

std::optional<Assurance> assuranceOf(const ProfileAnswer& answer) {
  return assuranceBy(answer, std::nullopt);
}

}  // namespace battery_sof
