#include "baseline/baseline_predictor.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <map>
#include <numeric>
#include <stdexcept>
#include <string>

#include "recording/events.hpp"

namespace battery_sof {
namespace {

constexpr std::size_t kFewestSamples = 5;
constexpr std::size_t kFewestForTails = 20;  // one of them lies beyond each bound
constexpr double kForgetting = 0.8;          // weight of a crank relative to the next one
constexpr double kLineWeight = 1.0;          // of the line relative to one crank

/// Several values or samples, where they lie.
using Values = Eigen::Map<const Eigen::ArrayXd>;

Values allOf(const std::vector<double>& values) {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}

Values valuesIn(const std::vector<double>& values, IndexRange range) {
  return {values.data() + range.first, static_cast<Eigen::Index>(range.size())};
}

double standardDeviation(const std::vector<double>& errors) {
  return errors.empty() ? 0.0 : std::sqrt(allOf(errors).square().mean());
}

/// Bounds that nine in ten further errors keep: quantiles of many, Student's t for few; otherwise's
/// for a single one.
Bounds ninetyPercent(const std::vector<double>& errors, Bounds otherwise) {
  const std::size_t count = errors.size();
  if (count >= kFewestForTails) return {quantile(errors, 0.05), quantile(errors, 0.95)};
  if (count < 2) return otherwise;
  const double n = static_cast<double>(count);
  const double width = boost::math::quantile(boost::math::students_t(n - 1.0), 0.95) *
                       standardDeviation(errors) * std::sqrt(n / (n - 1.0) * (1.0 + 1.0 / n));
  return {-width, width};
}

std::optional<BaselineLine> lineThrough(const Values& x, const Values& y) {
  BaselineLine line;
  line.samples = static_cast<std::size_t>(x.size());
  if (line.samples < kFewestSamples) return std::nullopt;
  line.centre = x.mean();
  const double level = y.mean();
  const double squares = (x - line.centre).square().sum();
  const double products = ((x - line.centre) * (y - level)).sum();
  line.slope = squares > 0.0 ? products / squares : 0.0;
  line.intercept = level - line.slope * line.centre;
  line.spread = std::sqrt(squares / static_cast<double>(line.samples));
  std::vector<double> errors(line.samples);
  Eigen::Map<Eigen::ArrayXd>(errors.data(), x.size()) = y - (line.intercept + line.slope * x);
  line.std = standardDeviation(errors);
  line.error = ninetyPercent(errors, {});
  return line;
}

/// i(v) over the samples with controlled voltage, or v(i) over the others.
std::optional<BaselineLine> lineWhere(const Series& series, IndexRange window,
                                      const std::vector<char>& voltage_controlled,
                                      bool voltage_is_controlled) {
  std::vector<double> x, y;
  for (std::size_t k = window.first; k < window.last; ++k) {
    if ((voltage_controlled[k] != 0) != voltage_is_controlled) continue;
    x.push_back(voltage_is_controlled ? series.voltage[k] : series.current[k]);
    y.push_back(voltage_is_controlled ? series.current[k] : series.voltage[k]);
  }
  return lineThrough(allOf(x), allOf(y));
}

/// Calls visit(sample, step) for every sample of the charge that begins at first, until the voltage
/// is no longer controlled.
template <typename Visit>
void forEachAge(const Series& series, IndexRange range, std::size_t first,
                const std::vector<char>& voltage_controlled, double step, Visit visit) {
  for (std::size_t k = first; k < range.last && voltage_controlled[k]; ++k)
    visit(k, static_cast<std::size_t>(std::lround((series.time[k] - series.time[first]) / step)));
}

std::optional<BaselinePhase> medianPhase(const Series& series, IndexRange window,
                                         const std::vector<char>& voltage_controlled,
                                         const std::vector<std::size_t>& beginnings,
                                         Bounds otherwise) {
  if (beginnings.empty()) return std::nullopt;
  BaselinePhase phase;
  phase.step = std::max(1.0, medianInterval(series));
  phase.charges = beginnings.size();
  std::map<std::size_t, std::vector<double>> by_age;
  std::map<std::size_t, std::size_t> charges_at;
  for (const std::size_t first : beginnings) {
    std::optional<std::size_t> before;
    forEachAge(series, window, first, voltage_controlled, phase.step,
               [&](std::size_t k, std::size_t age) {
                 by_age[age].push_back(series.current[k]);
                 if (before != age) ++charges_at[age];
                 before = age;
               });
  }
  std::vector<double> errors;
  for (std::size_t age = 0; 2 * charges_at[age] >= beginnings.size(); ++age) {
    phase.current.push_back(quantile(by_age[age], 0.5));
    for (const double current : by_age[age]) errors.push_back(current - phase.current.back());
  }
  phase.std = standardDeviation(errors);
  phase.error = beginnings.size() > 1 ? ninetyPercent(errors, otherwise) : otherwise;
  return phase;
}

std::optional<BaselineHistory> chargesOver(const Series& series, IndexRange window,
                                           const std::vector<char>& voltage_controlled,
                                           const std::vector<std::size_t>& beginnings,
                                           double duration, Bounds otherwise) {
  std::vector<double> means;
  for (const std::size_t first : beginnings) {
    const auto samples = beginningOfCharge(series, window, first, duration, voltage_controlled);
    if (samples) means.push_back(valuesIn(series.current, *samples).mean());
  }
  if (means.empty()) return std::nullopt;
  BaselineHistory history;
  history.median = quantile(means, 0.5);
  history.last = means.back();
  history.events = means.size();
  for (double& mean : means) mean -= history.median;
  history.error = ninetyPercent(means, otherwise);
  return history;
}

/// What a crank's minimum has beyond the line, from the first `count` cranks; recent ones weigh
/// more, the line itself as one.
double beyondLine(const std::vector<Event>& cranks, std::size_t count, const BaselineLine& line) {
  double weights = 0.0, weight = 1.0, sum = 0.0;
  for (std::size_t k = count; k-- > 0; weight *= kForgetting) {
    weights += weight;
    sum += weight * (cranks[k].min_voltage - line.at(cranks[k].peak_current));
  }
  return sum / (weights + kLineWeight);
}

std::optional<BaselineCranks> baselineCranks(const std::vector<Event>& cranks,
                                             const std::optional<BaselineLine>& line) {
  if (cranks.empty()) return std::nullopt;
  std::vector<double> currents, minima;
  for (const Event& crank : cranks) {
    currents.push_back(crank.peak_current);
    minima.push_back(crank.min_voltage);
  }
  BaselineCranks baseline;
  baseline.events = cranks.size();
  baseline.last = {currents.back(), minima.back()};
  baseline.median = {quantile(currents, 0.5), quantile(minima, 0.5)};
  BaselineLine level;
  level.intercept = baseline.median.minimum;
  const BaselineLine& known = line ? *line : level;
  baseline.slope = known.slope;
  baseline.intercept = known.intercept + beyondLine(cranks, cranks.size(), known);
  std::vector<double> errors;  // of each crank, predicted from those before
  for (std::size_t k = 0; k < cranks.size(); ++k)
    errors.push_back(minima[k] - known.at(currents[k]) - beyondLine(cranks, k, known));
  const double single = std::abs(errors.front());
  baseline.error = ninetyPercent(errors, {-single, single});
  return baseline;
}

Interval withErrors(double value, Bounds error) {
  return {value, value + error.lower, value + error.upper};
}

void push(const Interval& interval, std::vector<double>& value, std::vector<double>& lower,
          std::vector<double>& upper) {
  value.push_back(interval.value);
  lower.push_back(interval.lower);
  upper.push_back(interval.upper);
}

void usePhase(const BaselinePhase& phase, const Series& series, IndexRange range,
              const std::vector<char>& voltage_controlled, MixedPrediction& predicted) {
  for (const std::size_t first : chargeBeginnings(series, range, voltage_controlled))
    forEachAge(series, range, first, voltage_controlled, phase.step,
               [&](std::size_t k, std::size_t age) {
                 if (age >= phase.current.size()) return;
                 const std::size_t n = k - range.first;
                 predicted.current[n] = phase.current[age];
                 predicted.current_lower[n] = phase.current[age] + phase.error.lower;
                 predicted.current_upper[n] = phase.current[age] + phase.error.upper;
               });
}

/// Mean over duration of the phase as far as it goes and of the line beyond it.
double meanOverPhase(const BaselinePhase& phase, double duration, double beyond) {
  const auto steps = static_cast<std::size_t>(std::max(1.0, std::round(duration / phase.step)));
  const std::size_t known = std::min(steps, phase.current.size());
  const double sum = std::accumulate(phase.current.begin(), phase.current.begin() + known,
                                     beyond * static_cast<double>(steps - known));
  return sum / static_cast<double>(steps);
}

}  // namespace

Interval BaselineLine::around(double x) const {
  const double distance = spread > 0.0 ? (x - centre) / spread : 0.0;
  const double wider =
      std::sqrt(1.0 + distance * distance / static_cast<double>(std::max<std::size_t>(samples, 1)));
  return withErrors(at(x), {wider * error.lower, wider * error.upper});
}

BaselinePredictor fitBaseline(const Series& series, IndexRange window,
                              const std::vector<char>& voltage_controlled,
                              const EventLimits& limits) {
  const auto beginnings = chargeBeginnings(series, window, voltage_controlled);
  BaselinePredictor baseline;
  baseline.current_from_voltage = lineWhere(series, window, voltage_controlled, true);
  baseline.voltage_from_current = lineWhere(series, window, voltage_controlled, false);
  Bounds of_line;
  if (baseline.current_from_voltage) of_line = baseline.current_from_voltage->error;
  baseline.phase = medianPhase(series, window, voltage_controlled, beginnings, of_line);
  const auto charges = [&](double span) {
    return chargesOver(series, window, voltage_controlled, beginnings, span, of_line);
  };
  baseline.charge_10s = charges(kComparedSpans[0]);
  baseline.charge_60s = charges(kComparedSpans[1]);
  baseline.cranks =
      baselineCranks(detectCranks(series, window, limits), baseline.voltage_from_current);
  return baseline;
}

BaselinePredictor fitBaselineDrivenByCurrent(const Series& series, IndexRange window,
                                             const EventLimits& limits) {
  BaselinePredictor baseline;
  baseline.voltage_from_current =
      lineThrough(valuesIn(series.current, window), valuesIn(series.voltage, window));
  baseline.cranks =
      baselineCranks(detectCranks(series, window, limits), baseline.voltage_from_current);
  return baseline;
}

MixedPrediction predictBaseline(const BaselinePredictor& baseline, const Series& series,
                                IndexRange range, const std::vector<char>& voltage_controlled) {
  MixedPrediction predicted;
  for (std::size_t k = range.first; k < range.last; ++k) {
    if (baseline.current_from_voltage)
      push(baseline.current_from_voltage->around(series.voltage.at(k)), predicted.current,
           predicted.current_lower, predicted.current_upper);
    if (baseline.voltage_from_current)
      push(baseline.voltage_from_current->around(series.current.at(k)), predicted.voltage,
           predicted.voltage_lower, predicted.voltage_upper);
  }
  if (baseline.phase && baseline.current_from_voltage)
    usePhase(*baseline.phase, series, range, voltage_controlled, predicted);
  return predicted;
}

std::optional<Interval> baselineCrankMinimum(const BaselinePredictor& baseline, double current) {
  if (baseline.cranks)
    return withErrors(baseline.cranks->intercept + baseline.cranks->slope * current,
                      baseline.cranks->error);
  if (baseline.voltage_from_current) return baseline.voltage_from_current->around(current);
  return std::nullopt;
}

std::optional<Interval> baselineChargeCurrent(const BaselinePredictor& baseline, double voltage,
                                              double duration) {
  if (!(duration > 0.0))
    throw std::invalid_argument("baselineChargeCurrent: duration is " + std::to_string(duration) +
                                " s; expected above 0");
  if (!baseline.phase) {
    if (!baseline.current_from_voltage) return std::nullopt;
    return baseline.current_from_voltage->around(voltage);
  }
  const double last = baseline.phase->current.back();
  const double beyond =
      baseline.current_from_voltage ? baseline.current_from_voltage->at(voltage) : last;
  const double mean = meanOverPhase(*baseline.phase, duration, beyond);
  const bool is_short = duration * duration <= kComparedSpans[0] * kComparedSpans[1];
  const auto& history = is_short && baseline.charge_10s ? baseline.charge_10s : baseline.charge_60s;
  return withErrors(mean, history ? history->error : baseline.phase->error);
}

}  // namespace battery_sof
