#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "battery_sof/series.hpp"
#include "model/input_sequence.hpp"
#include "recording/events.hpp"

namespace battery_sof {

/// What a battery is doing (docs/physics.md#regimes).
enum class Regime {
  kEdge,
  kCrank,
  kLongCharge,
  kHighVoltageCharge,
  kShortCharge,
  kLongDischarge,
  kDischarge,
  kPostChargeRest,
  kPostDischargeRest,
  kFirstRest,
};
inline constexpr std::size_t kRegimes = 10;

/// @return "edge", "crank", "long charge", "high-voltage charge", "short charge", "long discharge",
/// "discharge",
///   "post-charge rest", "post-discharge rest", "rest before any load".
std::string regimeName(Regime regime);

/**
 * @brief Regime of every sample; the first that holds:
 *
 * | regime | a sample |
 * |---|---|
 * | edge | a change of the current by more than 30 A within 0.15 s to both sides; else behind it |
 * | crank | below EventLimits::crank_current; before edge where samples are farther apart than 0.15 s |
 * | long charge | of a charge that lasts longer than 10 s at more than 2 A on average |
 * | high-voltage charge | of a charge at more than 13.8 V on average |
 * | short charge | of any other charge |
 * | long discharge | of a discharge longer than 20 s |
 * | discharge | of any other discharge |
 * | post-charge rest, post-discharge rest | by the last load before it that moved more than 1 As |
 * | rest before any load | of a rest that no such load comes before |
 *
 * Charge, discharge and rest are runs: a load begins beyond 0.5 A (EventLimits), or beyond 2 % of
 * the largest current where that is less, and ends below half of that, so that noise does not cut
 * it up; a crank or a gap ends it. Voltages of 12 V blocks.
 */
std::vector<Regime> regimesOf(const InputSequence& inputs, const EventLimits& limits = {});

/// The same of a series, one a sample of the range; by its compressed inputs, whose means have less
/// noise.
std::vector<Regime> regimesOf(const Series& series, IndexRange range,
                              const EventLimits& limits = {});

/// @throws std::invalid_argument unless there are as many regimes, and samples that were fitted, as
/// inputs; the message names the function.
void requireOneSize(const char* function, const InputSequence& inputs,
                    const std::vector<Regime>& regimes, std::size_t fitted);

/// A run of samples of one regime.
struct Episode {
  Regime regime;
  IndexRange range;  ///< samples of the inputs
};

/// @return runs of one regime, in order; a gap ends one.
std::vector<Episode> episodesOf(const InputSequence& inputs, const std::vector<Regime>& regimes);

}  // namespace battery_sof
