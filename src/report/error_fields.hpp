#pragma once

#include "state/fitted_model.hpp"
#include "util/text.hpp"
#include "yaml_fields.hpp"

namespace battery_sof {

// The section `errors` of MODEL.yaml, described for both directions (yaml_fields.hpp).

template <typename File, typename Calibration>
void describeCalibration(File& file, const char* key, Calibration& calibration) {
  file.map(
      key,
      [&](auto& one) {
        one.number("factor", calibration.factor);
        one.count("events", calibration.events);
        one.count("inside", calibration.inside);
        one.require(calibration.factor > 0.0 && calibration.factor <= 1e6 &&
                        calibration.events >= calibration.inside,
                    "factor", "must be above 0, with events >= inside >= 0");
      },
      MapStyle::kFlow);
}

template <typename File, typename Residual>
void describeResidual(File& now, Residual& d) {
  now.number("drift_v", d.drift, kVoltages);
  now.number("colored_v", d.colored, kVoltages);
  now.row("covariance_v2", d.p_dd, d.p_da, d.p_aa);
  constexpr double kMaxVariance = 1e4;  // [V^2]
  now.require(d.p_dd >= 0.0 && d.p_dd <= kMaxVariance && d.p_aa >= 0.0 && d.p_aa <= kMaxVariance &&
                  d.p_da * d.p_da <= d.p_dd * d.p_aa * (1.0 + kSame) + 1e-24,
              "covariance_v2",
              format("is [%g, %g, %g], expected variance of the drift, covariance, variance of the "
                     "colored part",
                     d.p_dd, d.p_da, d.p_aa));
}

/// What it misses at the present load, and how far such errors missed later voltages.
template <typename File, typename Present>
void describePresent(File& file, Present& present) {
  file.number("current_a", present.current, kCurrents);
  file.number("since_s", present.since, {0.0, 1e10});
  file.number("level_v", present.level, kVoltages);
  file.number("largest_current_a", present.largest, kCurrents);
  auto& [next, middle, last] = present.squares;
  auto& [of_next, of_middle, of_last] = present.weights;
  file.row("missed_v2", next, middle, last);
  file.row("comparisons", of_next, of_middle, of_last);
  constexpr double kMost = 1e4;  // [V^2]
  for (const double square : present.squares)
    file.require(square >= 0.0 && square <= kMost, "missed_v2",
                 format("has %g, expected 0 to %g", square, kMost));
  for (const double weight : present.weights)
    file.require(weight >= 0.0, "comparisons", format("has %g, expected at least 0", weight));
}

/// What the model misses, and how wide its intervals must be.
template <typename File, typename Model>
void describeErrors(File& file, Model& model) {
  constexpr Range kStd{0.0, 10.0};  // [V] and [V/sqrt(s)], of a 12 V battery's error
  if constexpr (File::kReads)
    if (file.has("white_std_v")) model.fit.noise.emplace();
  if (auto& noise = model.fit.noise) {
    file.number("white_std_v", noise->white_std, {1e-9, kStd.most});
    file.number("ar_std_v", noise->ar_std, kStd);
    file.number("ar_time_s", noise->ar_time, {1e-6, 1e9});
    file.number("walk_std_v_per_sqrt_s", noise->walk_std, kStd);
    file.map("now", [&](auto& now) { describeResidual(now, model.state.residual_state); });
  }
  auto& present = model.state.residual_state.present;
  if (file.has("present", present.weights[0] > 0.0))
    file.map("present", [&](auto& part) { describePresent(part, present); });
  auto& missed = model.intervals.missed_answer;
  if (file.has("missed_answer", missed.has_value())) {
    if constexpr (File::kReads) missed.emplace();
    file.row("missed_answer", missed->time, missed->measured, missed->lower, missed->upper);
  }
  describeCalibration(file, "crank_intervals", model.intervals.calibrations.cranks);
  describeCalibration(file, "charge_intervals", model.intervals.calibrations.charges);
}

}  // namespace battery_sof
