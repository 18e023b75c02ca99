#pragma once

#include <optional>
#include <string>

#include "battery_sof/series.hpp"

namespace battery_sof {

/**
 * @brief Why the newest samples of a stream are no measurement: a channel that stands still where a
 * battery's cannot. Looks back from the last sample of the series only, so that it can be asked
 * again and again while samples arrive.
 *
 * - The voltage repeats one value while the current turns round three times. A battery whose
 *   terminals are held at one voltage takes a current that settles, it does not swing to and fro;
 *   each swing of di moves the voltage by r di, where r is at least 0.1 Ohm Ah / capacity (2 mOhm
 *   of 50 Ah). A swing counts where that is 2.5 steps of the voltage, and where it is above the
 *   current's noise and a twentieth of the capacity (the 20 h rate).
 * - The current repeats one value while the voltage turns round three times by more than 0.1 V a
 *   block. Under one current a battery's voltage relaxes, it does not swing.
 * - Both repeat their values under load for a minute and more, and for ten times as long as they
 *   ever did in the samples before, of which ten minutes under load must be there. Without such a
 *   past: for longer than twice the time in which the charge that flows moves the open-circuit
 *   voltage by one step (0.8 V of a block for a unit of state of charge, docs/physics.md#ocv_soc).
 *
 * At rest a battery and its sensor may stand still for as long as they like: a current below the 20
 * h rate is no load here.
 *
 * @param series of one block; the past that is kept.  @param capacity [Ah], nominal.
 * @param max_gap [s], longest interval that is joined.
 * @return one sentence without a full stop; none when nothing is frozen.
 */
std::optional<std::string> frozenChannels(const Series& series, double capacity, double max_gap);

/// Which channels have repeated one value under load for 5 s and 10 samples, up to the newest sample,
/// and the other one moved meanwhile: by itself that is no fault, but where a model begins to miss
/// the voltage at the same time the channel may be stuck.
struct RepeatingChannels {
  bool current = false, voltage = false;
};

/// @param series of one block.  @param capacity, max_gap as of frozenChannels().
RepeatingChannels repeatingChannels(const Series& series, double capacity, double max_gap);

}  // namespace battery_sof
