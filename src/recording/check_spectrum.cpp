#include <Eigen/Dense>

#include <algorithm>
#include <cmath>

#include "check_parts.hpp"
#include "recording/channel_statistics.hpp"
#include "recording/spectral_line.hpp"
#include "util/constants.hpp"

/// Findings about tones in the voltage that the current does not explain.
namespace battery_sof::check_parts {
namespace {

constexpr double kUneven = 0.5;  // of an interval; more and the phase is lost
// [V], what a fit's residual is judged by (docs/physics.md#aliasing)
constexpr double kMinAmplitude = 0.001;
constexpr double kMinNoiseShare = 0.5;  // of the noise, from the same place
constexpr double kProportion = 2.0;     // of the resistance at edges, within which impedances lie
constexpr int kTaps = 2;                // samples to either side of the shift between channels
constexpr int kColumns = 2 * (2 * kTaps + 1);

using Row = Eigen::Matrix<double, kColumns, 1>;
using Square = Eigen::Matrix<double, kColumns, kColumns>;

/// Samples by which voltage follows current.
long shiftOf(const Evidence& evidence) {
  return std::lround(evidence.edges->lag / evidence.interval);
}

/// Ranges of changes from one sample to the next, all over about one interval, with the neighbours
/// that the regression needs. Change k is that from sample k - 1 to sample k.
std::vector<IndexRange> evenRanges(const Evidence& evidence) {
  const std::vector<double>& time = evidence.series.time;
  const auto margin = static_cast<std::size_t>(std::abs(shiftOf(evidence)) + kTaps);
  const auto is_even = [&](std::size_t k) {
    return std::abs(time[k] - time[k - 1] - evidence.interval) <= kUneven * evidence.interval;
  };
  std::vector<IndexRange> ranges;
  for (const IndexRange& range : rangesWhere({1, time.size()}, is_even))
    if (range.size() > 2 * margin) ranges.push_back({range.first + margin, range.last - margin});
  return ranges;
}

template <typename Value>
std::vector<double> changesOf(const std::vector<double>& values, Value value) {
  std::vector<double> changes(values.size(), 0.0);
  for (std::size_t k = 1; k < values.size(); ++k)
    changes[k] = value(values[k]) - value(values[k - 1]);
  return changes;
}

double itself(double value) { return value; }
double magnitude(double value) { return std::abs(value); }

/// Changes of current and of its magnitude around one sample: with both, charge and discharge have
/// resistances of their own.
struct Regressors {
  explicit Regressors(const Evidence& evidence)
      : shift(shiftOf(evidence)),
        current(changesOf(evidence.series.current, itself)),
        size(changesOf(evidence.series.current, magnitude)) {}

  Row at(std::size_t k) const {
    Row row;
    for (Eigen::Index j = -kTaps; j <= kTaps; ++j) {
      const auto from = static_cast<std::size_t>(static_cast<long>(k) - shift + j);
      row[2 * (j + kTaps)] = current[from];
      row[2 * (j + kTaps) + 1] = size[from];
    }
    return row;
  }

  long shift;
  std::vector<double> current, size;
};

/// Changes of voltage minus their least-squares regression on the changes of current.
std::vector<double> unexplainedChanges(const Evidence& evidence, const Regressors& regressors,
                                       const std::vector<IndexRange>& ranges) {
  std::vector<double> changes = changesOf(evidence.series.voltage, itself);
  Square products = Square::Zero();
  Row projection = Row::Zero();
  for (const IndexRange& range : ranges) {
    for (std::size_t k = range.first; k < range.last; ++k) {
      const Row row = regressors.at(k);
      products.noalias() += row * row.transpose();
      projection += changes[k] * row;
    }
  }
  const Row weights = products.completeOrthogonalDecomposition().solve(projection);
  for (const IndexRange& range : ranges) {
    for (std::size_t k = range.first; k < range.last; ++k)
      changes[k] -= weights.dot(regressors.at(k));
  }
  return changes;
}

}  // namespace

std::vector<Finding> findAliasing(const Evidence& evidence) {
  if (!evidence.excited || !evidence.edges) return {};
  const Regressors regressors(evidence);
  const std::vector<IndexRange> ranges = evenRanges(evidence);
  const LineSearch search =
      findSpectralLines(unexplainedChanges(evidence, regressors, ranges), ranges);
  const double least = std::max(kMinAmplitude, kMinNoiseShare * evidence.voltage.noise),
               max_ohmic = kProportion * std::abs(evidence.edges->resistance);
  std::vector<SpectralLine> tones;  // amplitudes in [V]
  for (SpectralLine line : search.lines) {
    if (line.amplitude <= max_ohmic * amplitudeAt(regressors.current, ranges, line.frequency))
      continue;
    // amplitude of a tone's changes from sample to sample, over that of the tone
    line.amplitude /= 2.0 * std::sin(kPi * line.frequency);
    if (line.amplitude >= least) tones.push_back(line);
  }
  if (tones.empty()) return {};
  const SpectralLine& tone =
      *std::max_element(tones.begin(), tones.end(),
                        [](const auto& a, const auto& b) { return a.amplitude < b.amplitude; });
  const double samples = tone.share * static_cast<double>(search.blocks * kLineBlock),
               frequency = tone.frequency / evidence.interval;
  return {Finding{
      "aliasing", Severity::kWarning,
      "voltage carries a steady tone of " + number(frequency) + " Hz (amplitude " +
          twoDigits(1e3 * tone.amplitude) + " mV) that current does not carry in proportion, in " +
          number(std::round(100.0 * tone.share)) + " % of " + counted(search.blocks, "block") +
          " of " + number(kLineBlock * evidence.interval) + " s" +
          (tones.size() > 1 ? "; " + counted(tones.size() - 1, "weaker tone") + " besides" : ""),
      "ripple from above half the sampling rate, an alternator's for instance, folded down "
      "without an anti-alias filter; or a real load that switches at this rate and is not in the "
      "measured current: the recording cannot show which. Fits take it for noise, and the lowest "
      "voltage of a crank is off by up to its amplitude",
      frequency, "Hz", static_cast<std::size_t>(std::lround(samples))}};
}

std::size_t evenBlocks(const Evidence& evidence) {
  std::size_t blocks = 0;
  for (const IndexRange& range : evenRanges(evidence)) blocks += range.size() / kLineBlock;
  return blocks;
}

}  // namespace battery_sof::check_parts
