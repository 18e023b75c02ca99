#include "diagnosis/locate.hpp"

#include <algorithm>
#include <array>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "diagnosis/random_bits.hpp"
#include "recording/channel_statistics.hpp"

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

// [s], docs/physics.md#stretches-of-time
constexpr std::array<double, 4> kWindows{10.0, 30.0, 100.0, 300.0};
constexpr double kStride = 0.1;  // of a window's length
// a window with fewer is no window
constexpr double kMinSamples = 10.0;
constexpr std::size_t kSimulated = 200;
constexpr double kQuantile = 0.99;
constexpr double kMaxInnovation = 5.0;
constexpr std::size_t kFactors = 3;

using Factors = std::array<double, kFactors>;

/// Samples first to last - 1, and 1 / sqrt(sum f^2) over them for every f.
struct MovingWindow {
  std::size_t first, last;
  double length;  // [s]
  Factors scale;
};

/// Moving sums of innovations, for the measured and the simulated ones alike.
class MovingSums {
 public:
  explicit MovingSums(const InputSequence& inputs) : inputs_(inputs) {
    factors_.reserve(inputs.samples.size());
    sums_.resize(inputs.samples.size() + 1);
    for (const InputSample& sample : inputs.samples) {
      const double i = sample.step.current;
      const double counts = sample.count > 0.0 ? 1.0 : 0.0;
      factors_.push_back({counts,
                          counts * (i > 0.0   ? 1.0
                                    : i < 0.0 ? -1.0
                                              : 0.0),
                          counts * std::abs(i)});
    }
    for (std::size_t n = 0; n < factors_.size(); ++n)
      for (std::size_t k = 0; k < kFactors; ++k)
        sums_[n + 1][k] = sums_[n][k] + factors_[n][k] * factors_[n][k];
    for (const double length : kWindows) addWindows(length);
  }

  /// Takes in innovations. @param innovation of every sample; those of count 0 do not matter.
  template <typename Innovation>
  void take(Innovation&& innovation) {
    for (std::size_t n = 0; n < factors_.size(); ++n) {
      const double v = factors_[n][0] > 0.0 ? innovation(n) : 0.0;
      for (std::size_t k = 0; k < kFactors; ++k) sums_[n + 1][k] = sums_[n][k] + factors_[n][k] * v;
    }
  }

  const std::vector<MovingWindow>& windows() const { return windows_; }

  /// Largest |M| over the factors.
  double statistic(const MovingWindow& window) const {
    double most = 0.0;
    for (std::size_t k = 0; k < kFactors; ++k)
      most = std::max(most,
                      std::abs(sums_[window.last][k] - sums_[window.first][k]) * window.scale[k]);
    return most;
  }

  double largest() const {
    double most = 0.0;
    for (const MovingWindow& window : windows_) most = std::max(most, statistic(window));
    return most;
  }

 private:
  /// While sums_ holds the squares of the factors.
  void addWindows(double length) {
    const auto time = [&](std::size_t n) { return inputs_.samples[n].step.time; };
    double next = inputs_.samples.empty() ? 0.0 : time(0) + length;
    std::size_t first = 0;
    for (std::size_t n = 0; n < factors_.size(); ++n) {
      if (time(n) < next) continue;
      next = time(n) + kStride * length;
      while (time(first) < time(n) - length) ++first;
      MovingWindow window{first, n + 1, length, {}};
      if (sums_[n + 1][0] - sums_[first][0] < kMinSamples) continue;
      for (std::size_t k = 0; k < kFactors; ++k) {
        const double square = sums_[n + 1][k] - sums_[first][k];
        // A window at rest must not be made of the sums' rounding errors.
        window.scale[k] = square > 1e-9 * sums_[n + 1][k] ? 1.0 / std::sqrt(square) : 0.0;
      }
      windows_.push_back(window);
    }
  }

  const InputSequence& inputs_;
  std::vector<Factors> factors_;
  std::vector<Factors> sums_;  // before sample n
  std::vector<MovingWindow> windows_;
};

/// Largest M of simulated series, increasing.
std::vector<double> simulatedMaxima(MovingSums& sums) {
  std::vector<double> maxima;
  RandomBits random(2);
  for (std::size_t draw = 0; draw < kSimulated; ++draw) {
    sums.take([&](std::size_t) { return random.nearlyNormal(); });
    maxima.push_back(sums.largest());
  }
  std::sort(maxima.begin(), maxima.end());
  return maxima;
}

struct Found {
  IndexRange range;
  double statistic;
  double length;  // [s], of the window
};

/// Windows above the threshold, the shortest first and then the clearest, without those that
/// overlap one before: a longer one reports nothing of where.
std::vector<Found> separateWindows(const MovingSums& sums, double threshold) {
  std::vector<Found> above, found;
  for (const MovingWindow& window : sums.windows()) {
    const double statistic = sums.statistic(window);
    if (statistic > threshold)
      above.push_back({{window.first, window.last}, statistic, window.length});
  }
  std::stable_sort(above.begin(), above.end(), [](const Found& a, const Found& b) {
    return a.length != b.length ? a.length < b.length : a.statistic > b.statistic;
  });
  for (const Found& window : above)
    if (std::none_of(found.begin(), found.end(), [&](const Found& other) {
          return window.range.first < other.range.last && other.range.first < window.range.last;
        }))
      found.push_back(window);
  std::sort(found.begin(), found.end(),
            [](const Found& a, const Found& b) { return a.range.first < b.range.first; });
  return found;
}

std::vector<Found> joined(const InputSequence& inputs, const std::vector<Found>& windows) {
  std::vector<Found> segments;
  for (const Found& window : windows) {
    if (!segments.empty()) {
      Found& last = segments.back();
      const double apart = inputs.samples[window.range.first].step.time -
                           inputs.samples[last.range.last - 1].step.time;
      if (apart < std::min(window.length, last.length)) {
        last = {{last.range.first, window.range.last},
                std::max(last.statistic, window.statistic),
                window.length};
        continue;
      }
    }
    segments.push_back(window);
  }
  return segments;
}

MismatchSegment describedSegment(const Found& found, const WhitenedFit& fit,
                                 const InputSequence& inputs, const std::vector<Regime>& regimes) {
  MismatchSegment segment;
  segment.from = inputs.samples[found.range.first].step.time;
  segment.to = inputs.samples[found.range.last - 1].step.time;
  std::array<double, kRegimes> duration{};
  double count = 0.0;
  for (std::size_t n = found.range.first; n < found.range.last; ++n) {
    const InputSample& sample = inputs.samples[n];
    if (sample.count <= 0.0) continue;
    const double error = fit.residual[n];
    duration[static_cast<std::size_t>(regimes[n])] += sample.step.duration;
    segment.mean_error += sample.count * error;
    count += sample.count;
    if (std::abs(error) > std::abs(segment.peak_error)) segment.peak_error = error;
  }
  segment.mean_error /= count;
  const auto most = std::max_element(duration.begin(), duration.end());
  segment.regime = regimeName(static_cast<Regime>(most - duration.begin()));
  return segment;
}

}  // namespace

std::vector<MismatchSegment> mismatchSegments(const WhitenedFit& fit, const InputSequence& inputs,
                                              const std::vector<Regime>& regimes,
                                              const std::optional<NoiseModel>& noise) {
  requireOneSize("mismatchSegments", inputs, regimes, fit.innovation.size());
  const Eigen::VectorXd innovation =
      noise ? Whitening(*noise, inputs.samples).whitened(fit.residual) : fit.innovation;
  MovingSums sums(inputs);
  if (sums.windows().empty()) return {};
  const std::vector<double> maxima = simulatedMaxima(sums);
  const double threshold =
      maxima[static_cast<std::size_t>(kQuantile * static_cast<double>(maxima.size()))];
  sums.take(
      [&](std::size_t n) { return std::clamp(innovation[n], -kMaxInnovation, kMaxInnovation); });
  std::vector<MismatchSegment> segments;
  for (const Found& found : joined(inputs, separateWindows(sums, threshold))) {
    segments.push_back(describedSegment(found, fit, inputs, regimes));
    const auto larger =
        maxima.end() - std::lower_bound(maxima.begin(), maxima.end(), found.statistic);
    segments.back().p_value =
        static_cast<double>(larger + 1) / static_cast<double>(maxima.size() + 1);
  }
  return segments;
}

}  // namespace battery_sof
