#include <cmath>
#include <cstdio>
#include <numeric>

#include "diagnosis/diagnose.hpp"
#include "experiment.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

void print(const std::string& recording, const SessionEvents& events,
           const OnlineSession& session) {
  for (const EventComparison& c : events.cranks)
    std::printf("%s,crank,%.2f,%.2f,%.4f,%.4f,%.4f,%.4f,%.4f\n", recording.c_str(), c.time,
                c.current, c.measured, c.expected.value, c.expected.lower, c.expected.upper,
                session.calibrations().cranks.factor);
  for (const EventComparison& c : events.charges)
    std::printf("%s,charge,%.2f,%.3f,%.4f,%.4f,%.4f,%.4f,%.4f\n", recording.c_str(), c.time,
                c.voltage, c.measured, c.expected.value, c.expected.lower, c.expected.upper,
                session.calibrations().charges.factor);
}

/// Diagnoses what is buffered and has the extended composition fitted whatever its verdict; the node
/// fits named physics and what was estimated.
void adoptDiagnosis(OnlineSession& session) {
  Recording buffered;
  buffered.series = session.series();
  buffered.offered = buffered.series.size();
  DiagnoseOptions options;
  options.lists_detection_limits = false;
  const Diagnosis found = diagnose(buffered, options);
  std::fprintf(stderr, "%.0f s: %s\n", *session.newestTime(), found.summary.c_str());
  if (!found.extended.fit.effects.empty())
    session.fitWith(found.extended.fit.effects, 0.0, found.extended.fit.discrepancy);
}

/// What was expected of one kind of event.
struct Tally {
  std::vector<double> errors, widths;
  double inside = 0.0;

  void add(double measured, const Interval& expected) {
    errors.push_back(std::abs(measured - expected.value));
    widths.push_back(expected.upper - expected.lower);
    inside += expected.lower <= measured && measured <= expected.upper ? 1.0 : 0.0;
  }
  void print() const {
    const double count = static_cast<double>(errors.size());
    std::printf(",%.0f,%.4f,%.4f,%.1f,%.3f", count,
                std::accumulate(errors.begin(), errors.end(), 0.0) / count, medianOf(errors),
                100.0 * inside / count, medianOf(widths));
  }
};

}  // namespace

void printEvents(const Recording& recording, const ExperimentOptions& o) {
  OnlineSession session(o.session);
  bool is_diagnosed = o.diagnose_at <= 0.0;
  play(samplesOf(recording.series), session, [&](std::size_t, const SessionEvents& events) {
    print(recording.name, events, session);
    if (!is_diagnosed && session.driving() >= o.diagnose_at) {
      is_diagnosed = true;
      adoptDiagnosis(session);
    }
    const auto outcome = fitDue(session);
    if (!outcome || !is_diagnosed || o.diagnose_at <= 0.0) return;
    std::fprintf(stderr, "%.0f s: %s%s; effects: %s\n", *session.newestTime(),
                 outcome->accepted ? "" : "refused: ", outcome->message.c_str(),
                 join(session.status().effects).c_str());
  });
}

void leaveOutSteps(const Recording& recording, const ExperimentOptions& o) {
  const std::pair<const char*, bool AnswerSteps::*> steps[] = {
      {"nothing", nullptr},
      {"residual filter", &AnswerSteps::residual_filter},
      {"event history", &AnswerSteps::event_history},
      {"interval calibration", &AnswerSteps::calibration}};
  for (const auto& [left_out, step] : steps) {
    SessionOptions options = o.session;
    if (step) options.steps.*step = false;
    OnlineSession session(options);
    Tally cranks, charges;
    play(samplesOf(recording.series), session, [&](std::size_t, const SessionEvents& events) {
      for (const EventComparison& c : events.cranks) cranks.add(c.measured, c.expected);
      for (const EventComparison& c : events.charges) charges.add(c.measured, c.expected);
    });
    std::printf("%s,%s", recording.name.c_str(), left_out);
    cranks.print();
    charges.print();
    std::puts("");
  }
}

}  // namespace battery_sof
