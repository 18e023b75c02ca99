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

std::vector<Finding> findRate(const Evidence& evidence);
std::vector<Finding> findGaps(const Evidence& evidence);
std::vector<Finding> findClock(const Evidence& evidence);
std::vector<Finding> findMissing(const Evidence& evidence);

std::vector<Finding> findQuantisation(const Evidence& evidence);
std::vector<Finding> findClipping(const Evidence& evidence);
std::vector<Finding> findStuck(const Evidence& evidence);

std::vector<Finding> findSign(const Evidence& evidence);
std::vector<Finding> findSkew(const Evidence& evidence);
std::vector<Finding> findOffset(const Evidence& evidence);

std::vector<Finding> findAliasing(const Evidence& evidence);

std::vector<Finding> findVoltageLevel(const Evidence& evidence);
std::vector<Finding> findExcitation(const Evidence& evidence);

/// What the evidence is not enough for, each with its reason.
std::vector<std::string> listNotJudged(const Evidence& evidence);

/// Ranges in which the battery seems to rest: small, even current and a voltage that barely moves,
/// for a minute or more.
std::vector<IndexRange> apparentRests(const Evidence& evidence);

/// The samples after which the current channel is regularly updated; 1 when it is at every sample.
std::size_t updateInterval(const Evidence& evidence);

/// Blocks of evenly spaced samples in which tones can be looked for; needs edges.
std::size_t evenBlocks(const Evidence& evidence);

/// Median of the voltage [V].
double typicalVoltage(const Evidence& evidence);

/// Whether the voltage is that of a 12 V lead-acid block, the only one the limits here are meant
/// for.
bool isTwelveVoltBlock(const Evidence& evidence);

/// Up to ten times [s], evenly spread over all where something was found.
std::vector<double> someTimes(const std::vector<double>& times);

/// "3.325", "-250", "22603": four significant digits, and never an exponent for what is counted or
/// timed.
std::string number(double value);
/// "0.019", "20": two significant digits.
std::string twoDigits(double value);
/// "1 sample", "3 samples".
std::string counted(std::size_t count, const std::string& noun);

}  // namespace battery_sof::check_parts
