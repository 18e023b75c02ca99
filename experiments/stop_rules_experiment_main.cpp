#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>
#include <sstream>

#include "battery_sof/csv.hpp"
#include "column_options.hpp"
#include "energy_manager/decision.hpp"
#include "prediction/online_session.hpp"

namespace {

using namespace battery_sof;
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

/// Plays a recording through a session and an energy manager; one row a decision, at the beginning
/// of a stop and every `period` in it.
class Play {
 public:
  Play(const Rule& rule, const SessionOptions& options, std::vector<Stop> stops, double period)
      : rule_(rule), habits_(rule), session_(options), stops_(std::move(stops)), period_(period) {}

  void take(const RawSample& sample) {
    for (const EventComparison& crank : session_.push(sample).cranks)
      habits_.addCrank(crank.current);
    if (auto job = session_.takeDueJob()) session_.finish(runIdentification(*job));
    if (next_ == stops_.size()) return;
    const Stop& stop = stops_[next_];
    if (sample.time >= stop.end) {
      habits_.endStop();
      ++next_;
      asked_ = -1e300;
      return;
    }
    if (sample.time < stop.begin) return;
    if (sample.time >= asked_ + period_) decideAt(sample);
    habits_.addStanding(sample.current);
  }

 private:
  void decideAt(const RawSample& sample) {
    asked_ = sample.time;
    const bool is_ready = session_.status().state == SessionState::kReady;
    const Verdict verdict = energy_manager::decide(
        rule_, is_ready ? std::optional(ask(session_, rule_, habits_)) : std::nullopt, "no model");
    std::printf("%zu,%.3f,%d,%.4f,%.2f,%.2f,\"%s\"\n", next_, sample.time, verdict.may_stop,
                verdict.reserve, verdict.longest_stop, verdict.planned_charge,
                verdict.reason.c_str());
  }

  Rule rule_;
  Habits habits_;
  OnlineSession session_;
  std::vector<Stop> stops_;
  double period_;  // [s]
  std::size_t next_ = 0;
  double asked_ = -1e300;
};

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Plays a recording (CSV) through the energy manager of examples/ and prints its decisions in "
      "the recorded stops.");
  std::string recording, stops;
  double period = 1.0;
  Rule rule;
  SessionOptions options;
  CsvColumns columns;
  app.add_option("REC", recording, "CSV recording")->required();
  app.add_option("STOPS", stops, "CSV of begin_s,end_s")->required();
  app.add_option("--u-required", rule.u_required, "[V]");
  app.add_option("--margin", rule.margin, "[V]");
  app.add_option("--look-ahead", rule.look_ahead, "[s]");
  app.add_option("--i-cranking", rule.i_cranking, "[A]");
  app.add_option("--t-cranking", rule.t_cranking, "[s]");
  app.add_option("--period", period, "[s] between decisions in a stop");
  app.add_option("--identify-period", options.identify_period, "[s]");
  addColumnOptions(app, columns);
  CLI11_PARSE(app, argc, argv);
  std::puts("stop,time_s,may_stop,reserve_v,longest_stop_s,planned_charge_a,reason");
  try {
    Play play(rule, options, readStops(stops), period);
    const Series series = readCsv(recording, columns).series;
    for (std::size_t k = 0; k < series.size(); ++k)
      play.take({series.time[k], series.current[k], series.voltage[k], std::nullopt});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "stop_rules_experiment: %s\n", error.what());
    return 2;
  }
  return 0;
}
