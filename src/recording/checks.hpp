#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "battery_sof/series.hpp"
#include "recording/crank_current.hpp"

namespace battery_sof {

/// How much a finding restricts the use of a recording.
enum class Severity {
  kNote,     ///< a property worth knowing
  kWarning,  ///< results are affected; the meaning says how
  kProblem,  ///< this recording cannot answer the usual questions as it is
};

/// One thing found in a recording, and what it means to somebody who is to use it.
struct Finding {
  /// rate, gaps, clock, missing, clipping, quantisation, sign, offset, skew, stuck, aliasing,
  /// voltage_level, deep_discharge, time_unit, excitation, temperature
  std::string id;
  Severity severity = Severity::kNote;
  std::string what;             ///< what was found, with numbers and units
  std::string meaning;          ///< what follows from it
  std::optional<double> value;  ///< the finding's number, in the unit `unit` names
  std::string unit = {};
  std::size_t samples = 0;      ///< samples concerned
  std::vector<double> at = {};  ///< [s], up to ten times where it was found
};

/// Everything the lint found; the order is the order in which a reader should learn it.
struct CheckReport {
  std::size_t samples = 0;
  double from = 0.0;                    ///< [s]
  double to = 0.0;                      ///< [s]
  double median_interval = 0.0;         ///< [s]
  std::optional<double> voltage_lsb;    ///< [V], step of the voltage channel when quantised
  std::optional<double> current_lsb;    ///< [A], step of the current channel when quantised
  std::vector<Finding> findings;        ///< problems first, then warnings, then notes
  std::vector<std::string> not_judged;  ///< what this recording cannot show, each with its reason
  CrankCurrent crank;                   ///< what counts as an engine start
};

/// @return "note", "warning" or "problem".
std::string toString(Severity severity);

/**
 * @brief Lints a recording: rate, gaps, clock, missing values, clipping, quantisation, sign,
 * offset, skew, stuck values, aliasing, voltage level and excitation.
 *
 * Methods (docs/physics.md#instruments). A fault is named on its own evidence only:
 * - clipping: an extreme value repeats while the other channel moves both ways, as it does through
 *   a crank whose peak is cut off; or it repeats, where the channel flickers elsewhere, for longer
 *   than its own noise would leave it unmoved (chance below 0.001 in the whole recording, faster
 *   than 5 Hz); or, for single samples at slow rates, the extreme stands out from scattered values
 *   below it. A current that a source holds at its limit, and a voltage that a regulator holds, are
 *   not clipped.
 * - quantisation: the greatest step of which nearly all changes are multiples.
 * - time_unit: more charge moves one way than any 12 V block holds (a problem), or, in rows of 2 s or
 *   more, a discharge has the course of an engine start and lasts longer than a starter may turn, as
 *   it does where milliseconds are read as seconds (a warning).
 * - sign: that of the correlation of voltage with current changes at edges.
 * - offset: one small current at every apparent rest. A consumer looks the same: always a note.
 * - skew: the sub-sample shift between voltage and current changes at edges, alike in both halves
 *   of the recording; whole samples only below 20 Hz.
 * - stuck: one value repeats while the other channel moves up and down, or repeats for long where
 *   the channel is noisy elsewhere; or both channels repeat the sample before under load where both
 *   flicker.
 * - missing: samples that the intake refused, and samples that a regular grid lacks in 20 places or
 *   more. A gap in which the logger was off is not missing.
 * - aliasing: a steady tone (findSpectralLines) in the voltage less its regression on the changes
 *   of current, of more than 1 mV and half the noise, and of more than twice what the resistance at
 *   edges makes of the current at its frequency. It can also be a real load that is not in the
 *   measured current. What the regression leaves hides weak tones: at 100 Hz some 2 mV are found,
 *   at 1 Hz 80 mV.
 *
 * @param crank_current [A], below 0; else findCrankCurrent().
 * @throws std::invalid_argument when the recording has no sample.
 * @note A common gain of the current, gain and offset of the voltage, and a constant contact
 * resistance leave no trace in current and voltage: nothing here can find them.
 */
CheckReport checkRecording(const Recording& recording,
                           std::optional<double> crank_current = std::nullopt);

/**
 * @brief The problems alone of a series: what it must not be fitted with unless somebody means it.
 *
 * Voltage level, sign, time unit and excitation of checkRecording().
 * @return nothing for an empty series.
 */
std::vector<Finding> findProblems(const Series& series);
/// The same of a recording: also that most of it was beyond anything a battery sensor shows.
std::vector<Finding> findProblems(const Recording& recording);

/// @return each problem with what follows from it, joined by "; "; empty for none.
std::string format(const std::vector<Finding>& problems);

}  // namespace battery_sof
