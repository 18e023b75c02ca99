#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "battery_sof/series.hpp"
#include "recording/events.hpp"

namespace battery_sof {

/// Which of the two quantities is given from outside; the other one is the battery's answer.
enum class ControlMode {
  kCurrent,  ///< loads, cranks, a charger at constant current, a rest without source
  kVoltage,  ///< an alternator, a DC-DC converter, a charger at constant voltage
};

/// What a sample's judgement rests on.
enum class ControlModeReason {
  kNoSource,         ///< nothing in the recording charges the battery or holds its voltage
  kLoad,             ///< the current is below the rule's least current
  kConstantCurrent,  ///< the current stayed within its noise while the voltage moved one way
  kRestApart,        ///< no current to speak of, and the voltage relaxes smoothly
  kChargeAsBefore,   ///< a charge of which nothing is known yet, in a recording whose charges begin
                     ///< with a controlled current
  kHeldVoltage,      ///< the voltage stayed while the current moved by more than it could without a
                     ///< source
  kSource,           ///< above the least current, and nothing speaks for a controlled current
};

/// @return the reason in words a reader can check, e.g. "current held within its noise while the
/// voltage moved".
std::string toString(ControlModeReason reason);

/**
 * @brief What a recording says of its source, enough to judge later samples one by one.
 *
 * A default-constructed rule knows no source: every sample's current is controlled.
 */
struct ControlModeRule {
  bool present = false;      ///< something charges the battery
  double min_current = 0.0;  ///< [A]; below it a load controls the current. Negative, as a source
  ///< may let the battery help out
  /// taken for a charge as long as nothing is known of it
  ControlMode charge_begins = ControlMode::kVoltage;
  double current_noise = 0.0;  ///< [A], standard deviation; at least what the channel's steps make
  double voltage_noise = 0.0;  ///< [V], the same, at least half a step
  std::optional<double> resistance;  ///< [Ohm], dv/di at edges of the current
  double max_gap = 5.0;  ///< [s]; what was known before a longer gap says nothing of what follows
};

/// [s], of a source's past that its judgement rests on
inline constexpr double kControlModeLookBack = 300.0;

/**
 * @brief Judges a stream sample by sample, without looking ahead.
 *
 * At or below the least current a load controls the current. Above it a source controls the
 * voltage, until the current stays in a band
 *
 *     max i - min i <= b_i = max(8 sigma_i, 0.5 % of i)
 *     while the voltage moves one way by max(10 sigma_v, 10 r (max i - min i))
 *
 * which no source of voltage does: the current is controlled, until
 *
 *     max v - min v <= max(8 sigma_v, 0.1 % of v)
 *     while i falls by more than b_i and by 2 max(max v - min v, 4 sigma_v) / r
 *
 * Both look at the stretch since the quantity last left its band; no step makes more than half of
 * the move. The band must be no more than 5 % of the current (i >= 160 sigma_i): an alternator
 * raises its voltage at a nearly constant current too, and a battery that takes nothing has a
 * constant current whoever controls the voltage. Where charges begin with a controlled voltage, a
 * constant current is over when the current leaves its band. At no current (3 sigma_i) a minute of
 * such a move is a rest apart from the source; where charges begin with a controlled current a fall
 * of the voltage out of its band is one too.
 *
 * @note A current that a source is given from outside and that changes all the time (hardware in
 * the loop) is known by the rule's charge_begins alone, which needs a recording. A source's current
 * limit is known once the voltage has risen.
 */
class ControlModeDetector {
 public:
  /// @throws std::invalid_argument for a rule that is not finite, or has a negative noise or gap.
  explicit ControlModeDetector(const ControlModeRule& rule);

  /**
   * @param time [s], after the sample before; an earlier one begins again.  @param current [A],
   * positive into the battery.
   * @param voltage [V].
   * @return whether the voltage is controlled.
   * @throws std::invalid_argument for a value that is not finite.
   */
  bool add(double time, double current, double voltage);

  ControlModeReason reason() const { return reason_; }  ///< of the last sample

  /// @return how many samples, the last one included, the last sample's evidence is about; 0 when
  /// it brought none.
  std::size_t evidenceReach() const { return reach_; }

 private:
  /// A stretch in which one quantity stayed within a band, and what the other one did meanwhile.
  struct Run {
    std::size_t samples = 0;
    double from = 0.0, last = 0.0;       // [s]; other quantity
    double lowest = 0.0, highest = 0.0;  // of the one that stayed
    double other_lowest = 0.0, other_highest = 0.0;
    double rise = 0.0, fall = 0.0, largest_step = 0.0;  // of the other one
    double spread() const { return highest - lowest; }
    /// @return whether it stayed; else a new stretch begins here.
    bool add(double time, double held, double other, double band);
  };

  void beginCharge();
  void follow(double time, double current, double voltage);
  bool movedOneWay() const;
  bool isConstantCurrent() const;
  bool isRestApart(double time) const;
  bool isHeldVoltage() const;
  double currentBand(double current) const;

  ControlModeRule rule_;
  ControlModeReason reason_ = ControlModeReason::kNoSource;
  std::size_t reach_ = 0;
  std::optional<double> last_time_;
  bool charging_ = false, voltage_fell_ = false;
  Run steady_current_, steady_voltage_;
};

/// Samples of one judgement.
struct ControlModeTotals {
  std::string reason;  ///< what the judgement rests on
  ControlMode mode = ControlMode::kCurrent;
  std::size_t stretches = 0, samples = 0;  ///< a stretch spans no gap
};

/// A stretch of time, from a sample to another.
struct ControlledTime {
  double from = 0.0, to = 0.0;  ///< [s]
};

/// Operating mode in a recording, as a reader needs it; times in place of indices.
struct ControlModeOverview {
  bool seen = false;                      ///< something charges the battery
  double share = 0.0;                     ///< of the samples whose voltage is controlled [0, 1]
  std::string summary;                    ///< one or two sentences
  std::vector<ControlModeTotals> totals;  ///< one a reason, in alphabetical order
  /// in which the voltage is controlled, in order: from a stretch's first sample to the first one
  /// behind it, or to its last one before a gap and at the end; neighbours are one
  std::vector<ControlledTime> times;
};

/// Operating mode in a recording.
struct ControlModes : ControlModeOverview {
  std::vector<char> voltage_controlled;  ///< one a sample; 1 where the voltage is controlled
  ControlModeRule rule;
};

/**
 * @brief Operating mode, from current and voltage alone, at any rate.
 *
 * A source is there when a hundredth of all charge flows into the battery above the noise (3
 * sigma_i), or a block's voltage stands above 13.5 V for 300 s, undischarged. A driven current is
 * well posed while its error in the voltage is below the voltage's noise. In discharge the double
 * layer's resistance is 1 / (beta |i|): noise sigma_i is worth sigma_v at sigma_i / (beta sigma_v):
 *
 *     min_current = -(3 sigma_i + sigma_i / (beta sigma_v)),   beta = 35 / V
 *
 * beta is that of start-stop cars' batteries (22 to 56 were seen). Where charges begin with a
 * controlled voltage the battery helps the source out at times: there it is at most -0.2 of the
 * 95 % quantile of |current|: on three recordings of start-stop cars the engine runs in 99 to 99.9
 * % of the samples above it, and in some of those below. Where discharges answer to small changes
 * of current by less than half of what they answer to large ones, the voltage is held there too and
 * the least current moves down to a crank's level (EventLimits::crankLevel()).
 *
 * Charges begin with a controlled current when half of them show constant current, or when changes
 * of voltage follow those of current in charges (r^2 of 0.9 and more), as in a profile that is
 * played to a battery. Each sample is then judged by ControlModeDetector; a judgement reaches back
 * over the stretch that proves it.
 *
 * @param series any sampling.
 * @return nothing seen for an empty series.
 * @note One source a recording: driving followed by a night at a charger has one rule for both.
 */
ControlModes detectControlMode(const Series& series, const EventLimits& limits = {});

/// @return "voltage" or "current".
std::string toString(ControlMode controlled);

/// @return judgements summed up. @param reasons one a sample.
ControlModeOverview overviewOf(const Series& series, const std::vector<ControlModeReason>& reasons,
                               const ControlModeRule& rule);

}  // namespace battery_sof
