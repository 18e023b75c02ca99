#include <algorithm>
#include <cmath>

#include "battery_sof/intake.hpp"
#include "prediction/questions.hpp"
#include "state/state_estimator.hpp"
#include "util/constants.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr double kLongest = 3600.0;  // [s]
constexpr double kFirstStep = 0.02;  // [s]
constexpr double kGrowth = 1.15;
constexpr double kSteps = 100.0;  // longest step is t_sof2 / kSteps, at least kFirstStep

/// A voltage held for a while.
struct VoltageStep {
  double duration;  // [s]
  double voltage;   // [V]
};

struct MeanCurrent {
  double value = 0.0;              // [A]
  double highest = 0.0;            // [A]
  double beyond_identified = 0.0;  // [V], Simulation::beyondIdentified() at its most
  Eigen::VectorXd derivatives;     // to the tangents
};

/// @param shift [V], added to the voltages, as a function of the time since the start.
template <typename Shift>
MeanCurrent meanCurrent(Simulation simulation, const std::vector<VoltageStep>& steps,
                        double i_limit, Shift&& shift) {
  MeanCurrent mean;
  mean.derivatives = Eigen::VectorXd::Zero(simulation.tangents());
  double since = 0.0;
  for (const VoltageStep& step : steps) {
    since += step.duration;
    const double i =
        simulation.advanceAtVoltage(step.voltage + shift(since), step.duration, i_limit);
    mean.value += i * step.duration;
    mean.highest = std::max(mean.highest, i);
    mean.beyond_identified = std::max(mean.beyond_identified, simulation.beyondIdentified());
    // At the limit the current does not depend on the battery.
    if (simulation.tangents() > 0 && i < i_limit)
      mean.derivatives += simulation.currentDerivatives() * step.duration;
  }
  mean.value = std::min(mean.value / since, i_limit);  // the sum is rounded
  mean.derivatives /= since;
  return mean;
}

/// @param u_boost [V], of one block.
std::vector<VoltageStep> stepsOf(const ChargeAcceptanceQuery& query, double u_boost) {
  std::vector<VoltageStep> steps;
  double step = std::min(kFirstStep, query.t_sof2);
  for (double since = 0.0; since < query.t_sof2 * (1.0 - 1e-9);) {
    steps.push_back({std::min(step, query.t_sof2 - since), u_boost});
    since += steps.back().duration;
    step = std::min(step * kGrowth, std::max(kFirstStep, query.t_sof2 / kSteps));
  }
  return steps;
}

struct ExpectedCurrent {
  Interval current;
  double highest, beyond_identified;
};

/// Mean current with its interval: the tangents' share, and what a standard deviation of the
/// voltage's error moves it by.
ExpectedCurrent expectedCurrent(const FittedModel& model, const std::vector<VoltageStep>& steps,
                                double i_limit) {
  const ResidualFilter errors(model);
  const auto expected = [&](double since) { return -errors.forecast(since).mean; };
  const MeanCurrent mean = meanCurrent(uncertainSimulationOf(model), steps, i_limit, expected);
  double duration = 0.0;
  for (const VoltageStep& step : steps) duration += step.duration;
  const double own = model.fit.noise ? model.fit.noise->white_std : model.fit.scores.rmse;
  const double error = std::sqrt(errors.forecast(0.5 * duration).variance + own * own +
                                 std::pow(mean.beyond_identified, 2));
  const MeanCurrent moved = meanCurrent(simulationOf(model), steps, i_limit,
                                        [&](double since) { return expected(since) - error; });
  const double variance = mean.derivatives.squaredNorm() + std::pow(mean.value - moved.value, 2);
  Interval current =
      ninetyPercent(mean.value, std::sqrt(variance), model.intervals.calibrations.charges.factor);
  current.upper = std::min(current.upper, i_limit);
  return {current, mean.highest, mean.beyond_identified};
}

/// @param answered of the answer: it says nothing where it is as wide as the largest charge of the
/// window (1.25 times), of past charges like it and of the source.
/// @param u_boost [V], of one block.
QueryRange rangeOf(const FittedModel& model, const ChargeAcceptanceQuery& query, double u_boost,
                   const ExpectedCurrent& mean, const Interval& answered) {
  QueryRange range;
  range.charges = true;
  range.max_current = mean.highest;
  range.beyond_identified = mean.beyond_identified;
  range.max_voltage = u_boost;
  range.charge_duration = query.t_sof2;
  range.charge_moved = std::abs(mean.current.value) * query.t_sof2 / kSecondsPerHour;
  range.temperature = query.temperature;
  range.evidence = chargeEvidence(model.intervals.event_history, u_boost, query.t_sof2);
  range.answered_current = answered;
  const double seen = std::max(kCurrentReach * std::max(model.fit.excited.max_current, 0.0),
                               range.evidence.typical);
  range.says_nothing =
      widthSaysNothing(ReasonKind::kWideCurrent, answered, std::min(seen, query.i_limit),
                       "the largest charge of window and source");
  return range;
}

/// Mean of what a model with a source expects to flow, sample by sample.
Interval followedCurrent(const FittedModel& model, const Series& series,
                         const std::vector<double>& driving) {
  StateEstimator estimator(model);
  const double max_gap = gapThreshold(series);
  double sum = 0.0, spread = 0.0;
  for (std::size_t n = 0; n < series.size(); ++n) {
    InputSample sample;
    sample.step = estimator.stepTo(series.time[n], series.current[n], max_gap);
    sample.voltage = driving[n];
    sample.voltage_controlled = true;
    const FollowedSample at = estimator.predict(sample);
    sum += at.current * sample.step.duration;
    spread += std::sqrt(at.variance) * sample.step.duration;
  }
  const double duration = estimator.state().time - model.state.time;
  const double own = model.fit.scores.current_rmse.value_or(0.0);
  return ninetyPercent(sum / duration, std::hypot(spread / duration, own),
                       model.intervals.calibrations.charges.factor);
}

}  // namespace

ChargeAcceptanceQuery asked(ChargeAcceptanceQuery request) {
  request.t_sof2 = askedFor(request.t_sof2).value_or(ChargeAcceptanceQuery().t_sof2);
  request.i_limit = askedFor(request.i_limit).value_or(ChargeAcceptanceQuery().i_limit);
  return request;
}

Faults faultsOf(const ChargeAcceptanceQuery& q) {
  Faults faults;
  requireOf(faults, q.u_boost > 0.0 && q.u_boost <= 100.0, "u_boost [V]", q.u_boost,
            "above 0, up to 100");
  requireOf(faults, q.t_sof2 > 0.0 && q.t_sof2 <= kLongest, "t_sof2 [s]", q.t_sof2,
            "above 0, up to 3600");
  requireOf(faults, q.i_limit > 0.0 && q.i_limit <= kMaxCurrent, "i_limit [A]", q.i_limit,
            "above 0, up to 5000");
  return faults;
}

ChargeAcceptanceAnswer predictChargeAcceptance(const FittedModel& model,
                                               const ChargeAcceptanceQuery& query,
                                               double capacity) {
  return answered<ChargeAcceptanceAnswer>(
      model, faultsOf(query), capacity,
      [&](ChargeAcceptanceAnswer& answer) -> std::optional<QueryRange> {
        const double u_boost = query.u_boost / model.fit.series_blocks;
        const ExpectedCurrent mean = expectedCurrent(model, stepsOf(query, u_boost), query.i_limit);
        answer.i_boost =
            chargeAnswer(model, {u_boost, u_boost, query.t_sof2}, mean.current, query.i_limit);
        if (!areNumbers(*answer.i_boost)) return std::nullopt;
        const QueryRange range = rangeOf(model, query, u_boost, mean, *answer.i_boost);
        answer.message =
            format("mean current %.1f A over %.1f s at %.2f V, 90 %% between %.1f and %.1f A",
                   answer.i_boost->value, query.t_sof2, query.u_boost, answer.i_boost->lower,
                   answer.i_boost->upper);
        if (range.evidence.is_supported)
          answer.message += format("; the median error on %d past charges like it was %.1f A",
                                   range.evidence.charges, range.evidence.median_error);
        return range;
      });
}

EventComparison currentAtVoltage(const FittedModel& model, const Series& series,
                                 const std::vector<double>& driving) {
  constexpr double kStep = 0.1;  // [s]
  EventComparison charge;
  charge.kind = PastEvent::Kind::kCharge;
  charge.time = series.time.front();
  charge.duration = series.time.back() - model.state.time;
  charge.first_voltage = series.voltage.front();
  std::vector<VoltageStep> steps;
  double total = 0.0, duration = 0.0, volt_seconds = 0.0, before = model.state.time;
  for (std::size_t n = 0; n < series.size(); ++n) {
    const double dt = series.time[n] - before;
    before = series.time[n];
    total += dt;
    charge.measured += series.current[n] * dt;
    charge.voltage += series.voltage[n] * dt;
    duration += dt;
    volt_seconds += series.voltage[n] * dt;
    if (duration < kStep && n + 1 < series.size()) continue;
    steps.push_back({duration, volt_seconds / duration});
    duration = volt_seconds = 0.0;
  }
  charge.measured /= total;
  charge.voltage /= total;
  charge.expected = model.fit.source ? followedCurrent(model, series, driving)
                                     : expectedCurrent(model, steps, kMaxCurrent).current;
  charge.modelled = charge.expected.value;
  if (model.fit.source)
    charge.expected = chargeAnswer(model, {charge.voltage, charge.first_voltage, total},
                                   charge.expected, kMaxCurrent);
  return charge;
}

}  // namespace battery_sof
