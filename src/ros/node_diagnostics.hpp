#pragma once

#include <diagnostic_updater/diagnostic_updater.h>

#include <optional>
#include <string>

#include "ros/battery_identity.hpp"
#include "ros/diagnosis_runner.hpp"
#include "ros/node_statistics.hpp"

namespace battery_sof {

/// What the node has seen since its start.
struct NodeRecord {
  EventTallies events;
  std::optional<double> fit_ms;  ///< [ms], of the last identification
  std::string internal_fault;    ///< what failed last inside the node; empty when nothing did
  std::size_t internal_faults = 0;
  std::string state_file_fault;  ///< empty when the last access went well
  std::string other_battery;     ///< since when another one is followed; empty when none is
};

/// What the diagnostics are made of, taken at one moment.
struct DiagnosticsSnapshot : NodeRecord {
  SessionStatus status;
  StreamCounts counts;
  std::optional<double> no_data_for;  ///< [s] of ROS time, when samples have stopped
  ResponseTimes response_times;
  DiagnosisLine diagnosis;
  std::string state_file;  ///< its path, or "off"
  BatteryIdentity battery;
  std::string hardware_id;
  double capacity = 0.0;  ///< [Ah], that answers rest on
};

/// Publishes data rate, rejected samples by reason, deep discharges, identification, prediction error, response
/// times and diagnosis on /diagnostics.
class NodeDiagnostics {
 public:
  NodeDiagnostics();
  void publish(DiagnosticsSnapshot snapshot);

 private:
  diagnostic_updater::Updater updater_;
  DiagnosticsSnapshot before_, now_;
};

}  // namespace battery_sof
