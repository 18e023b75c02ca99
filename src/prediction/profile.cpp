#include "prediction/profile.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "battery_sof/intake.hpp"
#include "model/input_sequence.hpp"
#include "state/state_tracker.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr double kSameTime = 1e-6;     // [s]
constexpr double kSameCurrent = 1e-6;  // [A]
// [s], samples that the first state is taken from
constexpr double kStartSpan = 1.0;

void append(PredictedVoltage& predicted, const Interval& u) {
  predicted.voltage.push_back(u.value);
  predicted.lower.push_back(u.lower);
  predicted.upper.push_back(u.upper);
}

std::string extrapolation(const Fit& fit, const std::vector<double>& current) {
  const auto [low, high] = std::minmax_element(current.begin(), current.end());
  if (*low >= kCurrentReach * std::min(fit.excited.min_current, 0.0) &&
      *high <= kCurrentReach * std::max(fit.excited.max_current, 0.0))
    return "";
  return format("the profile spans %.1f to %.1f A but the window only %.1f to %.1f A", *low, *high,
                fit.excited.min_current, fit.excited.max_current);
}

/// Of the first sample whose interval says nothing.
std::string emptiness(const Fit& fit, const PredictedVoltage& predicted) {
  for (std::size_t n = 0; n < predicted.voltage.size(); ++n) {
    const std::string reason =
        voltageSaysNothing(fit, {predicted.voltage[n], predicted.lower[n], predicted.upper[n]});
    if (!reason.empty()) return format("sample %zu: ", n) + reason;
  }
  return "";
}

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
  const Eigen::VectorXd rest = compositionOf(model.fit).restState();
  start.state = {series.time.front(),
                 0.0,
                 series.current.front(),
                 std::vector<double>(rest.data() + 1, rest.data() + rest.size()),
                 std::nullopt,
                 {},
                 {},
                 model.state.residual_state};
  std::vector<double> missing;
  for (std::size_t n = 0; n < series.size(); ++n) {
    if (series.time[n] - series.time.front() > kStartSpan) break;
    missing.push_back(missingAt(start, series, n));
  }
  const auto middle = missing.begin() + static_cast<std::ptrdiff_t>(missing.size() / 2);
  std::nth_element(missing.begin(), middle, missing.end());
  const double voltage = series.voltage.front() - missingAt(start, series, 0) + *middle;
  setStateFromVoltage(start, series.time.front(), series.current.front(), voltage);
  return start;
}

/// Index of the sample that the model's state belongs to, when the series is the recording it was
/// fitted to.
std::optional<std::size_t> indexOfState(const FittedModel& model, const Series& series) {
  const auto at =
      std::lower_bound(series.time.begin(), series.time.end(), model.state.time - kSameTime);
  if (at == series.time.end() || *at > model.state.time + kSameTime) return std::nullopt;
  const auto index = static_cast<std::size_t>(at - series.time.begin());
  if (std::abs(series.current[index] - model.state.current) > kSameCurrent) return std::nullopt;
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
  if (known && *known < range.first) return {model, *known, true};
  return {modelAtFirstSample(model, series), 0, false};
}

ProfileAnswer brokenOff(std::size_t done, std::size_t samples, const std::string& why) {
  ProfileAnswer none;
  none.code = AnswerCode::kInvalidQuery;
  none.message = format("%zu of %zu samples were done when ", done, samples) + why;
  return none;
}

}  // namespace

ProfileAnswer simulateProfile(const FittedModel& model, const std::vector<double>& time,
                              const std::vector<double>& current, const WorkWatch& watch) {
  ProfileAnswer answer;
  const std::string fault = time.empty() && current.empty()
                                ? "the profile is empty, expected at least one sample"
                                : faultOf(time, current, "profile", kMaxProfileSamples);
  if (isRefused(answer, model.fit, fault)) return answer;
  Simulation simulation = uncertainSimulationOf(model);
  const ResidualFilter errors(model);
  const double own = model.fit.noise ? model.fit.noise->white_std : model.fit.scores.rmse;
  double time_before = 0.0;
  double current_before = model.state.current;
  for (std::size_t n = 0; n < time.size(); ++n) {
    const std::string why_end =
        watch ? watch(static_cast<double>(n) / static_cast<double>(time.size())) : "";
    if (!why_end.empty()) return brokenOff(n, time.size(), why_end);
    InputStep step = inputStep(time_before, current_before, time[n], current[n],
                               std::numeric_limits<double>::infinity());
    step.time += model.state.time;
    simulation.advance(step);
    const Interval u = voltageAnswer(simulation, errors.forecast(time[n]), own, {});
    if (!areNumbers(u)) return withoutNumbers<ProfileAnswer>();
    append(answer.predicted, ofSeries(u, model.fit.series_blocks));
    time_before = time[n];
    current_before = current[n];
  }
  std::string reasons = extrapolation(model.fit, current);
  const std::string empty = emptiness(model.fit, answer.predicted);
  if (!empty.empty()) reasons += (reasons.empty() ? "" : "; ") + empty;
  answer.message = format("%zu voltages", time.size());
  judge(answer, reasons);
  return answer;
}

FittedModel drivenByCurrent(FittedModel model) {
  model.fit.source.reset();
  model.fit.voltage_lag = 0;
  model.fit.residual_regression = {};
  return model;
}

FollowedPrediction predictSeries(const FittedModel& model, const Series& series, IndexRange range) {
  if (range.empty()) return {};
  const auto [start, first, was_there] = startFor(model, series, range);
  const InputSequence inputs = inputsOf(start.fit, series, {first, range.last});
  const double own_current = std::pow(start.fit.scores.current_rmse.value_or(0.0), 2);
  const double own_voltage = std::pow(start.fit.scores.rmse, 2);
  StateEstimator estimator(start);
  FollowedPrediction predicted;
  for (std::size_t n = was_there ? first + 1 : first; n < range.last; ++n) {
    const FollowedSample at = estimator.predict(inputs.samples[n - first]);
    if (n < range.first) continue;
    const double half =
        kNinetyPercent *
        std::sqrt(at.variance + (at.voltage_controlled ? own_current : own_voltage));
    const double half_a = at.voltage_controlled ? half : 0.0,
                 half_v = at.voltage_controlled ? 0.0 : half;
    predicted.voltage_controlled.push_back(at.voltage_controlled);
    predicted.voltage.push_back(at.voltage);
    predicted.voltage_lower.push_back(at.voltage - half_v);
    predicted.voltage_upper.push_back(at.voltage + half_v);
    predicted.equations_voltage.push_back(at.voltage -
                                          (at.voltage_controlled ? 0.0 : at.regression_correction));
    predicted.current.push_back(at.current);
    predicted.current_lower.push_back(at.current - half_a);
    predicted.current_upper.push_back(at.current + half_a);
  }
  for (auto* voltage : {&predicted.voltage, &predicted.voltage_lower, &predicted.voltage_upper,
                        &predicted.equations_voltage})
    delay(*voltage, start.fit.voltage_lag);
  return predicted;
}

}  // namespace battery_sof
