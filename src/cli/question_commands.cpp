#include "prediction/charge_acceptance.hpp"
#include "prediction/maps.hpp"
#include "prediction/stop_time.hpp"
#include "query_options.hpp"
#include "report/descriptions.hpp"
#include "report/results.hpp"

namespace battery_sof {
namespace {

struct CrankArguments {
  QueryArguments general;
  std::optional<double> i_load, t_stop, i_cranking, u_required;
  double t_cranking = 1.0;
  std::string load_profile, crank_profile;
};

double given(const std::optional<double>& value, const char* name, const char* profile) {
  if (!value) throw UsageError(std::string(name) + " or " + profile + " is required");
  return *value;
}

CrankingQuery queryOf(const CrankArguments& arguments) {
  CrankingQuery query;
  query.u_required = arguments.u_required;
  query.t_cranking = arguments.t_cranking;
  if (arguments.load_profile.empty()) {
    query.i_load = given(arguments.i_load, "--i-load", "--load-profile");
    query.t_stop = given(arguments.t_stop, "--t-stop", "--load-profile");
  } else {
    query.load = readProfile(arguments.load_profile);
  }
  if (arguments.crank_profile.empty())
    query.i_cranking = given(arguments.i_cranking, "--i-cranking", "--crank-profile");
  else
    query.crank = readProfile(arguments.crank_profile);
  return asked(std::move(query));
}

int runCrank(const CommandLine& line, const CrankArguments& arguments) {
  const FittedModel model = modelOf(arguments.general);
  const CrankingQuery query = queryOf(arguments);
  const CrankingAnswer answer = predictCranking(model, query, arguments.general.capacity_ah);
  return finish(line, answer, resultText(query, answer), resultJson(answer),
                arguments.general.json);
}

struct StopTimeArguments {
  QueryArguments general;
  StopTimeQuery query;
};

int runStopTime(const CommandLine& line, const StopTimeArguments& arguments) {
  const FittedModel model = modelOf(arguments.general);
  const StopTimeQuery query = asked(arguments.query);
  const StopTimeAnswer answer = predictStopTime(model, query, arguments.general.capacity_ah);
  return finish(line, answer, resultText(query, answer), resultJson(answer),
                arguments.general.json);
}

struct ChargeArguments {
  QueryArguments general;
  ChargeAcceptanceQuery query;
};

int runCharge(const CommandLine& line, const ChargeArguments& arguments) {
  const FittedModel model = modelOf(arguments.general);
  const ChargeAcceptanceQuery query = asked(arguments.query);
  const ChargeAcceptanceAnswer answer =
      predictChargeAcceptance(model, query, arguments.general.capacity_ah);
  return finish(line, answer, resultText(query, answer), resultJson(answer),
                arguments.general.json);
}

struct MapArguments {
  QueryArguments general;
  std::vector<double> i_load, t_stop, u_boost, t_sof2;
  std::optional<double> i_cranking;
  CrankingQuery crank;
  ChargeAcceptanceQuery charge;
};

MapResult mapsOf(const MapArguments& arguments, Progress& progress) {
  const FittedModel model = modelOf(arguments.general);
  const double capacity = arguments.general.capacity_ah;
  const auto done = [&progress](double share) {
    progress.done(share);
    return std::string();
  };
  MapResult result{arguments.i_load, arguments.t_stop, {}, arguments.u_boost, arguments.t_sof2, {}};
  if (!result.i_load.empty() || !result.t_stop.empty()) {
    if (!arguments.i_cranking)
      throw UsageError("--i-cranking is required with --i-load and --t-stop");
    CrankingQuery crank = asked(arguments.crank);
    crank.i_cranking = *arguments.i_cranking;
    progress.stage("mapping cranks");
    result.cranking = mapCranking(model, crank, result.i_load, result.t_stop, capacity, done);
  }
  if (!result.u_boost.empty() || !result.t_sof2.empty()) {
    progress.stage("mapping charges");
    result.charge = mapChargeAcceptance(model, asked(arguments.charge), result.u_boost,
                                        result.t_sof2, capacity, done);
  }
  return result;
}

int runMap(const CommandLine& line, const MapArguments& arguments) {
  Progress progress(line.err);
  const MapResult result = mapsOf(arguments, progress);
  progress.end();
  return finish(line, verdictOf(result.cranking, result.charge), resultText(result),
                resultJson(result), arguments.general.json);
}

void addList(CLI::App& command, const char* name, std::vector<double>& list,
             const char* description) {
  command.add_option(name, list, description)->delimiter(',')->allow_extra_args(false);
}

}  // namespace

void addCrankCommand(CLI::App& app, CommandLine& line) {
  CLI::App* command = app.add_subcommand("crank", "lowest voltage of a crank after a stop (SOF1)");
  auto arguments = std::make_shared<CrankArguments>();
  addQueryOptions(*command, arguments->general);
  auto* i_load =
      command->add_option("--i-load", arguments->i_load, "current while stopped [A], <= 0");
  auto* t_stop = command->add_option("--t-stop", arguments->t_stop, "duration of the stop [s]");
  auto* i_cranking =
      command->add_option("--i-cranking", arguments->i_cranking, "current of the crank [A], < 0");
  auto* t_cranking =
      command->add_option("--t-cranking", arguments->t_cranking, "duration of the crank [s]")
          ->capture_default_str();
  command->add_option("--u-required", arguments->u_required,
                      "lowest voltage that still cranks [V]");
  command
      ->add_option("--load-profile", arguments->load_profile,
                   "CSV time_s,current_a of the stop, in place of --i-load and --t-stop")
      ->type_name(kReadFile)
      ->excludes(i_load, t_stop);
  command
      ->add_option("--crank-profile", arguments->crank_profile,
                   "CSV time_s,current_a of the crank, in place of --i-cranking and --t-cranking")
      ->type_name(kReadFile)
      ->excludes(i_cranking, t_cranking);
  whenChosen(*command, line, arguments, runCrank);
}

void addStopTimeCommand(CLI::App& app, CommandLine& line) {
  CLI::App* command =
      app.add_subcommand("stop-time", "longest stop after which a crank still holds a voltage");
  auto arguments = std::make_shared<StopTimeArguments>();
  addQueryOptions(*command, arguments->general);
  auto& query = arguments->query;
  command->add_option("--i-load", query.i_load, "current while stopped [A], <= 0")->required();
  command->add_option("--i-cranking", query.i_cranking, "current of the crank [A], < 0")
      ->required();
  command->add_option("--t-cranking", query.t_cranking, "duration of the crank [s]")
      ->capture_default_str();
  command->add_option("--u-required", query.u_required, "lowest voltage that still cranks [V]")
      ->required();
  whenChosen(*command, line, arguments, runStopTime);
}

void addChargeCommand(CLI::App& app, CommandLine& line) {
  CLI::App* command = app.add_subcommand("charge", "mean current at a held voltage (SOF2)");
  auto arguments = std::make_shared<ChargeArguments>();
  addQueryOptions(*command, arguments->general);
  auto& query = arguments->query;
  command->add_option("--u-boost", query.u_boost, "voltage held [V]")->required();
  command->add_option("--t-sof2", query.t_sof2, "how long [s]")->capture_default_str();
  command->add_option("--i-limit", query.i_limit, "what the source can give [A]")
      ->capture_default_str();
  whenChosen(*command, line, arguments, runCharge);
}

void addMapCommand(CLI::App& app, CommandLine& line) {
  CLI::App* command = app.add_subcommand(
      "map",
      "cranks over (--i-load, --t-stop), charge currents over (--u-boost, --t-sof2), or both");
  auto arguments = std::make_shared<MapArguments>();
  addQueryOptions(*command, arguments->general);
  addList(*command, "--i-load", arguments->i_load,
          "rows: currents while stopped [A], comma-separated");
  addList(*command, "--t-stop", arguments->t_stop,
          "columns: durations of the stop [s], comma-separated");
  command->add_option("--i-cranking", arguments->i_cranking, "current of the crank [A], < 0");
  command->add_option("--t-cranking", arguments->crank.t_cranking, "duration of the crank [s]")
      ->capture_default_str();
  command->add_option("--u-required", arguments->crank.u_required,
                      "lowest voltage that still cranks [V]");
  addList(*command, "--u-boost", arguments->u_boost, "rows: voltages held [V], comma-separated");
  addList(*command, "--t-sof2", arguments->t_sof2, "columns: how long [s], comma-separated");
  command->add_option("--i-limit", arguments->charge.i_limit, "what the source can give [A]")
      ->capture_default_str();
  whenChosen(*command, line, arguments, runMap);
}

}  // namespace battery_sof
