#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "recording/checks.hpp"
#include "recording/edges.hpp"

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
  bool excited;          ///< the current changes by more than its noise
  bool fast;             ///< sampled at 20 Hz or more
  std::size_t hold = 1;  ///< samples from one update of the current channel to the next
};

std::vector<Finding> findSlowRate(const Evidence& evidence);
std::vector<Finding> findUnevenRate(const Evidence& evidence);
std::vector<Finding> findHeldValues(const Evidence& evidence);
std::vector<Finding> findGaps(const Evidence& evidence);
std::vector<Finding> findClock(const Evidence& evidence);
std::vector<Finding> findRefused(const Evidence& evidence);
std::vector<Finding> findLost(const Evidence& evidence);

std::vector<Finding> findQuantisation(const Evidence& evidence);
std::vector<Finding> findClipping(const Evidence& evidence);
std::vector<Finding> findStuck(const Evidence& evidence);
std::vector<Finding> findRepeated(const Evidence& evidence);

std::vector<Finding> findSign(const Evidence& evidence);
std::vector<Finding> findSkew(const Evidence& evidence);
std::vector<Finding> findOffset(const Evidence& evidence);

std::vector<Finding> findAliasing(const Evidence& evidence);

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

/// A change of a channel over stride samples, in the channel's unit.
struct Move {
  std::size_t stride;
  double threshold;
};

/// Samples outside given ranges, and the share of them at which the channel turns round: 2/3 for
/// white noise, little for curves.
struct Flicker {
  std::size_t samples = 0;
  double turning = 0.0;
  double size = 0.0;  ///< median change
};

/// Least move of the channel that neither noise nor quantisation of either channel explains.
Move realMove(const Evidence& evidence, const Channel& channel);

const Channel& otherThan(const Evidence& evidence, const Channel& channel);

/// @return ranges between gaps in which one exact value repeats at least min_samples times.
std::vector<IndexRange> runsOf(const Evidence& evidence, const Channel& channel,
                               std::size_t min_samples);

/// [s], from the first to the last sample of a range that is not empty.
double durationOf(const Evidence& evidence, IndexRange run);

std::size_t totalSamples(const std::vector<IndexRange>& runs);

/**
 * @brief Where the channel is cut off at its lowest or highest value.
 *
 * The extreme repeats while the other channel turns round, so the true peak lies beyond; or it
 * repeats for longer than the channel's own noise would leave it unmoved, at most for 5 s at a
 * time, in several places or between steep flanks; or, for the current at slow rates, separate
 * samples share one extreme though those below it are scattered and the voltages differ. A value
 * that a source or a regulator holds is not found.
 * @param extreme the channel's lowest or highest value.
 */
std::vector<IndexRange> clippedRuns(const Evidence& evidence, const Channel& channel,
                                    double extreme);

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

/// @param runs in order.
Flicker flickerOutside(const Channel& channel, const std::vector<IndexRange>& runs);

/// Whether the channel turns round at most samples outside the runs, by more than quantisation and
/// rounding do.
bool isNoisyOutside(const Channel& channel, const Flicker& flicker);

}  // namespace battery_sof::check_parts
