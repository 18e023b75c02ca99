#include "prediction/charge_acceptance.hpp"

#include "query_options.hpp"
#include "report/answers.hpp"

namespace battery_sof {
namespace {

struct ChargeArguments {
  QueryArguments general;
  ChargeAcceptanceQuery query;
};

int runCharge(const CommandLine& line, const ChargeArguments& arguments) {
  const FittedModel model = modelOf(arguments.general);
  const ChargeAcceptanceQuery query = asked(arguments.query);
  const ChargeAcceptanceAnswer answer =
      predictChargeAcceptance(model, query, arguments.general.capacity_ah);
  return finish(line, answer, chargeAcceptanceText(query, answer), chargeAcceptanceJson(answer),
                arguments.general.json);
}

}  // namespace

void addChargeCommand(CLI::App& app, CommandLine& line) {
  CLI::App* command = app.add_subcommand("charge", "mean current at a held voltage (SOF2)");
  auto arguments = std::make_shared<ChargeArguments>();
  addQueryOptions(*command, arguments->general);
  auto& query = arguments->query;
  command->add_option("--u-boost", query.u_boost, "voltage held [V]")->required();
  command->add_option("--t-sof2", query.t_sof2, "how long [s]")->capture_default_str();
  command->add_option("--i-limit", query.i_limit, "what the source can give [A]")
      ->capture_default_str();
  command->callback([&line, arguments] {
    line.run = [&line, arguments] { return runCharge(line, *arguments); };
  });
}

}  // namespace battery_sof
