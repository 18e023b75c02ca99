#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "battery_sof/series.hpp"

namespace battery_sof {

inline constexpr double kShortestStep = 1e-7;  ///< [s], in which nothing moves

/// A current held over the interval that ends at a sample.
struct HeldCurrent {
  double current = 0.0;   ///< [A]
  double duration = 0.0;  ///< [s]
};

/**
 * @brief The current a model is driven with between two neighbouring samples.
 *
 *     i_held = (i(n-1) + i(n)) / 2   within a recording; second order for a current linear between samples
 *     i_held = 0                     across a gap (duration > max_gap): the battery is taken to rest
 *
 * @param max_gap [s], see gapThreshold().
 */
inline HeldCurrent heldCurrent(double time_before, double current_before, double time,
                               double current, double max_gap) {
  const double duration = time - time_before;
  return {duration > max_gap ? 0.0 : 0.5 * (current_before + current), duration};
}

/**
 * @brief A measured current as a function of time: linear between samples, zero across gaps.
 *
 * Lets an effect ask for the current a little earlier or later than the sample.
 */
class CurrentTrace {
 public:
  CurrentTrace() = default;
  /// @param max_gap [s], see gapThreshold().
  CurrentTrace(const Series& series, IndexRange range, double max_gap);

  void append(double time, double current, double max_gap);
  /// Forgets samples before `time` but for the last of them.
  void forgetBefore(double time);

  double at(double time) const;  ///< [A]; the nearest end's value outside
  /// [A/s], of the segment that ends at or holds `time`; 0 outside
  double slopeAt(double time) const;
  double meanBetween(double from, double to) const;  ///< [A], from < to
  bool empty() const { return samples_.empty(); }

 private:
  struct Sample {
    double time, current;
    double charge;  // [As], since the first sample
    bool gap;       // the segment that ends here is one
  };
  /// @return the sample that ends the segment which holds a time; there are two samples at least.
  const Sample* endOfSegment(double time) const;
  double chargeUntil(double time) const;

  std::vector<Sample> samples_;
};

/// An interval of an input sequence and the sample that ends it.
struct InputStep {
  double time = 0.0;      ///< [s], of the sample
  double duration = 0.0;  ///< [s], since the sample before, >= 0
  /// [A], mean measured current over the interval; 0 across a gap
  double held = 0.0;
  /// [A], measured at the sample (mean over it where several were averaged)
  double current = 0.0;
  /// [A/s], of the measured current just before the sample; 0 across gaps and for means
  double slope = 0.0;
  /// [s], over which current and voltage are means, the sample's time in its middle; 0: one sample
  double span = 0.0;
  bool gap = false;  ///< the interval is longer than what may be joined
  /// [As], drawn by a crank of which the sampling saw too little; before the interval
  double missed = 0.0;
  const CurrentTrace* trace = nullptr;  ///< the measured current around the sample; may be absent

  /**
   * @brief Equal pieces, each under its mean current, in which the ramp of the current over the
   * interval is passed.
   *
   *     sqrt(k |di| |i| dt^2), rounded, 1 to 16
   *
   * One held mean misses beta |i| |di| dt^2 / (24 C_2^2) volts, a piece the square of their number
   * less; k is that over half a millivolt for a battery of Table I. At 100 Hz a crank is one piece,
   * at 1 Hz a charge that begins is six.
   */
  int rampPieces() const;
};

/// @return [s], over which the mean of evenly spaced samples is taken; 0 of one.
double meanSpan(double first_time, double last_time, std::size_t samples);

/// @return the step from one sample to the next; the first of a sequence has duration 0.
InputStep inputStep(double time_before, double current_before, double time, double current,
                    double max_gap);

/**
 * @brief What a slow sampling missed of a crank, sample by sample.
 *
 * A crank lasts half a second or less; of samples a second apart some cranks show none. A discharge
 * that drew as much as a crank and ended with a source's voltage ended with a crank, too: an engine
 * that was started. The crank's charge less what samples below EventLimits::engineTurns() showed of it is what was
 * missed.
 */
class MissedCrank {
 public:
  /// [As], of a crank; start-stop recordings: 60 to 250
  static constexpr double kCharge = 150.0;
  static constexpr double kSlowestSeen = 0.5;  ///< [s], between samples that see every crank

  /// @return [As], >= 0; above 0 only where the voltage is the input again.
  double add(double duration, double current, bool voltage_controlled);

 private:
  double drawn_ = 0.0, seen_ = 0.0;  // [As], of the discharge under way
};

/// One step with what was measured at its end.
struct InputSample {
  InputStep step;
  double voltage = 0.0;  ///< [V]
  /// samples averaged into this one; 0: not a measurement, an input of the simulation only
  double count = 1.0;
  /// a source controlled the voltage: it is the input, the current is compared
  bool voltage_controlled = false;
};

/// A stretch of a recording as a simulation goes through it.
struct InputSequence {
  std::vector<InputSample> samples;
  /// of the range at full rate; the samples' steps point to it
  std::shared_ptr<const CurrentTrace> trace;
  double first_time = 0.0;  ///< [s]
};

/// @return one InputSample a sample of the range, the first with duration 0.
/// @param masked one a sample of the series, 1: not a measurement (InstrumentLimits::masked); empty
/// for none.
/// @param voltage_controlled likewise, 1: the voltage is controlled there.
InputSequence inputSequence(const Series& series, IndexRange range,
                            const std::vector<char>& masked = {},
                            const std::vector<char>& voltage_controlled = {});

/// @return [s], above 0; 1 of fewer than two samples.
double medianDuration(const InputSequence& inputs);

inline constexpr double kLongestStretch = 0.5;  ///< [s], see compressedInputs()

/**
 * @brief An input sequence with stretches of nearly held current averaged into single samples; full
 * rate at edges.
 *
 * A stretch's mean current is the input from middle to middle, so its state represents the mean
 * of the state over the stretch; the error is (length / time constant)^2 / 24 of the state's
 * movement. A stretch holds no change of the current by more than 2 A and is at most a quarter of
 * the time since the last such change.
 *
 * @param longest [s], of a stretch.
 */
InputSequence compressedInputs(const Series& series, IndexRange range,
                               double longest = kLongestStretch,
                               const std::vector<char>& masked = {});

}  // namespace battery_sof
