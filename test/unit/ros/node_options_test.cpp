#include "ros/node_options.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <limits>

namespace battery_sof {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string refusal(const XmlRpc::XmlRpcValue& parameters) {
  try {
    parseNodeOptions(parameters);
  } catch (const NodeOptionsError& error) {
    return error.what();
  }
  return "";
}

XmlRpc::XmlRpcValue with(const std::string& key, const XmlRpc::XmlRpcValue& value) {
  XmlRpc::XmlRpcValue parameters;
  parameters[key] = value;
  return parameters;
}

TEST(NodeOptions, NothingGivenIsTheDefaults) {
  const NodeOptions options = parseNodeOptions(XmlRpc::XmlRpcValue());
  EXPECT_EQ(options.session.buffer, 1800.0);
  EXPECT_FALSE(options.session.window_length);
  EXPECT_EQ(options.standing.cranking.i_cranking, -200.0);
  EXPECT_TRUE(options.state_file.empty());
}

/// Parameters as the parameter server would hold them; scalars of a YAML file that are numbers are
/// doubles.
XmlRpc::XmlRpcValue asParameters(const YAML::Node& node) {
  XmlRpc::XmlRpcValue value;
  if (node.IsMap()) {
    for (const auto& entry : node)
      value[entry.first.as<std::string>()] = asParameters(entry.second);
    return value;
  }
  const std::string text = node.as<std::string>();
  if (text == "true" || text == "false") return XmlRpc::XmlRpcValue(text == "true");
  double number = 0.0;
  if (YAML::convert<double>::decode(node, number)) return XmlRpc::XmlRpcValue(number);
  return XmlRpc::XmlRpcValue(text);
}

TEST(NodeOptions, ShippedFileHoldsEveryDefault) {
  const YAML::Node file = YAML::LoadFile(BATTERY_SOF_SOURCE_DIR "/config/battery_sof.yaml");
  const NodeOptions shipped = parseNodeOptions(asParameters(file));
  const NodeOptions built_in;
  EXPECT_EQ(shipped.session.buffer, built_in.session.buffer);
  EXPECT_EQ(shipped.session.window_length, built_in.session.window_length);
  EXPECT_EQ(shipped.session.min_window_quality, built_in.session.min_window_quality);
  EXPECT_EQ(shipped.session.identify_period, built_in.session.identify_period);
  EXPECT_EQ(shipped.session.retry_period, built_in.session.retry_period);
  EXPECT_EQ(shipped.session.capacity, built_in.session.capacity);
  EXPECT_EQ(shipped.session.series_blocks, built_in.session.series_blocks);
  EXPECT_EQ(shipped.session.events.crank_current, built_in.session.events.crank_current);
  EXPECT_EQ(shipped.session.identify.start, built_in.session.identify.start);
  EXPECT_EQ(shipped.session.identify.crank_weight, built_in.session.identify.crank_weight);
  EXPECT_EQ(shipped.session.identify.crank_current, built_in.session.identify.crank_current);
  EXPECT_EQ(shipped.session.identify.max_iterations, built_in.session.identify.max_iterations);
  EXPECT_EQ(shipped.diagnose_period, built_in.diagnose_period);
  EXPECT_EQ(shipped.change_period, built_in.change_period);
  EXPECT_EQ(shipped.use_diagnosis, built_in.use_diagnosis);
  EXPECT_EQ(shipped.standing.cranking.i_load, built_in.standing.cranking.i_load);
  EXPECT_EQ(shipped.standing.cranking.t_stop, built_in.standing.cranking.t_stop);
  EXPECT_EQ(shipped.standing.cranking.i_cranking, built_in.standing.cranking.i_cranking);
  EXPECT_EQ(shipped.standing.cranking.t_cranking, built_in.standing.cranking.t_cranking);
  EXPECT_EQ(shipped.standing.cranking.u_required, built_in.standing.cranking.u_required);
  EXPECT_EQ(shipped.standing.charge.u_boost, built_in.standing.charge.u_boost);
  EXPECT_EQ(shipped.standing.charge.t_sof2, built_in.standing.charge.t_sof2);
  EXPECT_EQ(shipped.standing.charge.i_limit, built_in.standing.charge.i_limit);
}

TEST(NodeOptions, TakesWhatStandardLibrariesReadBelowTheNodesName) {
  XmlRpc::XmlRpcValue given = with("diagnostic_period", 5.0);
  given["identify"] = with("status_list_timeout", 5.0);
  given["actionlib_status_frequency"] = 5.0;
  given["diagnose"] = with("status_frequency", 2);
  EXPECT_EQ(parseNodeOptions(given).diagnostic_period, 5.0);
  given["diagnose"] = with("timeout", 2);
  EXPECT_THAT(refusal(given), HasSubstr("~diagnose/timeout is unknown"));
}

TEST(NodeOptions, KnowsWhetherTheCapacityIsGiven) {
  EXPECT_FALSE(parseNodeOptions({}).session.capacity);
  EXPECT_EQ(parseNodeOptions(with("capacity_ah", 50.0)).session.capacity, 50.0);
  EXPECT_EQ(parseNodeOptions(with("battery_name", std::string("starter"))).battery_name, "starter");
}

TEST(NodeOptions, VoltagesOfARowOfBlocksAreAsManyTimesAsLargeByDefault) {
  for (const XmlRpc::XmlRpcValue& two : {XmlRpc::XmlRpcValue(2), XmlRpc::XmlRpcValue(2.0)}) {
    const NodeOptions row = parseNodeOptions(with("series_blocks", two));
    EXPECT_EQ(row.session.series_blocks, 2.0);
    EXPECT_EQ(row.standing.cranking.u_required, 14.4);
    EXPECT_EQ(row.standing.charge.u_boost, 28.4);
  }
  XmlRpc::XmlRpcValue given = with("series_blocks", 0.5);
  given["standing_query"] = with("u_required_v", 3.9);
  EXPECT_EQ(parseNodeOptions(given).standing.cranking.u_required, 3.9);
  EXPECT_EQ(parseNodeOptions(given).standing.charge.u_boost, 7.1);
  EXPECT_THAT(
      refusal(with("series_blocks", 0.7)),
      HasSubstr(
          "~series_blocks is 0.7, expected 0.5 (6 V), 1 (12 V), 2 (24 V), 4 (48 V) or another"));
  EXPECT_THAT(refusal(with("series_blocks", 24)),
              HasSubstr("~series_blocks is 24, expected 0.5 to 6"));
  EXPECT_THAT(refusal(with("series_blocks", "two")),
              HasSubstr("~series_blocks is a string, expected a number"));
}

TEST(NodeOptions, IntegersAndNumbersAreBothNumbers) {
  EXPECT_EQ(parseNodeOptions(with("buffer_s", 600)).session.buffer, 600.0);
  EXPECT_EQ(parseNodeOptions(with("buffer_s", 600.5)).session.buffer, 600.5);
}

TEST(NodeOptions, DiagnosisIsOnRequestAndNotAdoptedUnlessAskedFor) {
  const NodeOptions standard = parseNodeOptions(XmlRpc::XmlRpcValue());
  EXPECT_EQ(standard.diagnose_period, 0.0);
  EXPECT_FALSE(standard.use_diagnosis);
  EXPECT_EQ(parseNodeOptions(with("diagnose_period_s", 900)).diagnose_period, 900.0);
  EXPECT_TRUE(parseNodeOptions(with("use_diagnosis", true)).use_diagnosis);
}

TEST(NodeOptions, DiagnosisOptionsThatCannotBeAreNamedTogether) {
  XmlRpc::XmlRpcValue parameters = with("diagnose_period_s", 20.0);
  parameters["use_diagnosis"] = true;
  parameters["fit"] = with("start", std::string("paper"));
  EXPECT_THAT(
      refusal(parameters),
      AllOf(HasSubstr("~diagnose_period_s is 20, expected 0 (only on request) or 60 to 86400"),
            HasSubstr("~use_diagnosis is true and ~fit/start paper")));
  EXPECT_THAT(refusal(with("change_period_s", 20.0)),
              HasSubstr("~change_period_s is 20, expected 0 (never) or 60 to 86400"));
  EXPECT_THAT(refusal(with("use_diagnosis", 1)),
              HasSubstr("~use_diagnosis is an integer, expected true or false"));
}

TEST(NodeOptions, UnknownKeyIsNamedWithTheKnownOnes) {
  EXPECT_THAT(refusal(with("bufer_s", 600.0)),
              AllOf(HasSubstr("~bufer_s is unknown"), HasSubstr("buffer_s")));
  EXPECT_THAT(refusal(with("standing_query", with("t_stop", 3.0))),
              HasSubstr("~standing_query/t_stop is unknown"));
}

TEST(NodeOptions, WrongTypeIsNamed) {
  EXPECT_THAT(refusal(with("buffer_s", "600")), HasSubstr("~buffer_s is a string"));
  EXPECT_THAT(refusal(with("fit", 3)), HasSubstr("~fit/ is an integer, expected a map"));
  EXPECT_THAT(refusal(with("state_file", 3)), HasSubstr("~state_file is an integer"));
}

TEST(NodeOptions, OutOfRangeIsNamedWithTheRangeAndNanIsOutOfEveryRange) {
  EXPECT_THAT(refusal(with("capacity_ah", -5.0)),
              HasSubstr("~capacity_ah is -5, expected 1 to 1000"));
  EXPECT_THAT(refusal(with("capacity_ah", std::numeric_limits<double>::quiet_NaN())),
              HasSubstr("~capacity_ah is nan"));
  EXPECT_THAT(refusal(with("fit", with("start", "clever"))), HasSubstr("robust or paper"));
}

TEST(NodeOptions, StandingChargeIsCheckedLikeTheRest) {
  XmlRpc::XmlRpcValue query = with("u_boost_v", 0.5);
  query["t_sof2_s"] = 4000.0;
  query["i_limit_a"] = "much";
  EXPECT_THAT(refusal(with("standing_query", query)),
              AllOf(HasSubstr("~standing_query/u_boost_v is 0.5, expected 0 (at which the battery "
                              "was charged lately) or 1 to 100"),
                    HasSubstr("~standing_query/t_sof2_s is 4000, expected 0.1 to 3600"),
                    HasSubstr("~standing_query/i_limit_a is a string")));
}

TEST(NodeOptions, StandingStopTimeAsksForTheStandingCrank) {
  XmlRpc::XmlRpcValue query = with("i_load_a", -15.0);
  query["t_cranking_s"] = 0.5;
  NodeOptions options = parseNodeOptions(with("standing_query", query));
  const StopTimeQuery stop_time = options.standing.stopTime();
  EXPECT_EQ(stop_time.i_load, -15.0);
  EXPECT_EQ(stop_time.t_cranking, 0.5);
  EXPECT_EQ(stop_time.u_required, 7.2);
  options.standing.cranking.u_required.reset();
  EXPECT_EQ(options.standing.stopTime().u_required, 0.0) << "not asked";
}

TEST(NodeOptions, ZeroIsNotAskedWhereItHasNoMeaning) {
  XmlRpc::XmlRpcValue query = with("u_required_v", 0.0);
  query["u_boost_v"] = 0;
  const NodeOptions options = parseNodeOptions(with("standing_query", query));
  EXPECT_FALSE(options.standing.cranking.u_required);
  EXPECT_FALSE(options.standing.u_boost_is_given);
  EXPECT_EQ(options.standing.charge.u_boost, 14.2);
}

TEST(StandingQueries, AskAtTheVoltageTheBatteryWasChargedAtUnlessOneIsGiven) {
  StandingQueries standing;
  EXPECT_EQ(standing.chargeAt(std::nullopt).u_boost, 14.2);
  EXPECT_EQ(standing.chargeAt(12.9).u_boost, 12.9);
  standing = parseNodeOptions(with("standing_query", with("u_boost_v", 14.4))).standing;
  EXPECT_EQ(standing.chargeAt(12.9).u_boost, 14.4);
}

TEST(NodeOptions, PriorsAreReadForTheTypeOfVehicleAndWhatCannotBeReadIsNamed) {
  const auto file = std::filesystem::temp_directory_path() /
                    ("battery_sof priors " + std::to_string(getpid()) + ".yaml");
  std::ofstream(file) << "schema: battery_sof/priors/1\npriors:\n"
                         "- {vehicle_type: van, effects: [], parameters: {r_discharge: {value: "
                         "0.006, std: 0.2, logarithmic: true}}}\n"
                         "- {vehicle_type: '', effects: [], parameters: {r_discharge: {value: "
                         "0.004, std: 0.3, logarithmic: true}}}\n";
  XmlRpc::XmlRpcValue given = with("priors", file.string());
  const auto resistance = [&] {
    return parseNodeOptions(given).session.identify.priors.at(0).parameters.at(0).value;
  };
  EXPECT_EQ(resistance(), 0.004);
  given["vehicle_type"] = std::string("van");
  EXPECT_EQ(resistance(), 0.006);
  std::ofstream(file) << "schema: other\n";
  EXPECT_THAT(refusal(given), AllOf(HasSubstr("~priors: "), HasSubstr("schema is \"other\"")));
  std::filesystem::remove(file);
  EXPECT_THAT(refusal(given), AllOf(HasSubstr("~priors: "), HasSubstr(file.filename().string())));
  EXPECT_THAT(refusal(with("vehicle_type", std::string("van"))),
              HasSubstr("~vehicle_type is 'van', expected only with ~priors"));
}

TEST(NodeOptions, ContradictionIsNamed) {
  XmlRpc::XmlRpcValue parameters = with("buffer_s", 300.0);
  parameters["window_s"] = 400.0;
  EXPECT_THAT(refusal(parameters), HasSubstr("at most ~buffer_s, which is 300"));
}

TEST(NodeOptions, AllFaultsComeAtOnce) {
  XmlRpc::XmlRpcValue parameters = with("buffer_s", "long");
  parameters["window"] = 240.0;
  parameters["standing_query"] = with("i_load_a", 20.0);
  EXPECT_THAT(refusal(parameters), AllOf(HasSubstr("~buffer_s"), HasSubstr("~window is unknown"),
                                         HasSubstr("~standing_query/i_load_a is 20")));
}

}  // namespace
}  // namespace battery_sof
