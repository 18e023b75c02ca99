#include "ros/node_diagnostics.hpp"

#include <utility>

#include "util/text.hpp"

namespace battery_sof {

namespace {

using Level = diagnostic_msgs::DiagnosticStatus;
using Status = diagnostic_updater::DiagnosticStatusWrapper;
using Snapshot = DiagnosticsSnapshot;

constexpr double kLateSample = 100.0;  // [ms], ten samples of the design rate

std::string shown(const std::optional<double>& value, double factor = 1.0) {
  return value ? std::to_string(factor * *value) : "none";
}

/// How one kind of event compares with what was expected of it.
void add(Status& status, const std::string& events, const char* unit, const KindTally& kind,
         const IntervalCalibration& scale) {
  const EventTally &tally = kind.model, &baseline = kind.baseline;
  status.add(events, tally.count);
  status.add(events + " inside their interval", tally.inside);
  status.add(events + "' share inside [%]", shown(tally.coverageOf(), 100.0));
  status.add(events + "' mean absolute error [" + unit + "]", shown(tally.meanAbsError()));
  status.add(events + "' mean absolute error, baseline [" + unit + "]",
             shown(baseline.meanAbsError()));
  status.add(events + "' interval factor", scale.factor);
}

void reportDataRate(Status& status, const Snapshot& now, const Snapshot& before) {
  const auto &then = before.status.newest_time, &newest = now.status.newest_time;
  std::optional<double> rate;  // [Hz] by the stamps, since the last report
  if (then && newest && *newest > *then)
    rate = static_cast<double>(now.counts.accepted - before.counts.accepted) / (*newest - *then);
  if (!newest) {
    status.summary(Level::WARN, now.status.state == SessionState::kNoSample ? now.status.reason
                                                                            : "no sample yet");
  } else if (now.no_data_for) {
    status.summaryf(Level::ERROR, "no sample for %.1f s", *now.no_data_for);
  } else if (!now.status.not_valid.empty()) {
    status.summary(Level::ERROR, "no answer is valid, because " + now.status.not_valid);
  } else {
    status.summary(Level::OK, rate ? "samples arrive" : "no new sample since the last report");
  }
  status.add("rate by stamps [Hz]", shown(rate));
  status.add("accepted", now.counts.accepted);
  status.add("clock restarts", now.counts.clock_restarts);
}

void reportRejected(Status& status, const Snapshot& now, const Snapshot& before) {
  const RejectedCounts& rejected = now.counts.rejected;
  const std::size_t total = now.counts.rejectedTotal();
  const std::size_t fresh = total - before.counts.rejectedTotal();
  const std::size_t hot = now.counts.rejected_temperatures;
  const std::string temperatures =
      hot == 0 ? "" : format("; %zu temperatures were out of range and ignored", hot);
  if (fresh > 0 || hot > before.counts.rejected_temperatures) {
    status.summaryf(Level::WARN, "%zu samples rejected since the last report, %zu in total%s",
                    fresh, total, temperatures.c_str());
  } else {
    status.summaryf(Level::OK, "%zu samples rejected in total%s", total, temperatures.c_str());
  }
  status.add("missing value", rejected.missing_value);
  status.add("not finite", rejected.not_finite);
  status.add("duplicate stamp", rejected.duplicate_stamp);
  status.add("clock step back", rejected.clock_step_back);
  status.add("out of range", rejected.out_of_range);
  status.add("temperature out of range", now.counts.rejected_temperatures);
  status.add("stamp ahead", now.counts.stamp_ahead);
}

void reportBattery(Status& status, const Snapshot& now, const Snapshot&) {
  const std::string& deep = now.status.deep_discharge;
  if (!now.battery.whyNone().empty()) {
    status.summary(Level::WARN, now.battery.whyNone());
  } else if (!deep.empty()) {
    status.summary(Level::WARN, deep);
  } else {
    status.summary(Level::OK,
                   now.other_battery.empty() ? "no deep discharge so far" : now.other_battery);
  }
  status.add("serial number", now.battery.serialNumber());
  status.add("location", now.battery.location());
  status.add("capacity [Ah]", now.capacity);
}

void reportIdentification(Status& status, const Snapshot& now, const Snapshot&) {
  const SessionStatus& session = now.status;
  if (!now.internal_fault.empty()) {
    status.summary(Level::ERROR, now.internal_fault);
  } else if (!now.state_file_fault.empty()) {
    status.summary(Level::WARN, now.state_file_fault);
  } else if (session.state == SessionState::kReady && session.not_valid.empty()) {
    status.summary(Level::OK, session.reason);
  } else {
    status.summary(Level::WARN, session.reason);
  }
  status.add("model age [s]", shown(session.model_age));
  status.add("window quality", shown(session.window_quality));
  status.add("last fit [ms]", shown(now.fit_ms));
  status.add("charger", session.charger_present ? "detected" : "not detected");
  status.add("samples with a controlled voltage [%]", shown(session.charger_share, 100.0));
  status.add("input of the model", session.voltage_controlled ? "voltage" : "current");
  status.add("state file", now.state_file);
  status.add("internal faults", now.internal_faults);
}

void reportPredictionError(Status& status, const Snapshot& now, const Snapshot&) {
  const BacktestScore& backtest = now.status.backtest;
  const EventTallies& events = now.events;
  if (!backtest.q_dyn_percent) {
    status.summary(Level::OK, "no prediction to compare yet");
  } else if (*backtest.q_dyn_percent < 0.0) {
    status.summaryf(Level::WARN, "Q_dyn is %.1f %%, so a constant would predict better",
                    *backtest.q_dyn_percent);
  } else {
    status.summaryf(Level::OK, "Q_dyn is %.1f %%", *backtest.q_dyn_percent);
  }
  status.add("Q_dyn [%]", shown(backtest.q_dyn_percent));
  status.add("compared over [s]", backtest.duration);
  add(status, "cranks", "V", events.cranks, events.calibrations.cranks);
  add(status, "charges", "A", events.charges, events.calibrations.charges);
}

void reportResponseTimes(Status& status, const Snapshot& now, const Snapshot&) {
  const ResponseTimes& times = now.response_times;
  if (times.sample_longest_ms > kLateSample) {
    status.summaryf(Level::WARN, "a sample waited for %.0f ms", times.sample_longest_ms);
  } else {
    status.summaryf(Level::OK, "%zu queries, 99 %% of the recent ones answered within %.2f ms",
                    times.queries, times.query_p99_ms);
  }
  status.add("queries", times.queries);
  status.add("query work p99 [ms]", times.query_p99_ms);
  status.add("query work longest [ms]", times.query_longest_ms);
  status.add("sample delay p99 [ms]", times.sample_p99_ms);
  status.add("sample delay longest since the last report [ms]", times.sample_longest_ms);
}

void reportDiagnosis(Status& status, const Snapshot& now, const Snapshot&) {
  const DiagnosisLine& line = now.diagnosis;
  if (!line.fault.empty()) {
    status.summary(Level::WARN, line.fault);
  } else if (line.verdict.empty()) {
    status.summary(Level::OK, line.runs ? "the first diagnosis is running" : "no diagnosis yet");
  } else {
    status.summary(Level::OK, line.verdict + ": " + line.summary);
  }
  status.add("verdict", line.verdict.empty() ? "none" : line.verdict);
  status.add("runs", line.runs);
  status.add("finished", line.finished);
  status.add("left out", line.skipped);
  status.add("last diagnosis [ms]", shown(line.duration_ms));
  status.add("adoption", line.adoption.empty() ? "none" : line.adoption);
}

}  // namespace

NodeDiagnostics::NodeDiagnostics() {
  const auto add = [this](const char* name, auto* report) {
    updater_.add(name, [this, report](Status& status) { report(status, now_, before_); });
  };
  add("data rate", reportDataRate);
  add("rejected samples", reportRejected);
  add("battery", reportBattery);
  add("identification", reportIdentification);
  add("prediction error", reportPredictionError);
  add("response times", reportResponseTimes);
  add("diagnosis", reportDiagnosis);
}

void NodeDiagnostics::publish(DiagnosticsSnapshot snapshot) {
  now_ = std::move(snapshot);
  updater_.setHardwareID(now_.hardware_id);
  updater_.force_update();
  before_ = now_;
}

}  // namespace battery_sof
