#include "diagnosis/locate.hpp"

#include <algorithm>
#include <array>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "estimation/composition_fit.hpp"
#include "recording/channel_statistics.hpp"
#include "state/state_estimator.hpp"

namespace battery_sof {
namespace {

// ---------------------------------------------------------------------------------------------- regimes

constexpr std::size_t kMinEpisodes = 5;  // docs/physics.md#regimes
// at most 2 % of recordings without mismatch have a significant finding
constexpr double kDiscoveryRate = 0.02;
constexpr double kEndShare = 0.2;  // of an episode
constexpr std::size_t kSlopeSamples = 5;
constexpr double kSlopeTime = 1.0;        // [s]
constexpr std::size_t kSlopePoints = 40;  // a Theil-Sen slope takes the pairs of so many means

enum Statistic { kMean, kSlope, kEnd, kStatistics };
constexpr std::array<const char*, kStatistics> kStatisticNames{"mean", "slope", "end"};

/// Measured samples of an episode.
struct EpisodeError {
  std::vector<std::size_t> samples;
  double duration = 0.0;         // [s]
  std::size_t first_of_end = 0;  // among the samples, of its last fifth
};

EpisodeError episodeError(const InputSequence& inputs, const Episode& episode) {
  EpisodeError error;
  for (std::size_t n = episode.range.first; n < episode.range.last; ++n)
    if (inputs.samples[n].count > 0.0) error.samples.push_back(n);
  if (error.samples.empty()) return error;
  const auto timeOf = [&](std::size_t k) { return inputs.samples[error.samples[k]].step.time; };
  std::size_t& k = error.first_of_end;
  k = error.samples.size() - 1;
  const double to = timeOf(k);
  error.duration = to - timeOf(0);
  while (k > 0 && timeOf(k - 1) >= to - kEndShare * error.duration) --k;
  return error;
}

/// Means of time and error over samples first to last - 1 of an episode.
struct Point {
  double time = 0.0, error = 0.0;
};

Point meanPoint(const WhitenedFit& fit, const InputSequence& inputs, const EpisodeError& episode,
                std::size_t first, std::size_t last) {
  Point mean;
  double count = 0.0;
  for (std::size_t k = first; k < last; ++k) {
    const InputSample& sample = inputs.samples[episode.samples[k]];
    mean.time += sample.count * sample.step.time;
    mean.error += sample.count * fit.residual[episode.samples[k]];
    count += sample.count;
  }
  return {mean.time / count, mean.error / count};
}

/// Median of the slopes between all pairs (Theil 1950; Sen 1968) [V/s].
double theilSenSlope(const WhitenedFit& fit, const InputSequence& inputs,
                     const EpisodeError& episode) {
  const std::size_t size = episode.samples.size(), count = std::min(size, kSlopePoints);
  std::vector<Point> points;
  for (std::size_t k = 0; k < count; ++k)
    points.push_back(meanPoint(fit, inputs, episode, size * k / count, size * (k + 1) / count));
  std::vector<double> slopes;
  for (std::size_t a = 0; a < count; ++a)
    for (std::size_t b = a + 1; b < count; ++b)
      slopes.push_back((points[b].error - points[a].error) / (points[b].time - points[a].time));
  return quantile(std::move(slopes), 0.5);
}

/// The sample of an episode with which a statistic begins.
std::size_t firstOf(Statistic statistic, const EpisodeError& episode) {
  return statistic == kEnd ? episode.first_of_end : 0;
}

double valueOf(Statistic statistic, const WhitenedFit& fit, const InputSequence& inputs,
               const EpisodeError& episode) {
  if (statistic == kSlope) return theilSenSlope(fit, inputs, episode);
  return meanPoint(fit, inputs, episode, firstOf(statistic, episode), episode.samples.size()).error;
}

/// An episode's part of the statistic's signature [1] or [s].
void addSignature(Statistic statistic, const WhitenedFit& fit, const InputSequence& inputs,
                  const EpisodeError& episode, Eigen::Ref<Eigen::VectorXd> column) {
  const std::size_t size = episode.samples.size();
  const double middle = meanPoint(fit, inputs, episode, 0, size).time;
  for (std::size_t k = firstOf(statistic, episode); k < size; ++k) {
    const std::size_t n = episode.samples[k];
    column[n] = statistic == kSlope ? inputs.samples[n].step.time - middle : 1.0;
  }
}

/// A statistic of a regime and the episodes it is taken over.
struct Question {
  Regime regime;
  Statistic statistic;
  std::vector<EpisodeError> episodes;
};

std::vector<Question> questionsOf(const InputSequence& inputs, const std::vector<Regime>& regimes) {
  std::array<std::vector<EpisodeError>, kRegimes> of_regime;
  for (const Episode& episode : episodesOf(inputs, regimes)) {
    EpisodeError error = episodeError(inputs, episode);
    if (!error.samples.empty())
      of_regime[static_cast<std::size_t>(episode.regime)].push_back(std::move(error));
  }
  std::vector<Question> questions;
  for (std::size_t g = 0; g < kRegimes; ++g)
    for (const Statistic statistic : {kMean, kSlope, kEnd}) {
      Question question{static_cast<Regime>(g), statistic, of_regime[g]};
      auto& episodes = question.episodes;
      if (statistic == kSlope)
        episodes.erase(std::remove_if(episodes.begin(), episodes.end(),
                                      [](const auto& e) {
                                        return e.samples.size() < kSlopeSamples ||
                                               e.duration < kSlopeTime;
                                      }),
                       episodes.end());
      if (episodes.size() >= kMinEpisodes) questions.push_back(std::move(question));
    }
  return questions;
}

/// Two-sided p of a score of independent innovations, with the variance of its own terms.
double scoreP(const Eigen::Ref<const Eigen::VectorXd>& signature,
              const Eigen::VectorXd& innovation) {
  const Eigen::VectorXd terms = signature.cwiseProduct(innovation);
  const double std = terms.norm();
  return std > 0.0 ? std::erfc(std::abs(terms.sum()) / (std::sqrt(2.0) * std)) : 1.0;
}

/// Mean of dependent values with its 95 % interval (Newey and West 1987, Bartlett weights).
void takeMean(const std::vector<double>& values, RegimeFinding& finding) {
  const double count = static_cast<double>(values.size());
  for (const double value : values) finding.value += value / count;
  const auto lags = static_cast<std::size_t>(4.0 * std::pow(count / 100.0, 2.0 / 9.0));
  double variance = 0.0;
  for (std::size_t lag = 0; lag <= std::min(lags, values.size() - 1); ++lag) {
    const double weight =
        lag == 0 ? 1.0 : 2.0 * (1.0 - static_cast<double>(lag) / (static_cast<double>(lags) + 1.0));
    for (std::size_t j = lag; j < values.size(); ++j)
      variance += weight * (values[j] - finding.value) * (values[j - lag] - finding.value);
  }
  const double half = boost::math::quantile(boost::math::students_t(count - 1.0), 0.975) *
                      std::sqrt(std::max(0.0, variance) / (count * (count - 1.0)));
  finding.lower = finding.value - half;
  finding.upper = finding.value + half;
}

void markSignificant(std::vector<RegimeFinding>& findings) {
  std::vector<double> sorted;
  for (const RegimeFinding& finding : findings) sorted.push_back(finding.p_value);
  std::sort(sorted.begin(), sorted.end());
  double limit = 0.0;
  for (std::size_t k = 0; k < sorted.size(); ++k)
    if (sorted[k] <=
        kDiscoveryRate * static_cast<double>(k + 1) / static_cast<double>(sorted.size()))
      limit = sorted[k];
  for (RegimeFinding& finding : findings)
    finding.is_significant =
        finding.p_value <= limit && (finding.lower > 0.0 || finding.upper < 0.0);
}

}  // namespace

std::vector<RegimeFinding> regimeFindings(const WhitenedFit& fit, const InputSequence& inputs,
                                          const std::vector<Regime>& regimes) {
  requireOneSize("regimeFindings", inputs, regimes, fit.innovation.size());
  const std::vector<Question> questions = questionsOf(inputs, regimes);
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(fit.innovation.size(), questions.size());
  for (std::size_t k = 0; k < questions.size(); ++k)
    for (const EpisodeError& episode : questions[k].episodes)
      addSignature(questions[k].statistic, fit, inputs, episode, columns.col(k));
  const Signatures signatures = signaturesOf(fit, inputs, std::move(columns));
  std::vector<RegimeFinding> findings;
  for (std::size_t k = 0; k < questions.size(); ++k) {
    const Question& question = questions[k];
    RegimeFinding finding;
    finding.regime = regimeName(question.regime);
    finding.statistic = kStatisticNames[question.statistic];
    finding.episodes = question.episodes.size();
    std::vector<double> values;
    for (const EpisodeError& episode : question.episodes)
      values.push_back(valueOf(question.statistic, fit, inputs, episode));
    takeMean(values, finding);
    finding.p_value = scoreP(signatures.columns.col(k), fit.innovation);
    findings.push_back(finding);
  }
  markSignificant(findings);
  return findings;
}

// ---------------------------------------------------------------------------------------------- segments

namespace {

constexpr double kUnit = 10.0;     // [s], the steps in which a stretch begins and ends
constexpr double kUnitRows = 5.0;  // in each, where sampling is slower
constexpr double kWindowUnits = 6.0;
constexpr double kEdgeLevel = 2.0;   // times the usual level: what belongs to a stretch
constexpr double kTolerance = 1e-4;  // of the search

/// Some seconds of the rows.
struct Unit {
  IndexRange range;
  double from = 0.0;   // [s]
  double cost = 0.0;   // of their errors [1]
  double count = 0.0;  // of samples
  double level() const { return std::sqrt(cost / count); }
};

std::vector<Unit> unitsOf(const InputSequence& inputs, double length,
                          const CompositionProblem& problem, const Eigen::VectorXd& error) {
  std::vector<Unit> units;
  for (std::size_t n = 0; n < inputs.samples.size(); ++n) {
    const InputSample& sample = inputs.samples[n];
    if (!(sample.count > 0.0)) continue;
    const double time = sample.step.time;
    if (units.empty() || time >= units.back().from + length) units.push_back({{n, n}, time});
    Unit& unit = units.back();
    unit.range.last = n + 1;
    unit.cost += problem.costOf(n, error[n]);
    unit.count += sample.count;
  }
  return units;
}

/// Units first to last - 1.
struct Window {
  std::size_t first, last;
  double level;  // of all of them, in standard deviations
};

/// Windows of six units, or of those that a gap leaves of six.
std::vector<Window> windowsOf(const std::vector<Unit>& units, double length) {
  std::vector<Window> windows;
  for (std::size_t first = 0; first < units.size(); ++first) {
    Unit sum;
    std::size_t last = first;
    const double end = units[first].from + kWindowUnits * length;
    for (; last < units.size() && units[last].from < end; ++last) {
      sum.cost += units[last].cost;
      sum.count += units[last].count;
    }
    if (sum.count >= kUnitRows) windows.push_back({first, last, sum.level()});
    if (last == units.size()) break;
  }
  return windows;
}

/// Probability that the worst of so many windows, of one independent error each, is so many times
/// the usual level.
double worstOfP(double windows, double ratio) {
  if (!(windows > 1.0) || !std::isfinite(ratio)) return 1.0;
  const boost::math::fisher_f of_one(1.0, windows - 1.0);
  return std::min(1.0, windows * boost::math::cdf(complement(of_one, ratio * ratio)));
}

MismatchSegment describedSegment(IndexRange range, const InputSequence& inputs,
                                 const Eigen::VectorXd& error, const std::vector<Regime>& regimes,
                                 double& rms) {
  MismatchSegment segment;
  segment.from = inputs.samples[range.first].step.time;
  segment.to = inputs.samples[range.last - 1].step.time;
  std::array<double, kRegimes> duration{};
  double count = 0.0, square = 0.0;
  for (std::size_t n = range.first; n < range.last; ++n) {
    const InputSample& sample = inputs.samples[n];
    if (!(sample.count > 0.0)) continue;
    const double volt = sample.voltage_controlled ? -kOhmsOfCurrentError * error[n] : error[n];
    duration[static_cast<std::size_t>(regimes[n])] += sample.step.duration;
    segment.mean_error += sample.count * volt;
    square += sample.count * volt * volt;
    count += sample.count;
    if (std::abs(volt) > std::abs(segment.peak_error)) segment.peak_error = volt;
  }
  segment.mean_error /= count;
  rms = std::sqrt(square / count);
  const auto most = std::max_element(duration.begin(), duration.end());
  segment.regime = regimeName(static_cast<Regime>(most - duration.begin()));
  return segment;
}

/// Of each unit, the smallest p of the significant windows that hold it.
std::vector<double> significanceOf(const std::vector<Unit>& units,
                                   const std::vector<Window>& windows, double usual) {
  std::vector<double> p_values(units.size(), 1.0);
  const double independent = static_cast<double>(units.size()) / kWindowUnits;
  for (const Window& window : windows) {
    const double p = worstOfP(independent, window.level / usual);
    if (p > kDiscoveryRate) continue;
    for (std::size_t k = window.first; k < window.last; ++k) p_values[k] = std::min(p_values[k], p);
  }
  return p_values;
}

/// The runs of units that are in a significant window, each from its first to its last unit above
/// the edge level. @param gap [s] between units, which ends a run.
std::vector<IndexRange> runsOf(const std::vector<Unit>& units, const std::vector<double>& p_values,
                               double edge, double gap) {
  std::vector<IndexRange> runs;
  for (std::size_t first = 0, end; first < units.size(); first = end) {
    end = first + 1;
    if (p_values[first] >= 1.0) continue;
    while (end < units.size() && p_values[end] < 1.0 && units[end].from - units[end - 1].from < gap)
      ++end;
    std::size_t last = end;
    while (first < last && units[first].level() <= edge) ++first;
    while (first < last && units[last - 1].level() <= edge) --last;
    if (first < last) runs.push_back({first, last});
  }
  return runs;
}

}  // namespace

std::vector<MismatchSegment> mismatchSegments(const InputSequence& inputs,
                                              const CompositionPoint& start,
                                              const std::vector<Regime>& regimes, double least,
                                              const std::function<void()>& pulse) {
  requireOneSize("mismatchSegments", inputs, regimes, inputs.samples.size());
  const BatteryModel circuit;
  FitCost cost;
  cost.channels.emplace();
  const CompositionProblem problem(circuit, inputs, cost, start);
  CompositionSearch search;
  search.tolerance = kTolerance;
  search.pulse = pulse;
  const std::optional<CompositionFit> fit = fitFromStarts(problem, {start}, search);
  if (!fit) return {};
  const Eigen::VectorXd error = problem.residual(fit->x);
  const double length = std::max(kUnit, kUnitRows * medianDuration(inputs));
  const std::vector<Unit> units = unitsOf(inputs, length, problem, error);
  const std::vector<Window> windows = windowsOf(units, length);
  if (windows.empty()) return {};
  std::vector<double> levels;
  for (const Window& window : windows) levels.push_back(window.level);
  const double usual = quantile(std::move(levels), 0.5);
  const std::vector<double> p_values = significanceOf(units, windows, usual);
  std::vector<MismatchSegment> segments;
  for (const auto& [first, last] :
       runsOf(units, p_values, kEdgeLevel * usual, kWindowUnits * length)) {
    double rms = 0.0;
    MismatchSegment segment = describedSegment(
        {units[first].range.first, units[last - 1].range.last}, inputs, error, regimes, rms);
    segment.p_value = *std::min_element(p_values.begin() + first, p_values.begin() + last);
    if (rms >= least) segments.push_back(std::move(segment));
  }
  return segments;
}

}  // namespace battery_sof
