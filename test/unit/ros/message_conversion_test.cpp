#include "battery_sof/ros/message_conversion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "battery_sof/report/model_yaml.hpp"

namespace battery_sof {
namespace {

FittedModel someModel() {
  FittedModel model;
  model.estimates = {{"r_discharge", "ohm", 0.006, 0.0001, false, true},
                     {"r_charge", "ohm", 0.0085, std::nullopt, true, false},
                     {"c2", "F", 1100.0, 20.0, false, true},
                     {"beta", "1/V", 22.0, 0.5, false, true},
                     {"u_dc", "V", 12.7, 0.01, false, true}};
  model.covariance = Eigen::MatrixXd::Identity(kCovarianceRows, kCovarianceRows) * 1e-4;
  model.state = {1234.5, -0.12, -20.0};
  model.window = {900.0, 1140.0, 24000};
  model.message = "converged";
  model.fit_ms = 12.0;
  return model;
}

TEST(QueryOf, RequirementOfNanIsNone) {
  PredictCranking::Request request;
  request.i_load = -20.0;
  request.u_required = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(queryOf(request).u_required);
  request.u_required = 7.2;
  EXPECT_EQ(queryOf(request).u_required, 7.2);
  EXPECT_EQ(queryOf(request).i_load, -20.0);
}

TEST(ResponseOf, AbsentNumbersAreNanNeverZero) {
  CrankingAnswer answer;
  answer.code = AnswerCode::kNoModel;
  answer.message = "nothing identified yet";
  const PredictCranking::Response response = responseOf(answer);
  EXPECT_TRUE(std::isnan(response.u_min) && std::isnan(response.lower) &&
              std::isnan(response.upper));
  EXPECT_FALSE(response.capable);
  EXPECT_EQ(response.code, PredictCranking::Response::NO_MODEL);
  EXPECT_EQ(response.message, "nothing identified yet");
}

TEST(ResponseOf, CodesOfTheServicesAreThoseOfTheCore) {
  EXPECT_EQ(PredictCranking::Response::OK, static_cast<int>(AnswerCode::kOk));
  EXPECT_EQ(PredictCranking::Response::INVALID_QUERY, static_cast<int>(AnswerCode::kInvalidQuery));
  EXPECT_EQ(PredictCranking::Response::NO_MODEL, static_cast<int>(AnswerCode::kNoModel));
  EXPECT_EQ(PredictCranking::Response::EXTRAPOLATION, static_cast<int>(AnswerCode::kExtrapolation));
  EXPECT_EQ(SimulateProfile::Response::INVALID_QUERY, static_cast<int>(AnswerCode::kInvalidQuery));
  EXPECT_EQ(SimulateProfile::Response::NO_MODEL, static_cast<int>(AnswerCode::kNoModel));
  EXPECT_EQ(SimulateProfile::Response::EXTRAPOLATION, static_cast<int>(AnswerCode::kExtrapolation));
}

TEST(MessageOf, ModelKeepsEveryParameterAndTheWholeFile) {
  const FittedModel model = someModel();
  const IdentifiedModel message = messageOf(model);
  EXPECT_THAT(message.names,
              ::testing::ElementsAre("r_discharge", "r_charge", "c2", "beta", "u_dc"));
  EXPECT_EQ(message.values[2], 1100.0);
  EXPECT_TRUE(std::isnan(message.std[1]));
  EXPECT_TRUE(message.at_bound[1]);
  EXPECT_FALSE(message.determined[1]);
  EXPECT_EQ(message.header.stamp.toSec(), 1234.5);
  EXPECT_EQ(message.u_c2, -0.12);
  EXPECT_EQ(message.window_samples, 24000u);
  EXPECT_EQ(message.status, "converged");
  EXPECT_EQ(message.model_yaml, modelYaml(model));
}

TEST(MessageOf, StatusWithoutModelAndCrankHasNanInTheirPlaces) {
  StatusContents contents;
  contents.session.reason = "no sample yet";
  contents.standing_query = {-20.0, 30.0, -200.0, 1.0, std::nullopt};
  contents.standing_answer.code = AnswerCode::kNoModel;
  const SofStatus message = messageOf(contents);
  EXPECT_EQ(message.state, SofStatus::NO_DATA);
  EXPECT_EQ(message.reason, "no sample yet");
  for (double value :
       {message.model_age, message.suitability, message.backtest_q_dyn_percent, message.u_required,
        message.u_min, message.crank_time, message.crank_measured, message.crank_expected}) {
    EXPECT_TRUE(std::isnan(value));
  }
  EXPECT_EQ(message.i_cranking, -200.0);
}

TEST(MessageOf, StatusShowsTheLastCrankAndTheCounts) {
  StatusContents contents;
  contents.session.state = SessionState::kReady;
  contents.counts.accepted = 100;
  contents.counts.rejected.missing_value = 3;
  contents.counts.stamp_ahead = 1;
  contents.last_crank = CrankComparison{50.0, -240.0, 9.8, {9.9, 9.7, 10.1}};
  contents.cranks = 2;
  const SofStatus message = messageOf(contents);
  EXPECT_EQ(message.state, SofStatus::READY);
  EXPECT_EQ(message.accepted, 100u);
  EXPECT_EQ(message.rejected, 4u);
  EXPECT_EQ(message.crank_measured, 9.8);
  EXPECT_EQ(message.crank_expected, 9.9);
  EXPECT_EQ(message.cranks, 2u);
}

}  // namespace
}  // namespace battery_sof
