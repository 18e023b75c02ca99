#include <algorithm>
#include <utility>

#include "baseline/baseline_predictor.hpp"
#include "baseline/ridge.hpp"
#include "diagnosis/comparison.hpp"
#include "diagnosis/model_selection.hpp"
#include "prediction/scores.hpp"
#include "recording/fit_mask.hpp"

namespace battery_sof {
namespace {

constexpr std::size_t kMinForRidge = 60;  // samples, as ridgeVoltage() requires

/// The whole recording as it is compared with: the training part as it was fitted, then what was
/// held out, its current treated as training taught and not by what its own voltage says. Where the
/// current is cut off it stays so.
struct Opened {
  Series whole;
  std::vector<char> masked;
};

Opened open(const Series& series, const Residuals& residuals, std::vector<std::string>& notes) {
  Opened opened{treatedAsScreened(series, residuals.screened), {}};
  InstrumentLimits limits = instrumentLimits(series);
  maskBehindUnknownCharge(series, limits);
  const std::vector<char>& trained = residuals.screened.limits.masked;
  std::copy(trained.begin(), trained.end(), limits.masked.begin());
  const auto begin =
      limits.masked.begin() + static_cast<std::ptrdiff_t>(residuals.parts.holdout.first);
  if (std::all_of(begin, limits.masked.end(), [](char fault) { return fault != 0; })) {
    std::fill(begin, limits.masked.end(), 0);
    notes.push_back(
        "no sample of the part that was held out is a measurement beyond doubt; it is compared "
        "as "
        "it stands");
  }
  opened.masked = std::move(limits.masked);
  return opened;
}

FitWindow windowOf(const Series& series, IndexRange range) {
  return {series.time[range.first], series.time[range.last - 1], range.size()};
}

ErrorMetrics metricsOf(const Opened& opened, IndexRange range, const std::vector<double>& voltage,
                       const FittedModel& model) {
  ErrorMetrics metrics = errorMetrics(opened.whole, range, voltage, opened.masked);
  metrics.charge_current_error = chargeCurrentError(model, opened.whole, range, opened.masked);
  return metrics;
}

/// The whole recording from the training part's first state on [V].
std::vector<double> voltageOf(const Opened& opened, const BatteryModel& model,
                              const CompositionPoint& point) {
  const Eigen::VectorXd voltage =
      simulatedVoltage(model, point, inputSequence(opened.whole, {0, opened.whole.size()}));
  return {voltage.data(), voltage.data() + voltage.size()};
}
std::vector<double> voltageOf(const Opened& opened, const FittedModel& model) {
  const ModelPoint first = pointOf(atFirstState(model));
  return voltageOf(opened, compositionOf(model.fit), {first.parameters, first.state});
}

/// @param scores MixedScores, or another model's errors.
template <typename Scores>
void takeShares(const Scores& scores, ErrorMetrics& metrics) {
  metrics.share_percent = scores.share_percent;
  metrics.current_share_percent = scores.current_share_percent;
  metrics.voltage_share_percent = scores.voltage_share_percent;
}

/// In the direction that is controlled.
MixedScores sharesOf(FittedModel model, const ChargerControl& driving, const Series& series,
                     IndexRange holdout) {
  model.fit.source = driving.rule;
  model.fit.voltage_lag = driving.repair.lag;
  const FollowedPrediction predicted = predictSeries(model, series, holdout);
  return scoreBothWays(model, series, holdout, predicted).mixed;
}

/// The hold-out by what needs no physics.
void compareBaseline(Comparison& fit, const Series& series, const Residuals& residuals,
                     const Opened& opened, const std::optional<ChargerControl>& driving) {
  const IndexRange train = residuals.parts.train, holdout = residuals.parts.holdout;
  const std::vector<char> controlled =
      driving ? driving->voltage_controlled : std::vector<char>(series.size(), 0);
  const BaselinePredictor baseline = fitBaseline(series, train, controlled);
  if (baseline.voltage_from_current) {
    fit.baseline_line = errorMetrics(
        series, holdout, predictBaseline(baseline, series, {0, series.size()}, controlled).voltage,
        opened.masked);
    if (driving)
      takeShares(scoreBaseline(baseline, series, holdout,
                               {controlled.begin() + static_cast<std::ptrdiff_t>(holdout.first),
                                controlled.end()})
                     .mixed,
                 *fit.baseline_line);
  }
  if (train.size() < kMinForRidge) return;
  std::vector<double> voltage = series.voltage;
  const std::vector<double> ridge = ridgeVoltage(opened.whole, train, holdout);
  std::copy(ridge.begin(), ridge.end(),
            voltage.begin() + static_cast<std::ptrdiff_t>(holdout.first));
  fit.baseline_ridge = errorMetrics(series, holdout, voltage, opened.masked);
}

void takeErrorsOfBase(const ErrorMetrics& base, ErrorMetrics& extended) {
  const ErrorMetrics shares = std::exchange(extended, base);
  takeShares(shares, extended);
}

/// What predicts the hold-out worse than the base model is reported and not given. Where a source
/// controls the voltage, the model that is handed on answers in the other direction and stays.
void withhold(Diagnosis& found, bool is_driven) {
  Comparison& fit = found.fit;
  found.withheld_rmse = fit.extended_holdout.rmse;
  found.extended_voltage = found.base_voltage;
  if (found.discrepancy) found.discrepancy->is_used = false;
  if (is_driven) {
    takeErrorsOfBase(fit.base_train, fit.extended_train);
    takeErrorsOfBase(fit.base_holdout, fit.extended_holdout);
  } else {
    found.extended = found.base;
    fit.extended_train = fit.base_train;
    fit.extended_holdout = fit.base_holdout;
  }
}

/// Where a source controls the voltage, what was estimated of the voltage from the current; the
/// model that is handed on answers in the other direction.
std::vector<double> extendedVoltage(const Opened& opened, const ModelSelection& selected,
                                    const Diagnosis& found) {
  if (!selected.explained.driving) return voltageOf(opened, found.extended);
  const std::optional<WhitenedFit>& fit = selected.with_discrepancy;
  return fit ? voltageOf(opened, fit->model, fit->point) : found.base_voltage;
}

/// Of the error: relative to the spread of current and voltage where a charger controls the voltage.
std::optional<double> gainPercent(const ErrorMetrics& base, const ErrorMetrics& extended) {
  const bool is_driven = base.share_percent && extended.share_percent;
  const double before = is_driven ? 100.0 - *base.share_percent : base.rmse;
  const double after = is_driven ? 100.0 - *extended.share_percent : extended.rmse;
  if (before <= 0.0) return std::nullopt;
  return 100.0 * (1.0 - after / before);
}

void compareErrors(Diagnosis& found, const Parts& parts, const Opened& opened) {
  Comparison& fit = found.fit;
  fit.base_train = metricsOf(opened, parts.train, found.base_voltage, found.base);
  fit.base_holdout = metricsOf(opened, parts.holdout, found.base_voltage, found.base);
  fit.extended_train = metricsOf(opened, parts.train, found.extended_voltage, found.extended);
  fit.extended_holdout = metricsOf(opened, parts.holdout, found.extended_voltage, found.extended);
}

}  // namespace

void validate(const Recording& recording, const Residuals& residuals,
              const ModelSelection& selected, const DiagnoseOptions& options, Diagnosis& found) {
  tell(options, "opening the part that was held out");
  const Series& series = recording.series;
  const Parts& parts = residuals.parts;
  const bool is_driven = selected.explained.driving.has_value();
  Comparison& fit = found.fit;
  const Opened opened = open(series, residuals, found.instrument);
  found.base_voltage = voltageOf(opened, found.base);
  found.extended_voltage = extendedVoltage(opened, selected, found);
  fit.train = windowOf(series, parts.train);
  fit.holdout = windowOf(series, parts.holdout);
  pulse(options);
  compareErrors(found, parts, opened);
  pulse(options);
  found.source = detectControlMode(series);
  const std::optional<ChargerControl> driving = chargerControl(series);
  compareBaseline(fit, series, residuals, opened, driving);
  pulse(options);
  if (driving) {
    takeShares(
        sharesOf(selected.base_both_ways.value_or(found.base), *driving, series, parts.holdout),
        fit.base_holdout);
    takeShares(sharesOf(found.extended, *driving, series, parts.holdout), fit.extended_holdout);
  }
  const std::optional<double> gain_percent = gainPercent(fit.base_holdout, fit.extended_holdout);
  for (Candidate& candidate : found.candidates)
    if (candidate.rejected_because.empty()) candidate.holdout_gain_percent = gain_percent;
  if (is_driven && !selected.with_discrepancy)
    found.instrument.push_back(
        "the extended model answers in current: its voltage rows are the base model's, its gain is "
        "the explained variation");
  if (fit.extended_holdout.rmse > fit.base_holdout.rmse) withhold(found, is_driven);
  fit.regimes = compareRegimes(opened.whole, parts.holdout, found.base_voltage,
                               found.extended_voltage, opened.masked);
}

}  // namespace battery_sof
