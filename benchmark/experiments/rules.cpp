#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>

#include "experiment.hpp"

namespace battery_sof {
namespace {
using energy_manager::Answer;
using energy_manager::Answers;
using energy_manager::Habits;
using energy_manager::Rule;
using energy_manager::Verdict;

/// The engine of the recorded car was off from begin to end [s], where the crank begins.
struct Stop {
  double begin, end;
};

/// "begin_s,end_s" a line, below a header. @throws std::runtime_error naming the file, and the line
/// that cannot be read.
std::vector<Stop> readStops(const std::string& path) {
  std::ifstream file(path);
  std::vector<Stop> stops;
  std::string line;
  if (!std::getline(file, line)) throw std::runtime_error(path + ": cannot be read");
  while (std::getline(file, line)) {
    Stop stop{};
    char comma = 0;
    if (!(std::istringstream(line) >> stop.begin >> comma >> stop.end))
      throw std::runtime_error(path + ": \"" + line + "\" is not begin_s,end_s");
    stops.push_back(stop);
  }
  return stops;
}

/// As the example's node asks the services.
Answers ask(const OnlineSession& session, const Rule& rule, const Habits& habits) {
  CrankingQuery crank{habits.load(), rule.look_ahead, habits.cranking(), rule.t_cranking,
                      rule.u_required};
  StopTimeQuery stop{habits.load(), habits.cranking(), rule.t_cranking,
                     rule.u_required + rule.margin};
  ChargeAcceptanceQuery charge{rule.u_boost, rule.t_boost, rule.i_limit};
  const ModelSnapshot live = session.live();
  const auto held = live.predictCranking(crank);
  const auto length = live.predictStopTime(stop);
  const auto taken = live.predictChargeAcceptance(charge);
  const auto lower = [](const std::optional<Interval>& of) {
    return of ? of->lower : std::numeric_limits<double>::quiet_NaN();
  };
  return {{held.valid, lower(held.u_min), held.message},
          {length.valid, lower(length.t_stop), length.message},
          {taken.valid, lower(taken.i_boost), taken.message}};
}

}  // namespace

/// One row a decision, at the beginning of a stop and every `period` in it.
void decideInStops(const Recording& recording, const ExperimentOptions& o) {
  const std::vector<Stop> stops = readStops(o.stops);
  const std::vector<RawSample> samples = samplesOf(recording.series);
  OnlineSession session(o.session);
  Habits habits(o.rule);
  std::size_t next = 0;
  double asked = -HUGE_VAL;
  play(samples, session, [&](std::size_t n, const SessionEvents& events) {
    const double time = samples[n].time;
    for (const EventComparison& crank : events.cranks) habits.addCrank(crank.current);
    fitDue(session);
    if (next == stops.size() || time < stops[next].begin) return;
    if (time >= stops[next].end) {
      habits.endStop();
      ++next;
      asked = -HUGE_VAL;
      return;
    }
    if (time >= asked + o.period) {
      asked = time;
      const bool is_ready = session.status().state == SessionState::kReady;
      const Verdict verdict = energy_manager::decide(
          o.rule, is_ready ? std::optional(ask(session, o.rule, habits)) : std::nullopt,
          "no model");
      std::printf("%zu,%.3f,%d,%.4f,%.2f,%.2f,\"%s\"\n", next, time, verdict.may_stop,
                  verdict.reserve, verdict.longest_stop, verdict.planned_charge,
                  verdict.reason.c_str());
    }
    habits.addStanding(samples[n].current);
  });
}

}  // namespace battery_sof
