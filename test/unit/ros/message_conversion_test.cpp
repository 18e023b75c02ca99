#include "ros/message_conversion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "report/model_yaml.hpp"
#include "support/known_model.hpp"

namespace battery_sof {
namespace {

FittedModel someModel() {
  FittedModel model;
  model.fit.estimates = {{"r_discharge", "ohm", 0.006, 0.0001, false, true},
                         {"r_charge", "ohm", 0.0085, std::nullopt, true, false},
                         {"c2", "F", 1100.0, 20.0, false, true},
                         {"beta", "1/V", 22.0, 0.5, false, true},
                         {"u_dc", "V", 12.7, 0.01, false, true}};
  model.fit.covariance = Eigen::MatrixXd::Identity(kCovarianceRows, kCovarianceRows) * 1e-4;
  model.state = {1234.5, -20.0, Eigen::VectorXd::Constant(1, -0.12)};
  model.fit.window = {900.0, 1140.0, 24000};
  model.fit.message = "converged";
  model.provenance.fit_ms = 12.0;
  return model;
}

TEST(QueryOf, ARequirementThatWasLeftOutIsNone) {
  PredictCranking::Request request;
  request.i_load = -20.0;
  EXPECT_FALSE(queryOf(request).u_required);
  request.u_required = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(queryOf(request).u_required);
  request.u_required = 7.2;
  EXPECT_EQ(queryOf(request).u_required, 7.2);
  EXPECT_EQ(queryOf(request).i_load, -20.0);
}

TEST(QueryOf, ProfilesOfACrankAreKept) {
  PredictCranking::Request request;
  request.load_time = {0.0, 5.0};
  request.load_current = {-20.0, -30.0};
  request.cranking_time = {0.0};
  const CrankingQuery query = queryOf(request);
  EXPECT_EQ(query.load.duration(), 5.0);
  EXPECT_EQ(query.load.current[1], -30.0);
  EXPECT_THAT(faultsOf(query),
              ::testing::Contains(::testing::HasSubstr("crank has 1 times and 0 currents")));
}

TEST(QueryOf, ARequestThatWasNotFilledInAsksForNothing) {
  const ModelSnapshot model(test::knownModel(), std::nullopt, 50.0);
  EXPECT_EQ(model.predictCranking(queryOf(PredictCranking::Request())).code,
            AnswerCode::kInvalidQuery);
  EXPECT_THAT(model.predictStopTime(queryOf(PredictStopTime::Request())).message,
              ::testing::HasSubstr("no limit is given"));
  EXPECT_THAT(model.predictChargeAcceptance(queryOf(PredictChargeAcceptance::Request())).message,
              ::testing::HasSubstr("u_boost [V] is 0"));
  PredictCranking::Request crank;
  crank.i_cranking = -200.0;
  const PredictCranking::Response response =
      messageAs<PredictCranking::Response>(model.predictCranking(queryOf(crank)));
  EXPECT_TRUE(response.valid) << response.message;
  EXPECT_FALSE(response.capable);
  EXPECT_THAT(response.message, ::testing::HasSubstr("no u_required was given"));
}

TEST(QueryOf, ZeroOrNanIsTheDefaultWhereTheRequestSaysSo) {
  for (const double left_out : {0.0, std::numeric_limits<double>::quiet_NaN()}) {
    PredictStopTime::Request stop;
    stop.t_cranking = left_out;
    EXPECT_EQ(queryOf(stop).t_cranking, 1.0);
    PredictChargeAcceptance::Request charge;
    charge.t_sof2 = charge.i_limit = left_out;
    EXPECT_EQ(queryOf(charge).t_sof2, 10.0);
    EXPECT_EQ(queryOf(charge).i_limit, 5000.0);
    PredictCranking::Request crank;
    crank.i_cranking = -200.0;
    crank.t_cranking = left_out;
    EXPECT_EQ(queryOf(crank).t_cranking, 1.0);
  }
  PredictChargeAcceptance::Request given;
  given.t_sof2 = -1.0;
  given.i_limit = 80.0;
  EXPECT_EQ(queryOf(given).t_sof2, -1.0);
  EXPECT_EQ(queryOf(given).i_limit, 80.0);
}

TEST(ResponseOf, AnEndlessStopIsInfiniteAndAnAbsentOneNan) {
  StopTimeAnswer always;
  always.outcome = StopTimeOutcome::kAlways;
  const double ever = std::numeric_limits<double>::infinity();
  always.t_stop = Interval{ever, 40.0, ever};
  EXPECT_TRUE(std::isinf(messageAs<PredictStopTime::Response>(always).t_stop));
  EXPECT_EQ(messageAs<PredictStopTime::Response>(always).lower, 40.0);
  EXPECT_EQ(messageAs<PredictStopTime::Response>(always).outcome, "always");
  StopTimeAnswer least;
  least.outcome = StopTimeOutcome::kAtLeast;
  least.t_stop = Interval{72.0, 72.0, 7200.0};
  EXPECT_EQ(messageAs<PredictStopTime::Response>(least).outcome, "at_least");
  EXPECT_EQ(messageAs<PredictStopTime::Response>(least).t_stop, 72.0);
  StopTimeAnswer none;
  none.code = AnswerCode::kNoModel;
  EXPECT_TRUE(std::isnan(messageAs<PredictStopTime::Response>(none).t_stop));
  EXPECT_EQ(messageAs<PredictStopTime::Response>(none).outcome, "");
  EXPECT_FALSE(messageAs<PredictStopTime::Response>(none).monotone);
}

TEST(ResponseOf, AChargeKeepsItsNumbers) {
  ChargeAcceptanceAnswer answer;
  answer.i_boost = Interval{50.0, 40.0, 60.0};
  answer.code = AnswerCode::kExtrapolation;
  EXPECT_EQ(messageAs<PredictChargeAcceptance::Response>(answer).i_boost, 50.0);
  EXPECT_EQ(messageAs<PredictChargeAcceptance::Response>(answer).lower, 40.0);
  EXPECT_EQ(messageAs<PredictChargeAcceptance::Response>(answer).code,
            PredictChargeAcceptance::Response::EXTRAPOLATION);
  EXPECT_TRUE(
      std::isnan(messageAs<PredictChargeAcceptance::Response>(ChargeAcceptanceAnswer{}).upper));
}

PredictMap::Request mapRequest() {
  PredictMap::Request request;
  request.i_load = {-10.0, -20.0};
  request.t_stop = {0.0, 5.0, 10.0};
  request.i_cranking = -200.0;
  request.u_required = std::numeric_limits<double>::quiet_NaN();
  return request;
}

PredictMap::Response mapMessage(const ModelSnapshot& model, const PredictMap::Request& request) {
  return messageAs<PredictMap::Response>(mapsOf(model, request));
}

TEST(MapsOf, AnswersTheMapsThatHaveLists) {
  const ModelSnapshot model(test::knownModel(), std::nullopt, 50.0);
  PredictMap::Request request = mapRequest();
  EXPECT_EQ(mapMessage(model, request).u_min.size(), 6u);
  EXPECT_TRUE(mapMessage(model, request).i_boost.empty());
  EXPECT_TRUE(mapMessage(model, request).valid);
  request.u_boost = {13.0};
  request.t_sof2 = {1.0, -1.0};
  const PredictMap::Response both = mapMessage(model, request);
  EXPECT_THAT(both.i_boost_code, ::testing::ElementsAre(0, 1));
  EXPECT_TRUE(std::isnan(both.i_boost[1]));
  EXPECT_EQ(both.code, PredictMap::Response::INVALID_QUERY);
  EXPECT_EQ(mapMessage(model, PredictMap::Request()).code, PredictMap::Response::INVALID_QUERY);
}

TEST(MapsOf, WithoutAModelSaysTheSessionsReason) {
  const ModelSnapshot model({}, "no model has been identified yet", 50.0);
  const PredictMap::Response response = mapMessage(model, mapRequest());
  EXPECT_EQ(response.code, PredictMap::Response::NO_MODEL);
  EXPECT_EQ(response.message, "no model has been identified yet");
}

TEST(ResponseOf, AbsentNumbersAreNanNeverZero) {
  CrankingAnswer answer;
  answer.code = AnswerCode::kNoModel;
  answer.message = "no model has been identified yet";
  const PredictCranking::Response response = messageAs<PredictCranking::Response>(answer);
  EXPECT_TRUE(std::isnan(response.u_min) && std::isnan(response.lower) &&
              std::isnan(response.upper));
  EXPECT_FALSE(response.capable);
  EXPECT_EQ(response.code, PredictCranking::Response::NO_MODEL);
  EXPECT_EQ(response.message, "no model has been identified yet");
}

TEST(ResponseOf, CodesOfTheServicesAreThoseOfTheCore) {
  EXPECT_EQ(PredictCranking::Response::OK, static_cast<int>(AnswerCode::kOk));
  EXPECT_EQ(PredictCranking::Response::INVALID_QUERY, static_cast<int>(AnswerCode::kInvalidQuery));
  EXPECT_EQ(PredictCranking::Response::NO_MODEL, static_cast<int>(AnswerCode::kNoModel));
  EXPECT_EQ(PredictCranking::Response::EXTRAPOLATION, static_cast<int>(AnswerCode::kExtrapolation));
  EXPECT_EQ(PredictStopTime::Response::NO_MODEL, static_cast<int>(AnswerCode::kNoModel));
  EXPECT_EQ(PredictStopTime::Response::EXTRAPOLATION, static_cast<int>(AnswerCode::kExtrapolation));
  EXPECT_EQ(PredictChargeAcceptance::Response::NO_MODEL, static_cast<int>(AnswerCode::kNoModel));
  EXPECT_EQ(PredictMap::Response::INVALID_QUERY, static_cast<int>(AnswerCode::kInvalidQuery));
  EXPECT_EQ(PredictMap::Response::EXTRAPOLATION, static_cast<int>(AnswerCode::kExtrapolation));
  EXPECT_EQ(SimulateProfile::Response::INVALID_QUERY, static_cast<int>(AnswerCode::kInvalidQuery));
  EXPECT_EQ(SimulateProfile::Response::NO_MODEL, static_cast<int>(AnswerCode::kNoModel));
  EXPECT_EQ(SimulateProfile::Response::EXTRAPOLATION, static_cast<int>(AnswerCode::kExtrapolation));
}

TEST(MessageOf, ServicesAnswerInTheFieldsOfTheStatus) {
  using ros::message_traits::md5sum;
  EXPECT_STREQ(md5sum<PredictCranking::Response>(), md5sum<CrankAnswer>());
  EXPECT_STREQ(md5sum<PredictStopTime::Response>(), md5sum<StopTimeMessage>());
  EXPECT_STREQ(md5sum<PredictChargeAcceptance::Response>(), md5sum<ChargeAnswer>());
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

TEST(MessageOf, StatusWithoutModelAndEventsHasNanInTheirPlaces) {
  StatusContents contents;
  contents.session.reason = "no sample yet";
  contents.standing.cranking.u_required.reset();
  contents.model.emplace(std::nullopt, "no sample yet", 50.0);
  const SofStatus message = messageOf(contents);
  EXPECT_EQ(message.state, SofStatus::NO_DATA);
  EXPECT_EQ(message.reason, "no sample yet");
  for (double value :
       {message.model_age, message.window_quality, message.backtest_q_dyn_percent,
        message.u_required, message.crank.u_min, message.past_cranks.time,
        message.past_cranks.measured, message.past_cranks.expected, message.stop_time.t_stop,
        message.stop_time.upper, message.charge.i_boost, message.charge.lower,
        message.past_charges.time, message.past_charges.duration, message.past_charges.measured,
        message.past_charges.expected, message.past_cranks.coverage,
        message.past_charges.mean_abs_error}) {
    EXPECT_TRUE(std::isnan(value));
  }
  EXPECT_EQ(message.i_cranking, -200.0);
  EXPECT_EQ(message.crank.code, CrankAnswer::NO_MODEL);
  EXPECT_EQ(message.charge.code, ChargeAnswer::NO_MODEL);
  EXPECT_EQ(message.stop_time.code, StopTimeMessage::INVALID_QUERY)
      << "not asked without u_required";
  EXPECT_EQ(message.past_cranks.interval_factor, 1.0);
}

TEST(MessageOf, StatusHoldsTheThreeStandingAnswers) {
  StatusContents contents;
  contents.standing.charge = {13.5, 5.0, 200.0};
  contents.standing.cranking.i_load = 0.0;
  contents.model.emplace(test::knownModel(), std::nullopt, 50.0);
  const SofStatus message = messageOf(contents);
  EXPECT_TRUE(message.crank.valid && message.crank.capable);
  EXPECT_EQ(message.stop_time.outcome, "always");
  EXPECT_TRUE(std::isinf(message.stop_time.t_stop) && message.stop_time.valid);
  EXPECT_GT(message.charge.i_boost, 10.0);
  EXPECT_LE(message.charge.i_boost, 200.0);
  EXPECT_EQ(message.u_boost, 13.5);
  EXPECT_EQ(message.t_sof2, 5.0);
  EXPECT_EQ(message.i_limit, 200.0);
}

TEST(MessageOf, StatusShowsCranksChargesAndTheCounts) {
  using Kind = PastEvent::Kind;
  StatusContents contents;
  contents.session.state = SessionState::kReady;
  contents.counts.accepted = 100;
  contents.counts.rejected.missing_value = 3;
  contents.counts.stamp_ahead = 1;
  contents.events.add(
      {{{{Kind::kCrank, 40.0, 0.0, -200.0, 0.0, 0.0, 10.0, 9.1}, {9.0, 8.7, 9.3}},
        {{Kind::kCrank, 50.0, 0.0, -240.0, 0.0, 0.0, 9.8, 9.7}, {9.9, 9.7, 10.1}}},
       {{{Kind::kCharge, 60.0, 10.0, 0.0, 14.1, 13.9, 30.0, 27.0}, {28.0, 25.0, 31.0}}},
       {}});
  contents.events.calibrations.cranks.factor = 1.25;
  const SofStatus message = messageOf(contents);
  EXPECT_EQ(message.state, SofStatus::READY);
  EXPECT_EQ(message.accepted, 100u);
  EXPECT_EQ(message.rejected, 4u);
  EXPECT_EQ(message.past_cranks.measured, 9.8);
  EXPECT_EQ(message.past_cranks.expected, 9.9);
  EXPECT_EQ(message.past_cranks.time, 50.0);
  EXPECT_EQ(message.past_cranks.stimulus, -240.0);
  EXPECT_TRUE(std::isnan(message.past_cranks.duration));
  EXPECT_EQ(message.past_cranks.count, 2u);
  EXPECT_EQ(message.past_cranks.coverage, 0.5);
  EXPECT_NEAR(message.past_cranks.mean_abs_error, 0.55, 1e-12);
  EXPECT_EQ(message.past_cranks.interval_factor, 1.25);
  EXPECT_EQ(message.past_charges.count, 1u);
  EXPECT_EQ(message.past_charges.stimulus, 14.1);
  EXPECT_EQ(message.past_charges.duration, 10.0);
  EXPECT_EQ(message.past_charges.measured, 30.0);
  EXPECT_EQ(message.past_charges.upper, 31.0);
  EXPECT_EQ(message.past_charges.coverage, 1.0);
  EXPECT_EQ(message.past_charges.mean_abs_error, 2.0);
}

FinishedDiagnosis someReport() {
  FinishedDiagnosis report;
  report.from = 100.0;
  report.to = 1900.5;
  report.samples = 180000;
  report.duration_ms = 4200.0;
  Diagnosis diagnosis;
  diagnosis.verdict = Verdict::kEffect;
  diagnosis.summary = "gassing is missing";
  NamedEffect gassing;
  gassing.id = "gassing";
  gassing.confidence = 0.97;
  gassing.mechanism = "side_reactions";
  gassing.probability = 0.98;
  gassing.biased_parameters = {"r_charge"};
  DiagnosedParameter current;
  current.name = "i_gas";
  current.unit = "A";
  current.value = 0.02;
  current.upper = 0.03;
  gassing.parameters = {current};
  diagnosis.effects = {gassing};
  Candidate other;
  other.id = "ocv_soc";
  other.mechanism = "open_circuit";
  other.evidence = 7.5;
  other.rejected_because = "no gain on held-out blocks";
  diagnosis.candidates = {other};
  MismatchSegment segment;
  segment.from = 200.0;
  segment.regime = "long_charge";
  segment.mean_error = -0.2;
  diagnosis.mismatch = {segment};
  diagnosis.mechanism = Mechanism::kSideReactions;
  diagnosis.probability = 0.98;
  diagnosis.mechanisms = {{Mechanism::kSideReactions, 0.98}, {Mechanism::kAcid, 0.0}};
  diagnosis.unexplained.rmse = 0.0004;
  diagnosis.fit.train = {100.0, 1450.0, 135000};
  diagnosis.fit.base_holdout.rmse = 0.05;
  diagnosis.fit.extended_holdout.rmse = 0.02;
  diagnosis.fit.extended_holdout.charge_bias = 0.001;
  report.diagnosis = diagnosis;
  return report;
}

TEST(MessageOf, DiagnosisSaysEverythingAndNanForWhatIsMissing) {
  const DiagnosisMessage message = messageOf(someReport(), {{"gassing"}, "runs beside"});
  EXPECT_EQ(message.header.stamp.toSec(), 1900.5);
  EXPECT_EQ(message.from_time, 100.0);
  EXPECT_EQ(message.samples, 180000u);
  EXPECT_EQ(message.verdict, DiagnosisMessage::EFFECT);
  EXPECT_EQ(message.mechanism_ids, (std::vector<std::string>{"side_reactions", "acid"}));
  ASSERT_EQ(message.mechanism_probabilities.size(), 2u);
  EXPECT_EQ(message.mechanism_probabilities[0], 0.98);
  EXPECT_TRUE(std::isnan(message.mechanism_probabilities[1]));
  EXPECT_EQ(message.summary, "gassing is missing");
  EXPECT_EQ(message.mechanism, "side_reactions");
  EXPECT_EQ(message.probability, 0.98);
  EXPECT_EQ(message.unexplained_rmse, 0.0004);
  ASSERT_EQ(message.effects.size(), 1u);
  EXPECT_EQ(message.effects[0].biased_parameters[0], "r_charge");
  EXPECT_EQ(message.effects[0].parameters[0].upper, 0.03);
  EXPECT_TRUE(std::isnan(message.effects[0].parameters[0].lower));
  EXPECT_TRUE(std::isnan(message.effects[0].parameters[0].std));
  EXPECT_TRUE(std::isnan(message.candidates[0].holdout_gain_percent));
  EXPECT_EQ(message.effects[0].mechanism, "side_reactions");
  EXPECT_EQ(message.effects[0].probability, 0.98);
  EXPECT_EQ(message.candidates[0].mechanism, "open_circuit");
  EXPECT_EQ(message.candidates[0].evidence, 7.5);
  EXPECT_EQ(message.candidates[0].rejected_because, "no gain on held-out blocks");
  EXPECT_EQ(message.mismatch[0].from_time, 200.0);
  EXPECT_EQ(message.mismatch[0].mean_error, -0.2);
  EXPECT_EQ(message.base_holdout.rmse, 0.05);
  EXPECT_EQ(message.extended_holdout.charge_bias, 0.001);
  EXPECT_TRUE(std::isnan(message.base_holdout.crank_mae));
  EXPECT_TRUE(message.adopted);
  EXPECT_EQ(message.adoption, "runs beside");
}

TEST(MessageOf, DiagnosisThatComparedNothingHasNoMetrics) {
  FinishedDiagnosis report = someReport();
  report.diagnosis = Diagnosis();
  const DiagnosisMessage message = messageOf(report, {});
  EXPECT_EQ(message.verdict, DiagnosisMessage::INSUFFICIENT_DATA);
  EXPECT_TRUE(message.effects.empty());
  EXPECT_EQ(message.mechanism, "");
  EXPECT_TRUE(std::isnan(message.base_holdout.rmse) && std::isnan(message.holdout_from));
  EXPECT_FALSE(message.adopted);
}

TEST(MessageOf, EveryVerdictIsOneOfTheMessagesConstants) {
  const std::vector<std::string> constants = {
      DiagnosisMessage::NO_MISMATCH,  DiagnosisMessage::EFFECT,
      DiagnosisMessage::SEVERAL,      DiagnosisMessage::AMBIGUOUS,
      DiagnosisMessage::MECHANISM,    DiagnosisMessage::UNEXPLAINED,
      DiagnosisMessage::SENSOR_FAULT, DiagnosisMessage::INSUFFICIENT_DATA};
  FinishedDiagnosis report = someReport();
  for (int verdict = 0; verdict < 8; ++verdict) {
    report.diagnosis->verdict = static_cast<Verdict>(verdict);
    EXPECT_EQ(messageOf(report, {}).verdict, constants[static_cast<std::size_t>(verdict)]);
  }
}

TEST(ResultOf, DiagnosisHasItsMessageOrItsFault) {
  const DiagnoseResult good = resultOf(someReport(), {});
  EXPECT_TRUE(good.success);
  EXPECT_EQ(good.code, DiagnoseResult::OK);
  EXPECT_EQ(good.message, "gassing is missing");
  EXPECT_EQ(good.diagnosis.verdict, "effect");
  FinishedDiagnosis broken;
  broken.fault = "it broke off";
  const DiagnoseResult bad = resultOf(broken, {});
  EXPECT_FALSE(bad.success);
  EXPECT_EQ(bad.code, DiagnoseResult::FAILED);
  EXPECT_EQ(bad.message, "it broke off");
}

TEST(MessageOf, StatusSaysWhichModelAnswers) {
  StatusContents contents;
  EXPECT_TRUE(messageOf(contents).effects.empty());
  contents.session.effects = {"gassing"};
  EXPECT_EQ(messageOf(contents).effects[0], "gassing");
}

}  // namespace
}  // namespace battery_sof
