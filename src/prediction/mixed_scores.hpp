#pragma once

#include <optional>
#include <vector>

#include "baseline/baseline_predictor.hpp"

namespace battery_sof {

/// Mean current at the beginning of a charge, measured and predicted.
struct ChargeScore {
  double time = 0.0;                               ///< [s], of the charge's first sample
  double duration = 0.0;                           ///< [s], 10 or 60
  double measured = 0.0;                           ///< [A]
  double mean_voltage = 0.0, first_voltage = 0.0;  ///< [V]
  /// [A]; bounds are means of bounds, the value itself where none are given
  Interval predicted;
};

/// How a prediction in the mixed direction compares with what was measured.
struct MixedScores {
  std::optional<double> share_percent;          ///< both quantities together
  std::optional<double> current_share_percent;  ///< where the voltage is controlled
  std::optional<double> voltage_share_percent;  ///< where the current is controlled
  std::optional<double> current_rmse;           ///< [A], where the voltage is controlled
  std::vector<ChargeScore> charges;             ///< in the order of time, 10 s before 60 s
};

/**
 * @brief Scores in the mixed direction: each sample by the quantity that is not controlled there.
 *
 *     share = 1 - RMS error / spread,  the explained variation; spread: standard deviation measured
 *     combined = 1 - sqrt((sum e_i^2 / spread_i^2 + sum e_v^2 / spread_v^2) / n)
 *
 * A quantity with fewer than six samples has no share and adds no error to the combined one.
 * Charges are those of chargeBeginnings and beginningOfCharge: nine in ten samples of the first 10
 * s (60 s) have a controlled voltage; the others count as predicted exactly.
 *
 * @param voltage_controlled one a sample of series (ControlModes::voltage_controlled).
 * @return numbers that a quantity without prediction, or without spread, would enter are none.
 * @throws std::invalid_argument when sizes do not fit, or range is empty or outside the series.
 */
MixedScores scoreMixed(const Series& series, IndexRange range,
                       const std::vector<char>& voltage_controlled,
                       const MixedPrediction& predicted);

}  // namespace battery_sof
