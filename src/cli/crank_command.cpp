#include <ostream>

#include "prediction/cranking.hpp"
#include "query_options.hpp"
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
  return finish(line, answer, crankingText(query, answer), crankingJson(answer),
                arguments.general.json);
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
  command->callback(
      [&line, arguments] { line.run = [&line, arguments] { return runCrank(line, *arguments); }; });
}

}  // namespace battery_sof
