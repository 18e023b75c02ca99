#include <algorithm>
#include <cmath>

#include "battery_sof/csv.hpp"
#include "command.hpp"
#include "prediction/questions.hpp"
#include "report/descriptions.hpp"
#include "report/model_yaml.hpp"
#include "report/results.hpp"
#include "util/text.hpp"

/// The commands that ask a saved model: crank, stop-time, charge and map.
namespace battery_sof {
namespace {

// ---------------------------------------------------------------------------------------------
// current profiles

/// A current profile from a CSV file with columns of time and current, read as a recording's.
/// @throws UsageError naming file, line, what stands there and what was expected.
CurrentProfile readProfile(const std::string& path) {
  CurrentProfile profile;
  std::vector<std::string> notes;
  const auto take = [&](double time, double current, std::size_t line) {
    const auto require = [&](bool holds, const char* name, double value,
                             const std::string& expected) {
      if (!holds)
        throw UsageError(path + format(", line %zu: %s is %g, expected ", line, name, value) +
                         expected);
    };
    require(std::isfinite(time), "time", time, "a finite number");
    require(std::isfinite(current), "current", current, "a finite number");
    require(time >= 0.0, "time", time, "0 or more");
    if (!profile.empty())
      require(time > profile.time.back(), "time", time,
              format("more than the %g before it", profile.time.back()));
    profile.time.push_back(time);
    profile.current.push_back(current);
  };
  try {
    readProfileCsv(path, {}, take, &notes);
  } catch (const RecordingError& error) {
    throw UsageError(error.what());
  }
  for (const std::string& note : notes)
    std::fprintf(stderr, "sof: %s: %s\n", path.c_str(), note.c_str());
  return profile;
}

// ---------------------------------------------------------------------------------------------
// what all questions share

struct QueryArguments {
  std::string model;
  std::optional<double> capacity_ah;
  bool rested = false;
  std::string json;
};

void addQueryOptions(CLI::App& command, QueryArguments& arguments) {
  addModelOption(command, arguments.model);
  addOption(command, "--capacity-ah", arguments.capacity_ah,
            "nominal capacity [Ah]; default: as it was given to sof identify, else 50");
  command.add_flag("--rested", arguments.rested,
                   "begin from a rested battery, not from the saved state");
  addJsonOption(command, arguments.json);
}

/// The model, rested when that was asked.
FittedModel modelOf(const QueryArguments& arguments) {
  requireCapacity(arguments.capacity_ah);
  const FittedModel saved = readModelFile(arguments.model);
  return arguments.rested ? rested(saved) : saved;
}

/// @return the exit code to an answer, after printing it: negative where it is not valid or does not
/// assure the limit. @throws UsageError for an invalid query.
template <typename Answer>
int finish(const CommandLine& line, const Answer& answer, const std::string& text,
           const nlohmann::json& json, const QueryArguments& general) {
  if (answer.code == AnswerCode::kInvalidQuery) throw UsageError(answer.message);
  emit(line, text, json, general.json);
  if (answer.code == AnswerCode::kOk && assuranceOf(answer) != Assurance::kNotAssured)
    return kExitDone;
  if (general.json == "-") complain(line.err, answer.message);  // else the text says it
  return kExitNegative;
}

template <typename Query>
struct QuestionArguments {
  QueryArguments general;
  Query query;
};

template <typename Query>
Query queryOf(const QuestionArguments<Query>& arguments) {
  return asked(arguments.query);
}

/// @tparam predict what answers: predictCranking() or another of its kind.
template <auto predict, typename Arguments>
int ask(const CommandLine& line, const Arguments& arguments) {
  const FittedModel model = modelOf(arguments.general);
  const auto query = queryOf(arguments);
  const auto answer = predict(model, query, capacityFor(model.fit, arguments.general.capacity_ah));
  return finish(line, answer, resultText(query, answer), jsonOf(answer), arguments.general);
}

// ---------------------------------------------------------------------------------------------
// the questions

constexpr char kLoad[] = "current of the consumers during the stop [A], <= 0";
constexpr char kStop[] = "duration of the stop [s]";
constexpr char kCrank[] = "current of the crank [A], < 0";
constexpr char kCrankTime[] = "duration of the crank [s]";
constexpr char kRequired[] = "voltage that the starter needs [V]";
constexpr char kSource[] = "largest current of the charger [A]";

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

using StopTimeArguments = QuestionArguments<StopTimeQuery>;
using ChargeArguments = QuestionArguments<ChargeAcceptanceQuery>;

struct MapArguments {
  QueryArguments general;
  std::vector<double> i_load, t_stop, u_boost, t_sof2;
  std::optional<double> i_cranking;
  CrankingQuery crank;
  ChargeAcceptanceQuery charge;
};

MapResult mapsOf(const MapArguments& arguments, Progress& progress) {
  const FittedModel model = modelOf(arguments.general);
  const double capacity = capacityFor(model.fit, arguments.general.capacity_ah);
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
  return finish(line, verdictOf(result.cranking, result.charge), resultText(result), jsonOf(result),
                arguments.general);
}

}  // namespace

void addCrankCommand(CLI::App& app, CommandLine& line) {
  const auto [options, values] =
      addSubcommand(app, line, "crank", "lowest voltage of a crank after a stop (SOF1)",
                    ask<predictCranking, CrankArguments>);
  addQueryOptions(options, values.general);
  auto* i_load = addOption(options, "--i-load", values.i_load, kLoad);
  auto* t_stop = addOption(options, "--t-stop", values.t_stop, kStop);
  auto* i_cranking = addOption(options, "--i-cranking", values.i_cranking, kCrank);
  auto* t_cranking = addOption(options, "--t-cranking", values.t_cranking, kCrankTime);
  addOption(options, "--u-required", values.u_required, kRequired);
  addFile(options, kReadFile, "--load-profile", values.load_profile,
          "CSV time_s,current_a of the stop, in place of --i-load and --t-stop")
      ->excludes(i_load, t_stop);
  addFile(options, kReadFile, "--crank-profile", values.crank_profile,
          "CSV time_s,current_a of the crank, in place of --i-cranking and --t-cranking")
      ->excludes(i_cranking, t_cranking);
}

void addStopTimeCommand(CLI::App& app, CommandLine& line) {
  const auto [options, values] = addSubcommand(
      app, line, "stop-time", "longest stop after which a crank still holds a voltage",
      ask<predictStopTime, StopTimeArguments>);
  addQueryOptions(options, values.general);
  addRequired(options, "--i-load", values.query.i_load, kLoad);
  addRequired(options, "--i-cranking", values.query.i_cranking, kCrank);
  addOption(options, "--t-cranking", values.query.t_cranking, kCrankTime);
  addRequired(options, "--u-required", values.query.u_required, kRequired);
}

void addChargeCommand(CLI::App& app, CommandLine& line) {
  const auto [options, values] =
      addSubcommand(app, line, "charge", "mean current at a held voltage (SOF2)",
                    ask<predictChargeAcceptance, ChargeArguments>);
  addQueryOptions(options, values.general);
  addRequired(options, "--u-boost", values.query.u_boost, "voltage that the charger holds [V]");
  addOption(options, "--t-sof2", values.query.t_sof2, "time over which the mean is taken [s]");
  addOption(options, "--i-limit", values.query.i_limit, kSource);
}

void addMapCommand(CLI::App& app, CommandLine& line) {
  const auto [options, values] = addSubcommand(
      app, line, "map",
      "cranks over (--i-load, --t-stop), charge currents over (--u-boost, --t-sof2), or both",
      runMap);
  addQueryOptions(options, values.general);
  const auto add_list = [&options = options](const char* name, std::vector<double>& list,
                                             const char* description) {
    addList(options, name, list, description)->allow_extra_args(false);
  };
  add_list("--i-load", values.i_load,
           "rows: currents of the consumers during the stop [A], comma-separated");
  add_list("--t-stop", values.t_stop, "columns: durations of the stop [s], comma-separated");
  addOption(options, "--i-cranking", values.i_cranking, kCrank);
  addOption(options, "--t-cranking", values.crank.t_cranking, kCrankTime);
  addOption(options, "--u-required", values.crank.u_required, kRequired);
  add_list("--u-boost", values.u_boost,
           "rows: voltages that the charger holds [V], comma-separated");
  add_list("--t-sof2", values.t_sof2,
           "columns: times over which the mean is taken [s], comma-separated");
  addOption(options, "--i-limit", values.charge.i_limit, kSource);
}

}  // namespace battery_sof
