#pragma once

#include <optional>
#include <string>
#include <vector>

#include "battery_sof/csv.hpp"
#include "energy_manager/decision.hpp"
#include "prediction/online_session.hpp"

namespace battery_sof {

/// A recording's stretches as drives of a node, and what is put into them.
struct ChangeOfDrives {
  double drive = 900.0;                // [s] of driving
  std::size_t references = 6;          // of the first drives, that begin a reference in turn
  bool one_drive = false;              // is the reference, as ~set_reference makes it
  int after = 0;                       // drives since the reference that stay as they are
  double contact = 0.0, offset = 0.0;  // [Ohm] in the sense of the voltage, [A] of the current
};

/// Options of all subcommands of `experiment`; each has those that it reads.
struct ExperimentOptions {
  SessionOptions session;
  double capacity = 50.0;    // [Ah]
  double diagnose_at = 0.0;  // [s] of driving; 0: never
  double parked = 43200.0;   // [s], between trips
  double period = 1.0;       // [s], between questions
  bool verbose = false;
  int windows = 12;
  std::string stops;  // file with the stops that a rule is asked in
  energy_manager::Rule rule;
  ChangeOfDrives change;
};

/// Each prints its rows of one recording; the subcommand (experiment_main.cpp) says what they are.
void printEvents(const Recording& recording, const ExperimentOptions& o);
void leaveOutSteps(const Recording& recording, const ExperimentOptions& o);
void askStanding(const Recording& recording, const ExperimentOptions& o);
void askPresent(const Recording& recording, const ExperimentOptions& o);
void printStops(const Recording& recording, const ExperimentOptions& o);
void decideInStops(const Recording& recording, const ExperimentOptions& o);
void fitUnderSettings(const Recording& recording, const ExperimentOptions& o);
void compareDrives(const Recording& recording, const ExperimentOptions& o);
void judgeWindows(const Recording& recording, const ExperimentOptions& o);
/// Trips of one battery, in order.
void playTrips(const std::vector<Recording>& recordings, const ExperimentOptions& o);

/// The samples of a recording, without its temperatures.
inline std::vector<RawSample> samplesOf(const Series& series) {
  std::vector<RawSample> samples;
  for (std::size_t n = 0; n < series.size(); ++n)
    samples.push_back({series.time[n], series.current[n], series.voltage[n], std::nullopt});
  return samples;
}

/// Fits a window if one is due; the node does so while samples arrive.
inline std::optional<IdentificationOutcome> fitDue(OnlineSession& session) {
  auto job = session.takeDueJob();
  return job ? std::optional(session.finish(runIdentification(*job))) : std::nullopt;
}

/// Plays samples through a session: onSample(n, events) is called after each, and what is due is
/// fitted before the next one, unless onSample() has called fitDue().
template <typename OnSample>
void play(const std::vector<RawSample>& samples, OnlineSession& session, OnSample onSample) {
  for (std::size_t n = 0; n < samples.size(); ++n) {
    onSample(n, session.push(samples[n]));
    fitDue(session);
  }
}

}  // namespace battery_sof
