#pragma once

#include <deque>
#include <optional>

#include "prediction/sample_stream.hpp"
#include "recording/control_mode.hpp"

namespace battery_sof {

/// Which share of the samples that are kept has a controlled voltage: judged over a recording at
/// once, then sample by sample.
class ChargerShare {
 public:
  /// Nothing is known of a source.
  ChargerShare() = default;
  /// A rule from an earlier run.
  explicit ChargerShare(const ControlModeRule& rule);
  /// Over a recording (detectControlMode()); goes on from its last sample.
  ChargerShare(const Series& series, const ControlModes& source);

  /// A sample later than the ones before.
  void add(const StreamSample& sample);
  /// Drops blocks of 10 s that end before `time` [s].
  void forgetBefore(double time);
  /// The clock jumped: nothing is kept.
  void forgetPast();

  bool seen() const { return seen_; }   ///< something charges the battery
  std::optional<double> share() const;  ///< [0, 1]; none where nothing was judged
  std::optional<double> until() const;  ///< [s], of the last sample

 private:
  struct Block {
    double from = 0.0, to = 0.0;  // [s]
    std::size_t samples = 0, controlled = 0;
  };
  void count(double time, bool controlled);

  bool seen_ = false;
  std::optional<ControlModeDetector> watch_;
  std::deque<Block> blocks_;
};

}  // namespace battery_sof
