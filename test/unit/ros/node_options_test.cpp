#include "battery_sof/ros/node_options.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

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
  EXPECT_EQ(options.standing_query.i_cranking, -200.0);
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
  double number = 0.0;
  if (YAML::convert<double>::decode(node, number)) return XmlRpc::XmlRpcValue(number);
  return XmlRpc::XmlRpcValue(node.as<std::string>());
}

TEST(NodeOptions, ShippedFileHoldsEveryDefault) {
  const YAML::Node file = YAML::LoadFile(BATTERY_SOF_SOURCE_DIR "/config/battery_sof.yaml");
  const NodeOptions shipped = parseNodeOptions(asParameters(file));
  const NodeOptions built_in;
  EXPECT_EQ(shipped.session.buffer, built_in.session.buffer);
  EXPECT_EQ(shipped.session.window_length, built_in.session.window_length);
  EXPECT_EQ(shipped.session.min_suitability, built_in.session.min_suitability);
  EXPECT_EQ(shipped.session.identify_period, built_in.session.identify_period);
  EXPECT_EQ(shipped.session.retry_period, built_in.session.retry_period);
  EXPECT_EQ(shipped.session.model_max_age, built_in.session.model_max_age);
  EXPECT_EQ(shipped.session.capacity, built_in.session.capacity);
  EXPECT_EQ(shipped.session.events.crank_current, built_in.session.events.crank_current);
  EXPECT_EQ(shipped.session.identify.start, built_in.session.identify.start);
  EXPECT_EQ(shipped.session.identify.crank_weight, built_in.session.identify.crank_weight);
  EXPECT_EQ(shipped.session.identify.crank_weight_current,
            built_in.session.identify.crank_weight_current);
  EXPECT_EQ(shipped.session.identify.max_iterations, built_in.session.identify.max_iterations);
  EXPECT_EQ(shipped.standing_query.i_load, built_in.standing_query.i_load);
  EXPECT_EQ(shipped.standing_query.t_stop, built_in.standing_query.t_stop);
  EXPECT_EQ(shipped.standing_query.i_cranking, built_in.standing_query.i_cranking);
  EXPECT_EQ(shipped.standing_query.t_cranking, built_in.standing_query.t_cranking);
  EXPECT_EQ(shipped.standing_query.u_required, built_in.standing_query.u_required);
}

TEST(NodeOptions, IntegersAndNumbersAreBothNumbers) {
  EXPECT_EQ(parseNodeOptions(with("buffer_s", 600)).session.buffer, 600.0);
  EXPECT_EQ(parseNodeOptions(with("buffer_s", 600.5)).session.buffer, 600.5);
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
