#include <ostream>

#include "battery_sof/predict/cranking.hpp"
#include "battery_sof/report/model_yaml.hpp"
#include "battery_sof/report/results.hpp"
#include "command.hpp"

namespace battery_sof {
namespace {

struct CrankArguments {
  std::string model;
  CrankingQuery query;
  double capacity_ah = 50.0;
  bool rested = false;
  std::string json;
};

int runCrank(const CommandLine& line, const CrankArguments& arguments) {
  if (!(arguments.capacity_ah > 0.0))
    throw UsageError("--capacity-ah is " + std::to_string(arguments.capacity_ah) +
                     ", expected above 0");
  const FittedModel saved = readModelFile(arguments.model);
  const FittedModel model = arguments.rested ? rested(saved) : saved;
  const CrankingAnswer answer = predictCranking(model, arguments.query, arguments.capacity_ah);
  if (answer.code == AnswerCode::kInvalidQuery) throw UsageError(answer.message);
  emit(line, crankingText(arguments.query, answer), crankingJson(answer), arguments.json);
  if (!answer.valid) line.err << "sof: " << answer.message << "\n";
  return answer.valid ? kExitDone : kExitNegative;
}

}  // namespace

void addCrankCommand(CLI::App& app, CommandLine& line) {
  CLI::App* command = app.add_subcommand("crank", "lowest voltage of a crank after a stop (SOF1)");
  auto arguments = std::make_shared<CrankArguments>();
  command->add_option("MODEL", arguments->model, "model file of sof identify")->required();
  auto& query = arguments->query;
  command->add_option("--i-load", query.i_load, "current while stopped [A], <= 0")->required();
  command->add_option("--t-stop", query.t_stop, "duration of the stop [s]")->required();
  command->add_option("--i-cranking", query.i_cranking, "current of the crank [A], < 0")
      ->required();
  command->add_option("--t-cranking", query.t_cranking, "duration of the crank [s]")
      ->capture_default_str();
  command->add_option("--u-required", query.u_required, "lowest voltage that still cranks [V]");
  command->add_option("--capacity-ah", arguments->capacity_ah, "nominal capacity [Ah]")
      ->capture_default_str();
  command->add_flag("--rested", arguments->rested,
                    "begin from a rested battery, not from the saved state");
  addJsonOption(*command, arguments->json);
  command->callback(
      [&line, arguments] { line.run = [&line, arguments] { return runCrank(line, *arguments); }; });
}

}  // namespace battery_sof
