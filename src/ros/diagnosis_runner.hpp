#pragma once

#include <actionlib/server/action_server.h>
#include <ros/ros.h>

#include <atomic>
#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include "ros/background_work.hpp"
#include "ros/message_conversion.hpp"

namespace battery_sof {

/// What the diagnostics say of diagnoses.
struct DiagnosisLine {
  bool runs = false;
  std::size_t finished = 0;  ///< since the start
  std::size_t skipped = 0;   ///< due while another one ran
  std::string verdict;       ///< of the last one; empty before the first
  std::string summary, adoption;
  std::string fault;                  ///< of the last one, when it broke off
  std::optional<double> duration_ms;  ///< [ms], of the last one
};

/**
 * @brief Runs diagnoses in parallel to everything else, one at a time, and publishes each on
 * ~diagnosis (latched).
 *
 * One is begun by a goal or, with a period, when a multiple of it has been driven: a bag played
 * faster is diagnosed at the same samples. A goal is accepted, gets its feedback and ends here. May be called from any thread. What is adopted of a
 * periodic diagnosis takes effect `identify_period` [s] of driving after its last sample, or when it is
 * finished, if that is later; of a requested one at once.
 */
class DiagnosisRunner {
 public:
  using Goal = actionlib::ServerGoalHandle<DiagnoseAction>;
  /// Called on the runner's thread with what is to be fitted.
  using Adopt = std::function<void(const Adoption& adoption, double from_driving)>;

  /// @param options outlive it.
  DiagnosisRunner(ros::NodeHandle& private_node, const NodeOptions& options, Adopt adopt);
  /// Breaks a running diagnosis off.
  ~DiagnosisRunner() { stop(); }

  /// @param series not empty. @return false when another one runs: the goal is left as it is.
  bool begin(const Series& series, const std::string& name, const Goal& goal);
  /// Begins one when it is due: by one thread at a time, which waits for the worker only then.
  /// @param driving [s].
  void beginIfDue(const Series& series, const std::string& name, double driving);

  DiagnosisLine line();
  /// Breaks the diagnosis of a goal off, if it runs.
  void cancel(const Goal& goal);
  void stop();

 private:
  struct Job {
    Recording recording;
    double from_driving = 0.0;  // [s]
    Goal goal;                  // none of a periodic one
  };

  bool post(const Series& series, const std::string& name, double from_driving, const Goal& goal);
  void run(Job job);
  /// diagnose() on one thread, with its time.
  FinishedDiagnosis diagnosed(Job& job);
  Adoption adopt(const Diagnosis& diagnosis, double from_driving);
  void note(const FinishedDiagnosis& report, const Adoption& adoption);

  const NodeOptions& options_;
  Adopt adopt_;
  ros::Publisher publisher_;
  double next_due_;   // [s] of driving, of beginIfDue() alone
  std::mutex mutex_;  // guards the next two
  DiagnosisLine line_;
  std::string goal_id_;                 // of the running one; empty of a periodic one
  std::atomic<bool> cancelled_{false};  // the running one
  std::atomic<bool> stopped_{false};
  BackgroundWorker worker_;
};

}  // namespace battery_sof
