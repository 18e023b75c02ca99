#pragma once

#include <diagnostic_updater/diagnostic_updater.h>

#include <functional>
#include <optional>
#include <string>

#include "battery_sof/predict/online_session.hpp"

namespace battery_sof {

/// How the cranks since the start compare with what the model expected.
struct CrankTally {
  std::size_t count = 0;
  std::size_t inside = 0;      ///< inside their 90 % interval
  double sum_abs_error = 0.0;  ///< [V]
  std::optional<CrankComparison> last;

  void add(const CrankComparison& crank);
};

/// What the diagnostics are made of, taken at one moment.
struct DiagnosticsSnapshot {
  SessionStatus status;
  StreamCounts counts;
  std::optional<double> fit_ms;       ///< [ms], of the last identification
  std::optional<double> no_data_for;  ///< [s] of ROS time, when samples have stopped
  CrankTally cranks;
  std::string state_file;        ///< its path, or "off"
  std::string state_file_fault;  ///< empty when the last access went well
};

/// Publishes data rate, rejected samples by reason, identification and prediction error on
/// /diagnostics.
class NodeDiagnostics {
 public:
  using TakeSnapshot = std::function<DiagnosticsSnapshot()>;

  explicit NodeDiagnostics(TakeSnapshot take_snapshot);

  /// Takes a snapshot and publishes.
  void publish();

 private:
  using Status = diagnostic_updater::DiagnosticStatusWrapper;

  void reportDataRate(Status& status);
  void reportRejected(Status& status);
  void reportIdentification(Status& status);
  void reportPredictionError(Status& status);

  TakeSnapshot take_snapshot_;
  diagnostic_updater::Updater updater_;
  DiagnosticsSnapshot before_, now_;
};

}  // namespace battery_sof
