#include "estimation/identification.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "estimation/composition_fit.hpp"
#include "estimation/depth_physics.hpp"
#include "estimation/fit_quality.hpp"
#include "estimation/fit_window.hpp"
#include "recording/events.hpp"
#include "state/state_estimator.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

// Windows up to this many samples are fitted as they are; longer ones are compressed first.
constexpr std::size_t kCompressFrom = 4000;
// Standard errors come from the full rate up to here: 13 MB of Jacobian with sixteen unknowns.
constexpr std::size_t kFullRateErrors = 100000;
constexpr int kFirstIterations = 20;  // before weights are taken again
// Share of the cost below which a step is not worth taking: a tenth of what half a standard error
// makes of it.
constexpr double kEnough = 1e-4;
// of the search at full rate; beyond it compression was no good start
constexpr int kLastIterations = 10;
constexpr double kBoundShare = 1e-3;  // [1], of a bound

/// Where every strength is at its magnitude.
CompositionPoint withMagnitudes(const BatteryModel& model, CompositionPoint point) {
  point.parameters.tail(point.parameters.size() - kBaseRows) =
      model.typicalParameters().tail(point.parameters.size() - kBaseRows);
  return point;
}

/// Whether a search ended where nothing but its bound held the parameter.
bool standsAtBound(const ParameterInfo& info, double value) {
  return value <= (1.0 + kBoundShare) * info.lower || value >= (1.0 - kBoundShare) * info.upper;
}

bool hasInstant(const BatteryModel& model) {
  const auto& infos = model.parameters();
  return std::any_of(infos.begin(), infos.end(), [](const auto& info) { return info.instant; });
}

/// Where every instant of the recording is `time` [s] after its beginning.
CompositionPoint withInstants(const BatteryModel& model, CompositionPoint point, double time) {
  for (Eigen::Index j = 0; j < model.parameterCount(); ++j)
    if (model.parameters()[j].instant) point.parameters[j] = time;
  return point;
}

struct Fitted {
  CompositionFit fit;
  FitCost cost;
};

/// Goes on from where a search ended; iterations add up.
void searchOn(Fitted& fitted, const CompositionProblem& problem, const CompositionSearch& search) {
  const int before = fitted.fit.iterations;
  fitted.fit = fitComposition(problem, {fitted.fit.point}, search);
  fitted.fit.iterations += before;
}

FitCost costOf(const IdentifyOptions& options) {
  FitCost cost;
  cost.crank_weight = options.crank_weight;
  cost.crank_weight_current = options.crank_current;
  cost.known = knownOf(options.priors, options.effects);
  cost.capacity = options.capacity;
  return cost;
}

/// A window and its inputs; compressed is empty for short ones.
struct Window {
  Window(const Series& of, IndexRange samples, const std::vector<char>& masked,
         const std::vector<char>& voltage_controlled = {})
      : series(of), range(samples), full(inputSequence(of, samples, masked, voltage_controlled)) {
    if (samples.size() > kCompressFrom && voltage_controlled.empty())
      compressed = compressedInputs(of, samples, kLongestStretch, masked);
  }
  const Series& series;
  IndexRange range;
  InputSequence full, compressed;

  const InputSequence& searched() const { return compressed.samples.empty() ? full : compressed; }
  /// Those that the errors are taken from.
  const InputSequence& judged() const {
    return range.size() <= kFullRateErrors ? full : searched();
  }
};

/// The parameters of circuit and pores in a discharge of one load: they and the open-circuit voltage
/// add up to one voltage, so that they stay at their magnitudes in its search. Its errors still have
/// them.
std::vector<std::string> fixedUnderOneLoad(const BatteryModel& model, const InputSequence& inputs) {
  if (!contains(model.effects(), kUsedUp)) return {};
  double least = HUGE_VAL, most = -HUGE_VAL;
  for (const InputSample& sample : inputs.samples) {
    least = std::min(least, sample.step.current);
    most = std::max(most, sample.step.current);
  }
  if (!isOneLoad(least, most)) return {};
  return {"r_discharge", "r_charge", "c2", "beta", "pore_delay", "pore_refill_time"};
}

/// The point of a fit, of which some coordinates were not searched, in those of the whole problem.
/// @throws std::invalid_argument where the model has no finite voltage.
void inAllCoordinates(Fitted& fitted, const CompositionProblem& problem) {
  fitted.fit.x = problem.coordinatesOf(fitted.fit.point);
  if (!problem.evaluate(fitted.fit.x, fitted.fit.at))
    throw std::invalid_argument("the model has no finite voltage at the optimum");
}

Fitted search(const BatteryModel& model, const InputSequence& inputs,
              const IdentifyOptions& options, const CompositionPoint& base) {
  CompositionSearch search;
  search.max_iterations = std::max(options.max_iterations, CompositionSearch{}.max_iterations);
  search.threads = options.threads;
  const std::vector<std::string> fixed = fixedUnderOneLoad(model, inputs);
  search.more_starts = model.effects().empty() || !fixed.empty() ? 0 : options.more_starts;
  const CompositionPoint nested =
      fixed.empty() ? embedded(BatteryModel(), base, model) : typicalStart(model, inputs);
  std::vector<CompositionPoint> starts = {nested};
  if (!model.effects().empty() && fixed.empty()) starts.push_back(withMagnitudes(model, nested));
  for (const double share : {0.125, 0.375, 0.625, 0.875})
    if (hasInstant(model))
      starts.push_back(withInstants(model, starts[1],
                                    share * (inputs.samples.back().step.time - inputs.first_time)));
  starts.insert(starts.end(), options.starts.begin(), options.starts.end());
  Fitted fitted{{}, costOf(options)};
  const CompositionProblem problem(model, inputs, fitted.cost, nested, fixed);
  fitted.fit = fitComposition(problem, starts, search);
  return fitted;
}

/// The search with errors in both variables: from typical values, the base circuit from its optimum,
/// and from the starts that are given. Weights depend on the point: they are taken at the first
/// start, and again at what was found.
Fitted searchBothWays(const BatteryModel& model, const InputSequence& inputs,
                      const IdentifyOptions& options, const CompositionPoint& base) {
  Fitted fitted{{}, fitCost(options)};
  CompositionSearch search;
  search.tolerance = kEnough;
  search.max_iterations = std::max(options.max_iterations, kFirstIterations);
  std::vector<CompositionPoint> starts = {model.effects().empty() ? base
                                                                  : typicalStart(model, inputs)};
  if (options.only_starts && !options.starts.empty()) starts.clear();
  starts.insert(starts.end(), options.starts.begin(), options.starts.end());
  CompositionProblem problem(model, inputs, fitted.cost, starts.front());
  fitted.fit = fitComposition(problem, starts, search);
  search.max_iterations = std::max(options.max_iterations, CompositionSearch{}.max_iterations);
  problem.reweigh(fitted.fit.point);
  searchOn(fitted, problem, search);
  return fitted;
}

bool isAtBound(const CompositionProblem& problem, const Eigen::VectorXd& x, Eigen::Index k) {
  const double span = problem.upper()[k] - problem.lower()[k];
  return x[k] <= problem.lower()[k] + 1e-9 * span || x[k] >= problem.upper()[k] - 1e-9 * span;
}

/// Covariance of the coordinates; those at a bound are taken as known. @param inputs of the pass.
Eigen::MatrixXd covarianceOf(const CompositionProblem& problem, const Fitted& fitted,
                             const InputSequence& inputs, ModelPass pass,
                             const Eigen::VectorXd& weights) {
  Eigen::MatrixXd information = problem.priorInformation(fitted.fit.x);
  for (Eigen::Index k = 0; k < problem.size(); ++k)
    if (isAtBound(problem, fitted.fit.x, k)) {
      pass.jacobian.col(k).setZero();
      information.row(k).setZero();
      information.col(k).setZero();
    }
  Eigen::VectorXd time(pass.residual.size());
  for (Eigen::Index n = 0; n < time.size(); ++n) time[n] = inputs.samples[n].step.time;
  Eigen::VectorXd own_weights = weights;
  if (fitted.cost.channels) {
    // The noise is that of residuals in units of their deviations.
    const Eigen::VectorXd unit = weights.cwiseSqrt();
    pass.jacobian = unit.asDiagonal() * pass.jacobian;
    pass.residual = unit.cwiseProduct(pass.residual);
    own_weights = (weights.array() > 0.0).cast<double>();
  }
  Sandwich parts = sandwichParts(pass.jacobian, pass.residual, own_weights, time);
  const double weight = problem.priorWeight();
  parts.A += weight * information;
  parts.B += weight * weight * information;
  return combined(parts);
}

/// Scores of a residual that is a voltage's or, where the voltage is the input, a current's.
FitScores scoresBothWays(const Series& series, IndexRange range, const InputSequence& inputs,
                         const Eigen::VectorXd& residual, const CrankLimits& limits) {
  Eigen::VectorXd of_voltage = residual;
  double squares_a = 0.0, currents = 0.0;
  for (std::size_t n = 0; n < inputs.samples.size(); ++n) {
    if (!inputs.samples[n].voltage_controlled) continue;
    double& error = of_voltage[n];
    squares_a += error * error;
    currents += 1.0;
    error = 0.0;
  }
  const double rho = lagOneCorrelation(of_voltage);
  FitScores scores = scoresOf(series, range, of_voltage, rho, limits);
  if (currents == 0.0) return scores;
  scores.current_rmse = std::sqrt(squares_a / currents);
  const double voltages = static_cast<double>(residual.size()) - currents;
  // A window wholly behind a source shows no voltage's error: its currents', through 10 mOhm.
  scores.rmse = voltages > 0.0 ? std::sqrt(of_voltage.squaredNorm() / voltages)
                               : kOhmsOfCurrentError * *scores.current_rmse;
  return scores;
}

/// Scores of the same point with the current driving throughout (paper, eq. 6).
FitScores scoresFromCurrent(const BatteryModel& model, const Series& series, IndexRange range,
                            const IdentifyOptions& options, const CompositionPoint& point) {
  const InputSequence inputs = inputSequence(series, range, options.masked);
  const CompositionProblem problem(model, inputs, FitCost(), point);
  return scoresBothWays(series, range, inputs, problem.residual(problem.coordinatesOf(point)),
                        crankLimitsOf(options));
}

FittedModel completed(const BatteryModel& model, const Window& on, const IdentifyOptions& options,
                      const Fitted& fitted) {
  const auto& [series, range, full, compressed] = on;
  const InputSequence& for_errors = on.judged();
  const CompositionProblem problem(model, for_errors, fitted.cost, fitted.fit.point);
  const ModelPass pass =
      passOver(model, for_errors, fitted.fit.point, problem.seedsAt(fitted.fit.x));
  Eigen::VectorXd weights(pass.residual.size());
  for (Eigen::Index n = 0; n < weights.size(); ++n) weights[n] = problem.weightOf(n);
  // A pass over the whole window has its residual already; otherwise weights play no part in one.
  const Eigen::VectorXd residual =
      &for_errors == &full
          ? pass.residual
          : CompositionProblem(model, full, FitCost(), fitted.fit.point).residual(fitted.fit.x);

  FittedModel found = modelOf(series, range, model, fitted.fit);
  for (Eigen::Index k = 0; k < problem.size(); ++k)
    if (problem.rowOf(k) < model.parameterCount())
      found.fit.estimates[problem.rowOf(k)].at_bound = isAtBound(problem, fitted.fit.x, k);
  const Eigen::MatrixXd covariance = covarianceOf(problem, fitted, for_errors, pass, weights);
  found.fit.covariance = pass.at_end * covariance * pass.at_end.transpose();
  found.fit.scores = scoresBothWays(series, range, full, residual, crankLimitsOf(options));
  if (fitted.cost.channels)
    found.fit.scores.q_dyn_percent =
        scoresFromCurrent(model, series, range, options, fitted.fit.point).q_dyn_percent;
  conclude(found.fit);

  Simulation at_end(model, fitted.fit.point.at(full.first_time));
  for (const InputSample& sample : full.samples) at_end.follow(sample);
  takeState(found, at_end, series.current[range.last - 1]);
  return found;
}

// ---------------------------------------------------------------------------------------------
// what a window that a charger controls gives in addition

void addCranks(EventHistory& event_history, const Series& series, IndexRange range,
               const std::vector<double>& modelled, const EventLimits& limits) {
  const Series part = slice(series, range);
  for (const Event& event : detectCranks(part, {0, part.size()}, limits)) {
    PastEvent crank = measuredCrank(part, event.range);
    crank.modelled = *std::min_element(modelled.begin() + event.range.first,
                                       modelled.begin() + event.range.last);
    event_history.add(crank);
  }
}

void addCharges(EventHistory& event_history, const Series& series, IndexRange range,
                const ControlModes& source, const std::vector<double>& modelled) {
  for (const std::size_t first : chargeBeginnings(series, range, source.voltage_controlled))
    for (const double duration : kComparedSpans) {
      const auto charge =
          beginningOfCharge(series, range, first, duration, source.voltage_controlled);
      if (!charge) continue;
      PastEvent past = measuredCharge(series, *charge, duration);
      for (std::size_t n = charge->first; n < charge->last; ++n)
        past.modelled += modelled[n - range.first] / static_cast<double>(charge->size());
      event_history.add(past);
    }
}

/// @param modelled [V], by the equations and what was estimated from the window's other blocks.
void addStops(EventHistory& event_history, const InputSequence& inputs,
              const std::vector<char>& voltage_controlled, const std::vector<double>& modelled,
              double min_current, const EventLimits& limits) {
  EventDetector detector(limits);
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
  std::vector<AnswerErrors> errors(2);  // of voltage and current
  for (std::size_t k = 0; k < samples.error.size(); ++k) {
    const bool is_current = samples.voltage_controlled[k];
    errors[is_current].add(
        is_current ? series.current[range.first + k] : series.voltage[range.first + k],
        samples.error[k] - left_out[k]);
  }
  return explainedPercent(errors);
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

/**
 * @brief What a fitted window gives in addition to the parameters: the baseline predictors,
 * the residual regression, past events.
 *
 * Sets baseline, source, residual_regression and event_history, and the state's memory. Of the
 * window's own charges `modelled` holds what the equations and a regression without the charge's
 * block say, so that past errors are not those of a fit to itself.
 *
 * @param model fitted to the range, with its first_state.  @param inputs of the range, as it was
 * fitted.
 */
void followWindow(FittedModel& model, const Series& series, IndexRange range,
                  const InputSequence& inputs, const ControlModes& source) {
  const EventLimits limits{model.fit.crank_current};
  model.fit.source = source.rule;
  model.fit.baseline = fitBaseline(series, range, source.voltage_controlled, limits);
  const Course course = courseOf(compositionOf(model.fit), pointOf(atFirstState(model)), inputs);
  std::vector<double> left_out;
  model.fit.residual_regression = fitResidualRegression(course, left_out);
  model.state.memory = course.memory;
  holdInside(model.fit.residual_regression, series, range, source);
  model.fit.scores.left_out_share_percent = leftOutShare(course, left_out, series, range);
  std::vector<double> current = course.current, voltage = course.voltage;
  for (std::size_t n = 0; n < current.size(); ++n)
    (course.voltage_controlled[n] ? current : voltage)[n] += left_out[n];
  addCranks(model.intervals.event_history, series, range, course.voltage, limits);
  addCharges(model.intervals.event_history, series, range, source, current);
  addStops(model.intervals.event_history, inputs, course.voltage_controlled, voltage,
           source.rule.min_current, limits);
}

// ---------------------------------------------------------------------------------------------
// the whole

FittedModel identifyBothWays(const BatteryModel& model, const Series& series, IndexRange range,
                             const IdentifyOptions& options, const CompositionPoint& base) {
  const auto [sound, masked, inputs] = fitWindow(series, range, options);
  const Window window(sound, range, masked, options.source->voltage_controlled);
  FittedModel found =
      completed(model, window, options, searchBothWays(model, window.full, options, base));
  found.fit.voltage_lag = options.source->repair.lag;
  found.fit.crank_current = options.crank_current;
  followWindow(found, sound, range, window.full, *options.source);
  return found;
}

}  // namespace

FitWindowRows fitWindow(const Series& series, IndexRange range, const IdentifyOptions& options) {
  if (!options.source)
    return {series, options.masked, inputSequence(series, range, options.masked)};
  FitWindowRows window{
      repaired(series, options.source->repair), options.source->repair.dropped, {}};
  for (std::size_t n = 0; n < options.masked.size(); ++n)
    window.masked[n] = window.masked[n] || options.masked[n];
  window.inputs =
      inputSequence(window.sound, range, window.masked, options.source->voltage_controlled);
  return window;
}

FitCost fitCost(const IdentifyOptions& options) {
  FitCost cost = costOf(options);
  if (options.source) cost.channels.emplace();
  return cost;
}

std::vector<CompositionPoint> startsInLarger(const BatteryModel& nested,
                                             const CompositionPoint& point,
                                             const BatteryModel& larger) {
  CompositionPoint kept = embedded(nested, point, larger);
  CompositionPoint own = kept;
  bool has_own = false;
  for (Eigen::Index j = 0; j < larger.parameterCount(); ++j) {
    const ParameterInfo& info = larger.parameters()[j];
    const auto row = nested.parameterRow(info.name);
    if (!row)
      kept.parameters[j] = own.parameters[j] = larger.typicalParameters()[j];
    else if (nested.parameters()[*row].magnitude != info.magnitude ||
             (j < kBaseRows && standsAtBound(info, point.parameters[*row])))
      own.parameters[j] = larger.typicalParameters()[j], has_own = true;
  }
  if (!has_own) return {kept};
  return {kept, own};
}

FittedModel identifyComposition(const Series& series, IndexRange range,
                                const IdentifyOptions& options, const CompositionPoint& base) {
  const BatteryModel model(options.effects, options.discrepancy);
  if (options.source) return identifyBothWays(model, series, range, options, base);
  const Window window(series, range, options.masked);
  Fitted fitted = search(model, window.searched(), options, base);
  if (&window.judged() != &window.searched()) {
    // The compressed optimum is off by a share of a standard error; from there two passes at full
    // rate end it.
    const CompositionProblem over_all(model, window.full, fitted.cost, fitted.fit.point,
                                      fixedUnderOneLoad(model, window.full));
    CompositionSearch last;
    last.max_iterations = kLastIterations;
    searchOn(fitted, over_all, last);
  }
  if (!fixedUnderOneLoad(model, window.full).empty())
    inAllCoordinates(fitted, {model, window.searched(), fitted.cost, fitted.fit.point});
  return completed(model, window, options, fitted);
}

FittedModel completedModel(const Series& series, IndexRange range, const IdentifyOptions& options,
                           const CompositionPoint& optimum) {
  const BatteryModel model(options.effects, options.discrepancy);
  const Window window(series, range, options.masked);
  Fitted fitted{{}, costOf(options)};
  fitted.fit.point = optimum;
  inAllCoordinates(fitted, {model, window.searched(), fitted.cost, optimum});
  return completed(model, window, options, fitted);
}

}  // namespace battery_sof
