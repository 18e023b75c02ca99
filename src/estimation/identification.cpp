#include "estimation/identification.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "estimation/base_search.hpp"
#include "estimation/depth_physics.hpp"
#include "estimation/fit_quality.hpp"
#include "estimation/fit_window.hpp"
#include "estimation/physics_choice.hpp"
#include "estimation/window.hpp"
#include "recording/checks.hpp"
#include "recording/crank_current.hpp"
#include "recording/fit_mask.hpp"
#include "recording/series_blocks.hpp"
#include "state/posterior.hpp"
#include "state/state_estimator.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

// A window whose current moves less than this cannot distinguish a resistance from an offset.
constexpr double kMinCurrentSpan = 0.5;  // [A]
constexpr double kMovingVoltage = 0.02;  // [V], which a battery moves by under a held current
constexpr int kBoundRounds = 4;          // of a fit and the bounds that it violates
constexpr double kSlowSampling = 0.25;   // [s], from here on a crank's rise falls between samples

/// A window, and what several steps ask of its samples.
struct Window {
  const Series& series;
  IndexRange range;
  double max_gap;  // [s], of the whole series
  ExcitedRange excited;
};

void requireValid(const IdentifyOptions& options, const Series& series, IndexRange range) {
  requireThat(options.crank_weight >= 1.0, "crank_weight", options.crank_weight, "at least 1");
  requireThat(options.crank_current < 0.0, "crank_current [A]", options.crank_current, "below 0");
  requireThat(options.max_iterations > 0, "max_iterations", options.max_iterations, "at least 1");
  for (std::size_t j = 0; j < options.initial.size(); ++j) {
    const auto& info = tableOne()[j];
    const double value = options.initial[j];
    requireThat(value >= info.lower && value <= info.upper, "initial " + info.name, value,
                "inside Table I's bounds");
  }
  const double capacity = nominalCapacity(options.capacity);
  requireThat(capacity > 0.0, "capacity [Ah]", capacity, "above 0");
  requireThat(options.more_starts >= 0, "more_starts", options.more_starts, "at least 0");
  requireThat(options.threads >= 0, "threads", options.threads, "at least 0");
  BatteryModel known(options.effects, options.discrepancy);
  if (!options.masked.empty() && options.masked.size() != series.size())
    throw std::invalid_argument(format("masked has %zu entries for a recording of %zu",
                                       options.masked.size(), series.size()));
  if (!options.bounded.empty() && options.bounded.size() != series.size())
    throw std::invalid_argument(format("bounded has %zu entries for a recording of %zu",
                                       options.bounded.size(), series.size()));
  if (options.source && options.source->voltage_controlled.size() != series.size())
    throw std::invalid_argument(format("source has %zu entries for a recording of %zu",
                                       options.source->voltage_controlled.size(), series.size()));
  if (options.start == FitStart::kPaper && options.source)
    throw std::invalid_argument("the paper's start has the current as its only input: no source");
  if (options.start == FitStart::kPaper && !options.effects.empty())
    throw std::invalid_argument("the paper's start fits the base model alone: no effects");
  if (range.last > series.size() || range.first > range.last)
    throw std::invalid_argument(format("window of samples %zu to %zu in a recording of %zu",
                                       range.first, range.last, series.size()));
}

bool atBound(const ParameterInfo& info, double value) {
  return value <= info.lower * (1.0 + 1e-6) || value >= info.upper * (1.0 - 1e-6);
}

/// Covariance of (parameters, first state), of what a fit leaves; nothing is
/// estimated of those that are held at a bound.
Eigen::MatrixXd covarianceOf(const std::vector<ParameterEstimate>& estimates, BaseJacobian& left,
                             const Eigen::VectorXd& time) {
  static constexpr std::array<int, kCovarianceRows> kColumnOfRow = {
      kColumnDischarge, kColumnCharge, kColumnLogC2, kColumnLogBeta, kColumnOne, kColumnInitial};
  Eigen::VectorXd scale = Eigen::VectorXd::Ones(kCovarianceRows);
  for (const int j : {kRowC2, kRowBeta}) scale[j] = estimates[j].value;
  for (std::size_t j = 0; j < estimates.size(); ++j)
    if (estimates[j].at_bound) left.columns.col(kColumnOfRow[j]).setZero();
  const Eigen::MatrixXd of_columns =
      combined(sandwichParts(left.columns, left.residual, left.weight, time));
  return scale.asDiagonal() * of_columns(kColumnOfRow, kColumnOfRow) * scale.asDiagonal();
}

Eigen::VectorXd timesOf(const Series& series, IndexRange range) {
  return Eigen::Map<const Eigen::VectorXd>(series.time.data() + range.first,
                                           static_cast<Eigen::Index>(range.size()));
}

/// Replaces the state's row of a covariance by that of the state it became: V <- T V T'.
void carryCovariance(Eigen::MatrixXd& covariance, const Overpotential& carried) {
  Eigen::MatrixXd T = Eigen::MatrixXd::Identity(kCovarianceRows, kCovarianceRows);
  T(kRowState, kRowState) = carried.d_initial;
  T(kRowState, kRowC2) = carried.d_c2;
  T(kRowState, kRowBeta) = carried.d_beta;
  covariance = T * covariance * T.transpose();
}

/// Fills in everything that follows from where the search ended.
FittedModel describeFit(const Window& window, const CompositionFit& fit,
                        const BaseNormalEquations& equations, const CrankLimits& limits) {
  const auto& [series, range, max_gap, excited] = window;
  const BaseParameters p = baseParameters(fit.point.parameters);
  BaseJacobian left =
      equations.jacobian({p.c2, p.beta, fit.point.state[0]}, {p.r_discharge, p.r_charge, p.u_dc});
  const double rho = lagOneCorrelation(left.residual);

  FittedModel model = modelOf(series, range, BatteryModel(), fit, excited);
  std::vector<ParameterEstimate>& estimates = model.fit.estimates;
  for (std::size_t j = 0; j < kRowUDc; ++j)
    estimates[j].at_bound = atBound(tableOne()[j], estimates[j].value);
  model.fit.covariance = covarianceOf(estimates, left, timesOf(series, range));
  model.fit.scores = scoresOf(series, range, left.residual, rho, limits);
  conclude(model.fit);
  model.state.states[0] = left.last.value;
  carryCovariance(model.fit.covariance, left.last);
  return model;
}

/// A window that no model can be fitted to, and why.
std::optional<FittedModel> refused(const Window& window, const IdentifyOptions& options) {
  const auto& [series, range, max_gap, excited] = window;
  const double span = excited.max_current - excited.min_current;
  const bool is_short = range.size() < kMinFitSamples;
  // Under a held current an effect may still be determined, such as the open-circuit voltage's.
  const bool is_bench =
      !options.effects.empty() && excited.max_voltage - excited.min_voltage >= kMovingVoltage;
  if (!is_short && (is_bench || !(span < kMinCurrentSpan))) return std::nullopt;
  const std::string message =
      is_short ? format("the window has %zu samples, but at least %zu are needed", range.size(),
                        kMinFitSamples)
               : format(
                     "the current changes by %g A in the window, but at least %g A is needed to "
                     "distinguish a resistance from an offset; if the current is held, only "
                     "effects can be fitted (--effects, sof effects)",
                     span, kMinCurrentSpan);
  return unfitted(series, range, BatteryModel(options.effects, options.discrepancy),
                  is_short ? FitStatus::kWindowTooShort : FitStatus::kNotExcited, message, excited);
}

double windowQualityOf(const Fit& fit, const WindowSamples& samples) {
  if (const auto& share = fit.scores.left_out_share_percent)
    return std::clamp(*share / 100.0, 0.0, 1.0);
  return windowQuality(fit.scores.rmse / seriesBlocksAt(fit.parameters.u_dc),
                       windowExcitation(samples));
}

/// Whether the fast search, which holds every interval's mean current, is as exact as the
/// simulation.
bool isHeld(const Window& window) {
  const auto& [series, range, max_gap, excited] = window;
  for (std::size_t n = range.first + 1; n < range.last; ++n) {
    const InputStep step = inputStep(series.time[n - 1], series.current[n - 1], series.time[n],
                                     series.current[n], max_gap);
    if (step.rampPieces() > 1) return false;
  }
  return true;
}

/// The fit with what is masked at no cost.
FittedModel fittedTo(const Window& window, const IdentifyOptions& options) {
  const auto& [series, range, max_gap, excited] = window;
  const WindowSamples samples{
      series, range, {options.crank_weight, options.crank_current}, max_gap, options.masked};
  const BaseNormalEquations equations(samples, BaseParameters{}.i0);
  CompositionFit fit;  // effects at a source are searched from their magnitudes
  if (options.start == FitStart::kPaper)
    fit = searchAsInPaper(samples, options, series[range.first]);
  else if (options.effects.empty() || !options.source)
    fit = searchWindow(samples, equations, options);
  const bool is_base = options.start == FitStart::kPaper ||
                       (options.effects.empty() && !isVoltageControlled(options, range) &&
                        knownOf(options.priors, {}).empty() && isHeld(window));
  FittedModel model = is_base ? describeFit(window, fit, equations, crankLimitsOf(options))
                              : identifyComposition(series, range, options, fit.point);
  if (!is_base) model.fit.iterations += fit.iterations;
  if (!model.fit.source)
    model.fit.baseline =
        fitBaselineDrivenByCurrent(series, range, EventLimits{options.crank_current});
  model.fit.window_quality = windowQualityOf(model.fit, samples);
  return model;
}

/// Bounds of a window that a model violates: where the current is cut off the true one lay beyond,
/// and the voltage cannot be above what the model makes of the limit (below, of a charge).
std::vector<char> violatedBounds(const FittedModel& model, const Window& window,
                                 const std::vector<char>& bounded) {
  const auto& [series, range, max_gap, excited] = window;
  std::vector<char> violated(series.size(), 0);
  const FittedModel at_first = atFirstState(model, series.current[range.first]);
  Simulation simulation = simulationOf(at_first);
  const InputSequence inputs = inputsOf(model.fit, series, range);
  for (std::size_t n = range.first; n < range.last; ++n) {
    const InputSample& sample = inputs.samples[n - range.first];
    const double error = simulation.follow(sample);
    const bool is_above = series.current[n] < 0.0 ? error > 0.0 : error < 0.0;
    violated[n] = bounded[n] && !sample.voltage_controlled && is_above;
  }
  return violated;
}

/// The fit with errors of one side where the current is cut off: such a sample costs something
/// where its bound is violated, and nothing elsewhere. Which those are is found in turns with the
/// fit.
FittedModel fitted(const Window& window, const IdentifyOptions& options) {
  const auto begin = options.bounded.begin();
  const bool has_bounds =
      !options.bounded.empty() && std::any_of(begin + window.range.first, begin + window.range.last,
                                              [](char bounded) { return bounded; });
  if (!has_bounds) return fittedTo(window, options);
  IdentifyOptions one_sided = options;
  one_sided.masked.resize(window.series.size(), 0);
  const std::vector<char> masked = one_sided.masked;
  std::vector<char> violated(window.series.size(), 0);
  FittedModel model;
  for (int round = 0; round < kBoundRounds; ++round) {
    for (std::size_t n = 0; n < masked.size(); ++n)
      one_sided.masked[n] = masked[n] || (options.bounded[n] && !violated[n]);
    model = fittedTo(window, one_sided);
    if (!isUsable(model.fit)) return model;
    const std::vector<char> now = violatedBounds(model, window, options.bounded);
    if (now == violated) return model;
    violated = now;
  }
  return model;
}

}  // namespace

bool isVoltageControlled(const IdentifyOptions& options, IndexRange range) {
  if (!options.source) return false;
  const auto begin = options.source->voltage_controlled.begin();
  return std::any_of(begin + range.first, begin + range.last,
                     [](char controlled) { return controlled; });
}

FittedModel identify(const Series& series, IndexRange range, const IdentifyOptions& options) {
  requireValid(options, series, range);
  if (options.chooses_effects) return identifyWithChosenPhysics(series, range, options);
  const double max_gap = gapThreshold(series);
  const Window window{series, range, max_gap, excitedRange(series, range, max_gap)};
  const std::optional<FittedModel> refusal = refused(window, options);
  FittedModel model = refusal ? *refusal : fitted(window, options);
  model.fit.excited.sensor_min_current = options.sensor_min_current;
  model.fit.crank_current = options.crank_current;
  model.fit.nominal_capacity = options.capacity;
  model.fit.start = options.start == FitStart::kPaper ? "paper" : "robust";
  return model;
}

std::optional<ChargerControl> chargerControl(const Series& series, std::optional<std::size_t> last,
                                             const EventLimits& limits) {
  const Series seen = slice(series, {0, last.value_or(series.size())});
  if (medianInterval(seen) < kSlowSampling) return std::nullopt;
  ChargerControl source{detectControlMode(seen, limits), {}};
  if (!source.seen || source.share <= 0.0) return std::nullopt;
  source.repair = findVoltageRepair(seen);
  source.voltage_controlled.resize(series.size(), 0);
  source.repair.dropped.resize(series.size(), 0);
  return source;
}

void takeInstrument(IdentifyOptions& options, const Series& series,
                    const InstrumentLimits& limits) {
  options.masked = limits.withoutClipped();
  options.bounded.assign(series.size(), 0);
  for (const double limit : limits.current_limits) {
    for (std::size_t n = 0; n < series.size(); ++n)
      if (series.current[n] == limit) options.bounded[n] = 1;
    if (limit < 0.0) options.sensor_min_current = limit;
  }
  if (options.start != FitStart::kPaper && medianInterval(series) >= kSlowSampling)
    options.crank_weight = 1.0;
}

void carryState(FittedModel& model, const Series& series, std::size_t last) {
  const auto at = std::lower_bound(series.time.begin(), series.time.end(), model.state.time);
  if (at == series.time.end() || *at != model.state.time || last >= series.size() ||
      series.time[last] < model.state.time)
    throw std::invalid_argument(
        "carryState: the state must stand at a sample at or before the end");
  const auto first = static_cast<std::size_t>(at - series.time.begin());
  const InputSequence inputs = inputsOf(model.fit, series, {first, last + 1});
  StateEstimator estimator(model);
  for (std::size_t n = 1; n < inputs.samples.size(); ++n) estimator.follow(inputs.samples[n]);
  estimator.saveTo(model);
}

namespace {

/// Whether problems keep a recording from being fitted, and what the plan says then: without
/// excitation there is no window, everything else has to be corrected first.
bool refuses(FitPlan& plan, const std::vector<Finding>& problems) {
  const bool is_excited = std::none_of(problems.begin(), problems.end(),
                                       [](const Finding& one) { return one.id == "excitation"; });
  (is_excited ? plan.refusal : plan.window.message) = format(problems);
  return !problems.empty();
}

/// The deep discharge that is under way, a deep cycle as a whole, else the best window.
WindowChoice windowOf(const Series& series, IndexRange searched, const IdentifyOptions& options) {
  if (options.start == FitStart::kPaper) return chooseWindow(series, searched);
  const auto discharge = dischargeUnderWay(series, searched, nominalCapacity(options.capacity));
  const MovedCharge moved = movedCharge(series, searched);
  if (!discharge && moved.isDeep(nominalCapacity(options.capacity)) && moved.isOneCycle())
    return {
        searched, windowExcitation(series, searched),
        format("%.3g Ah went one way, or there and back once, and the window is the whole of it",
               moved.span)};
  if (!discharge) return chooseWindow(series, searched);
  return {
      *discharge, windowExcitation(series, *discharge),
      format(
          "a deep discharge is under way, and the window begins at %.0f s, after its first tenth",
          series.time[discharge->first])};
}

}  // namespace

FitPlan planFit(const Series& series, const FitRequest& request) {
  const IndexRange searched = samplesBetween(series, request.from, request.to);
  FitPlan plan{{searched, 0.0, ""}, request.options};
  if (!request.anyway && refuses(plan, findProblems(series))) return plan;
  if (!request.from || !request.to || request.chooses_window)
    plan.window = windowOf(series, searched, request.options);
  if (!plan.window.range) return plan;
  takeInstrument(plan.options, series, instrumentLimits(series));
  plan.options.crank_current = crankCurrentOf(series, request.crank_current).current;
  if (plan.options.start != FitStart::kPaper)
    plan.options.source =
        chargerControl(series, plan.window.range->last, EventLimits{plan.options.crank_current});
  return plan;
}

FittedModel fitPlanned(const Series& series, const FitPlan& plan) {
  FittedModel model;
  if (!plan.refusal.empty()) {
    model.fit.status = FitStatus::kRefused;
    model.fit.message = plan.refusal;
    return model;
  }
  if (!plan.window.range) {
    model.fit.status = FitStatus::kNotExcited;
    model.fit.message = plan.window.message;
    return model;
  }
  model = identify(series, *plan.window.range, plan.options);
  requirePlausible(model.fit);
  if (isUsable(model.fit)) fitErrors(model, series, *plan.window.range);
  return model;
}

void carryToEnd(FittedModel& model, const Series& series, const FitRequest& request) {
  carryState(model, series, samplesBetween(series, std::nullopt, request.to).last - 1);
}

IndexRange samplesBetween(const Series& series, std::optional<double> from,
                          std::optional<double> to) {
  if (series.empty())
    throw std::invalid_argument("the recording has no samples, expected at least one");
  const double first = from.value_or(series.time.front()), last = to.value_or(series.time.back());
  if (!std::isfinite(first) || !std::isfinite(last))
    throw std::invalid_argument(
        format("the range is %g to %g s, expected finite times", first, last));
  const IndexRange range = indexRange(series, first, last);
  if (!range.empty()) return range;
  throw std::invalid_argument(
      format("no sample from %.3f to %.3f s; the recording holds %.3f to %.3f s", first, last,
             series.time.front(), series.time.back()));
}

}  // namespace battery_sof
