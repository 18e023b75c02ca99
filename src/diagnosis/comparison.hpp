#pragma once

#include <optional>
#include <vector>

#include "battery_sof/series.hpp"
#include "diagnosis/diagnosis.hpp"
#include "recording/events.hpp"
#include "state/fitted_model.hpp"

namespace battery_sof {

/**
 * @brief How well a modelled voltage follows the measured one, by the measures of
 * scorePrediction().
 *
 * Cranks and charges: detectEvents() over the range. charge_bias counts every sample of a charge
 * alike.
 *
 * @param modelled [V], one a sample of the series.
 * @param masked one a sample of the series, 1: not a measurement; empty for none. Left out
 * everywhere.
 * @return q_dyn_percent is 0 when the measured voltage never changes; chargeCurrentError() and
 * shares are not in it.
 * @throws std::invalid_argument when sizes differ or nothing is left in the range.
 */
ErrorMetrics errorMetrics(const Series& series, IndexRange range,
                          const std::vector<double>& modelled, const std::vector<char>& masked = {},
                          const EventLimits& limits = {});

/**
 * @brief Every regime's RMS error before and after, in the order of Regime, those that occur.
 *
 * Interval: 2.5 and 97.5 % of the change over 999 draws of blocks of time with replacement; both
 * models see the same draw. A block lasts a thirtieth of the range, 10 to 60 s: a mismatch of
 * minutes makes it somewhat too narrow. The draws are seeded.
 *
 * @param base, extended [V], one a sample of the series.  @param masked as in errorMetrics().
 * @throws std::invalid_argument when sizes differ.
 */
std::vector<RegimeComparison> compareRegimes(const Series& series, IndexRange range,
                                             const std::vector<double>& base,
                                             const std::vector<double>& extended,
                                             const std::vector<char>& masked = {},
                                             const EventLimits& limits = {});

/**
 * @brief What a model's current at the measured voltage is off by, over the charges of a range.
 *
 *     mean over windows of 10 s of | mean i_m - mean i_b |,   u_m(t; i_m) = u_b(t) from the charge's first sample on
 *
 * The state is carried to the charge by the measured current, without a look at the voltage. A
 * window takes the remainder of a charge shorter than it, but at least 1 s; windows count by their
 * length. Voltages of samples nearer than 0.1 s are averaged.
 *
 * @param model  its state, or, for a range that begins earlier, its first state: where the simulation begins.
 * @return [A]; none without a charge, or when the model begins later than the range.
 */
std::optional<double> chargeCurrentError(const FittedModel& model, const Series& series,
                                         IndexRange range, const std::vector<char>& masked = {});

}  // namespace battery_sof
