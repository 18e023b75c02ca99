#include "prediction/stop_time.hpp"

#include "query_options.hpp"
#include "report/answers.hpp"

namespace battery_sof {
namespace {

struct StopTimeArguments {
  QueryArguments general;
  StopTimeQuery query;
};

int runStopTime(const CommandLine& line, const StopTimeArguments& arguments) {
  const FittedModel model = modelOf(arguments.general);
  const StopTimeQuery query = asked(arguments.query);
  const StopTimeAnswer answer = predictStopTime(model, query, arguments.general.capacity_ah);
  return finish(line, answer, stopTimeText(query, answer), stopTimeJson(answer),
                arguments.general.json);
}

}  // namespace

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
  command->callback([&line, arguments] {
    line.run = [&line, arguments] { return runStopTime(line, *arguments); };
  });
}

}  // namespace battery_sof
