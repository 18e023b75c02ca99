#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "recording/checks.hpp"
#include "recording/edges.hpp"
#include "recording/events.hpp"

/// The parts of checkRecording: each looks at one kind of fault and returns what it found, nothing
/// when all is well.
namespace battery_sof::check_parts {

/// One channel and what is known of it.
struct Channel {
  const char* name;  ///< "current" or "voltage"
  const char* unit;  ///< "A" or "V"
  const std::vector<double>& values;
  std::optional<double> step;  ///< of quantisation
  double noise = 0.0;          ///< standard deviation, at least step / sqrt(12)
  double lowest = 0.0, highest = 0.0;
  std::vector<double> limits = {};  ///< provenLimits()
};

/// What the parts share, computed once.
struct Evidence {
  /// @param recording of the series, for findings about what the intake refused.
  explicit Evidence(const Series& series, const Recording* recording = nullptr);

  const Series& series;
  const Recording* recording;
  double interval;                    ///< [s], median
  std::vector<IndexRange> stretches;  ///< between gaps
  Channel current, voltage;
  double largest_current;  ///< [A], magnitude
  std::optional<EdgeResponse> edges;
  bool excited;                          ///< the current changes by more than its noise
  bool fast;                             ///< sampled at 20 Hz or more
  double crank_current = kCrankCurrent;  ///< [A]
  std::size_t hold = 1;  ///< samples from one update of the current channel to the next
};

std::vector<Finding> findTimeUnit(const Evidence& evidence);
std::vector<Finding> findSlowRate(const Evidence& evidence);
std::vector<Finding> findUnevenRate(const Evidence& evidence);
std::vector<Finding> findHeldValues(const Evidence& evidence);
std::vector<Finding> findGaps(const Evidence& evidence);
std::vector<Finding> findClock(const Evidence& evidence);
std::vector<Finding> findRefused(const Evidence& evidence);
std::vector<Finding> findImpossibleTemperatures(const Evidence& evidence);
std::vector<Finding> findLost(const Evidence& evidence);

std::vector<Finding> findQuantisation(const Evidence& evidence);
std::vector<Finding> findClipping(const Evidence& evidence);
std::vector<Finding> findStuck(const Evidence& evidence);
std::vector<Finding> findRepeated(const Evidence& evidence);

std::vector<Finding> findSign(const Evidence& evidence);
std::vector<Finding> findSkew(const Evidence& evidence);
std::vector<Finding> findOffset(const Evidence& evidence);

std::vector<Finding> findAliasing(const Evidence& evidence);

std::vector<Finding> findDeepDischarge(const Evidence& evidence);
std::vector<Finding> findVoltageLevel(const Evidence& evidence);
std::vector<Finding> findExcitation(const Evidence& evidence);

/// What the evidence is not enough for, each with its reason.
std::vector<std::string> listNotJudged(const Evidence& evidence);

/// The samples after which the current channel is regularly updated; 1 when it is at every sample.
std::size_t updateInterval(const Evidence& evidence);

/// Blocks of evenly spaced samples in which tones can be looked for; needs edges.
std::size_t evenBlocks(const Evidence& evidence);

/// Up to ten times [s], evenly spread over all where something was found.
std::vector<double> someTimes(const std::vector<double>& times);
/// The same of the beginnings of ranges that are not empty.
std::vector<double> startsOf(const Evidence& evidence, const std::vector<IndexRange>& ranges);
std::size_t totalSamples(const std::vector<IndexRange>& ranges);

/// "3.325", "-250", "22603": four significant digits, and never an exponent for what is counted or
/// timed.
std::string number(double value);
/// "0.019", "20": two significant digits.
std::string twoDigits(double value);
/// "1 sample", "3 samples".
std::string counted(std::size_t count, const std::string& noun);

// ---------------------------------------------------------------------------------------------
// Where a channel's values are proven wrong, judged by what the other channel does meanwhile. The
// findings report these ranges, the fit mask leaves them out.

/// [s], from the first to the last sample of a range that is not empty.
double durationOf(const Evidence& evidence, IndexRange run);

/// @return those of the channel's lowest and highest value at which it is cut off.
std::vector<double> provenLimits(const Evidence& evidence, const Channel& channel);

/// Where the channel repeats one value while the other moves up and down three times or more, and
/// is not clipped.
std::vector<IndexRange> frozenRuns(const Evidence& evidence, const Channel& channel);

/**
 * @brief Where both channels repeat their values under load though both flicker: a message was
 * repeated, or the logger put in the last one.
 *
 * Under load is above 5 % of the largest current; at rest a battery and its sensor may stand still.
 * Claimed when independent channels would repeat so often together, anywhere in the recording, with
 * a probability of less than 0.001; needs noise on both, below 5 Hz of more than the quantisation.
 * What is clipped is not repeated.
 * @return ranges without the one sample that is a measurement, the first.
 */
std::vector<IndexRange> repeatedRuns(const Evidence& evidence);

// ---------------------------------------------------------------------------------------------
// tones

/// A tone in evenly sampled values.
struct SpectralLine {
  double frequency = 0.0;   ///< [cycles per sample], 0 to 0.5
  double amplitude = 0.0;   ///< in the unit of the values; median over the blocks
  double share = 0.0;       ///< of the blocks in which the line stands out
  double steadiness = 0.0;  ///< of the phase advance from block to block; 1 for a pure tone
};

/// What was looked at, and the lines in it.
struct LineSearch {
  std::size_t blocks = 0;
  std::vector<SpectralLine> lines;  ///< the greatest amplitude first
};

constexpr std::size_t kLineBlock = 256;    ///< samples in a block
constexpr std::size_t kLineBlocksMin = 8;  ///< with fewer no line is looked for

/**
 * @brief Narrow lines of steady phase, by short periodograms (Welch, blocks of 256 samples, linear
 * trend taken off, Hann window, no overlap).
 *
 * In noise that is white, or coloured smoothly over some 30 bins, a bin P of the periodogram is
 * exponentially distributed (chi-square of two degrees of freedom), so that its median is ln 2 of
 * its mean and
 *
 *     Pr{ P > median / ln 2 * ln(K / alpha) } = alpha / K
 *
 * with the median of the neighbouring bins, K bins in a block and alpha = 0.01, the probability of
 * a false positive anywhere in one block. A line exceeds that in four of five blocks or more; in
 * noise eight blocks do so with a probability below 1e-20. Its phase advances alike from block to
 * block: the mean of exp(i advance) has a magnitude of 0.8 or more, which excludes resonances and
 * loads that switch at irregular times.
 *
 * A tone must have about 0.6 standard deviations of white noise to be found. Bins below 8 and above
 * 120 (of 128) are not looked at: trends leak into the former, the mirror image into the latter.
 *
 * @param values  any unit.   @param ranges evenly sampled parts of values, in order.
 * @return no line when there are fewer than eight blocks. The frequency is known to a bin (1/256),
 * and far better where the line is not half-way between two.
 */
LineSearch findSpectralLines(const std::vector<double>& values,
                             const std::vector<IndexRange>& ranges);

/**
 * @brief Amplitude of the values at one frequency, from the same blocks.
 * @param frequency [cycles per sample], 0 to 0.5.
 * @return median over the blocks, with what noise and trends have there; 0 without a block.
 */
double amplitudeAt(const std::vector<double>& values, const std::vector<IndexRange>& ranges,
                   double frequency);

}  // namespace battery_sof::check_parts
