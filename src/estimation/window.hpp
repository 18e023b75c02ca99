#pragma once

#include <optional>
#include <string>

#include "battery_sof/series.hpp"
#include "state/fitted_model.hpp"

namespace battery_sof {

struct WindowSamples;

/// Fewest samples that are fitted: five an unknown. Below that a fit follows its noise.
inline constexpr std::size_t kMinFitSamples = 30;

/// A window chosen, or the reason why there is none.
struct WindowChoice {
  std::optional<IndexRange> range;
  double excitation = 0.0;  ///< [0, 1]
  std::string message;      ///< one sentence: what was chosen and why, or what is missing
};

/**
 * @brief max(240 s, 900 sampling intervals): the paper's four minutes wherever the rate allows, and
 * at slow rates enough samples for six unknowns under strongly correlated residuals.
 */
double defaultWindowLength(const Series& series);

/**
 * @brief How well a window determines the parameters, from its current alone.
 *
 *     s = prod_j [ 0.05 / (0.05 + rel_j) ]^(1/4),   rel_j: predicted relative standard error of r_discharge, r_charge, c2, beta
 *
 * at the magnitudes of Table I with 10 mV of error correlated over 5 s. A parameter that is not
 * excited at all counts with 0.001 in place of its share, so a window without any charging stays
 * below 0.18.
 *
 * @return [0, 1]; 0 for fewer than 30 samples.
 */
double windowExcitation(const Series& series, IndexRange range);

/// The same of a window's samples, whatever their weights.
double windowExcitation(const WindowSamples& samples);

/**
 * @brief Chooses the best excited window of the wanted length without a gap inside; of windows
 * within 5 % of the best excitation, the latest, because the battery's state moves on.
 *
 * Where a window draws so much that a model of it answers for the largest discharge that was
 * searched (kCurrentReach), such a window is chosen, because an engine start is what most questions
 * are about; but for one whose excitation is less than 0.18 of the best, which is what a parameter
 * costs that is not excited at all.
 * @param searched samples that it lies in.  @param length [s]; none: defaultWindowLength().
 */
WindowChoice chooseWindow(const Series& series, IndexRange searched,
                          std::optional<double> length = std::nullopt);

/**
 * @brief How good predictions of a fitted window will be, from the window alone and before any
 * prediction.
 *
 *     s = 1 / (1 + e / 50 mV),   e = exp(-1.68) rmse^1.02 (max(excitation, 0.4) + 0.02)^-7.9
 *
 * e is the mean error of cranks over the recording that the window comes from, [V], as regressed on
 * 126 windows of nine simulated and three real stretches; how well it does on others:
 * docs/validation.md#windows-and-intervals.
 *
 * @param rmse of the fit over its window [V].  @param excitation windowExcitation().
 * @return [0, 1].
 */
double windowQuality(double rmse, double excitation);

/// @return what the samples of the range drove the battery through. @param max_gap [s],
/// gapThreshold(series) where that is known.
ExcitedRange excitedRange(const Series& series, IndexRange range,
                          std::optional<double> max_gap = std::nullopt);

}  // namespace battery_sof
