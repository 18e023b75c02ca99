#pragma once

#include <optional>
#include <string>

#include "battery_sof/series.hpp"
#include "state/fitted_model.hpp"

namespace battery_sof {

/// What a stream says it is of.
struct StreamBattery {
  double capacity = kTypicalCapacity;  ///< [Ah], nominal
  double series_blocks = 1.0;          ///< 12 V blocks in series
};

/**
 * @brief Why a stream's samples support no valid answer at present, whatever the model. Three faults
 * that no model can make up for:
 *
 * - Most of it is refused: over the last ten minutes of the samples' stamps, the newer the more, the
 *   intake refused the values for more than half of the time; or it refused every one for longer
 *   than a gap, so that the state is of a time that is over.
 * - It is of another number of blocks: a block's voltage is above 16 V, or below 9 V (1.5 V a cell)
 *   while next to nothing flows (the 20 h rate). The first sample that can tell decides; from then
 *   on 10 s of samples that say otherwise, one after the other.
 * - A channel is frozen (frozenChannels()), looked at once a second; or it has repeated its value
 *   since a model missed the voltage (doubt()).
 */
class StreamWatch {
 public:
  explicit StreamWatch(const StreamBattery& battery = {}) : battery_(battery) {}

  void setCapacity(double capacity) { battery_.capacity = capacity; }  ///< [Ah]
  /// A sample whose values were refused, at a stamp that may be believed [s].
  void refuse(double time, double max_gap);
  /// An accepted sample, the voltage that of one block.
  void accept(const Sample& sample, double max_gap);
  /// The past that is kept, of one block, after samples were added to it.
  void look(const Series& series, double max_gap);
  /// A model misses the voltage that is measured: a channel that repeats its value at the same time
  /// (repeatingChannels()) is taken for stuck until it moves. Looked at once a second.
  void doubt(const Series& series, double max_gap);
  /// The clock jumped: stamps before it say nothing of those that come.
  void forgetClock();

  /// @param reasons of what was refused (reasonsOf()).
  /// @return one sentence without a full stop; none when nothing is wrong.
  std::optional<std::string> whyNotValid(const std::string& reasons) const;

 private:
  void pass(double time, double max_gap, bool is_refused);
  void judgeBlocks(const Sample& sample);
  std::optional<std::string> whyRefused(const std::string& reasons) const;
  std::optional<std::string> whyOtherBlocks() const;
  std::optional<std::string> whyDoubted() const;

  StreamBattery battery_;
  // [s] of stamps, faded by a factor of e in ten minutes
  double offered_ = 0.0, refused_ = 0.0;
  std::optional<double> last_;        // [s], stamp of the last sample, refused or not
  std::optional<double> last_taken_;  // [s], of the last accepted one
  double longest_joined_ = 5.0;       // [s]
  // whether the blocks' number fits; none before a sample could tell
  std::optional<bool> fits_;
  std::optional<double> otherwise_since_;  // [s], first sample in a row that says otherwise
  double voltage_ = 0.0;                   // [V] of a block, of the last sample that did not fit
  std::optional<double> looked_;           // [s]
  std::optional<std::string> frozen_;
  std::optional<double> doubted_current_, doubted_voltage_;  // [A], [V], values that are repeated
  std::optional<double> doubted_at_;                         // [s]
};

}  // namespace battery_sof
