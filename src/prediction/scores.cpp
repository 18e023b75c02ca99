#include "prediction/scores.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "recording/channel_statistics.hpp"
#include "recording/events.hpp"
#include "recording/series_blocks.hpp"
#include "state/state_tracker.hpp"

namespace battery_sof {

// ---------------------------------------------------------------------------------------------
// a model's course through a recording

namespace {

constexpr double kSameTime = 1e-6;        // [s]
constexpr double kLikeCurrent = 0.5;      // [A]
constexpr double kLikeShare = 0.02;       // [1]
constexpr double kDatedFrom = 1e9;        // [s], times beyond count from 1970
constexpr double kUnmovedCurrent = 1e-6;  // [A]
// [s], samples that the first state is taken from
constexpr double kStartSpan = 1.0;

/// Voltage that the model misses at a sample with its state as it stands [V].
double missingAt(const FittedModel& model, const Series& series, std::size_t n) {
  Simulation here = simulationOf(model);
  InputStep now;
  now.time = series.time[n];
  now.held = now.current = series.current[n];
  here.advance(now);
  return series.voltage[n] - here.voltage();
}

/// The model with its state at the recording's first sample (paper, eq. 5), by the median over the
/// first second; the effects' states at rest.
FittedModel modelAtFirstSample(const FittedModel& model, const Series& series) {
  FittedModel start = model;
  start.state = {series.time.front(), series.current.front(), compositionOf(model.fit).restState(),
                 model.state.residual_state};
  std::vector<double> missing;
  for (std::size_t n = 0; n < series.size(); ++n) {
    if (series.time[n] - series.time.front() > kStartSpan) break;
    missing.push_back(missingAt(start, series, n));
  }
  const double middle = quantile(std::move(missing), 0.5);
  const double voltage = series.voltage.front() - missingAt(start, series, 0) + middle;
  setStateFromVoltage(start, series.time.front(), series.current.front(), voltage);
  return start;
}

/// Index of the sample that the model's state belongs to, when the series is the recording it was
/// fitted to.
/// @param like [A], by which the currents may differ.
std::optional<std::size_t> indexOfState(const FittedModel& model, const Series& series,
                                        double like = kUnmovedCurrent) {
  const auto at =
      std::lower_bound(series.time.begin(), series.time.end(), model.state.time - kSameTime);
  if (at == series.time.end() || *at > model.state.time + kSameTime) return std::nullopt;
  const auto index = static_cast<std::size_t>(at - series.time.begin());
  if (std::abs(series.current[index] - model.state.current) > like) return std::nullopt;
  return index;
}

/// As a channel shows it that is `lag` samples behind.
void delay(std::vector<double>& values, std::size_t lag) {
  for (std::size_t n = values.size(); n-- > lag;) values[n] = values[n - lag];
}

/// Where a model begins to run towards a range.
struct Start {
  FittedModel model;
  std::size_t first;  // sample that its state stands at
  bool was_there;     // the state took that sample in
};

Start startFor(const FittedModel& model, const Series& series, IndexRange range) {
  const std::optional<std::size_t> known = indexOfState(model, series);
  if (known && *known <= range.first) return {model, *known, *known < range.first};
  return {modelAtFirstSample(model, series), 0, false};
}

}  // namespace

FittedModel drivenByCurrent(FittedModel model) {
  model.fit.source.reset();
  model.fit.voltage_lag = 0;
  model.fit.residual_regression = {};
  return model;
}

double ModelAge::at(double time) const { return std::max(0.0, time - from); }

ModelAge modelAge(const FittedModel& model, const Series& series) {
  const FitWindow& window = model.fit.window;
  if (window.samples == 0) return {true, HUGE_VAL};
  // A diagnosis fits the current without its sensor's noise: it is near the one that was recorded.
  const double like = kLikeCurrent + kLikeShare * std::abs(model.state.current);
  const bool is_dated = std::min(window.to, series.time.front()) >= kDatedFrom;
  return {is_dated || indexOfState(model, series, like).has_value(), window.to};
}

namespace {

/// [V^2], by which the error of a voltage walked over an age [s].
double walkedBy(const Fit& fit, double age) {
  return fit.noise ? std::pow(fit.noise->walk_std, 2) * age : 0.0;
}

/// Of what a model misses of a current: the variance at an age [s] in units of the window's.
double ageing(const Fit& fit, double age) {
  const double duration = fit.window.to - fit.window.from;
  return duration > 0.0 ? 1.0 + age / duration : 1.0;
}

}  // namespace

FollowedPrediction predictSeries(const FittedModel& model, const Series& series, IndexRange range) {
  if (range.empty()) return {};
  const auto [start, first, was_there] = startFor(model, series, range);
  const InputSequence inputs = inputsOf(start.fit, series, {first, range.last});
  const double own_current = std::pow(start.fit.scores.current_rmse.value_or(0.0), 2);
  const double own_voltage = std::pow(start.fit.scores.rmse, 2);
  const ModelAge age = modelAge(model, series);
  StateEstimator estimator(start);
  FollowedPrediction predicted;
  for (std::size_t n = was_there ? first + 1 : first; n < range.last; ++n) {
    const FollowedSample at = estimator.predict(inputs.samples[n - first]);
    if (n < range.first) continue;
    const bool is_current = at.voltage_controlled;
    const double aged = age.at(estimator.state().time);
    const double own = is_current ? own_current * ageing(start.fit, aged)
                                  : own_voltage + walkedBy(start.fit, aged);
    const double deviation = std::sqrt(at.variance + own);
    const Interval voltage = ninetyPercent(at.voltage, is_current ? 0.0 : deviation),
                   current = ninetyPercent(at.current, is_current ? deviation : 0.0);
    predicted.voltage_controlled.push_back(at.voltage_controlled);
    predicted.voltage.push_back(voltage.value);
    predicted.voltage_lower.push_back(voltage.lower);
    predicted.voltage_upper.push_back(voltage.upper);
    predicted.equations_voltage.push_back(at.voltage -
                                          (is_current ? 0.0 : at.regression_correction));
    predicted.current.push_back(current.value);
    predicted.current_lower.push_back(current.lower);
    predicted.current_upper.push_back(current.upper);
  }
  for (auto* voltage : {&predicted.voltage, &predicted.voltage_lower, &predicted.voltage_upper,
                        &predicted.equations_voltage})
    delay(*voltage, start.fit.voltage_lag);
  return predicted;
}

// ---------------------------------------------------------------------------------------------
// scores

namespace {

double lowest(const std::vector<double>& values, IndexRange range) {
  return *std::min_element(values.begin() + range.first, values.begin() + range.last);
}

EventComparison scoreCrank(const Series& part, const PredictedVoltage& predicted,
                           IndexRange crank) {
  return {measuredCrank(part, crank),
          {lowest(predicted.voltage, crank), lowest(predicted.lower, crank),
           lowest(predicted.upper, crank)}};
}

std::optional<double> meanAbsError(const std::vector<EventComparison>& cranks) {
  if (cranks.empty()) return std::nullopt;
  double sum = 0.0;
  for (const EventComparison& crank : cranks) sum += crank.absError();
  return sum / static_cast<double>(cranks.size());
}

std::optional<double> rmsError(const std::vector<EventComparison>& cranks) {
  if (cranks.empty()) return std::nullopt;
  double squares = 0.0;
  for (const EventComparison& crank : cranks) squares += std::pow(crank.absError(), 2);
  return std::sqrt(squares / static_cast<double>(cranks.size()));
}

}  // namespace

PredictionScores scorePrediction(const Series& series, IndexRange range,
                                 const PredictedVoltage& predicted, const EventLimits& limits) {
  const Series part = slice(series, range);
  if (part.empty() || predicted.voltage.size() != part.size())
    throw std::invalid_argument("scorePrediction: " + std::to_string(predicted.voltage.size()) +
                                " predictions for " + std::to_string(part.size()) + " samples");
  PredictionScores scores;
  scores.window = {part.time.front(), part.time.back(), part.size()};
  scores.q_dyn_percent = qDyn(part.voltage, predicted.voltage);
  scores.rmse = rootMeanSquareError(part.voltage, predicted.voltage);
  std::size_t inside = 0;
  for (std::size_t n = 0; n < part.size(); ++n) {
    const double u = part.voltage[n];
    scores.max_abs = std::max(scores.max_abs, std::abs(u - predicted.voltage[n]));
    if (u >= predicted.lower[n] && u <= predicted.upper[n]) ++inside;
  }
  scores.coverage_90 = static_cast<double>(inside) / static_cast<double>(part.size());
  for (const Event& event : detectEvents(part, limits))
    if (event.kind == EventKind::kCrank)
      scores.cranks.push_back(scoreCrank(part, predicted, event.range));
  scores.crank_mean_abs_error = meanAbsError(scores.cranks);
  scores.crank_equations_rms = rmsError(scores.cranks);
  return scores;
}

namespace {

AnswerErrors errorsOf(const std::vector<double>& measured, const std::vector<double>& predicted,
                      IndexRange range, const std::vector<char>& voltage_controlled,
                      bool of_voltage) {
  AnswerErrors errors(!predicted.empty());
  for (std::size_t k = range.first; k < range.last; ++k)
    if ((voltage_controlled[k] != 0) == of_voltage)
      errors.add(measured[k], predicted.empty() ? 0.0 : measured[k] - predicted[k - range.first]);
  return errors;
}

/// Of a charge's mean current.
Interval expectedOf(const Series& series, IndexRange range, IndexRange samples,
                    const std::vector<char>& voltage_controlled, const MixedPrediction& predicted) {
  // The measured current where the current is controlled.
  const auto mean = [&](const std::vector<double>& given) {
    const std::vector<double>& values = given.empty() ? predicted.current : given;
    double sum = 0.0;
    for (std::size_t k = samples.first; k < samples.last; ++k)
      sum += voltage_controlled[k] ? values[k - range.first] : series.current[k];
    return sum / static_cast<double>(samples.size());
  };
  return {mean(predicted.current), mean(predicted.current_lower), mean(predicted.current_upper)};
}

void requireSizes(const Series& series, IndexRange range,
                  const std::vector<char>& voltage_controlled, const MixedPrediction& predicted) {
  const bool in_series = range.first < range.last && range.last <= series.size();
  bool fits = in_series && voltage_controlled.size() == series.size();
  for (const auto* values :
       {&predicted.current, &predicted.current_lower, &predicted.current_upper, &predicted.voltage,
        &predicted.voltage_lower, &predicted.voltage_upper})
    fits = fits && (values->empty() || values->size() == range.size());
  if (fits) return;
  throw std::invalid_argument("scoreMixed: range " + std::to_string(range.first) + " to " +
                              std::to_string(range.last) + " of " + std::to_string(series.size()) +
                              " samples, a mask of " + std::to_string(voltage_controlled.size()) +
                              ", " + std::to_string(predicted.current.size()) + " currents and " +
                              std::to_string(predicted.voltage.size()) + " voltages");
}

}  // namespace

MixedScores scoreMixed(const Series& series, IndexRange range,
                       const std::vector<char>& voltage_controlled,
                       const MixedPrediction& predicted) {
  requireSizes(series, range, voltage_controlled, predicted);
  const AnswerErrors current =
      errorsOf(series.current, predicted.current, range, voltage_controlled, true);
  const AnswerErrors voltage =
      errorsOf(series.voltage, predicted.voltage, range, voltage_controlled, false);
  MixedScores scores;
  scores.current_share_percent = explainedPercent({current});
  scores.voltage_share_percent = explainedPercent({voltage});
  // A quantity that should be judged and cannot leaves nothing to say of both together.
  const bool is_missing =
      (current.isJudged() && !current.relative()) || (voltage.isJudged() && !voltage.relative());
  if (!is_missing) scores.share_percent = explainedPercent({current, voltage});
  if (predicted.current.empty()) return scores;
  if (current.samples() > 0) scores.current_rmse = current.rms();
  for (const std::size_t first : chargeBeginnings(series, range, voltage_controlled))
    for (const double duration : kComparedSpans) {
      const auto samples = beginningOfCharge(series, range, first, duration, voltage_controlled);
      if (!samples) continue;
      scores.charges.push_back(
          {measuredCharge(series, *samples, duration),
           expectedOf(series, range, *samples, voltage_controlled, predicted)});
    }
  return scores;
}

namespace {

std::vector<char> overSeries(const Series& series, IndexRange range,
                             const std::vector<char>& flags) {
  std::vector<char> mask(series.size(), 0);
  std::copy(flags.begin(), flags.end(), mask.begin() + range.first);
  return mask;
}

/// @param voltage that cranks' lowest voltages are taken from; none where it is empty.
/// @param expect std::optional<Interval>(const EventComparison&): what is expected of a crank or a
/// charge in place of what samples say.
template <typename Expect>
BothWaysScores bothWays(const Series& series, IndexRange range, const std::vector<char>& mask,
                        const MixedPrediction& predicted, const PredictedVoltage& voltage,
                        const EventLimits& limits, Expect&& expect) {
  BothWaysScores scores;
  scores.mixed = scoreMixed(series, range, mask, predicted);
  if (!voltage.voltage.empty())
    static_cast<CrankScores&>(scores) = scorePrediction(series, range, voltage, limits);
  for (auto* events : {&scores.mixed.charges, &scores.cranks})
    for (EventComparison& event : *events) event.expected = expect(event).value_or(event.expected);
  scores.crank_mean_abs_error = meanAbsError(scores.cranks);
  return scores;
}

}  // namespace

namespace {

/// The voltage of the equations alone, in an interval as wide as that of the whole.
PredictedVoltage ofEquations(const FollowedPrediction& predicted) {
  PredictedVoltage voltage{predicted.equations_voltage, predicted.voltage_lower,
                           predicted.voltage_upper};
  for (std::size_t n = 0; n < voltage.voltage.size(); ++n) {
    const double corrected_by = predicted.voltage[n] - voltage.voltage[n];
    voltage.lower[n] -= corrected_by;
    voltage.upper[n] -= corrected_by;
  }
  return voltage;
}

/// A charge's interval that past ones replaced is of their age; one that they left has its own.
Interval agedAsExpected(const Interval& corrected, const Interval& expected, double factor) {
  const double width = corrected.upper - corrected.lower;
  if (std::abs(width - (expected.upper - expected.lower)) <= 1e-9 * width) return corrected;
  return {corrected.value, corrected.value - factor * (corrected.value - corrected.lower),
          corrected.value + factor * (corrected.upper - corrected.value)};
}

}  // namespace

BothWaysScores scoreBothWays(const FittedModel& model, const Series& series, IndexRange range,
                             const FollowedPrediction& predicted) {
  const ModelAge age = modelAge(model, series);
  return bothWays(series, range, overSeries(series, range, predicted.voltage_controlled), predicted,
                  ofEquations(predicted), EventLimits{model.fit.crank_current},
                  [&](const EventComparison& event) -> std::optional<Interval> {
                    if (event.kind == PastEvent::Kind::kCrank)
                      return correctCrankPrediction(model, event.current, event.expected,
                                                    CurrentMeaning::kShown);
                    const Interval corrected = correctChargePrediction(
                        model, {event.voltage, event.first_voltage, event.duration},
                        event.expected);
                    return agedAsExpected(corrected, event.expected,
                                          std::sqrt(ageing(model.fit, age.at(event.time))));
                  });
}

BothWaysScores scoreBaseline(const BaselinePredictor& baseline, const Series& series,
                             IndexRange range, const std::vector<char>& voltage_controlled,
                             const EventLimits& limits) {
  const std::vector<char> mask = overSeries(series, range, voltage_controlled);
  const MixedPrediction line = predictBaseline(baseline, series, range, mask);
  return bothWays(series, range, mask, line, line.voltages(), limits,
                  [&](const EventComparison& event) { return expectedBy(baseline, event); });
}

namespace {

void scale(CrankScores& scores, double series_blocks) {
  for (EventComparison& crank : scores.cranks) crank = ofSeries(crank, series_blocks);
  for (auto* error : {&scores.crank_mean_abs_error, &scores.crank_equations_rms})
    if (*error) **error *= series_blocks;
}

void scale(PredictionScores& scores, double series_blocks) {
  scores.rmse *= series_blocks;
  scores.max_abs *= series_blocks;
  scale(static_cast<CrankScores&>(scores), series_blocks);
}

void scale(BothWaysScores& scores, double series_blocks) {
  for (EventComparison& charge : scores.mixed.charges) charge = ofSeries(charge, series_blocks);
  scale(static_cast<CrankScores&>(scores), series_blocks);
}

/// What was computed of one block with the voltages of a series string of them.
RangePrediction ofSeries(RangePrediction of_one, double series_blocks) {
  FollowedPrediction& course = of_one.course;
  for (std::vector<double>* voltages :
       {&course.voltage, &course.voltage_lower, &course.voltage_upper, &course.equations_voltage})
    for (double& voltage : *voltages) voltage *= series_blocks;
  PredictionReport& report = of_one.report;
  scale(report.from_current, series_blocks);
  scale(report.baseline, series_blocks);
  if (report.both_ways) scale(*report.both_ways, series_blocks);
  if (report.baseline_from_current) scale(*report.baseline_from_current, series_blocks);
  return of_one;
}

/// Whether the voltage is the input where a source controls it; gives the fit a source when it was
/// fitted without.
bool drivesBothWays(Fit& fit, const Series& series, PredictionMode mode) {
  if (mode == PredictionMode::kCurrent) return false;
  if (mode == PredictionMode::kAsFitted || fit.source) return fit.source.has_value();
  const ControlModes source = detectControlMode(series, EventLimits{fit.crank_current});
  if (!source.seen) throw NoSource("no source is seen in the recording: " + source.summary);
  fit.source = source.rule;
  return true;
}

}  // namespace

RangePrediction predictRange(FittedModel model, const Series& series, IndexRange range,
                             PredictionMode mode) {
  if (const double series_blocks = std::exchange(model.fit.series_blocks, 1.0);
      series_blocks != 1.0)
    return ofSeries(predictRange(std::move(model), perBlock(series, series_blocks), range, mode),
                    series_blocks);
  const EventLimits limits{model.fit.crank_current};
  const bool both_ways = drivesBothWays(model.fit, series, mode);
  FollowedPrediction from_current = predictSeries(drivenByCurrent(model), series, range);
  RangePrediction result;
  PredictionReport& report = result.report;
  if (const ModelAge age = modelAge(model, series); age.is_known)
    report.model_age = range.empty() ? 0.0 : age.at(series.time[range.last - 1]);
  report.from_current = scorePrediction(series, range, from_current.voltages(), limits);
  result.course = both_ways ? predictSeries(model, series, range) : std::move(from_current);
  if (both_ways) {
    report.both_ways = scoreBothWays(model, series, range, result.course);
    static_cast<CrankScores&>(report.from_current) = *report.both_ways;
  }
  report.largest_discharge = std::min(model.fit.excited.min_current, 0.0);
  for (const EventComparison& crank : report.from_current.cranks)
    if (crank.current < kCurrentReach * report.largest_discharge) ++report.cranks_beyond_window;
  const BaselinePredictor& baseline = model.fit.baseline;
  report.baseline =
      scoreBaseline(baseline, series, range, result.course.voltage_controlled, limits);
  const PredictedVoltage line =
      predictBaseline(baseline, series, range, std::vector<char>(series.size(), 0)).voltages();
  if (!line.voltage.empty())
    report.baseline_from_current = scorePrediction(series, range, line, limits);
  return result;
}

}  // namespace battery_sof
