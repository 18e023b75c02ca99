#include "state/window_history.hpp"

#include <algorithm>
#include <cmath>

#include "baseline/charge_phases.hpp"
#include "recording/events.hpp"
#include "state/state_estimator.hpp"

namespace battery_sof {
namespace {

constexpr double kMinForShare = 5.0;  // samples of a quantity, as scoreMixed()

/// The window as the equations alone follow it.
struct Followed {
  ResidualSamples samples;
  std::vector<double> voltage, current;  // modelled [V], [A]
  InputMemory memory;                    // at the end
};

Followed followWindow(const FittedModel& model, const InputSequence& inputs) {
  StateEstimator estimator(atFirstState(model, inputs.samples.front().step.current), false);
  Followed out;
  for (const InputSample& sample : inputs.samples) {
    const FollowedSample at = estimator.predict(sample);
    out.samples.columns.push_back(at.columns);
    out.samples.error.push_back(at.physics_error);
    out.samples.voltage_controlled.push_back(at.voltage_controlled);
    out.voltage.push_back(at.voltage);
    out.current.push_back(at.current);
  }
  out.memory = estimator.state().memory;
  return out;
}

void addCranks(EventHistory& event_history, const Series& series, IndexRange range,
               const std::vector<double>& modelled) {
  const Series part = slice(series, range);
  for (const Event& event : detectCranks(part, {0, part.size()}, {}, gapThreshold(part))) {
    const auto first = static_cast<std::ptrdiff_t>(event.range.first),
               last = static_cast<std::ptrdiff_t>(event.range.last);
    const auto lowest = std::min_element(part.voltage.begin() + first, part.voltage.begin() + last);
    PastEvent crank;
    crank.time = part.time[static_cast<std::size_t>(lowest - part.voltage.begin())];
    crank.current = event.peak_current;
    crank.measured = *lowest;
    crank.modelled = *std::min_element(modelled.begin() + first, modelled.begin() + last);
    event_history.add(crank);
  }
}

void addCharges(EventHistory& event_history, const Series& series, IndexRange range,
                const ControlModes& source, const std::vector<double>& modelled) {
  for (const std::size_t first : chargeBeginnings(series, range, source.voltage_controlled))
    for (const double duration : {10.0, 60.0}) {
      const auto charge =
          beginningOfCharge(series, range, first, duration, source.voltage_controlled);
      if (!charge) continue;
      PastEvent past{PastEvent::Kind::kCharge, series.time[first], duration};
      past.first_voltage = series.voltage[first];
      const double count = static_cast<double>(charge->size());
      for (std::size_t n = charge->first; n < charge->last; ++n) {
        past.voltage += series.voltage[n] / count;
        past.measured += series.current[n] / count;
        past.modelled += modelled[n - range.first] / count;
      }
      event_history.add(past);
    }
}

/// @param modelled [V], by the equations and what was estimated from the window's other blocks.
void addStops(EventHistory& event_history, const InputSequence& inputs,
              const std::vector<char>& voltage_controlled, const std::vector<double>& modelled,
              double min_current) {
  EventDetector detector;
  std::optional<double> began;
  double before = inputs.first_time;
  for (std::size_t n = 0; n < inputs.samples.size(); ++n) {
    const InputSample& sample = inputs.samples[n];
    detector.add(sample.step.time, sample.step.current, false,
                 voltage_controlled[n] ? -HUGE_VAL : min_current);
    if (detector.stopBegins()) began = before;
    if (!detector.isInStop()) began.reset();
    before = sample.step.time;
    if (!began || before - *began < PastEvent::kStopAge) continue;
    PastEvent stop{PastEvent::Kind::kStop, *began, PastEvent::kStopAge, sample.step.current};
    stop.measured = sample.voltage;
    stop.modelled = modelled[n];
    event_history.add(stop);
    began.reset();
  }
}

/// 1 - the RMS of the errors, those of each quantity in units of its spread.
std::optional<double> leftOutShare(const ResidualSamples& samples,
                                   const std::vector<double>& left_out, const Series& series,
                                   IndexRange range) {
  double relative = 0.0, counted = 0.0;
  for (const bool of_current : {true, false}) {
    double n = 0.0, sum = 0.0, squares = 0.0, errors = 0.0;
    for (std::size_t k = 0; k < samples.error.size(); ++k) {
      if (static_cast<bool>(samples.voltage_controlled[k]) != of_current) continue;
      const double x =
          of_current ? series.current[range.first + k] : series.voltage[range.first + k];
      n += 1.0;
      sum += x;
      squares += x * x;
      errors += std::pow(samples.error[k] - left_out[k], 2);
    }
    const double variance = n > 0.0 ? squares / n - std::pow(sum / n, 2) : 0.0;
    if (n <= kMinForShare || variance <= 0.0) continue;
    relative += errors / variance;
    counted += n;
  }
  if (counted == 0.0) return std::nullopt;
  return 100.0 * (1.0 - std::sqrt(relative / counted));
}

/// What is estimated takes no current further than the window's own.
void holdInside(ResidualRegression& residual_regression, const Series& series, IndexRange range,
                const ControlModes& source) {
  if (residual_regression.current.empty()) return;
  residual_regression.min_current = HUGE_VAL;
  residual_regression.max_current = -HUGE_VAL;
  for (std::size_t n = range.first; n < range.last; ++n) {
    if (!source.voltage_controlled[n]) continue;
    residual_regression.min_current = std::min(residual_regression.min_current, series.current[n]);
    residual_regression.max_current = std::max(residual_regression.max_current, series.current[n]);
  }
}

}  // namespace

void followWindow(FittedModel& model, const Series& series, IndexRange range,
                  const InputSequence& inputs, const ControlModes& source) {
  model.fit.source = source.rule;
  model.fit.baseline = fitBaseline(series, range, source.voltage_controlled);
  const Followed followed = followWindow(model, inputs);
  std::vector<double> left_out;
  model.fit.residual_regression = fitResidualRegression(followed.samples, &left_out);
  model.state.memory = followed.memory;
  holdInside(model.fit.residual_regression, series, range, source);
  model.fit.scores.left_out_share_percent = leftOutShare(followed.samples, left_out, series, range);
  std::vector<double> current = followed.current, voltage = followed.voltage;
  for (std::size_t n = 0; n < current.size(); ++n)
    (followed.samples.voltage_controlled[n] ? current : voltage)[n] += left_out[n];
  addCranks(model.intervals.event_history, series, range, followed.voltage);
  addCharges(model.intervals.event_history, series, range, source, current);
  addStops(model.intervals.event_history, inputs, followed.samples.voltage_controlled, voltage,
           source.rule.min_current);
}

}  // namespace battery_sof
