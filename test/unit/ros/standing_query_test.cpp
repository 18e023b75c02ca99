#include "ros/message_conversion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace battery_sof {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

SetStandingQuery::Request nothingAsked() {
  SetStandingQuery::Request request;
  request.i_load = request.t_stop = request.i_cranking = request.t_cranking = request.u_required =
      request.u_boost = request.t_sof2 = request.i_limit = std::numeric_limits<double>::quiet_NaN();
  return request;
}

TEST(StandingQuery, WhatIsNotGivenStays) {
  SetStandingQuery::Request request = nothingAsked();
  request.u_required = 9.0;
  request.i_limit = 120.0;
  const StandingQueries changed = changedBy(request, StandingQueries());
  EXPECT_EQ(changed.cranking.u_required, 9.0);
  EXPECT_EQ(changed.charge.i_limit, 120.0);
  EXPECT_EQ(changed.cranking.i_cranking, StandingQueries().cranking.i_cranking);
  EXPECT_EQ(changed.charge.u_boost, StandingQueries().charge.u_boost);
}

TEST(StandingQuery, OfARequestThatWasNotFilledInOnlyLoadAndStopAreTaken) {
  const StandingQueries present{{-30.0, 60.0, -300.0, 0.5, 8.0}, {13.5, 5.0, 90.0}, true};
  const StandingQueries changed = changedBy(SetStandingQuery::Request(), present);
  EXPECT_EQ(changed.cranking.i_load, 0.0);
  EXPECT_EQ(changed.cranking.t_stop, 0.0);
  EXPECT_EQ(changed.cranking.i_cranking, -300.0);
  EXPECT_EQ(changed.cranking.t_cranking, 0.5);
  EXPECT_EQ(changed.cranking.u_required, 8.0);
  EXPECT_EQ(changed.charge.u_boost, 13.5);
  EXPECT_EQ(changed.charge.t_sof2, 5.0);
  EXPECT_EQ(changed.charge.i_limit, 90.0);
}

TEST(StandingQuery, AVoltageThatIsGivenIsAskedFromThenOnAndElseThatOfPastCharges) {
  StandingQueries row;
  row.charge.u_boost = 28.4;
  const StandingQueries kept = changedBy(nothingAsked(), row);
  EXPECT_FALSE(kept.u_boost_is_given);
  EXPECT_EQ(kept.charge.u_boost, 28.4);
  EXPECT_EQ(responseOf(kept, 25.8).u_boost, 25.8);
  SetStandingQuery::Request request = nothingAsked();
  request.u_boost = 27.0;
  const StandingQueries given = changedBy(request, row);
  EXPECT_EQ(responseOf(given, 25.8).u_boost, 27.0);
  EXPECT_EQ(responseOf(changedBy(nothingAsked(), given), 25.8).u_boost, 27.0);
}

TEST(StandingQuery, AVoltageThatIsNotAskedStaysUnasked) {
  StandingQueries present;
  present.cranking.u_required.reset();
  EXPECT_FALSE(changedBy(nothingAsked(), present).cranking.u_required);
  SetStandingQuery::Request request = nothingAsked();
  request.u_required = 8.0;
  EXPECT_EQ(changedBy(request, present).cranking.u_required, 8.0);
}

TEST(StandingQuery, EveryValueOutOfItsRangeIsNamed) {
  SetStandingQuery::Request request = nothingAsked();
  request.i_load = 20.0;
  request.t_sof2 = -1.0;
  try {
    changedBy(request, StandingQueries());
    FAIL() << "was taken";
  } catch (const NodeOptionsError& error) {
    const auto response = responseOf(StandingQueries(), std::nullopt, error.what());
    EXPECT_FALSE(response.success);
    EXPECT_EQ(response.code, SetStandingQuery::Response::INVALID_QUERY);
    EXPECT_THAT(response.message,
                AllOf(HasSubstr("standing_query/i_load_a is 20, expected -500 to 0"),
                      HasSubstr("t_sof2_s is -1"), Not(HasSubstr("\n"))));
    EXPECT_EQ(response.i_load, StandingQueries().cranking.i_load);
  }
}

TEST(StandingQuery, TheResponseHoldsAllThatIsAsked) {
  const auto response =
      responseOf(StandingQueries{{-30.0, 60.0, -300.0, 0.5, 8.0}, {13.5, 5.0, 90.0}}, std::nullopt);
  EXPECT_TRUE(response.success);
  const std::vector<double> values = {response.i_load,     response.t_stop,     response.i_cranking,
                                      response.t_cranking, response.u_required, response.u_boost,
                                      response.t_sof2,     response.i_limit};
  EXPECT_EQ(values, (std::vector<double>{-30.0, 60.0, -300.0, 0.5, 8.0, 13.5, 5.0, 90.0}));
}

}  // namespace
}  // namespace battery_sof
