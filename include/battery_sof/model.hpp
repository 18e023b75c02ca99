#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "battery_sof/parameter_estimate.hpp"
#include "battery_sof/queries.hpp"
#include "battery_sof/series.hpp"

namespace battery_sof {

struct FittedModel;

/// Options of identify().
struct IdentifyRequest {
  std::optional<double> from;   ///< [s], recording's clock; default: its first sample
  std::optional<double> to;     ///< [s]; default: its last sample; the state is that of this time
  bool chooses_window = false;  ///< choose the window inside from..to even if both are given
  /// ids of effects to add; none: chosen by the recording; empty: the base model
  std::optional<std::vector<std::string>> effects;
  bool paper_start = false;    ///< initial state and u_dc as in the paper (eqs. 4 and 5)
  double series_blocks = 1.0;  ///< number of 12 V blocks in series
  int threads = 1;             ///< 0: as many as the machine has; changes no result
  /// hash of the recording's file, "sha256:...", stored in the model file; empty: unknown
  std::string recording_hash = {};
  bool anyway = false;  ///< also fit a recording with a problem (`sof check`)
  /// [A], of either sign, that counts as an engine start; none: read off the recording
  std::optional<double> crank_current = std::nullopt;
  /// [Ah], nominal: a window that moved a tenth of it calls for the open-circuit voltage (`effects`),
  /// and a discharge under way that drew so much is the window unless from and to are both given.
  /// What is known of it is a part of the fit of where a discharge ends; none: 50 Ah decides what is
  /// a tenth, and nothing is known
  std::optional<double> capacity = std::nullopt;
};

/**
 * @brief An identified model of a battery, with the state at which a query begins. It behaves as a
 * value, and copies share the constant parts.
 *
 * Signs and units as everywhere: SI, current positive into the battery.
 */
class Model {
 public:
  explicit Model(FittedModel model);
  /// @throws std::runtime_error with file and field if it cannot be read or is not a model.
  static Model read(const std::filesystem::path& file);
  /// Writes MODEL.yaml, whole or not at all. @throws std::invalid_argument if the model is not
  /// usable, std::runtime_error if the file cannot be written.
  void write(const std::filesystem::path& file) const;

  bool usable() const;                       ///< whether it can answer queries
  std::string message() const;               ///< how the identification ended, one sentence
  std::vector<std::string> effects() const;  ///< ids of physics beyond the base model
  std::vector<ParameterEstimate> parameters() const;
  /// @return the same model after a rest that is long enough for every state to settle.
  Model rested() const;
  std::string json() const;  ///< as `sof identify --json` (docs/cli.md)
  std::string text() const;  ///< as `sof identify` prints

  const FittedModel& fitted() const { return *fitted_; }  ///< internal

 private:
  std::shared_ptr<const FittedModel> fitted_;
};

/**
 * @brief Fits the model to a window of a recording, as `sof identify` does (paper, section IV).
 * @return the model. If the window determines none, it is not usable() and message() has the
 * reason.
 * @throws std::invalid_argument for a recording that breaks an invariant of Series, a range without
 * samples, an unknown effect, or an option that is out of range.
 */
Model identify(const Recording& recording, const IdentifyRequest& request = {});

// The queries (queries.hpp). The event begins at the model's state. @param capacity [Ah], nominal,
// above 0; none: as it was given to identify(), else 50 Ah.
CrankingAnswer predictCranking(const Model& model, const CrankingQuery& query,
                               std::optional<double> capacity = std::nullopt);
StopTimeAnswer predictStopTime(const Model& model, const StopTimeQuery& query,
                               std::optional<double> capacity = std::nullopt);
ChargeAcceptanceAnswer predictChargeAcceptance(const Model& model,
                                               const ChargeAcceptanceQuery& query,
                                               std::optional<double> capacity = std::nullopt);
/// @param time [s] after the state, >= 0, increasing.  @param current [A], linear in between.
/// @param watch called before every sample; see WorkWatch.
ProfileAnswer simulateProfile(const Model& model, const std::vector<double>& time,
                              const std::vector<double>& current, const WorkWatch& watch = nullptr);

/// Options of diagnose().
struct DiagnosisRequest {
  std::optional<double> from, to;  ///< [s]; default: the recording's ends
  /// share of the samples, the last ones, kept for the comparison and opened once, at the end
  double holdout_share = 0.25;
  std::vector<std::string> hypotheses = {};  ///< ids of effects to consider; empty: all
  std::vector<std::string> given = {};       ///< ids known to be present; disables the search
  double series_blocks = 1.0;                ///< number of 12 V blocks in series
  /// 0: as many as the machine has; changes no result
  int threads = 1;
  std::function<void(const std::string& stage)> progress = nullptr;  ///< called at each new stage
  std::string recording_hash = {};                                   ///< as in IdentifyRequest
  bool anyway = false;                                               ///< as in IdentifyRequest
  std::optional<double> crank_current = std::nullopt;                ///< as in IdentifyRequest
  /// [Ah], nominal: what is a tenth of it, as in IdentifyRequest; no part of the fit
  std::optional<double> capacity = std::nullopt;
};

struct Diagnosis;

/// Result of a diagnosis: which physics the base model lacks for a recording (docs/diagnosis.md).
class DiagnosisReport {
 public:
  DiagnosisReport(Recording recording, Diagnosis diagnosis);
  std::string verdict() const;  ///< one of those in the JSON, e.g. "effect"
  std::string summary() const;  ///< one plain sentence
  std::string json() const;     ///< as `sof diagnose --json` (docs/cli.md)
  std::string text() const;     ///< as `sof diagnose` prints
  std::string page() const;     ///< one HTML document that needs no network
  Model base() const;           ///< the base model, fitted to the training part
  Model extended() const;       ///< with what was found; the base model if nothing was

  const Diagnosis& diagnosis() const { return *diagnosis_; }  ///< internal
  const Recording& recording() const { return *recording_; }  ///< the stretch that was diagnosed

 private:
  std::shared_ptr<const Recording> recording_;
  std::shared_ptr<const Diagnosis> diagnosis_;
};

/// Diagnoses a recording, as `sof diagnose` does. This takes minutes on long recordings.
/// @throws std::invalid_argument for a recording that breaks an invariant of Series, a range without
/// samples, an unknown id, or an option that is out of range.
DiagnosisReport diagnose(const Recording& recording, const DiagnosisRequest& request);

}  // namespace battery_sof
