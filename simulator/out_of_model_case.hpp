#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "simulator/imperfect_recorder.hpp"
#include "simulator/out_of_model_battery.hpp"
#include "simulator/out_of_model_instrument.hpp"

namespace battery_sof_reference {

/// What to draw. Empty or missing: the seed chooses.
struct OutOfModelOrder {
  std::string kind = "other_form";  ///< null, imperfect_null, other_form
  std::string mechanism, form;      ///< of other_form
  std::string drive;                ///< of outOfModelDrives()
  std::optional<double> duration;   ///< [s], 120 to 7200; drawn: 600 to 3600
  std::optional<double> rate;       ///< [Hz], 1000 over a whole number; drawn: 1, 10 or 100
  std::uint64_t seed = 1;
  double scale = 1.0;  ///< times the strength that was found, finite and >= 0
};

/// RMS before the split and after it [V].
struct SplitRms {
  double training = 0.0, holdout = 0.0;
};

/// A recording and what is true of it.
struct OutOfModelCase {
  OutOfModelOrder order;  ///< with everything filled in
  Scenario scenario;      ///< base circuit, drive, limit
  std::vector<RecordedSample> samples;
  double strength = 0.0;  ///< of the form, scale included
  /// recorded less base circuit under the recorded current, about its mean
  SplitRms effect;
  SplitRms visible;          ///< the same, less what other base parameters would follow
  double crank_v = 0.0;      ///< most that a crank's minimum is off the base circuit's [V]
  double steps_rms_v = 0.0;  ///< imperfect_null: the voltage's steps and converter nonlinearity
  NoiseOptions voltage_noise, current_noise;
  double voltage_step_v = 0.0, current_step_a = 0.0;
  std::optional<ImperfectRecorder> recorder;
  int attempt = 0;  ///< draws that were not taken
};

/// Share of the samples that teach; the rest is held out (as `sof diagnose` splits).
constexpr double kTrainingShare = 0.75;
/// Bounds of the visible RMS of another form [V], and how many times the white noise it is at
/// least.
constexpr Range kVisible{4e-3, 60e-3};
constexpr double kMinOverNoise = 3.0;
/// What an imperfect null's filters, jitter, current channel and smooth structure leave at most
/// [V].
constexpr double kMaxImperfection = 0.7e-3;
/// The same for a crank's minimum [V]: below what matters to who asks for a crank (10 mV).
constexpr double kMaxCrankImperfection = 8e-3;

/**
 * @brief A case (docs/validation.md).
 *
 * The currents are those of a source with a voltage limit and the true battery, made linear between
 * samples. An other form's strength is searched until its visible RMS in the training part is the
 * one drawn; draws that cannot be seen, or not in the hold-out, are not taken, nor are imperfect
 * nulls above kMaxImperfection or kMaxCrankImperfection.
 *
 * @throws std::invalid_argument for an order that cannot be; NoSolution when twenty draws gave no
 * case.
 */
OutOfModelCase drawOutOfModelCase(const OutOfModelOrder& order);

/// All (kind, mechanism, form) that can be ordered; nulls with "-" for both.
struct OutOfModelKind {
  std::string kind, mechanism, form;
};
std::vector<OutOfModelKind> outOfModelKinds();

/**
 * @brief RMS of a voltage error, plain about its training mean, and with the base circuit's
 * parameters moved to follow it (linear regression on BaseAnswer::columns in the training part).
 */
struct ErrorSize {
  SplitRms plain, visible;
  /// most that a crank's minimum moves (below -100 A), parameters as they are
  double crank_v = 0.0;
};
ErrorSize errorSize(const std::vector<double>& error, const BaseAnswer& base);

}  // namespace battery_sof_reference
