#include <CLI/CLI.hpp>
#include <cstdio>

#include "experiment.hpp"

namespace {

using namespace battery_sof;

using OfAll = void (*)(const std::vector<Recording>&, const ExperimentOptions&);

template <void (*ofOne)(const Recording&, const ExperimentOptions&)>
void each(const std::vector<Recording>& recordings, const ExperimentOptions& o) {
  for (const Recording& recording : recordings) ofOne(recording, o);
}

/// What is given on the command line.
struct CommandLine {
  std::vector<std::string> recordings;
  CsvColumns columns;  // options named as those of `sof`
  ExperimentOptions o;
};

/// Adds a subcommand that prints a header, if there is one, and what `run` says of the recordings.
CLI::App& add(CLI::App& app, CommandLine& line, const char* name, const char* what,
              const char* header, OfAll run) {
  CLI::App& subcommand = *app.add_subcommand(name, what);
  subcommand.add_option("REC", line.recordings, "CSV recordings")->required();
  subcommand.add_option("--time-column", line.columns.time);
  subcommand.add_option("--current-column", line.columns.current);
  subcommand.add_option("--voltage-column", line.columns.voltage);
  subcommand.add_flag("--discharge-positive", line.columns.discharge_positive);
  subcommand.callback([&line, header, run] {
    if (*header) std::puts(header);
    std::vector<Recording> recordings;
    for (const auto& path : line.recordings) recordings.push_back(readCsv(path, line.columns));
    run(recordings, line.o);
  });
  return subcommand;
}

/// The same for one that plays recordings through a session.
CLI::App& addPlayed(CLI::App& app, CommandLine& line, const char* name, const char* what,
                    const char* header, OfAll run) {
  CLI::App& subcommand = add(app, line, name, what, header, run);
  subcommand.add_option("--identify-period", line.o.session.identify_period, "[s]");
  subcommand.add_option("--effects", line.o.session.identify.effects, "ids of further physics")
      ->delimiter(',');
  return subcommand;
}

void addPlays(CLI::App& app, CommandLine& line) {
  addPlayed(app, line, "play", "every crank and charge with what was expected",
            "recording,kind,time_s,current_a_or_voltage_v,measured,expected,lower,upper,scale",
            each<printEvents>)
      .add_option("--diagnose-at", line.o.diagnose_at,
                  "[s] of driving, when the buffer is diagnosed and what is found is fitted to the "
                  "next windows; 0: never");
  addPlayed(app, line, "steps",
            "what cranks and charges miss when each step of an answer is left out in turn: count, "
            "mean and median error, share inside [%], median width",
            "recording,left_out,cranks,mean_v,median_v,inside,width_v,charges,mean_a,median_a,"
            "inside,width_a",
            each<leaveOutSteps>);
  addPlayed(app, line, "questions",
            "how many answers were valid when the standing questions of ~status were asked once a "
            "second",
            "", each<askStanding>);
  CLI::App& present = addPlayed(
      app, line, "present",
      "asks for the present load: answers, share valid [%], of these the share that holds the "
      "present voltage and the median width [V], the same a minute ahead against the present "
      "voltage and against that of then, and valid answers that hold 10.5 V where less is measured",
      "recording,asked,valid,holds_now,width_v,minute_holds_now,minutes,holds_then,capable_low",
      each<askPresent>);
  present.add_option("--period", line.o.period, "[s] between questions");
  present.add_flag("--verbose", line.o.verbose, "every answer");
  addPlayed(app, line, "stops",
            "what was expected of stops: of voltage and crank, before the stop and while it lasts",
            "kind,basis,stop_s,look_s,ahead_s,drawn_percent,valid,measured,expected,lower,upper,"
            "modelled",
            each<printStops>)
      .add_option("--capacity", line.o.capacity, "[Ah]");
  CLI::App& trips = addPlayed(
      app, line, "trips",
      "trips of one battery one after the other, the state file of each given to the next: what "
      "was expected and which answers were valid",
      "trip,basis,kind,time_s,measured,expected,lower,upper,by_past", playTrips);
  trips.add_option("--parked", line.o.parked, "[s] between trips");
  trips.add_option("--capacity", line.o.capacity, "[Ah]");
}

void addRules(CLI::App& app, CommandLine& line) {
  CLI::App& rules = addPlayed(
      app, line, "rules", "decisions of the energy manager of examples/ in recorded stops",
      "stop,time_s,may_stop,reserve_v,longest_stop_s,planned_charge_a,reason", each<decideInStops>);
  energy_manager::Rule& rule = line.o.rule;
  rules.add_option("--stops", line.o.stops, "CSV of begin_s,end_s")->required();
  rules.add_option("--u-required", rule.u_required, "[V]");
  rules.add_option("--margin", rule.margin, "[V]");
  rules.add_option("--look-ahead", rule.look_ahead, "[s]");
  rules.add_option("--i-cranking", rule.i_cranking, "[A]");
  rules.add_option("--t-cranking", rule.t_cranking, "[s]");
  rules.add_option("--period", line.o.period, "[s] between decisions in a stop");
}

void addChanges(CLI::App& app, CommandLine& line) {
  CLI::App& changes =
      add(app, line, "changes",
          "what the node would say on ~change: a recording's stretches as drives, the first ones "
          "in turn as the beginning of the reference",
          "recording,reference,drive,is_changed,verdict,first", each<compareDrives>);
  ChangeOfDrives& change = line.o.change;
  changes.add_option("--drive", change.drive, "[s] of driving");
  changes.add_option("--references", change.references, "drives that begin a reference in turn");
  changes.add_flag("--one-drive", change.one_drive, "as ~set_reference makes a reference");
  changes.add_option("--after", change.after, "drives since the reference before the change");
  changes.add_option("--contact", change.contact, "[Ohm] put into the sense of the voltage");
  changes.add_option("--offset", change.offset, "[A] put into the current");
}

void addWindows(CLI::App& app, CommandLine& line) {
  add(app, line, "settings",
      "why look-alike windows predict so differently: the paper's windows, fitted under every "
      "setting and scored on the whole recording",
      "recording,setting,window,from_s,q_window_percent,q_hour_percent,crank_mae_v,crank_sd_v,"
      "pulses,iterations,status,r_discharge_ohm,r_charge_ohm,c2_f,beta_per_v,u_dc_v",
      each<fitUnderSettings>);
  add(app, line, "windows",
      "windows of recordings: what each alone says of itself and how it predicts the rest",
      "recording,from_s,q_whole,crank_mae,cranks,rmse_whole,excitation,sd_crank,sd_stop,sd_charge,"
      "sd_now,log_det,worst_rel,q_window,rmse_window,std_i,min_i,max_i,pulses,white,ar,ar_time,"
      "walk,charge_s,discharge_s,q_inside,window_quality",
      each<judgeWindows>)
      .add_option("--windows", line.o.windows, "windows of a stretch without a gap");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Experiments on the method with recordings, most played through a session.");
  CommandLine line;
  try {
    app.require_subcommand(1);
    addPlays(app, line);
    addRules(app, line);
    addChanges(app, line);
    addWindows(app, line);
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "experiment: %s\n", error.what());
    return 2;
  }
  return 0;
}
