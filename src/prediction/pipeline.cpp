#include "prediction/pipeline.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "battery_sof/intake.hpp"
#include "estimation/depth_physics.hpp"
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

/// It keeps missing the voltage of the present load by more than the whole interval in which that
/// was expected. A crank's own error is MissedAnswer's.
void addPresentlyMissed(Reasons& reasons, const FittedModel& model) {
  const PresentError& present = model.state.residual_state.present;
  if (!present.current || present.since < kKeepsMissing) return;
  const ErrorForecast expected = expectedPresentError(model);
  const double missed = present.level - expected.mean, width = 2.0 * halfWidthOf(expected);
  if (std::abs(missed) > width) reasons.push_back({ReasonKind::kMissedVoltage, {missed, width}});
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

/// The equations are no description of the window's own cranks.
void addMissedCranks(Reasons& reasons, const Fit& fit) {
  const auto& line = fit.baseline.cranks;
  if (fit.scores.cranks < static_cast<int>(kCranksThatSupport) || !line) return;
  const double of_line = 0.5 * (line->error.upper - line->error.lower) / kNinetyPercent;
  if (fit.scores.crank_error_std > of_line)
    reasons.push_back({ReasonKind::kMissedCranks,
                       {1.0 * fit.scores.cranks, fit.scores.crank_error_std, of_line}});
}

/// The voltage above which no battery of as many blocks as the voltage shows is [V].
double maxVoltage(const Fit& fit) { return kMaxOfBlock * seriesBlocksAt(fit.parameters.u_dc); }

/// So much charge is too much.
void addMovedCharge(Reasons& reasons, const Fit& fit, const QueryRange& range, double capacity) {
  const double moved = range.charge_moved;
  const double supported = supportedCharge(fit, capacity, range.charges);
  if (moved > capacity)
    reasons.push_back({ReasonKind::kCapacity, {moved, capacity}});
  else if (moved > supported)
    reasons.push_back(
        {ReasonKind::kMovedCharge,
         {moved, supported, 100.0 * (range.charges ? kConstantCharge : kSlopedCharge), capacity}});
}

void addCharging(Reasons& reasons, const Fit& fit, const QueryRange& range) {
  const ExcitedRange& seen = fit.excited;
  const ChargeEvidence& evidence = range.evidence;
  if (evidence.is_supported || !range.charges) return;
  if (fit.window.samples == 0) reasons.push_back({ReasonKind::kNoWindow});
  if (fit.source) {
    const double enough = std::max(kUsefulWidth, kUsefulShare * seen.max_current);
    const double width = range.answered_current->upper - range.answered_current->lower;
    if (width > enough) reasons.push_back({ReasonKind::kUselessCurrent, {width, enough}});
    return;
  }
  if (!range.charge_duration || *range.charge_duration <= kShortCharge) return;
  if (!contains(fit.effects, "charge_acceptance")) reasons.push_back({ReasonKind::kNoAcceptance});
  if (seen.longest_charge < kShortCharge)
    reasons.push_back({ReasonKind::kShortCharges, {seen.longest_charge, kShortCharge}});
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

void requireOf(Faults& faults, bool ok, const char* name, double value, const char* expected) {
  if (!ok)
    faults.push_back(format("%s is %s, expected %s", name, exactly(value).c_str(), expected));
}

std::optional<std::string> faultOf(const std::vector<double>& time,
                                   const std::vector<double>& current, const char* name,
                                   std::size_t most) {
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
  return std::nullopt;
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

Reasons denialOf(const FittedModel& model) {
  Reasons reasons;
  addPresentlyMissed(reasons, model);
  if (const auto& missed = model.intervals.missed_answer)
    reasons.push_back({ReasonKind::kMissedCrank, {missed->measured, missed->lower, missed->upper}});
  return reasons;
}

namespace {

/// Where a query goes beyond what the window showed, or its result beyond what a battery shows.
void addBeyondWindow(Reasons& reasons, const FittedModel& model, const QueryRange& range,
                     double capacity) {
  const Fit& fit = model.fit;
  const ExcitedRange& seen = fit.excited;
  if (range.min_current && *range.min_current < kCurrentReach * std::min(seen.min_current, 0.0))
    reasons.push_back({ReasonKind::kDischarge, {*range.min_current, seen.min_current}});
  if (range.max_current && !range.evidence.is_supported &&
      *range.max_current > kCurrentReach * std::max(seen.max_current, 0.0))
    reasons.push_back({ReasonKind::kCharge, {*range.max_current, seen.max_current}});
  if (range.max_voltage &&
      *range.max_voltage > seen.max_voltage + seriesBlocksAt(fit.parameters.u_dc) * kVoltageReach)
    reasons.push_back({ReasonKind::kVoltage, {*range.max_voltage, seen.max_voltage}});
  addMovedCharge(reasons, fit, range, capacity);
  if (const auto u = range.answered_voltage) {
    if (u->value < 0.0 || u->value > maxVoltage(fit))
      reasons.push_back({ReasonKind::kNoVoltage, {u->value, maxVoltage(fit)}});
    else if (const auto reason = voltageSaysNothing(fit, *u))
      reasons.push_back(*reason);
  }
  if (range.says_nothing) reasons.push_back(*range.says_nothing);
}

}  // namespace

Reasons extrapolationOf(const FittedModel& model, const QueryRange& range, double capacity) {
  const Fit& fit = model.fit;
  const ExcitedRange& seen = fit.excited;
  Reasons reasons;
  addBeyondWindow(reasons, model, range, capacity);
  for (const Reason& denial : denialOf(model)) reasons.push_back(denial);
  if (range.beyond_identified > kDiscrepancyReach)
    reasons.push_back({ReasonKind::kHeldDiscrepancy, {range.beyond_identified}});
  const auto temperature = range.temperature ? range.temperature : model.state.temperature;
  if (temperature && seen.temperature &&
      std::abs(*temperature - *seen.temperature) > kTemperatureReach)
    reasons.push_back({ReasonKind::kTemperature, {*temperature, *seen.temperature}});
  addCharging(reasons, fit, range);
  if (range.charges && range.evidence.is_supported) return reasons;
  // With fresh_sulphate one resistance serves both signs.
  const bool of_charging = range.charges && !contains(fit.effects, "fresh_sulphate");
  const std::size_t past_cranks = model.intervals.event_history.cranks.size();
  if (!range.charges && past_cranks >= kCranksThatSupport) return reasons;
  if (isOfHeldLoad(fit, range)) return reasons;
  if (!range.charges) addMissedCranks(reasons, fit);
  // With a source it is a share of explained variation, and the node's first model has none.
  if (!range.charges && !fit.source && fit.window.samples > 0 &&
      fit.window_quality < kUsefulQuality)
    reasons.push_back({ReasonKind::kWindowQuality, {fit.window_quality, kUsefulQuality}});
  std::vector<const char*> needed = {of_charging ? "r_charge" : "r_discharge"};
  if (!range.charges) needed.push_back("u_dc");
  for (const char* name : needed) {
    const ParameterEstimate* estimate = estimateOf(fit, name);
    if (estimate && !estimate->determined) reasons.push_back({ReasonKind::kUndetermined, {}, name});
  }
  return reasons;
}

Reasons whyNoCrank(const FittedModel& model) {
  QueryRange range;
  if (holdsOneLoad(model.fit)) range.min_current = model.fit.excited.min_current;
  return extrapolationOf(model, range, 1.0);
}

std::optional<Reason> voltageSaysNothing(const Fit& fit, const Interval& u) {
  const double width = kSpanOfBlock * seriesBlocksAt(fit.parameters.u_dc);
  if (u.lower >= 0.0 && u.upper <= maxVoltage(fit) && u.upper - u.lower < width)
    return std::nullopt;
  return Reason{ReasonKind::kWideVoltage, {u.lower, u.upper, maxVoltage(fit), width}};
}

std::optional<Reason> widthSaysNothing(ReasonKind kind, const Interval& answer, double width,
                                       const std::string& whose) {
  if (answer.upper - answer.lower < width) return std::nullopt;
  return Reason{kind, {answer.lower, answer.upper, width}, whose};
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
  return {value, value - std::hypot(u.value - u.lower, more),
          value + std::hypot(u.upper - u.value, more)};
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
