#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "prediction/model_monitor.hpp"
#include "prediction/online_session.hpp"
#include "prediction/questions.hpp"
#include "prediction/scores.hpp"
#include "state/state_estimator.hpp"
#include "support/base_circuit.hpp"
#include "support/known_model.hpp"
#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

using ::testing::HasSubstr;

/// A model that followed a load of 10 A whose voltage is off by so much.
FittedModel missing(double offset, double drift = 0.0, double rmse = 0.01) {
  FittedModel model = test::uncertainModel(0.01);
  model.fit.scores.rmse = rmse;
  model.fit.window.to = model.state.time;
  StateEstimator estimator(model);
  test::Random random(5);
  for (int n = 0; n < 300; ++n) {
    InputSample sample;
    sample.step = estimator.stepTo(estimator.state().time + 1.0, -10.0, 10.0);
    const FollowedSample followed = estimator.predict(sample);
    sample.voltage = followed.voltage + offset + drift * n + 0.002 * random.normal();
    const double error = sample.voltage - followed.voltage;
    estimator.update(sample, error, error);
  }
  estimator.saveTo(model);
  return model;
}

TEST(PresentAnswers, AnswerForThePresentLoadBeginsAtTheMeasuredVoltage) {
  for (const double offset : {-1.5, -0.2, 0.0, 0.3}) {
    const FittedModel model = missing(offset);
    Simulation here = simulationOf(model);
    here.hold(-10.0, 1.0);
    const double measured = here.voltage() + offset;
    const CrankingAnswer answer = predictCranking(model, {-10.0, 1.0, -10.0, 1.0, 7.2});
    ASSERT_TRUE(answer.u_min) << answer.message;
    EXPECT_NEAR(answer.u_min->value, measured, 0.02) << offset;
    EXPECT_LE(answer.u_min->lower, measured) << offset;
    EXPECT_GE(answer.u_min->upper, measured) << offset;
  }
}

TEST(PresentAnswers, AModelThatMissesThePresentVoltageByMoreThanItsIntervalAnswersNothingValid) {
  EXPECT_TRUE(predictCranking(missing(0.02), {-10.0, 30.0, -20.0, 1.0, 7.2}).valid);
  const CrankingAnswer answer = predictCranking(missing(-1.5), {-10.0, 30.0, -20.0, 1.0, 7.2});
  EXPECT_FALSE(answer.valid);
  EXPECT_THAT(answer.message, HasSubstr("misses the present voltage"));
}

TEST(PresentAnswers, AnUnexpectedErrorAtThePresentLoadWidensTheAnswerForACrank) {
  const auto width = [](double offset) {
    const CrankingAnswer answer = predictCranking(missing(offset), {-10.0, 1.0, -200.0, 1.0, 7.2});
    return answer.u_min->upper - answer.u_min->lower;
  };
  EXPECT_GT(width(-1.5), 1.5);
  EXPECT_LT(width(-0.01), 1.2 * width(0.0));
}

TEST(PresentAnswers, AProfileBeginsAtTheMeasuredVoltageToo) {
  const FittedModel model = missing(-0.2);
  Simulation here = simulationOf(model);
  here.hold(-10.0, 1.0);
  const ProfileAnswer answer = simulateProfile(model, {1.0, 2.0}, {-10.0, -10.0});
  EXPECT_NEAR(answer.predicted.voltage.front(), here.voltage() - 0.2, 0.02);
}

TEST(PresentAnswers, AnErrorThatDriftsMakesLaterAnswersWider) {
  const auto width = [](double t_stop) {
    const CrankingAnswer answer =
        predictCranking(missing(0.0, -5e-4, 0.1), {-10.0, t_stop, -10.0, 1.0, 7.2});
    return answer.u_min->upper - answer.u_min->lower;
  };
  EXPECT_GT(width(120.0), 2.0 * width(5.0));
}

/// A minute of a load of 10 A, then a crank of 200 A whose voltage is off by so much; what is
/// answered behind it.
CrankingAnswer behindACrankOffBy(double offset) {
  FittedModel model = test::uncertainModel(0.01);
  model.fit.excited.min_current = -250.0;
  ModelMonitor monitor({});
  monitor.install(model, 10.0);
  StateEstimator truth(model);
  double time = model.state.time;
  for (int n = 0; n < 7000; ++n) {
    const bool cranks = n >= 6000 && n < 6080;
    InputSample sample;
    sample.step = truth.stepTo(time += 0.01, cranks ? -200.0 : -10.0, 10.0);
    const double voltage = truth.predict(sample).voltage + (cranks ? offset : 0.0);
    monitor.follow({time, sample.step.current, voltage}, 10.0);
  }
  EXPECT_EQ(monitor.isDenied(), std::abs(offset) > 1.0);
  return predictCranking(monitor.now(), {-10.0, 10.0, -200.0, 0.8, 7.2});
}

TEST(PresentAnswers, ACrankMissedByMoreThanItsIntervalEndsValidityAtOnce) {
  EXPECT_TRUE(behindACrankOffBy(0.0).valid) << behindACrankOffBy(0.0).message;
  const CrankingAnswer answer = behindACrankOffBy(-3.0);
  EXPECT_FALSE(answer.valid);
  EXPECT_THAT(answer.message, HasSubstr("the last crank reached"));
}

TEST(PredictRange, IntervalsGrowWithTheAgeOfTheModelWhichIsReported) {
  FittedModel model = test::knownModel();
  model.fit.scores.rmse = 0.02;
  model.fit.noise = NoiseModel{0.002, 0.0, 1.0, 1e-3};
  Series series;
  for (int n = 0; n <= 1100; ++n) series.append({static_cast<double>(n), -10.0, 12.5});
  model.state.current = -10.0;  // the sample of this recording that the state stands at
  const RangePrediction predicted =
      predictRange(model, series, {100, 1101}, PredictionMode::kCurrent);
  EXPECT_NEAR(*predicted.report.model_age, 1000.0, 1e-9);
  const auto width = [&](std::size_t n) {
    return predicted.course.voltage_upper[n] - predicted.course.voltage_lower[n];
  };
  EXPECT_NEAR(width(1000) / width(0), std::hypot(0.02, 1e-3 * std::sqrt(1000.0)) / 0.02, 1e-6);
  EXPECT_EQ(modelAge(model, series).at(50.0), 0.0);
}

TEST(PredictRange, CountsTheCranksThatDrawMoreThanTheWindowOfTheModel) {
  FittedModel model = test::knownModel();
  Series series;
  for (int n = 0; n < 3000; ++n) {
    const bool cranks = n % 1000 >= 500 && n % 1000 < 560;
    series.append({0.01 * n, cranks ? -200.0 : -10.0, cranks ? 10.5 : 12.4});
  }
  const auto beyond = [&](double largest) {
    model.fit.excited.min_current = largest;
    return predictRange(model, series, {0, series.size()}, PredictionMode::kCurrent)
        .report.cranks_beyond_window;
  };
  EXPECT_EQ(beyond(-40.0), 3u);
  EXPECT_EQ(beyond(-190.0), 0u);
}

TEST(PredictRange, TheAgeOfAModelIsUnknownOnAnotherClockUnlessBothCountFrom1970) {
  FittedModel model = test::knownModel();
  const auto ageBehind = [&](double first, double window_end) {
    model.fit.window = {window_end - 240.0, window_end, 2400};
    model.state.time = window_end;
    Series series;
    for (int n = 0; n <= 100; ++n) series.append({first + n, -17.0, 12.5});
    return predictRange(model, series, {50, 101}, PredictionMode::kCurrent).report.model_age;
  };
  EXPECT_EQ(ageBehind(0.0, 5000.0), std::nullopt);
  EXPECT_NEAR(*ageBehind(1.6e9 + 3600.0, 1.6e9), 3700.0, 1e-6);
}

}  // namespace
}  // namespace battery_sof
