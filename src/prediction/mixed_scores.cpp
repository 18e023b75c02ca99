#include "prediction/mixed_scores.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

#include "baseline/charge_phases.hpp"

namespace battery_sof {
namespace {

constexpr std::size_t kFewestSamples = 6;
constexpr double kDurations[] = {10.0, 60.0};  // [s]

/// Squared errors of one quantity over the samples in which it is the battery's answer.
struct Errors {
  std::size_t samples = 0;
  double squares = 0.0;   // of the errors
  double variance = 0.0;  // of what was measured
  bool judged() const { return samples >= kFewestSamples; }
};

Errors errorsOf(const std::vector<double>& measured, const std::vector<double>& predicted,
                IndexRange range, const std::vector<char>& voltage_controlled, bool of_voltage) {
  Errors errors;
  double sum = 0.0;
  const auto each = [&](auto visit) {
    for (std::size_t k = range.first; k < range.last; ++k)
      if ((voltage_controlled[k] != 0) == of_voltage) visit(k);
  };
  each([&](std::size_t k) {
    ++errors.samples;
    sum += measured[k];
    if (predicted.empty()) return;
    const double error = measured[k] - predicted[k - range.first];
    errors.squares += error * error;
  });
  if (errors.samples == 0) return errors;
  const double mean = sum / static_cast<double>(errors.samples);
  each([&](std::size_t k) { errors.variance += (measured[k] - mean) * (measured[k] - mean); });
  errors.variance /= static_cast<double>(errors.samples);
  return errors;
}

/// 100 (1 - sqrt(mean of squared errors in units of the variance)).
double percent(double relative_squares, std::size_t samples) {
  return 100.0 * (1.0 - std::sqrt(relative_squares / static_cast<double>(samples)));
}

std::optional<double> shareOf(const Errors& errors, bool is_predicted) {
  if (!is_predicted || !errors.judged() || !(errors.variance > 0.0)) return std::nullopt;
  return percent(errors.squares / errors.variance, errors.samples);
}

std::optional<double> combined(const Errors& current, std::optional<double> current_share,
                               const Errors& voltage, std::optional<double> voltage_share) {
  const bool missing = (current.judged() && !current_share) || (voltage.judged() && !voltage_share);
  if (missing || (!current_share && !voltage_share)) return std::nullopt;
  double relative = 0.0;
  if (current_share) relative += current.squares / current.variance;
  if (voltage_share) relative += voltage.squares / voltage.variance;
  return percent(relative, current.samples + voltage.samples);
}

/// Mean over samples; the measured current where the current is controlled.
double meanCurrent(const Series& series, IndexRange range, IndexRange samples,
                   const std::vector<char>& voltage_controlled,
                   const std::vector<double>& predicted) {
  double sum = 0.0;
  for (std::size_t k = samples.first; k < samples.last; ++k)
    sum += voltage_controlled[k] ? predicted[k - range.first] : series.current[k];
  return sum / static_cast<double>(samples.size());
}

ChargeScore scoreCharge(const Series& series, IndexRange range, IndexRange samples,
                        const std::vector<char>& voltage_controlled,
                        const MixedPrediction& predicted) {
  const auto mean = [&](const std::vector<double>& values) {
    return meanCurrent(series, range, samples, voltage_controlled,
                       values.empty() ? predicted.current : values);
  };
  ChargeScore score;
  score.time = series.time[samples.first];
  for (std::size_t k = samples.first; k < samples.last; ++k) {
    score.measured += series.current[k];
    score.mean_voltage += series.voltage[k] / static_cast<double>(samples.size());
  }
  score.first_voltage = series.voltage[samples.first];
  score.measured /= static_cast<double>(samples.size());
  score.predicted = {mean(predicted.current), mean(predicted.current_lower),
                     mean(predicted.current_upper)};
  return score;
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
  const bool has_current = !predicted.current.empty(), has_voltage = !predicted.voltage.empty();
  const Errors current =
      errorsOf(series.current, predicted.current, range, voltage_controlled, true);
  const Errors voltage =
      errorsOf(series.voltage, predicted.voltage, range, voltage_controlled, false);
  MixedScores scores;
  scores.current_share_percent = shareOf(current, has_current);
  scores.voltage_share_percent = shareOf(voltage, has_voltage);
  scores.share_percent =
      combined(current, scores.current_share_percent, voltage, scores.voltage_share_percent);
  if (!has_current) return scores;
  if (current.samples > 0)
    scores.current_rmse = std::sqrt(current.squares / static_cast<double>(current.samples));
  for (const std::size_t first : chargeBeginnings(series, range, voltage_controlled))
    for (const double duration : kDurations) {
      const auto samples = beginningOfCharge(series, range, first, duration, voltage_controlled);
      if (!samples) continue;
      scores.charges.push_back(scoreCharge(series, range, *samples, voltage_controlled, predicted));
      scores.charges.back().duration = duration;
    }
  return scores;
}

}  // namespace battery_sof
