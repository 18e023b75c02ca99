#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "battery_sof/series.hpp"
#include "recording/events.hpp"

namespace battery_sof {

/// What counts as an engine start in a recording, and who says so.
struct CrankCurrent {
  enum class Source { kGiven, kRecording, kUsual };
  double current = kCrankCurrent;  ///< [A]; a crank falls to this or below
  Source source = Source::kUsual;
  /// [A], below 0: the depth of the recording's largest repeated pulses, where they were read
  std::optional<double> pulse = std::nullopt;
};

/// @return "given", "recording" or "usual".
std::string toString(CrankCurrent::Source source);

/**
 * @brief The current that tells an engine start from other loads, read off a recording.
 *
 *     crank_current = -150 A                     where half of the recording's pulses reach it
 *                     -min(150 A, 0.6 p)         else
 *
 * p is the third deepest of the pulses, or the shallowest where there are fewer. A pulse is a
 * discharge of 5 s at most that the voltage answers to by 1 V a block, as it does to a starter and
 * hardly to a consumer, and that stands clear of the ordinary load: it is twice as deep as nine
 * samples in ten, and of 60 A. A starter draws about 0.6 of its first rush while it turns the
 * engine.
 *
 * @param series of one block.
 * @return the usual kCrankCurrent also where no pulse is found, where pulses of 5 s fall between
 * samples, and where the ordinary load is itself beyond 75 A.
 */
CrankCurrent findCrankCurrent(const Series& series);

/// @return the given current [A], else findCrankCurrent(). @throws std::invalid_argument when it is
/// not finite and below zero.
CrankCurrent crankCurrentOf(const Series& series, std::optional<double> given);

}  // namespace battery_sof
