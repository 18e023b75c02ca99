#include <algorithm>
#include <utility>

#include "baseline/baseline_predictor.hpp"
#include "baseline/ridge.hpp"
#include "diagnosis/comparison.hpp"
#include "diagnosis/model_selection.hpp"
#include "prediction/scores.hpp"
#include "recording/fit_mask.hpp"
#include "state/state_estimator.hpp"

namespace battery_sof {
namespace {

constexpr std::size_t kMinForRidge = 60;  // samples, as ridgeVoltage() requires

/// The whole recording as it is compared with: the training part as it was fitted, then what was
/// held out, treated as training taught. Nothing is read off its own samples, neither the noise of
/// its current nor which of them are measurements; where it is cut off as training was it stays so.
struct Opened {
  Series whole;
  std::vector<char> masked;
};

Opened open(const Series& series, const Residuals& residuals, std::vector<std::string>& notes) {
  InstrumentLimits limits = residuals.screened.limits;
  extendByKnownLimits(series, limits);
  maskBehindUnknownCharge(series, limits);
  const auto begin =
      limits.masked.begin() + static_cast<std::ptrdiff_t>(residuals.parts.holdout.first);
  if (std::all_of(begin, limits.masked.end(), [](char fault) { return fault != 0; })) {
    std::fill(begin, limits.masked.end(), 0);
    notes.push_back(
        "every sample of the part that was held out is cut off by the instrument; it is compared "
        "as it stands");
  }
  return {treatedAsScreened(series, residuals.screened), std::move(limits.masked)};
}

EventLimits limitsOf(const FittedModel& model) { return EventLimits{model.fit.crank_current}; }

FitWindow windowOf(const Series& series, IndexRange range) {
  return {series.time[range.first], series.time[range.last - 1], range.size()};
}

ErrorMetrics metricsOf(const Opened& opened, IndexRange range, const std::vector<double>& voltage,
                       const FittedModel& model) {
  ErrorMetrics metrics = errorMetrics(opened.whole, range, voltage, opened.masked, limitsOf(model));
  metrics.charge_current_error = chargeCurrentError(model, opened.whole, range, opened.masked);
  return metrics;
}

/// A whole recording from the training part's first state on [V].
std::vector<double> voltageOf(const Series& series, const BatteryModel& model,
                              const CompositionPoint& point) {
  const Eigen::VectorXd voltage =
      simulatedVoltage(model, point, inputSequence(series, {0, series.size()}));
  return {voltage.data(), voltage.data() + voltage.size()};
}
std::vector<double> voltageOf(const Series& series, const FittedModel& model) {
  const ModelPoint first = pointOf(atFirstState(model));
  return voltageOf(series, compositionOf(model.fit), {first.parameters, first.state});
}

/// @param scores MixedScores, or another model's errors.
template <typename Scores>
void takeShares(const Scores& scores, ErrorMetrics& metrics) {
  metrics.share_percent = scores.share_percent;
  metrics.current_share_percent = scores.current_share_percent;
  metrics.voltage_share_percent = scores.voltage_share_percent;
}

/// A model's errors in the direction that is controlled: the voltage's where the current is the
/// input, and the explained variation of both quantities.
struct ControlledErrors {
  ErrorMetrics metrics;
  std::vector<double> voltage;           // [V], one a sample of the series
  std::vector<char> voltage_controlled;  // likewise
};

/// The explained variation without what the residual regression adds [%].
std::optional<double> equationsShare(FittedModel model, const Series& series, IndexRange range) {
  model.fit.residual_regression = {};
  return scoreBothWays(model, series, range, predictSeries(model, series, range))
      .mixed.share_percent;
}

/// @param model its state at the last sample before the range, or at its first.
ControlledErrors controlledErrors(const FittedModel& model, const Series& series,
                                  const Opened& opened, IndexRange range) {
  const FollowedPrediction predicted = predictSeries(model, series, range);
  ControlledErrors errors{{}, series.voltage, std::vector<char>(series.size(), 0)};
  const auto at = static_cast<std::ptrdiff_t>(range.first);
  std::copy(predicted.voltage.begin(), predicted.voltage.end(), errors.voltage.begin() + at);
  std::copy(predicted.voltage_controlled.begin(), predicted.voltage_controlled.end(),
            errors.voltage_controlled.begin() + at);
  std::vector<char> masked = opened.masked;
  for (std::size_t n = 0; n < masked.size(); ++n)
    masked[n] = masked[n] || errors.voltage_controlled[n];
  const auto first = masked.begin() + at;
  if (!std::all_of(first, first + static_cast<std::ptrdiff_t>(range.size()),
                   [](char out) { return out != 0; }))
    errors.metrics = errorMetrics(series, range, errors.voltage, masked, limitsOf(model));
  takeShares(scoreBothWays(model, series, range, predicted).mixed, errors.metrics);
  errors.metrics.equations_share_percent = equationsShare(model, series, range);
  errors.metrics.charge_current_error =
      chargeCurrentError(model, opened.whole, range, opened.masked);
  return errors;
}

/// Which samples' voltage is controlled, as the base model's rule says live.
std::vector<char> controlledBy(const FittedModel& model, const Series& series) {
  std::vector<char> controlled(series.size(), 0);
  if (!model.fit.source) return controlled;
  const InputSequence inputs = inputsOf(model.fit, series, {0, series.size()});
  for (std::size_t n = 0; n < controlled.size(); ++n)
    controlled[n] = inputs.samples[n].voltage_controlled;
  return controlled;
}

/// The hold-out by what needs no physics.
void compareBaseline(Comparison& fit, const Series& series, const Residuals& residuals,
                     const Opened& opened, const Diagnosis& found) {
  const IndexRange train = residuals.parts.train, holdout = residuals.parts.holdout;
  const std::vector<char> controlled = controlledBy(found.base, series);
  const EventLimits limits = limitsOf(found.base);
  const BaselinePredictor baseline = fitBaseline(series, train, controlled, limits);
  std::vector<char> masked = opened.masked;
  for (std::size_t n = 0; n < masked.size(); ++n) masked[n] = masked[n] || controlled[n];
  const bool is_compared = !std::all_of(masked.begin() + static_cast<std::ptrdiff_t>(holdout.first),
                                        masked.end(), [](char out) { return out != 0; });
  if (baseline.voltage_from_current) {
    fit.baseline_line.emplace();
    if (is_compared)
      fit.baseline_line =
          errorMetrics(series, holdout,
                       predictBaseline(baseline, series, {0, series.size()}, controlled).voltage,
                       masked, limits);
    if (found.base.fit.source)
      takeShares(scoreBaseline(baseline, series, holdout,
                               {controlled.begin() + static_cast<std::ptrdiff_t>(holdout.first),
                                controlled.end()},
                               limits)
                     .mixed,
                 *fit.baseline_line);
  }
  if (train.size() < kMinForRidge || !is_compared) return;
  std::vector<double> voltage = series.voltage;
  const std::vector<double> ridge = ridgeVoltage(opened.whole, train, holdout);
  std::copy(ridge.begin(), ridge.end(),
            voltage.begin() + static_cast<std::ptrdiff_t>(holdout.first));
  fit.baseline_ridge = errorMetrics(series, holdout, voltage, masked, limits);
}

/// Whether the hold-out is predicted worse than by the circuit, or worse than by its mean.
bool isNoImprovement(const Comparison& fit) {
  const ErrorMetrics &base = fit.base_holdout, &extended = fit.extended_holdout;
  if (!base.share_percent || !extended.share_percent) return extended.rmse > base.rmse;
  return *extended.share_percent < std::max(0.0, *base.share_percent);
}

constexpr double kAgrees = 50.0;  // [%], of the variation: the error is half of it

/// Whether a model and the hold-out are further apart than what agrees, beyond any noise.
bool isMissed(const ErrorMetrics& holdout) {
  return holdout.rmse > kPlausible &&
         holdout.share_percent.value_or(holdout.q_dyn_percent) < kAgrees;
}

/// What is no improvement on the hold-out is reported with its own errors, and the base model is
/// handed on in its place.
void withhold(Diagnosis& found) {
  found.withheld_rmse = found.fit.extended_holdout.rmse;
  found.extended_voltage = found.base_voltage;
  if (found.discrepancy) found.discrepancy->is_used = false;
  found.extended = found.base;
}

/// Of the error: relative to the spread of current and voltage where a charger controls the voltage.
std::optional<double> gainPercent(const ErrorMetrics& base, const ErrorMetrics& extended) {
  const bool is_driven = base.share_percent && extended.share_percent;
  const double before = is_driven ? 100.0 - *base.share_percent : base.rmse;
  const double after = is_driven ? 100.0 - *extended.share_percent : extended.rmse;
  if (before <= 0.0) return std::nullopt;
  return 100.0 * (1.0 - after / before);
}

/// Where the current is the input throughout.
void compareErrors(Diagnosis& found, const Parts& parts, const Opened& opened) {
  Comparison& fit = found.fit;
  fit.base_train = metricsOf(opened, parts.train, found.base_voltage, found.base);
  fit.base_holdout = metricsOf(opened, parts.holdout, found.base_voltage, found.base);
  fit.extended_train = metricsOf(opened, parts.train, found.extended_voltage, found.extended);
  fit.extended_holdout = metricsOf(opened, parts.holdout, found.extended_voltage, found.extended);
  fit.regimes = compareRegimes(opened.whole, parts.holdout, found.base_voltage,
                               found.extended_voltage, opened.masked, limitsOf(found.base));
}

/// Where a charger controls the voltage: both models as `sof predict --mode mixed` runs them.
void compareControlled(Diagnosis& found, const Series& series, const Parts& parts,
                       const Opened& opened) {
  Comparison& fit = found.fit;
  const auto inTraining = [&](const FittedModel& model) {
    return controlledErrors(atFirstState(model, series.current[parts.train.first]), series, opened,
                            parts.train)
        .metrics;
  };
  fit.base_train = inTraining(found.base);
  fit.extended_train = inTraining(found.extended);
  const ControlledErrors base = controlledErrors(found.base, series, opened, parts.holdout),
                         extended = controlledErrors(found.extended, series, opened, parts.holdout);
  fit.base_holdout = base.metrics;
  fit.extended_holdout = extended.metrics;
  std::vector<char> masked = opened.masked;
  for (std::size_t n = 0; n < masked.size(); ++n)
    masked[n] = masked[n] || base.voltage_controlled[n];
  fit.regimes = compareRegimes(series, parts.holdout, base.voltage, extended.voltage, masked,
                               limitsOf(found.base));
}

}  // namespace

void validate(const Recording& recording, const Residuals& residuals,
              const ModelSelection& selected, const DiagnoseOptions& options, Diagnosis& found) {
  tell(options, "opening the part that was held out");
  const Series& series = recording.series;
  const Parts& parts = residuals.parts;
  const std::optional<ChargerControl>& driving = selected.explained.driving;
  Comparison& fit = found.fit;
  const Opened opened = open(series, residuals, found.instrument);
  // The circuit is fitted to the rows as they were recorded.
  found.base_voltage =
      driving ? voltageOf(opened.whole, residuals.base.model, residuals.base.point)
              : voltageOf(selected.explained.circuit ? series : opened.whole, found.base);
  const bool as_recorded = selected.explained.by_blocks && !selected.with_discrepancy;
  found.extended_voltage =
      driving ? found.base_voltage : voltageOf(as_recorded ? series : opened.whole, found.extended);
  fit.train = windowOf(series, parts.train);
  fit.holdout = windowOf(series, parts.holdout);
  pulse(options);
  if (driving)
    compareControlled(found, series, parts, opened);
  else
    compareErrors(found, parts, opened);
  pulse(options);
  found.source = detectControlMode(series, limitsOf(found.base));
  compareBaseline(fit, series, residuals, opened, found);
  const std::optional<double> gain_percent = gainPercent(fit.base_holdout, fit.extended_holdout);
  for (Candidate& candidate : found.candidates)
    if (candidate.rejected_because.empty()) candidate.holdout_gain_percent = gain_percent;
  if (isNoImprovement(fit)) withhold(found);
  if (found.verdict == Verdict::kNoMismatch && isMissed(fit.base_holdout))
    found.verdict = Verdict::kUnexplained;
}

}  // namespace battery_sof
