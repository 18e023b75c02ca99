#include <Eigen/Dense>
#include <unsupported/Eigen/FFT>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include "check_parts.hpp"
#include "recording/channel_statistics.hpp"
#include "util/constants.hpp"

/// Tones, and findings about those in the voltage that the current does not explain.
namespace battery_sof::check_parts {
namespace {

constexpr double kWindowSum = 0.5 * kLineBlock;
constexpr std::size_t kFirstBin = 8;
constexpr std::size_t kLastBin = 120;
constexpr std::size_t kGuard = 3;   // bins; the main lobe of the Hann window and half a bin
constexpr std::size_t kReach = 16;  // bins to either side whose median is the local noise
constexpr double kFalseAlarm = 0.01;
constexpr double kShare = 0.8;
constexpr double kSteadiness = 0.8;

using Complex = std::complex<double>;

struct Block {
  std::size_t range;  ///< index of the range it lies in
  std::vector<Complex> spectrum;
  std::vector<double> excess;  ///< power over the threshold, by bin
};

/// The block's values without their linear trend, times the window.
std::vector<double> windowed(const std::vector<double>& values, std::size_t first) {
  static const auto window = [] {
    std::array<double, kLineBlock> hann;
    for (std::size_t k = 0; k < kLineBlock; ++k)
      hann[k] = 0.5 - 0.5 * std::cos(2.0 * kPi * static_cast<double>(k) / kLineBlock);
    return hann;
  }();
  constexpr double kMiddle = 0.5 * (kLineBlock - 1);
  constexpr double kSquares = kLineBlock * (static_cast<double>(kLineBlock) * kLineBlock - 1) / 12;
  double mean = 0.0, slope = 0.0;
  for (std::size_t k = 0; k < kLineBlock; ++k) {
    mean += values[first + k] / kLineBlock;
    slope += (static_cast<double>(k) - kMiddle) * values[first + k] / kSquares;
  }
  std::vector<double> result(kLineBlock);
  for (std::size_t k = 0; k < kLineBlock; ++k) {
    const double trend = mean + slope * (static_cast<double>(k) - kMiddle);
    result[k] = window[k] * (values[first + k] - trend);
  }
  return result;
}

/// Median power of the bins around one, but for those that a line there leaks into.
double localMedian(const std::vector<double>& power, std::size_t bin) {
  std::vector<double> around;
  const std::size_t first = std::max(kGuard, bin - std::min(bin, kReach));
  const std::size_t last = std::min(kLineBlock / 2 - kGuard, bin + kReach);
  for (std::size_t k = first; k <= last; ++k) {
    if (k + kGuard <= bin || k >= bin + kGuard) around.push_back(power[k]);
  }
  return quantile(std::move(around), 0.5);
}

std::vector<double> excessOf(const std::vector<Complex>& spectrum) {
  constexpr double kBins = kLastBin - kFirstBin + 1;
  static const double factor = std::log(kBins / kFalseAlarm) / std::log(2.0);
  std::vector<double> power(kLineBlock / 2 + 1), excess(power.size(), 0.0);
  for (std::size_t k = 0; k < power.size(); ++k) power[k] = std::norm(spectrum[k]);
  for (std::size_t k = kFirstBin; k <= kLastBin; ++k) {
    const double threshold = factor * localMedian(power, k);
    excess[k] = threshold > 0.0 ? power[k] / threshold : 0.0;
  }
  return excess;
}

template <typename Visit>
void forEachBlock(const std::vector<IndexRange>& ranges, Visit visit) {
  for (std::size_t range = 0; range < ranges.size(); ++range) {
    for (std::size_t k = ranges[range].first; k + kLineBlock <= ranges[range].last; k += kLineBlock)
      visit(range, k);
  }
}

std::vector<Block> transform(const std::vector<double>& values,
                             const std::vector<IndexRange>& ranges) {
  Eigen::FFT<double> fft;
  std::vector<Block> blocks;
  forEachBlock(ranges, [&](std::size_t range, std::size_t first) {
    Block block{range, {}, {}};
    fft.fwd(block.spectrum, windowed(values, first));
    block.excess = excessOf(block.spectrum);
    blocks.push_back(std::move(block));
  });
  return blocks;
}

double shareStandingOut(const std::vector<Block>& blocks, std::size_t bin) {
  const auto count = std::count_if(blocks.begin(), blocks.end(),
                                   [bin](const Block& block) { return block.excess[bin] > 1.0; });
  return static_cast<double>(count) / static_cast<double>(blocks.size());
}

/// Mean of exp(i advance) of the phase from each block to the next in the same range.
Complex meanAdvance(const std::vector<Block>& blocks, std::size_t bin) {
  Complex sum = 0.0;
  std::size_t pairs = 0;
  for (std::size_t k = 1; k < blocks.size(); ++k) {
    if (blocks[k].range != blocks[k - 1].range) continue;
    const Complex advance = blocks[k].spectrum[bin] * std::conj(blocks[k - 1].spectrum[bin]);
    if (std::abs(advance) > 0.0) sum += advance / std::abs(advance);
    ++pairs;
  }
  return pairs > 0 ? sum / static_cast<double>(pairs) : 0.0;
}

double medianMagnitude(const std::vector<Block>& blocks, std::size_t bin) {
  std::vector<double> magnitudes;
  for (const Block& block : blocks) magnitudes.push_back(std::abs(block.spectrum[bin]));
  return quantile(std::move(magnitudes), 0.5);
}

SpectralLine lineAt(const std::vector<Block>& blocks, std::size_t bin) {
  const Complex advance = meanAdvance(blocks, bin);
  const double offset = std::arg(advance) / (2.0 * kPi);
  SpectralLine line;
  line.frequency = (static_cast<double>(bin) + offset) / kLineBlock;
  // magnitude of the Hann window's transform, offset [bins] from its centre, over that at it
  const double gain = std::abs(offset) < 1e-6
                          ? 1.0
                          : std::sin(kPi * offset) / (kPi * offset) / (1.0 - offset * offset);
  line.amplitude = 2.0 * medianMagnitude(blocks, bin) / kWindowSum / gain;
  line.share = shareStandingOut(blocks, bin);
  line.steadiness = std::abs(advance);
  return line;
}

/// Bins at which a line stands out, the strongest of each group of neighbours.
std::vector<std::size_t> standingBins(const std::vector<Block>& blocks) {
  std::vector<std::size_t> bins;
  for (std::size_t k = kFirstBin; k <= kLastBin; ++k) {
    if (shareStandingOut(blocks, k) < kShare) continue;
    const bool is_near = !bins.empty() && k - bins.back() < kGuard;
    if (!is_near) {
      bins.push_back(k);
    } else if (medianMagnitude(blocks, k) > medianMagnitude(blocks, bins.back())) {
      bins.back() = k;
    }
  }
  return bins;
}

double magnitudeAt(const std::vector<double>& block, double frequency) {
  Complex sum = 0.0;
  for (std::size_t k = 0; k < block.size(); ++k)
    sum += block[k] * std::polar(1.0, -2.0 * kPi * frequency * static_cast<double>(k));
  return std::abs(sum);
}

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

std::vector<double> changesOf(const std::vector<double>& values) {
  std::vector<double> changes(values.size(), 0.0);
  for (std::size_t k = 1; k < values.size(); ++k) changes[k] = values[k] - values[k - 1];
  return changes;
}

std::vector<double> magnitudesOf(std::vector<double> values) {
  for (double& value : values) value = std::abs(value);
  return values;
}

/// Changes of current and of its magnitude around one sample: with both, charge and discharge have
/// resistances of their own.
struct Regressors {
  explicit Regressors(const Evidence& evidence)
      : shift(shiftOf(evidence)),
        current(changesOf(evidence.series.current)),
        size(changesOf(magnitudesOf(evidence.series.current))) {}

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
  std::vector<double> changes = changesOf(evidence.series.voltage);
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

LineSearch findSpectralLines(const std::vector<double>& values,
                             const std::vector<IndexRange>& ranges) {
  const std::vector<Block> blocks = transform(values, ranges);
  LineSearch search;
  search.blocks = blocks.size();
  if (blocks.size() < kLineBlocksMin) return search;
  for (const std::size_t bin : standingBins(blocks)) {
    const SpectralLine line = lineAt(blocks, bin);
    if (line.steadiness >= kSteadiness) search.lines.push_back(line);
  }
  std::sort(search.lines.begin(), search.lines.end(),
            [](const auto& a, const auto& b) { return a.amplitude > b.amplitude; });
  return search;
}

double amplitudeAt(const std::vector<double>& values, const std::vector<IndexRange>& ranges,
                   double frequency) {
  std::vector<double> amplitudes;
  forEachBlock(ranges, [&](std::size_t, std::size_t first) {
    amplitudes.push_back(2.0 / kWindowSum * magnitudeAt(windowed(values, first), frequency));
  });
  return quantile(std::move(amplitudes), 0.5);
}

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
      "the voltage contains a steady tone of " + number(frequency) + " Hz (amplitude " +
          twoDigits(1e3 * tone.amplitude) +
          " mV) that the current does not contain in proportion, in " +
          number(std::round(100.0 * tone.share)) + " % of " + counted(search.blocks, "block") +
          " of " + number(kLineBlock * evidence.interval) + " s" +
          (tones.size() > 1 ? "; " + counted(tones.size() - 1, "weaker tone") + " in addition"
                            : ""),
      "this is either ripple from above half the sampling rate, for instance of an alternator, "
      "that was aliased without an anti-alias filter, or a real load that switches at this rate "
      "and is not in the measured current; the recording cannot show which. Fits treat it as "
      "noise, and the lowest voltage of a crank is off by up to its amplitude",
      frequency, "Hz", static_cast<std::size_t>(std::lround(samples))}};
}

std::size_t evenBlocks(const Evidence& evidence) {
  std::size_t blocks = 0;
  for (const IndexRange& range : evenRanges(evidence)) blocks += range.size() / kLineBlock;
  return blocks;
}

}  // namespace battery_sof::check_parts
