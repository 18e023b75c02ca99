#pragma once

#include <optional>
#include <string>

#include "battery_sof/series.hpp"

namespace battery_sof {

/// One sample as a sensor, file or message delivers it, not yet validated. NaN means that the value
/// was not measured.
struct RawSample {
  double time = 0.0;                  ///< [s]
  double current = 0.0;               ///< [A], positive into the battery
  double voltage = 0.0;               ///< [V]
  std::optional<double> temperature;  ///< [K]
};

/// Outcome of validating a sample.
enum class SampleFate {
  kAccepted,
  kTemperatureOnly,  ///< neither current nor voltage, but a temperature, which was kept
  kMissingValue,
  kNotFinite,
  kDuplicateStamp,
  kClockStepBack,
  kOutOfRange,
};

/// [A], larger than the short-circuit current of any 12 V starter battery
inline constexpr double kMaxCurrent = 5000.0;

/// Limits beyond which a value cannot be a measurement.
struct IntakeLimits {
  static constexpr double kMaxAbsCurrent = kMaxCurrent;  ///< [A]
  static constexpr double kMaxAbsVoltage = 100.0;  ///< [V], well above a 12 V sensor's full scale
  /// [s], the year 2286; detects stamps in milliseconds since 1970
  static constexpr double kMaxAbsTime = 1e10;
  /// [s], closer stamps are duplicates; a double holds a stamp since 1970 to 2.4e-7 s
  static constexpr double kMinInterval = 1e-7;
  /// [K], -60 and 150 degrees Celsius: wider than the range of any sensor on a vehicle's battery
  static constexpr double kMinTemperature = 213.15, kMaxTemperature = 423.15;
};

/// Whether a battery can have this temperature [K].
inline bool isTemperature(double temperature) {
  return temperature >= IntakeLimits::kMinTemperature &&
         temperature <= IntakeLimits::kMaxTemperature;
}

/// @return why samples were refused, e.g. "10 duplicate stamp, 2 not finite"; empty if none was.
std::string reasonsOf(const RejectedCounts& rejected);

/// @return how many were refused and why, e.g. "12 rejected (10 duplicate stamp, 2 not finite)".
std::string toString(const RejectedCounts& rejected);

/**
 * @brief Validates every sample, whether it comes from a file, a bag or a topic.
 *
 * Invalid samples are refused and counted, never repaired. A sample is refused if its time, current
 * or voltage is missing or not finite, if its stamp is not at least IntakeLimits::kMinInterval
 * after the last accepted one (closer ones are duplicates), or if a stamp or value lies beyond
 * IntakeLimits. A temperature without current and voltage has a clock of its own, so its stamp is
 * compared with that of the last such temperature. An impossible temperature is refused and counted
 * separately, while the sample that it came with is used.
 */
class Intake {
 public:
  /// Compares one sample with the last accepted one, and stores its stamp if it is accepted.
  SampleFate judge(const RawSample& sample);

  /// Forgets the last accepted stamp, e.g. when a bag is looped; the counts stay.
  void forgetClock() { resumeAt(std::nullopt); }

  /// Sets the last accepted stamp back to an earlier one [s]; the counts stay.
  void resumeAt(const std::optional<double>& time);

  const RejectedCounts& rejected() const { return rejected_; }
  /// Number of refused temperatures; the samples that they came with are not in rejected().
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
 * @brief Validates a sample, appends it to the recording if it is accepted, and updates the
 * recording's counts.
 *
 * A temperature that comes with an accepted sample is dropped if the recording already has a later
 * one.
 * @throws std::invalid_argument if the intake accepts a time that is not after the recording's last
 * sample. In that case intake and recording do not belong together, or the clock was forgotten
 * without starting a new recording.
 */
SampleFate append(Recording& recording, Intake& intake, const RawSample& sample);

}  // namespace battery_sof
