#include "prediction/online_session.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "estimation/window.hpp"
#include "state/state_estimator.hpp"
#include "support/base_circuit.hpp"
#include "support/known_model.hpp"

namespace battery_sof {
namespace {

using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
const CrankingQuery kQuery{-25.0, 20.0, -200.0, 0.5, 7.2};

/// A start-stop drive of the base model itself: alternating charge and discharge, a crank every 30
/// s.
class InputSequence {
 public:
  explicit InputSequence(double interval, double start = 0.0, unsigned seed = 1)
      : interval_(interval), start_(start), random_(seed), step_(truth()) {}

  static BaseParameters truth() { return {0.006, 0.0085, 1100.0, 22.0, 12.7, 1.0, 0.5}; }

  RawSample next() {
    const double time = start_ + interval_ * static_cast<double>(count_++);
    const double current = currentAt(time - start_);
    if (count_ > 1) u_c2_ = step_.advance(u_c2_, 0.5 * (last_current_ + current), interval_);
    last_current_ = current;
    return {time, current, test::terminalVoltage(truth(), current, u_c2_) + noise_(random_), {}};
  }

 private:
  double currentAt(double since) {
    const double phase = std::fmod(since, 30.0);
    if (phase >= 12.0 && phase < 12.0 + std::max(0.6, 1.5 * interval_)) return -230.0;
    if (phase < 12.0) return -25.0;
    if (since >= next_change_) {
      level_ = std::uniform_real_distribution<double>(-30.0, 60.0)(random_);
      next_change_ = since + std::uniform_real_distribution<double>(2.0, 8.0)(random_);
    }
    return level_;
  }

  double interval_, start_;
  std::mt19937 random_;
  std::normal_distribution<double> noise_{0.0, 0.005};
  test::BaseStep step_;
  double u_c2_ = 0.0, last_current_ = 0.0, level_ = 20.0, next_change_ = 0.0;
  long count_ = 0;
};

/// Feeds a session as a node would, with the identification run on the spot.
class Feeder {
 public:
  explicit Feeder(OnlineSession& session) : session_(session) {}

  void push(const RawSample& sample) {
    const SessionEvents events = session_.push(sample);
    cranks.insert(cranks.end(), events.cranks.begin(), events.cranks.end());
    offered.push_back(sample);
    if (const auto job = session_.takeDueJob()) {
      outcomes.push_back(session_.finish(runIdentification(*job)));
      times.push_back(sample.time);
    }
  }

  void inputs(InputSequence& from, std::size_t samples) {
    for (std::size_t n = 0; n < samples; ++n) push(from.next());
  }

  std::vector<RawSample> offered;
  std::vector<EventComparison> cranks;
  std::vector<IdentificationOutcome> outcomes;
  std::vector<double> times;  // [s], newest sample of each identification

 private:
  OnlineSession& session_;
};

TEST(OnlineSession, GivesTheSameAnswersAsTheOfflineFunctionsOnTheSameSamples) {
  OnlineSession session;
  Feeder feeder(session);
  InputSequence inputs(0.01);
  feeder.inputs(inputs, 30050);
  ASSERT_EQ(feeder.outcomes.size(), 1u);
  ASSERT_TRUE(feeder.outcomes[0].accepted) << feeder.outcomes[0].message;

  Recording recording;
  Intake intake;
  for (const RawSample& sample : feeder.offered) append(recording, intake, sample);
  const WindowChoice choice =
      chooseWindow(recording.series, {0, firstAfter(recording.series, feeder.times[0])});
  ASSERT_TRUE(choice.range);
  FittedModel model = identify(recording.series, *choice.range);
  fitErrors(model, recording.series, *choice.range);
  carryState(model, recording.series, recording.series.size() - 1);
  // estimated from the cranks that passed
  model.intervals.calibrations.cranks = session.calibrations().cranks;
  const CrankingAnswer offline = predictCranking(model, kQuery);
  const CrankingAnswer online = session.live().predictCranking(kQuery);

  ASSERT_TRUE(offline.u_min && online.u_min);
  EXPECT_NEAR(online.u_min->value, offline.u_min->value, 1e-9);
  EXPECT_NEAR(online.u_min->lower, offline.u_min->lower, 1e-9);
  EXPECT_NEAR(online.u_min->upper, offline.u_min->upper, 1e-9);
  EXPECT_EQ(online.capable, offline.capable);
  EXPECT_EQ(online.valid, offline.valid);
  EXPECT_EQ(online.message, offline.message);
}

TEST(OnlineSession, ResultTakenBackLateGivesTheSameAnswersAsOneTakenBackAtOnce) {
  OnlineSession prompt, late;
  Feeder feeder(prompt);
  InputSequence inputs(0.01);
  std::optional<IdentificationResult> pending;
  for (int n = 0; n < 32000; ++n) {
    const RawSample sample = inputs.next();
    feeder.push(sample);
    late.push(sample);
    if (const auto job = late.takeDueJob()) pending = runIdentification(*job);
  }
  ASSERT_TRUE(pending);
  EXPECT_EQ(late.status().basis, AnswerBasis::kPopulation);
  ASSERT_TRUE(late.finish(*pending).accepted);
  EXPECT_EQ(late.live().predictCranking(kQuery).u_min->value,
            prompt.live().predictCranking(kQuery).u_min->value);
}

TEST(OnlineSession, WhatHappensDuringAnIdentificationIsJudgedByTheAnswerThatWasGiven) {
  SessionOptions options;
  options.identify_period = 60.0;
  OnlineSession prompt(options), late(options);
  Feeder feeder(prompt);
  InputSequence inputs(0.01);
  SessionEvents of_late;
  std::optional<IdentificationResult> pending;
  double due = 0.0;
  for (int n = 0; n < 42000; ++n) {
    const RawSample sample = inputs.next();
    feeder.push(sample);
    const SessionEvents events = late.push(sample);
    of_late.cranks.insert(of_late.cranks.end(), events.cranks.begin(), events.cranks.end());
    if (const auto job = late.takeDueJob()) {
      pending = runIdentification(*job);
      due = sample.time + 40.0;  // at least one crank later
    }
    if (pending && sample.time > due) {
      late.finish(*pending);
      pending.reset();
    }
  }
  ASSERT_GT(feeder.cranks.size(), 3u);
  ASSERT_EQ(of_late.cranks.size(), feeder.cranks.size());
  int inside = 0;
  for (std::size_t k = 0; k < of_late.cranks.size(); ++k) {
    const EventComparison& crank = of_late.cranks[k];
    EXPECT_EQ(crank.time, feeder.cranks[k].time);
    if (crank.expected.lower <= crank.measured && crank.measured <= crank.expected.upper) ++inside;
  }
  const IntervalCalibration& counted = late.calibrations().cranks;
  EXPECT_EQ(counted.events, static_cast<int>(of_late.cranks.size()));
  EXPECT_EQ(counted.inside, inside);
}

TEST(OnlineSession, IdentifiesAsSoonAsAWindowIsFullAndThenEveryPeriodOfDriving) {
  SessionOptions options;
  options.identify_period = 120.0;
  OnlineSession session(options);
  Feeder feeder(session);
  InputSequence inputs(0.01);
  feeder.inputs(inputs, 55000);
  ASSERT_EQ(feeder.times.size(), 3u);
  EXPECT_NEAR(feeder.times[0], 245.0, 6.0);
  EXPECT_NEAR(feeder.times[1] - feeder.times[0], 120.0, 0.1);
  EXPECT_NEAR(feeder.times[2] - feeder.times[1], 120.0, 0.1);
}

TEST(OnlineSession, FindsTheTruthOfTheDriveAndAWorkingBacktest) {
  OnlineSession session;
  Feeder feeder(session);
  InputSequence inputs(0.01);
  feeder.inputs(inputs, 40000);
  const auto model = session.model();
  ASSERT_TRUE(model);
  EXPECT_NEAR(model->fit.parameters.r_discharge, 0.006, 0.0002);
  EXPECT_NEAR(model->fit.parameters.u_dc, 12.7, 0.02);
  const SessionStatus status = session.status();
  EXPECT_EQ(status.state, SessionState::kReady);
  EXPECT_GT(*status.backtest.q_dyn_percent, 95.0);
  EXPECT_NEAR(status.backtest.duration, 399.99 - feeder.times.back(), 0.1);
}

TEST(OnlineSession, EachFinishedCrankIsComparedOnce) {
  OnlineSession session;
  Feeder feeder(session);
  InputSequence inputs(0.01);
  feeder.inputs(inputs, 40000);
  std::vector<double> due;
  for (double crank = 12.0; crank < 399.0; crank += 30.0) due.push_back(crank);
  ASSERT_EQ(feeder.cranks.size(), due.size());
  for (std::size_t n = 0; n < due.size(); ++n) {
    EXPECT_NEAR(feeder.cranks[n].time, due[n] + 0.3, 0.31);
    EXPECT_EQ(feeder.cranks[n].current, -230.0);
    // The population knows a resistance to a factor; the first crank shows it.
    EXPECT_NEAR(feeder.cranks[n].expected.value, feeder.cranks[n].measured,
                n == 0                        ? 2.0
                : due[n] < feeder.times.at(0) ? 0.3
                                              : 0.05);
    EXPECT_LT(feeder.cranks[n].expected.lower, feeder.cranks[n].expected.value);
  }
}

/// The first crank's expectation by a session that nothing was saved for.
Interval firstCrank(const SessionOptions& options, std::string* reason) {
  OnlineSession session(options);
  InputSequence inputs(0.01);
  std::vector<EventComparison> cranks;
  while (cranks.empty()) cranks = session.push(inputs.next()).cranks;
  *reason = session.status().reason;
  return cranks.front().expected;
}

TEST(OnlineSession, StartsFromTheBatteriesOfAFleet) {
  const BaseParameters truth = InputSequence::truth();
  SessionOptions of_fleet;
  of_fleet.identify.priors = {{{"fresh_sulphate"}, {{"u_dc", 13.5, 0.001, false}}},
                              {{},
                               {{"r_discharge", 1.1 * truth.r_discharge, 0.1, true},
                                {"beta", truth.beta, 1.0, false},
                                {"u_dc", truth.u_dc, 0.05, false}}}};
  std::string of_any, by_fleet;
  const Interval wide = firstCrank({}, &of_any), narrow = firstCrank(of_fleet, &by_fleet);
  EXPECT_THAT(of_any, HasSubstr("answers rest on what is known of lead-acid batteries"));
  EXPECT_THAT(by_fleet, HasSubstr("answers rest on the given priors"));
  EXPECT_LT(narrow.upper - narrow.lower, 0.7 * (wide.upper - wide.lower));
  const double moved = -230.0 * truth.r_discharge;  // of the whole crank, to first order
  EXPECT_NEAR(narrow.value, truth.u_dc + moved, 0.5);
}

TEST(OnlineSession, KnowsAtWhichVoltageTheBatteryWasChargedLately) {
  OnlineSession session;
  Feeder feeder(session);
  InputSequence inputs(0.01);
  EXPECT_FALSE(session.chargeVoltage());
  feeder.inputs(inputs, 26000);
  ASSERT_TRUE(session.model());
  double time = feeder.offered.back().time;
  for (int round = 0; round < 10; ++round)
    for (const double voltage : {13.1, 13.6, 13.3})
      for (int n = 0; n < 1600; ++n)
        feeder.push({time += 0.01, n < 400 ? -20.0 : 20.0, n < 400 ? 12.3 : voltage, {}});
  EXPECT_NEAR(session.chargeVoltage().value_or(0.0), 13.3, 1e-9);
}

TEST(OnlineSession, WorksAtOneHertzWithTheLongerWindow) {
  OnlineSession session;
  Feeder feeder(session);
  InputSequence inputs(1.0);
  feeder.inputs(inputs, 1500);
  ASSERT_FALSE(feeder.times.empty());
  EXPECT_NEAR(feeder.times[0], 905.0, 10.0);
  EXPECT_TRUE(feeder.outcomes[0].accepted) << feeder.outcomes[0].message;
  EXPECT_FALSE(feeder.cranks.empty());
}

TEST(OnlineSession, BringsAThousandHertzDownToAHundredAndFindsTheSameBattery) {
  OnlineSession session;
  Feeder feeder(session);
  InputSequence inputs(0.001);
  feeder.inputs(inputs, 260000);
  ASSERT_TRUE(session.model());
  EXPECT_NEAR(medianInterval(session.series()), 0.01, 1e-4);
  EXPECT_NEAR(session.model()->fit.parameters.r_discharge, 0.006, 0.0003);
  EXPECT_EQ(session.counts().accepted, 260000u);
}

TEST(OnlineSession, WithoutAModelQueriesSayWhyAndInvalidOnesAreStillCalledInvalid) {
  OnlineSession session;
  EXPECT_EQ(session.live().predictCranking(kQuery).code, AnswerCode::kNoModel);
  EXPECT_THAT(session.live().predictCranking(kQuery).message,
              HasSubstr("no model has been identified yet"));
  EXPECT_EQ(session.live().simulateProfile({0.0, 1.0}, {0.0, 0.0}).code, AnswerCode::kNoModel);
  CrankingQuery positive = kQuery;
  positive.i_cranking = 200.0;
  EXPECT_EQ(session.live().predictCranking(positive).code, AnswerCode::kInvalidQuery);
  EXPECT_EQ(session.status().state, SessionState::kNoSample);
  EXPECT_FALSE(session.takeJob());
}

TEST(OnlineSession, BeforeAFullWindowItAnswersAndSaysWhatIsMissing) {
  OnlineSession session;
  Feeder feeder(session);
  InputSequence inputs(0.01);
  feeder.inputs(inputs, 10000);
  EXPECT_EQ(session.status().state, SessionState::kReady);
  EXPECT_EQ(session.status().basis, AnswerBasis::kPopulation);
  EXPECT_TRUE(session.live().predictCranking(kQuery).valid)
      << session.live().predictCranking(kQuery).message;
  EXPECT_FALSE(session.live().predictChargeAcceptance({14.0, 5.0}).valid);
  EXPECT_THAT(session.status().reason, HasSubstr("of 240 s without a gap are buffered"));
  for (int n = 0; n < 40000; ++n) feeder.push({200.0 + n * 0.01, 5.0, 13.5, {}});
  EXPECT_THAT(session.status().reason, HasSubstr("no charge or no discharge"));
}

TEST(OnlineSession, JobOnRequestRunsWithoutBeingDueAndOnlyOneIsOut) {
  OnlineSession session;
  Feeder feeder(session);
  InputSequence inputs(0.01);
  feeder.inputs(inputs, 20000);
  ASSERT_TRUE(feeder.outcomes.empty());
  const auto job = session.takeJob();
  ASSERT_TRUE(job);
  EXPECT_FALSE(session.takeJob());
  IdentificationJob broken = *job;
  broken.identify.effects = {"gasing"};  // none of the catalogue: the fit throws
  const IdentificationOutcome refused = session.finish(runIdentification(broken));
  EXPECT_NE(refused.message.find("the identification failed: "), std::string::npos);
  ASSERT_TRUE(session.takeJob());
  EXPECT_TRUE(session.finish(runIdentification(*job)).accepted);
  EXPECT_EQ(session.status().state, SessionState::kReady);
  EXPECT_TRUE(session.takeJob());
}

TEST(OnlineSession, JobOnSamplesThatSayNothingIsRefusedWithTheReason) {
  OnlineSession session;
  for (int n = 0; n < 30000; ++n) session.push({n * 0.01, 5.0, 13.5, {}});
  const IdentificationOutcome outcome = session.finish(runIdentification(*session.takeJob()));
  EXPECT_FALSE(outcome.accepted);
  EXPECT_FALSE(outcome.message.empty());
  EXPECT_EQ(session.status().basis, AnswerBasis::kPopulation);
  EXPECT_EQ(session.live().predictCranking(kQuery).code, AnswerCode::kExtrapolation);
}

TEST(OnlineSession, LoopedBagKeepsTheModelWithItsAgeAndDropsAResultFromBefore) {
  OnlineSession session;
  Feeder feeder(session);
  InputSequence first(0.01);
  feeder.inputs(first, 30000);
  ASSERT_EQ(session.status().state, SessionState::kReady);
  const double age = *session.status().model_age;
  const auto job = session.takeJob();

  InputSequence again(0.01);
  feeder.inputs(again, 3000);
  const IdentificationOutcome outcome = session.finish(runIdentification(*job));
  EXPECT_FALSE(outcome.accepted);
  EXPECT_THAT(outcome.message, HasSubstr("clock jumped back"));
  EXPECT_EQ(session.status().state, SessionState::kReady);
  EXPECT_NEAR(*session.status().model_age, age + 29.99, 0.02);
  EXPECT_EQ(session.counts().clock_restarts, 1u);
  EXPECT_GT(*session.status().backtest.q_dyn_percent, 90.0);
  EXPECT_NEAR(*session.newestTime(), 29.99, 1e-9);
}

TEST(OnlineSession, ModelOfAnEarlierTripAnswersAtOnceAndWiderThanItDid) {
  OnlineSession before;
  Feeder feeder(before);
  InputSequence inputs(0.01);
  feeder.inputs(inputs, 26000);
  const Interval then = *before.live().predictCranking(kQuery).u_min;
  OnlineSession session;
  session.restore(*before.model());
  InputSequence next(0.01, 3.0 * 86400.0);
  for (int n = 0; n < 100; ++n) session.push(next.next());
  EXPECT_EQ(session.status().basis, AnswerBasis::kPreviousTrip);
  const CrankingAnswer answer = session.live().predictCranking(kQuery);
  ASSERT_TRUE(answer.u_min);
  EXPECT_TRUE(answer.valid) << answer.message;
  EXPECT_GT(answer.u_min->upper - answer.u_min->lower, then.upper - then.lower);
  EXPECT_NEAR(answer.u_min->value, then.value, 0.5);
  for (int n = 0; n < 26000; ++n) {
    session.push(next.next());
    if (const auto job = session.takeDueJob()) session.finish(runIdentification(*job));
  }
  EXPECT_EQ(session.status().basis, AnswerBasis::kThisTrip);
}

/// The status after a trip with a model of the inputs' battery, which then meets another one with
/// three cranks.
SessionStatus afterCranksOf(double rested, double resistance) {
  OnlineSession before;
  Feeder feeder(before);
  InputSequence inputs(0.01);
  feeder.inputs(inputs, 26000);
  OnlineSession session;
  session.restore(*before.model());
  for (int n = 0; n < 4500; ++n) {
    const double current = n % 1500 < 1450 ? -5.0 : -230.0;
    session.push({86400.0 + 0.01 * n, current, rested + resistance * current, {}});
  }
  return session.status();
}

TEST(OnlineSession, AnotherBatteryDeniesTheSavedModel) {
  for (const auto& [rested, resistance] : {std::pair(12.6, 0.03), std::pair(13.0, 0.004)}) {
    const SessionStatus status = afterCranksOf(rested, resistance);
    EXPECT_EQ(status.basis, AnswerBasis::kPopulation) << resistance << " Ohm";
    EXPECT_THAT(status.reason, HasSubstr("another battery"));
  }
}

TEST(OnlineSession, AcrossAGapTheBatteryIsTakenToRest) {
  OnlineSession session;
  Feeder feeder(session);
  InputSequence inputs(0.01);
  feeder.inputs(inputs, 26000);
  const RawSample last = feeder.offered.back();
  for (int n = 0; n < 3; ++n) feeder.push({last.time + 900.0 + 0.01 * n, 0.0, 12.7, {}});
  EXPECT_NEAR(session.model()->state.states[0], 0.0, 1e-3);
}

TEST(OnlineSession, RestoredModelAnswersFromTheFirstSampleOn) {
  OnlineSession before;
  Feeder feeder(before);
  InputSequence inputs(0.01);
  feeder.inputs(inputs, 26000);
  OnlineSession session;
  session.restore(*before.model());
  EXPECT_EQ(session.live().predictCranking(kQuery).code, AnswerCode::kNoModel);
  EXPECT_THAT(session.live().predictCranking(kQuery).message,
              HasSubstr("saved model is waiting for the first sample"));
  EXPECT_THAT(session.status().reason, HasSubstr("saved model is waiting for the first sample"));
  for (int n = 0; n < 200; ++n) session.push(inputs.next());
  EXPECT_EQ(session.status().state, SessionState::kReady);
  EXPECT_NEAR(session.live().predictCranking(kQuery).u_min->value,
              before.live().predictCranking(kQuery).u_min->value, 0.2);
}

TEST(OnlineSession, RestoredModelAnswersWhileTheRateIsStillMeasured) {
  OnlineSession before;
  Feeder feeder(before);
  InputSequence inputs(0.01);
  feeder.inputs(inputs, 26000);
  OnlineSession session;
  session.restore(*before.model());
  for (int n = 0; n < 150; ++n) {
    const RawSample next = inputs.next();
    before.push(next);
    session.push(next);
    EXPECT_FALSE(session.takeDueJob()) << n;
    EXPECT_FALSE(session.whyNoModel()) << n;
    EXPECT_EQ(session.status().state, SessionState::kReady) << n;
    EXPECT_THAT(session.status().reason, HasSubstr("the saved model is in use")) << n;
    EXPECT_NEAR(session.live().predictCranking(kQuery).u_min->value,
                before.live().predictCranking(kQuery).u_min->value, 0.2)
        << n;
  }
}

/// A state file may hold a model that is far from the battery: learning from its first samples may
/// overflow, and a crank among them is not compared with what is left of it.
TEST(OnlineSession, ARestoredModelThatOverflowsIsDroppedWhileTheRateIsStillMeasured) {
  FittedModel model = test::uncertainModel(0.966, {"ocv_soc", "acceptance_soc", "surface_charge"});
  for (ParameterEstimate& one : model.fit.estimates) {
    if (one.name == "u_dc") one.value = 56.6;
    if (one.name == "ocv_slope") one.value = 0.0842;
    if (one.name == "acceptance_fall") one.value = 5.0;
    if (one.name == "overcharge_current") one.value = 1.81;
    if (one.name == "surface_decay_time") one.value = 2.89e5;
    if (one.name == "surface_capacity") one.value = 8.06;
  }
  test::takeEstimates(model.fit);
  model.state.states[0] = -0.6;
  OnlineSession session;
  session.restore(model);
  const double currents[] = {0.0, 0.0, 0.0, -25.0, -25.0, -25.0, -260.0, -40.0, -40.0};
  double time = model.state.time + 900.0;
  for (const double current : currents)
    EXPECT_NO_THROW(session.push({time += 0.1, current, 12.5 + 0.006 * current, std::nullopt}));
  EXPECT_FALSE(session.live().predictCranking(kQuery).valid);
}

TEST(OnlineSession, RestoredModelOfAnotherClockIsRefusedWithTheReason) {
  OnlineSession before;
  Feeder feeder(before);
  InputSequence inputs(0.01, 1000.0);
  feeder.inputs(inputs, 26000);
  const auto refusal = [&](double start) {
    OnlineSession session;
    session.restore(*before.model());
    InputSequence other(0.01, start);
    session.push(other.next());
    EXPECT_THAT(session.live().predictCranking(kQuery).message,
                HasSubstr("the saved model was refused"));
    for (int n = 0; n < 200; ++n) session.push(other.next());
    EXPECT_EQ(session.status().basis, AnswerBasis::kPopulation);
    return session.status().reason;
  };
  EXPECT_THAT(refusal(0.0), HasSubstr("ahead of the first sample"));
}

TEST(IdentificationJob, ComparesBothModelsInOneDirectionOverTheSameSamples) {
  OnlineSession session;
  Feeder feeder(session);
  InputSequence inputs(0.01);
  feeder.inputs(inputs, 30000);
  auto job = session.takeJob();
  ASSERT_TRUE(job);
  const IdentificationResult first = runIdentification(*job);
  ASSERT_TRUE(first.model);
  job->incumbent = *first.model;
  ControlModeRule rule;
  rule.present = true;
  job->incumbent->fit.source = rule;
  EXPECT_NEAR(runIdentification(*job).worsening, 1.0, 1e-9);
  job->incumbent->fit.parameters.u_dc += 0.3;
  job->incumbent->fit.parameters.r_discharge *= 2.0;
  EXPECT_LT(runIdentification(*job).worsening, 0.9);
}

TEST(OnlineSession, WorseModelIsRefusedAndTheOldOneKept) {
  OnlineSession session;
  Feeder feeder(session);
  InputSequence inputs(0.01);
  feeder.inputs(inputs, 30000);
  const double r_discharge = session.model()->fit.parameters.r_discharge;
  const auto job = session.takeJob();
  IdentificationResult worse = runIdentification(*job);
  worse.model->fit.parameters.r_discharge = 0.02;
  worse.worsening = 1.2;
  const IdentificationOutcome outcome = session.finish(worse);
  EXPECT_FALSE(outcome.accepted);
  EXPECT_THAT(outcome.message, HasSubstr("RMSE"));
  EXPECT_EQ(session.model()->fit.parameters.r_discharge, r_discharge);
}

TEST(OnlineSession, FitThatLeavesARequiredParameterOpenIsRefusedByItsName) {
  OnlineSession session;
  Feeder feeder(session);
  InputSequence inputs(0.01);
  feeder.inputs(inputs, 10000);
  auto job = session.takeJob();
  job->window_length = 90.0;
  IdentificationResult result = runIdentification(*job);
  ASSERT_TRUE(result.model) << result.message;
  for (ParameterEstimate& estimate : result.model->fit.estimates) {
    if (estimate.name == "u_dc") estimate.determined = false;
  }
  EXPECT_THAT(session.finish(result).message, HasSubstr("does not determine u_dc"));
}

TEST(SampleStream, OneBadStampFarOffIsCountedAndChangesNothing) {
  SampleStream stream(100.0);
  for (int n = 0; n < 1000; ++n) {
    stream.push({n * 0.01 + 500.0, 1.0, 12.0, {}});
    if (n == 300) stream.push({1.0e6, 1.0, 12.0, {}});
    if (n == 600) stream.push({3.0, 1.0, 12.0, {}});
  }
  EXPECT_EQ(stream.series().size(), 1000u);
  EXPECT_EQ(stream.counts().stamp_ahead, 1u);
  EXPECT_EQ(stream.counts().rejected.clock_step_back, 1u);
  EXPECT_EQ(stream.counts().clock_restarts, 0u);
}

TEST(SampleStream, ConfirmedJumpsAreBelieved) {
  SampleStream stream(1000.0);
  for (int n = 0; n < 100; ++n) stream.push({500.0 + n, 1.0, 12.0, {}});
  for (int n = 0; n < 100; ++n) stream.push({900.0 + n, 1.0, 12.0, {}});
  EXPECT_EQ(stream.series().size(), 200u);
  for (int n = 0; n < 50; ++n) stream.push({10.0 + n, 1.0, 12.0, {}});
  EXPECT_EQ(stream.series().size(), 50u);
  EXPECT_EQ(stream.counts().clock_restarts, 1u);
  EXPECT_EQ(stream.counts().accepted, 250u);
  EXPECT_EQ(stream.counts().rejectedTotal(), 0u);
}

TEST(SampleStream, KeepsAtLeastThePastAskedForAndNotMuchMore) {
  SampleStream stream(100.0);
  for (int n = 0; n < 10000; ++n) stream.push({n * 0.1, 1.0, 12.0, 300.0});
  const Series& series = stream.series();
  EXPECT_GE(series.time.back() - series.time.front(), 99.9);
  EXPECT_LE(series.time.back() - series.time.front(), 125.0);
  EXPECT_GE(series.temperature_time.front(), series.time.front());
}

TEST(SampleStream, BadValuesAreCountedByReason) {
  SampleStream stream(100.0);
  const double infinite = std::numeric_limits<double>::infinity();
  for (int n = 0; n < 20; ++n) stream.push({static_cast<double>(n), 1.0, 12.0, {}});
  for (const RawSample& sample :
       {RawSample{20.0, kNan, 12.0, {}}, RawSample{20.0, infinite, 12.0, {}},
        RawSample{19.0, 1.0, 12.0, {}}, RawSample{17.0, 1.0, 12.0, {}},
        RawSample{20.0, 1.0, 500.0, {}}, RawSample{kNan, 1.0, 12.0, {}}}) {
    stream.push(sample);
  }
  const RejectedCounts rejected = stream.counts().rejected;
  EXPECT_EQ(rejected.missing_value + rejected.not_finite, 3u);
  EXPECT_EQ(rejected.duplicate_stamp, 1u);
  EXPECT_EQ(rejected.clock_step_back, 1u);
  EXPECT_EQ(rejected.out_of_range, 1u);
  EXPECT_EQ(stream.counts().accepted, 20u);
}

TEST(SetStateFromVoltage, ModelThenReadsTheMeasuredVoltage) {
  FittedModel model;
  model.fit.parameters = InputSequence::truth();
  model.fit.covariance = Eigen::MatrixXd::Zero(kCovarianceRows, kCovarianceRows);
  model.fit.covariance(kRowUDc, kRowUDc) = 0.01;
  model.fit.scores.rmse = 0.02;
  setStateFromVoltage(model, 5.0, -100.0, 11.8);
  EXPECT_NEAR(test::terminalVoltage(model.fit.parameters, -100.0, model.state.states[0]), 11.8,
              1e-12);
  EXPECT_NEAR(model.fit.covariance(kRowState, kRowState), 0.01 + 0.0004, 1e-12);
  EXPECT_NEAR(model.fit.covariance(kRowState, kRowUDc), -0.01, 1e-12);
}

}  // namespace
}  // namespace battery_sof
