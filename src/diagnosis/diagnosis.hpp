#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "battery_sof/series.hpp"
#include "diagnosis/explanation.hpp"
#include "recording/control_mode.hpp"
#include "regression/discrepancy_curve.hpp"
#include "regression/discrepancy_fit.hpp"
#include "state/fitted_model.hpp"
#include "util/constants.hpp"

namespace battery_sof {

/// What a diagnosis comes to.
enum class Verdict {
  kNoMismatch,        ///< model and measurement agree as far as this recording shows
  kEffect,            ///< one effect is missing from the base model
  kSeveral,           ///< more than one
  kAmbiguous,         ///< one of a few that this recording cannot distinguish
  kMechanism,         ///< a known mechanism is missing, and no equation of the catalogue fits
  kUnexplained,       ///< something is missing whose mechanism is not known
  kSensorFault,       ///< the instruments explain it
  kInsufficientData,  ///< the recording cannot answer
};

/// @return "no_mismatch", "effect", "several", "ambiguous", "mechanism", "unexplained",
/// "sensor_fault", "insufficient_data".
std::string toString(Verdict verdict);

/// Whether something is missing that no equation of the catalogue fits.
inline bool hasNoEquation(Verdict verdict) {
  return verdict == Verdict::kMechanism || verdict == Verdict::kUnexplained;
}

/// A parameter of an effect that was found.
struct DiagnosedParameter {
  std::string name, unit;
  double value = 0.0;         ///< in unit
  std::optional<double> std;  ///< standard error in unit
  /// 95 % interval by the standard error, within the catalogue's bounds; none without one
  std::optional<double> lower, upper;
  bool at_bound = false;  ///< its value lies at the catalogue's bound: not plausible as it stands
};

/// An effect that the verdict names, or one of a class that cannot be distinguished.
struct NamedEffect {
  std::string id;
  /// [0, 1], share of the evidence among those tied with it
  double confidence = 0.0;
  /// base parameters that had taken it up, most moved first
  std::vector<std::string> biased_parameters;
  std::vector<DiagnosedParameter> parameters;
  double evidence = 0.0;  ///< gain of ln evidence (explain())
  /// [V], RMS of what the effect adds to the voltage on the training part
  double voltage_rms = 0.0;
  std::vector<std::string> indistinguishable_from;  ///< ids of its class
  std::string mechanism;                            ///< mechanismId()
  /// [0, 1], that its mechanism is what is missing in its place
  double probability = 0.0;
};

/// An effect that was fitted and weighed.
struct Candidate {
  std::string id;
  /// gain of ln evidence by it alone, or where it came in
  double evidence = 0.0;
  double confidence = 0.0;       ///< [0, 1]
  std::string rejected_because;  ///< empty when accepted
  std::string mechanism;         ///< mechanismId()
  /// fall of the error on the hold-out, of what was accepted
  std::optional<double> holdout_gain_percent = std::nullopt;
  /// on left-out blocks over what had been accepted before, where a charger controls the voltage
  std::optional<ScoreGain> score = std::nullopt;
};

/// A stretch where model and measurement deviate.
struct MismatchSegment {
  double from = 0.0, to = 0.0;  ///< [s]
  std::string regime;           ///< see regimeName()
  double mean_error = 0.0;      ///< [V], measured minus base model
  double peak_error = 0.0;      ///< [V], of largest magnitude, signed
  double p_value = 1.0;
};

/// One statistic of the base model's error in one operating regime.
struct RegimeFinding {
  std::string regime;
  std::string statistic;  ///< "mean" [V], "slope" [V/s], "end" [V]
  std::size_t episodes = 0;
  /// measured minus base model, with a 95 % interval
  double value = 0.0, lower = 0.0, upper = 0.0;
  double p_value = 1.0;
  bool is_significant = false;  ///< after correction for the number of statistics
};

/// How much better a parameter would fit with another value in one regime than it does with one
/// value for all.
struct ParameterBias {
  std::string parameter;
  std::string regime;
  double z = 0.0;  ///< [1], > 0: a larger value fits better there
  /// that fits best, inside the parameter's bounds and relative to its value [1]; of u_dc in V
  double change = 0.0;
};

/// Errors of a model over a stretch; NaN where nothing was compared.
struct ErrorMetrics {
  double q_dyn_percent = kNan;
  double rmse = kNan;               ///< [V]
  double max_abs = kNan;            ///< [V]
  std::optional<double> crank_mae;  ///< [V], of the cranks' minima
  /// [V], mean of measured minus modelled over charges
  std::optional<double> charge_bias;
  /// [A], mean magnitude at the measured voltage over charges
  std::optional<double> charge_current_error;
  /// Explained variation in the direction that is controlled [%] (MixedScores), on
  /// the hold-out; none without a charger that controls the voltage.
  std::optional<double> share_percent = std::nullopt, current_share_percent = std::nullopt,
                        voltage_share_percent = std::nullopt;
  /// share_percent of the equations alone, the residual regression taken away [%]
  std::optional<double> equations_share_percent = std::nullopt;
  std::size_t cranks = 0;  ///< of which crank_mae is the mean
};

/// One regime's error before and after, on the hold-out.
struct RegimeComparison {
  std::string regime;
  std::size_t samples = 0;
  double base_rmse = 0.0, extended_rmse = 0.0;  ///< [V]
  /// [V], extended minus base, 95 % interval over blocks
  double change = 0.0, change_lower = 0.0, change_upper = 0.0;
};

struct Comparison {
  FitWindow train{kNan, kNan}, holdout{kNan, kNan};
  ErrorMetrics base_train, base_holdout, extended_train, extended_holdout;
  std::vector<RegimeComparison> regimes;
  /// Baselines without physics, fitted to the training part, on the hold-out: a line through
  /// voltage and current (through current and voltage where a charger controls the voltage), and a
  /// ridge regression on currents and their memories.
  std::optional<ErrorMetrics> baseline_line, baseline_ridge;
};

/// What was estimated where no equation represents it.
struct DiscrepancyFinding {
  DiscrepancyModel discrepancy;
  std::vector<MechanismWeight> mechanisms;  ///< strongest first
  /// of the discrepancy over the training part, the circuit's share taken out [V]
  double rms = 0.0;
  /// on blocks of the training part: whether it is worth using
  LeftOutErrors left_out;
  bool is_used = false;                    ///< in the extended model's voltage
  std::vector<std::string> terms;          ///< what it follows most, in words
  std::optional<double> answer_current;    ///< [A], of answers: one that was driven
  std::vector<DiscrepancyAnswer> answers;  ///< what it adds under that current
  /// the same over the currents of the training part, ascending
  std::vector<DiscrepancyAtCurrent> curve;
  std::string description;  ///< one sentence
  /// Whether it takes enough of the error on left-out blocks to be reported; a little less error is
  /// worth a place in the model alone. A block that the others hardly determine is missed by more
  /// than what is missing: the circuit fitted to all of them must be missed by more, too.
  bool holds() const {
    return is_used && left_out.discrepancy <
                          std::min((1.0 - kCatalogueTolerance) * left_out.base, left_out.in_sample);
  }
};

/// Everything a diagnosis found.
struct Diagnosis {
  Verdict verdict = Verdict::kInsufficientData;
  std::string summary;  ///< one plain sentence
  std::vector<NamedEffect> effects;
  std::vector<Candidate> candidates;  ///< best first
  std::vector<MismatchSegment> mismatch;
  std::vector<RegimeFinding> regimes;
  std::vector<ParameterBias> parameter_bias;
  std::vector<std::string> instrument;  ///< what the instrument screen said, a sentence each
  ControlModeOverview source;           ///< operating mode over the whole recording
  /// of the verdict: what moves the voltage most; none when nothing is missing, or nothing fits
  std::optional<Mechanism> mechanism;
  double probability = 0.0;  ///< of it [0, 1]
  /// that mechanisms are the one of the verdict, likeliest first, until they add up to 0.9
  std::vector<MechanismProbability> mechanisms;
  /// what mechanisms are judged by, each half-sample of the rows; none of what is no lead-acid
  /// battery
  std::vector<MechanismEvidence> mechanism_evidence;
  double evidence_base = 0.0, evidence_extended = 0.0;  ///< ln evidence, scaled by the fraction
  /// share of the rows that count as independent
  double effective_sample_fraction = 1.0;
  UnexplainedPart unexplained;
  std::optional<DiscrepancyFinding> discrepancy;
  std::vector<DetectionLimit> detection_limits;
  std::vector<std::string> outside;  ///< what no recording of current and voltage can show
  Comparison fit;
  /// [V], RMS on the hold-out of an extended model that is no improvement there: it predicts it worse
  /// than the base model, or worse than its mean. Its errors in `fit` are its own; `extended`, the
  /// model that is handed on, is the base model then.
  std::optional<double> withheld_rmse;
  std::string next_experiment;

  /// fitted to the training part; state at its last sample; extended equals base when nothing was
  /// added
  FittedModel base, extended;
  /// Modelled terminal voltage of every sample of the series that was diagnosed [V]; empty with
  /// insufficient data.
  std::vector<double> base_voltage, extended_voltage;
};

}  // namespace battery_sof
