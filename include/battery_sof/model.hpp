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

/// What is identified of a recording, and how.
struct IdentifyRequest {
  std::optional<double> from;   ///< [s], recording's clock; none: its first sample
  std::optional<double> to;     ///< [s]; none: its last sample; the state is carried there
  bool chooses_window = false;  ///< the best window inside from..to even where both are given
  /// ids of further physics; none: the recording chooses; empty: the base model
  std::optional<std::vector<std::string>> effects;
  bool whiten = false;         ///< a cost of whitened residuals
  bool paper_start = false;    ///< search from the paper's starting point alone
  double series_blocks = 1.0;  ///< of 12 V in series that the recording is of
  int threads = 1;             ///< 0: as many as the machine has; changes no result
  /// of the recording's file, for the model file: "sha256:..."; empty: unknown
  std::string recording_hash = {};
  bool anyway = false;  ///< fits a recording with a problem (`sof check`), too
};

/**
 * @brief A battery's identified model with the state that a question begins from. A value; copies
 * share what does not change.
 *
 * Signs and units as everywhere: SI, current positive into the battery.
 */
class Model {
 public:
  explicit Model(FittedModel model);
  /// @throws std::runtime_error naming file and field when it cannot be read or is no model.
  static Model read(const std::filesystem::path& file);
  /// Writes MODEL.yaml, whole or not at all. @throws std::invalid_argument when the model is not
  /// usable, std::runtime_error when the file cannot be written.
  void write(const std::filesystem::path& file) const;

  bool usable() const;                       ///< whether it answers questions
  std::string message() const;               ///< how the identification ended, one sentence
  std::vector<std::string> effects() const;  ///< ids of physics beyond the base model
  std::vector<ParameterEstimate> parameters() const;
  /// after a rest so long that every state is at rest
  Model rested() const;
  std::string json() const;  ///< as `sof identify --json` (docs/cli.md)
  std::string text() const;  ///< as `sof identify` prints

  const FittedModel& fitted() const { return *fitted_; }  ///< for the package itself

 private:
  std::shared_ptr<const FittedModel> fitted_;
};

/**
 * @brief Fits the model to a window of a recording, as `sof identify` does (paper, section IV).
 * @return a model; not usable, with the reason, where the window determines none.
 * @throws std::invalid_argument for a range without samples, unknown effects and options outside
 * their ranges.
 */
Model identify(const Recording& recording, const IdentifyRequest& request = {});

// The questions (queries.hpp). The event begins where the model's state stands. @param capacity
// [Ah], nominal, above 0.
CrankingAnswer predictCranking(const Model& model, const CrankingQuery& query,
                               double capacity = 50.0);
StopTimeAnswer predictStopTime(const Model& model, const StopTimeQuery& query,
                               double capacity = 50.0);
ChargeAcceptanceAnswer predictChargeAcceptance(const Model& model,
                                               const ChargeAcceptanceQuery& query,
                                               double capacity = 50.0);
/// @param time [s] after the state, >= 0, increasing.  @param current [A], linear between.  @param
/// watch queried before every sample.
ProfileAnswer simulateProfile(const Model& model, const std::vector<double>& time,
                              const std::vector<double>& current, const WorkWatch& watch = nullptr);

/// What is diagnosed of a recording, and how.
struct DiagnosisRequest {
  std::optional<double> from, to;  ///< [s]; none: the recording's ends
  /// of the samples, the last ones: opened once, at the end
  double holdout_share = 0.25;
  std::vector<std::string> hypotheses = {};  ///< ids to weigh; empty for all
  std::vector<std::string> given = {};       ///< ids known to be there: nothing is searched for
  double series_blocks = 1.0;                ///< of 12 V in series
  /// 0: as many as the machine has; changes no result
  int threads = 1;
  std::function<void(const std::string& stage)> progress = nullptr;  ///< called with what begins
  std::string recording_hash = {};                                   ///< as IdentifyRequest's
  bool anyway = false;                                               ///< as IdentifyRequest's
};

struct Diagnosis;

/// A finished diagnosis: which physics the base model lacks for a recording (docs/diagnosis.md).
class DiagnosisReport {
 public:
  DiagnosisReport(Recording recording, Diagnosis diagnosis);
  std::string verdict() const;  ///< as in the JSON
  std::string summary() const;  ///< one plain sentence
  std::string json() const;     ///< as `sof diagnose --json` (docs/cli.md)
  std::string text() const;     ///< as `sof diagnose` prints
  std::string page() const;     ///< one HTML document that needs no network
  Model base() const;           ///< fitted to the training part
  Model extended() const;       ///< with what was found; the base model where nothing was

  const Diagnosis& diagnosis() const { return *diagnosis_; }  ///< for the package itself
  const Recording& recording() const { return *recording_; }  ///< the stretch that was diagnosed

 private:
  std::shared_ptr<const Recording> recording_;
  std::shared_ptr<const Diagnosis> diagnosis_;
};

/// As `sof diagnose`; takes minutes on long recordings.
/// @throws std::invalid_argument for a range without samples, unknown ids and options outside their
/// ranges.
DiagnosisReport diagnose(const Recording& recording, const DiagnosisRequest& request);

}  // namespace battery_sof
