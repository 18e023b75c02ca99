#pragma once

#include <optional>

#include "estimation/identification.hpp"
#include "estimation/window.hpp"

namespace battery_sof {

/// Options of an identification of a recording, for the command and for whoever links the core.
struct FitRequest {
  std::optional<double> from;   ///< [s], recording's clock; none: its first sample
  std::optional<double> to;     ///< [s]; none: its last sample
  bool chooses_window = false;  ///< the best window inside from..to even where both are given
  /// masked, voltage_lsb_std and source are found from the recording.
  IdentifyOptions options;
};

/// What is fitted, and how.
struct FitPlan {
  WindowChoice window;  ///< without a range there is nothing to fit; its message says why
  /// with what the recording says of its instrument and of operating mode
  IdentifyOptions options;
};

/**
 * @brief The window and the settings of a fit: the whole of from..to where both are given, else the
 * best window inside (chooseWindow()); clipped samples are masked (instrumentLimits()), a source
 * is the input where one is seen (chargerControl(); not with FitStart::kPaper).
 *
 * @param series at the rate to fit at, see atDesignRate(); not empty.
 * @throws std::invalid_argument when there is no sample from `from` to `to`.
 */
FitPlan planFit(const Series& series, const FitRequest& request);

/**
 * @brief Fits what was planned (identify()) and describes its errors (fitErrors()).
 * @return the model with its state at the window's last sample; FitStatus::kNotExcited for a plan
 * without a window.
 */
FittedModel fitPlanned(const Series& series, const FitPlan& plan);

/// Carries a usable model's state to the request's end. @param series as planned with.
void carryToEnd(FittedModel& model, const Series& series, const FitRequest& request);

/// @return samples from `from` to `to` [s], the recording's ends where there is none.
/// @throws std::invalid_argument when the series has none there (the message says what it has) and
/// for a time that is not finite.
IndexRange samplesBetween(const Series& series, std::optional<double> from,
                          std::optional<double> to);

}  // namespace battery_sof
