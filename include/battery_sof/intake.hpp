#pragma once

#include <optional>
#include <string>

#include "battery_sof/series.hpp"

namespace battery_sof {

/// One instant as a sensor, file or message delivers it, before anything is believed of it. NaN
/// means not measured.
struct RawSample {
  double time = 0.0;                  ///< [s]
  double current = 0.0;               ///< [A], positive into the battery
  double voltage = 0.0;               ///< [V]
  std::optional<double> temperature;  ///< [K]
};

/// What became of an offered sample.
enum class SampleFate {
  kAccepted,
  kTemperatureOnly,  ///< no current and no voltage, but a temperature, which was kept
  kMissingValue,
  kNotFinite,
  kDuplicateStamp,
  kClockStepBack,
  kOutOfRange,
};

/// [A], above the short-circuit current of any 12 V starter battery
inline constexpr double kMaxCurrent = 5000.0;

/// Limits beyond which a value is not a measurement.
struct IntakeLimits {
  static constexpr double kMaxAbsCurrent = kMaxCurrent;  ///< [A]
  static constexpr double kMaxAbsVoltage = 100.0;  ///< [V], a 12 V sensor's full scale, ample room
  /// [s], the year 2286: milliseconds since 1970 are no seconds
  static constexpr double kMaxAbsTime = 1e10;
  /// [s], nearer stamps are one instant; the step of a stamp since 1970 is 2.4e-7 s
  static constexpr double kMinInterval = 1e-7;
  /// [K], -60 and 150 degrees Celsius: wider than the range of any sensor on a vehicle's battery
  static constexpr double kMinTemperature = 213.15, kMaxTemperature = 423.15;
};

/// Whether a temperature [K] can be a battery's.
inline bool isTemperature(double temperature) {
  return temperature >= IntakeLimits::kMinTemperature &&
         temperature <= IntakeLimits::kMaxTemperature;
}

/// @return why samples were refused, e.g. "10 duplicate stamp, 2 not finite"; empty without any.
std::string reasonsOf(const RejectedCounts& rejected);

/// @return how many were refused and why, e.g. "12 rejected (10 duplicate stamp, 2 not finite)".
std::string toString(const RejectedCounts& rejected);

/**
 * @brief The one gate through which samples enter, used by files, bags and the node alike.
 *
 * Refuses and counts; never repairs. A sample is refused when time, current or voltage is missing
 * or not finite, when its stamp is not after the last accepted one by IntakeLimits::kMinInterval
 * (nearer ones are duplicates), or when a stamp or value lies beyond IntakeLimits. A temperature
 * without current and voltage has a clock of its own: its stamp is judged against the last such
 * temperature. A temperature that none can be is refused and counted by itself; what it came with
 * is a sample all the same.
 */
class Intake {
 public:
  /// Judges one sample against the last accepted one and remembers it when accepted.
  SampleFate judge(const RawSample& sample);

  /// Forgets the last accepted stamp (a bag was looped, the clock was set); the counts stay.
  void forgetClock() { resumeAt(std::nullopt); }

  /// Puts the last accepted stamp back to an earlier one [s]; the counts stay.
  void resumeAt(const std::optional<double>& time);

  const RejectedCounts& rejected() const { return rejected_; }
  /// Temperatures that were refused; the samples they came with are not among rejected().
  std::size_t rejectedTemperatures() const { return rejected_temperatures_; }
  double largestStepBack() const { return largest_step_back_; }  ///< [s]

 private:
  SampleFate judgeOrder(double time, const std::optional<double>& last);
  void count(SampleFate fate);
  void countTemperature(const RawSample& sample);

  std::optional<double> last_time_;
  std::optional<double> last_temperature_time_;
  RejectedCounts rejected_;
  std::size_t rejected_temperatures_ = 0;
  double largest_step_back_ = 0.0;
};

/**
 * @brief Offers a sample to the intake, appends it to the recording when accepted, and keeps the
 * recording's counts.
 *
 * A temperature that comes with an accepted sample is dropped when a later temperature is already
 * there.
 * @throws std::invalid_argument when the intake accepts a time that is not after the recording's
 * last sample: intake and
 *   recording do not belong together, or the clock was forgotten without starting a new recording.
 */
SampleFate append(Recording& recording, Intake& intake, const RawSample& sample);

}  // namespace battery_sof
