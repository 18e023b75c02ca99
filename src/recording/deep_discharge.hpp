#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "battery_sof/series.hpp"

namespace battery_sof {

/// A stretch in which a battery was discharged deeply.
struct DeepDischarge {
  double from = 0.0, to = 0.0;  ///< [s], first and last sample below the limit
  double lowest = 0.0;          ///< [V] of one block
  double current = 0.0;         ///< [A], at the lowest voltage
};

/**
 * @brief Finds where a battery is discharged deeply, sample by sample.
 *
 *     u < 10.5 V a block:   for 10 s while |i| <= 25 A,  or for 60 s whatever flows
 *
 * 10.5 V (1.75 V a cell) is where both capacity tests of a starter battery end: that with the 20 h
 * current and that of the reserve capacity with 25 A (EN 50342-1). At such currents the voltage is
 * that of the acid that is left, not of a resistance. A crank is below 10.5 V too, but it is of
 * hundreds of amperes and over in seconds; what holds a voltage down for a minute is no crank.
 */
class DeepDischargeDetector {
 public:
  static constexpr double kLimit = 10.5;  ///< [V] of one block

  /// @param sample later than the last one, its voltage that of one block.  @param max_gap [s],
  /// longest interval that is joined.
  /// @return whether the battery is found to be discharged deeply with this sample, and was not
  /// with the one before.
  bool add(const Sample& sample, double max_gap);
  /// Nothing is under way any more: the clock jumped.
  void forgetClock() { run_.reset(); }

  std::size_t count() const { return count_; }  ///< of stretches found
  const std::optional<DeepDischarge>& first() const { return first_; }
  const std::optional<DeepDischarge>& deepest() const { return deepest_; }
  double duration() const { return duration_; }  ///< [s], of all of them

  /// One sentence without a full stop, e.g. "the battery was discharged below 10.5 V at 410 s, for
  /// 95 s, down to 9.02 V at -2.1 A"; empty when it was not.
  std::string toString(double series_blocks) const;

 private:
  /// Samples below the limit, one after the other.
  struct Run {
    DeepDischarge stretch;
    double last = 0.0;   // [s]
    double quiet = 0.0;  // [s], under small currents
    bool is_quiet = false, is_deep = false;
  };

  void note(Run& run, double since);

  std::optional<Run> run_;
  std::size_t count_ = 0;
  std::optional<DeepDischarge> first_, deepest_;
  double duration_ = 0.0;  // [s]
};

/// The same of a whole recording. @param series of one block.
DeepDischargeDetector findDeepDischarges(const Series& series);

}  // namespace battery_sof
