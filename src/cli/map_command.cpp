#include "prediction/maps.hpp"

#include "query_options.hpp"
#include "report/answers.hpp"

namespace battery_sof {
namespace {

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
  return finish(line, verdictOf(result.cranking, result.charge), mapText(result), mapJson(result),
                arguments.general.json);
}

void addList(CLI::App& command, const char* name, std::vector<double>& list,
             const char* description) {
  command.add_option(name, list, description)->delimiter(',')->allow_extra_args(false);
}

}  // namespace

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
  command->callback(
      [&line, arguments] { line.run = [&line, arguments] { return runMap(line, *arguments); }; });
}

}  // namespace battery_sof
