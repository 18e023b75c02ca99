#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "battery_sof/series.hpp"

namespace battery_sof {

enum class EventKind { kCrank, kDischarge, kCharge, kRest };

/// @return "crank", "discharge", "charge" or "rest".
std::string toString(EventKind kind);

/// [A]; a crank falls to this or below, where nobody says otherwise (paper, section V: pulses and
/// weighting). What a recording shows of its own engine is findCrankCurrent()'s.
inline constexpr double kCrankCurrent = -150.0;

/// Limits that distinguish events. Every current of a crank is a share of one value.
struct EventLimits {
  double crank_current = kCrankCurrent;             ///< [A]; a crank falls to this or below
  static constexpr double kCrankMaxDuration = 5.0;  ///< [s]; longer stretches are discharges
  static constexpr double kRestCurrent = 0.5;       ///< [A]; |current| below it is rest
  double crankLevel() const { return 0.5 * crank_current; }  ///< [A]; a crank goes on below it
  /// [A]; an engine may be turning below it: what a slow sampling shows of a crank
  double engineTurns() const { return 0.4 * crank_current; }
  /// [A]; more than a vehicle's consumers draw
  double aboveConsumers() const { return crank_current / 3.0; }
};

/// [A]; below it a discharge is under way that a charge may follow
inline constexpr double kDischargeCurrent = -10.0;

/// Whether a current is that of a stop: a load draws it that no charger helps out with, and it is
/// no crank's. @param min_current [A], below it a load controls the current (ControlModeRule).
bool isStopLoad(double current, double min_current, const EventLimits& limits = {});

/**
 * @brief Where cranks, charges and stops begin and end, sample by sample: of a recording as live.
 *
 *     crank   samples at or below half of crank_current that follow each other without a gap, one
 *             of them at or below it, no longer than kCrankMaxDuration
 *     charge  begins above 2 A; where a source may control the voltage, above 0 A after less than
 *             -10 A, at the first sample whose voltage is controlled (denyCharge())
 *     stop    begins with the first isStopLoad() behind a sample that is none
 */
class EventDetector {
 public:
  explicit EventDetector(const EventLimits& limits = {}) : limits_(limits) {}

  /// Moves on to a sample. @param is_gap behind the one before. @param min_current [A], of the
  /// source (isStopLoad()); none without a source: stops are not looked for.
  void add(double time, double current, bool is_gap = false,
           std::optional<double> min_current = std::nullopt);
  /// The newest sample's voltage is not controlled: a charge that would have begun may begin later.
  void denyCharge() { discharged_ = discharged_ || charge_begins_; }
  /// Begins behind a sample: what is under way there does not begin.
  void beginBehind(double current);

  bool isAtCrankLevel() const { return crank_since_.has_value(); }
  /// At crank level, and not for too long yet.
  bool mayBeCrank() const {
    return crank_since_ && crank_until_ - *crank_since_ <= limits_.kCrankMaxDuration;
  }
  /// The sample before was a crank's last.
  bool crankEnded() const { return crank_ended_; }
  bool chargeBegins() const { return charge_begins_; }
  bool isCharging() const { return charging_; }  ///< above 2 A
  bool stopBegins() const { return stop_begins_; }
  bool isInStop() const { return in_stop_; }

 private:
  EventLimits limits_;
  std::optional<double> crank_since_;              // [s], first sample at crank level
  double crank_until_ = 0.0, crank_lowest_ = 0.0;  // [s], [A]
  bool crank_ended_ = false, charge_begins_ = false, stop_begins_ = false;
  bool charging_ = false, discharged_ = false, in_stop_ = false;
  bool may_stop_ = false;  // the sample before was none of a stop
};

/// A stretch of one kind of load. Ranges of neighbouring events do not overlap; every sample
/// belongs to one event.
struct Event {
  EventKind kind = EventKind::kRest;
  IndexRange range;
  double from = 0.0;          ///< [s], time of the first sample
  double to = 0.0;            ///< [s], time of the last sample
  double peak_current = 0.0;  ///< [A], the value of largest magnitude
  double charge = 0.0;        ///< [As], trapezoidal; positive into the battery
  double min_voltage = 0.0;   ///< [V]
  double max_voltage = 0.0;   ///< [V]
  double duration() const { return to - from; }
};

/**
 * @brief Cuts a series into cranks, discharges, charges and rests.
 *
 * Cranks are those of EventDetector. The rest of the samples is cut by the sign of the current with
 * kRestCurrent as dead band. Events never span a gap (gapThreshold).
 *
 * @throws std::invalid_argument when crank_current is not finite and below zero.
 */
std::vector<Event> detectEvents(const Series& series, const EventLimits& limits = {});

/**
 * @brief The cranks alone, as detectEvents() finds them in slice(series, range); for those who ask
 * for nothing else.
 *
 * @param range of the series; the events' ranges are the series' too.
 * @throws as detectEvents().
 */
std::vector<Event> detectCranks(const Series& series, IndexRange range,
                                const EventLimits& limits = {});

/// How often one kind of event happened and how long in all.
struct EventTotals {
  std::size_t count = 0;
  double duration = 0.0;  ///< [s]
};

/// What happened in a series, added up. An event lasts until the next one begins, or to its last
/// sample before a gap.
struct EventSummary {
  std::array<EventTotals, 4> totals;  ///< in the order of EventKind
  double charge_in = 0.0;             ///< [As], what flowed into the battery; gaps count nothing
  double charge_out = 0.0;            ///< [As], negative, what flowed out of it
  double longest_charge = 0.0;        ///< [s]
  std::size_t long_charges = 0;       ///< charges longer than 10 s
  std::optional<double> min_charge_voltage, max_charge_voltage;  ///< [V], none without a charge
  EventTotals& of(EventKind kind) { return totals[static_cast<std::size_t>(kind)]; }
  const EventTotals& of(EventKind kind) const { return totals[static_cast<std::size_t>(kind)]; }
};

/// @return the totals of the events that detectEvents found in series.
EventSummary summarise(const Series& series, const std::vector<Event>& events);

/**
 * @brief Where charges begin: the first sample above 0 A with a controlled voltage after the
 * current was below kDischargeCurrent.
 *
 * @param voltage_controlled one a sample of series (ControlModes::voltage_controlled).
 * @return indices into series, rising, all in range; what was before range is not looked at.
 * @throws std::invalid_argument when the mask's size differs from the series' or range lies outside
 * it.
 */
std::vector<std::size_t> chargeBeginnings(const Series& series, IndexRange range,
                                          const std::vector<char>& voltage_controlled);

/// Least share of a charge's beginning in which its voltage is controlled.
inline constexpr double kMinControlled = 0.9;

/// [s], over which a charge is compared from its beginning on.
inline constexpr double kComparedSpans[] = {10.0, 60.0};

/**
 * @brief The samples of the first duration [s] of a charge that begins at sample `first`.
 *
 * Sample k represents the time from time[k] on, so that at 1 Hz ten seconds are ten samples.
 * @return none when range ends earlier, when fewer than kMinControlled of the samples that belong there have
 * a controlled voltage, or when sampling is slower than three samples in duration.
 */
std::optional<IndexRange> beginningOfCharge(const Series& series, IndexRange range,
                                            std::size_t first, double duration,
                                            const std::vector<char>& voltage_controlled);

}  // namespace battery_sof
