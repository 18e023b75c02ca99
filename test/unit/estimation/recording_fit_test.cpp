#include "estimation/identification.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "support/base_drive.hpp"
#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

class RecordingFit : public ::testing::Test {
 protected:
  InstrumentLimits cutOffAt(double limit) const {
    InstrumentLimits limits;
    limits.masked.assign(series_.size(), 0);
    limits.current_limits = {limit};
    return limits;
  }

  Series series_ = test::baseDrive(1, 400.0);
  FitRequest request_;
};

TEST_F(RecordingFit, TheWindowIsWhatWasAskedWhereBothEndsAreGiven) {
  request_.from = 20.0;
  request_.to = 380.0;
  const FitPlan plan = planFit(series_, request_);
  ASSERT_TRUE(plan.window.range);
  EXPECT_NEAR(series_.time[plan.window.range->first], 20.0, 1e-9);
  EXPECT_NEAR(series_.time[plan.window.range->last - 1], 380.0, 1e-9);
}

TEST_F(RecordingFit, TheWindowIsChosenInsideWhereOneEndIsMissingOrItIsAskedFor) {
  request_.from = 20.0;
  const FitPlan open = planFit(series_, request_);
  ASSERT_TRUE(open.window.range);
  EXPECT_GE(series_.time[open.window.range->first], 20.0);
  EXPECT_NEAR(series_.time[open.window.range->last - 1] - series_.time[open.window.range->first],
              240.0, 1.0);
  request_.to = 390.0;
  request_.chooses_window = true;
  EXPECT_NEAR(planFit(series_, request_).window.range->size(), open.window.range->size(), 2.0);
}

TEST_F(RecordingFit, TheStateIsCarriedToTheRequestsEnd) {
  request_.from = 0.0;
  request_.to = 240.0;
  FittedModel model = fitPlanned(series_, planFit(series_, request_));
  ASSERT_TRUE(isUsable(model.fit));
  EXPECT_TRUE(model.fit.noise.has_value());
  request_.to = 300.0;
  carryToEnd(model, series_, request_);
  EXPECT_NEAR(model.state.time, 300.0, 1e-9);
  request_.to.reset();
  carryToEnd(model, series_, request_);
  EXPECT_EQ(model.state.time, series_.time.back());
}

TEST_F(RecordingFit, WithoutAWindowThereIsNoModelAndAReason) {
  request_.from = 10.0;
  request_.to = 10.2;
  request_.chooses_window = true;
  const FitPlan plan = planFit(series_, request_);
  EXPECT_FALSE(plan.window.range);
  const FittedModel model = fitPlanned(series_, plan);
  EXPECT_FALSE(isUsable(model.fit));
  EXPECT_EQ(model.fit.message, plan.window.message);
  EXPECT_FALSE(model.fit.message.empty());
}

TEST_F(RecordingFit, ARangeWithoutSamplesIsRefusedWithWhatThereIs) {
  try {
    samplesBetween(series_, 500.0, 600.0);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_EQ(std::string(error.what())
                  .rfind("no sample from 500.000 to 600.000 s; the recording holds 0.000 to ", 0),
              0u)
        << error.what();
  }
  EXPECT_THROW(samplesBetween({}, 0.0, 1.0), std::invalid_argument);
}

TEST_F(RecordingFit, ARecordingWithAProblemIsRefusedUnlessItIsMeant) {
  for (double& current : series_.current) current = -current;
  const FittedModel refused = fitPlanned(series_, planFit(series_, request_));
  EXPECT_EQ(refused.fit.status, FitStatus::kRefused);
  EXPECT_NE(refused.fit.message.find("--discharge-positive"), std::string::npos);
  request_.anyway = true;
  EXPECT_NE(fitPlanned(series_, planFit(series_, request_)).fit.status, FitStatus::kRefused);
}

/// Cranks of which the sensor showed -200 A at most, and the same with their currents taken for
/// true.
TEST_F(RecordingFit, ACurrentThatIsCutOffBoundsTheResistance) {
  const double truth = test::drivenBattery().r_discharge;
  double cut_off = 0.0;
  for (double& current : series_.current) {
    cut_off += current < -200.0;
    current = std::max(current, -200.0);
  }
  ASSERT_GT(cut_off, 100.0);
  request_.from = 0.0;
  request_.to = 400.0;
  FitPlan plan = planFit(series_, request_);
  takeInstrument(plan.options, series_, cutOffAt(-200.0));
  const FittedModel bounded = fitPlanned(series_, plan);
  ASSERT_TRUE(isUsable(bounded.fit)) << bounded.fit.message;
  EXPECT_EQ(bounded.fit.excited.sensor_min_current, -200.0);
  plan.options.bounded.clear();
  const FittedModel counted = fitPlanned(series_, plan);
  EXPECT_NEAR(bounded.fit.parameters.r_discharge, truth, 0.02 * truth);
  EXPECT_GT(counted.fit.parameters.r_discharge, 1.1 * truth);
}

/// The samples without the bound determine a resistance that is too small: then the bound counts.
TEST_F(RecordingFit, ABoundThatIsViolatedCostsSomething) {
  for (std::size_t n = 0; n < series_.size(); ++n) {
    if (series_.current[n] >= -200.0) continue;
    series_.current[n] = -200.0;
    series_.voltage[n] += 1.0;
  }
  request_.from = 0.0;
  request_.to = 400.0;
  FitPlan plan = planFit(series_, request_);
  takeInstrument(plan.options, series_, cutOffAt(-200.0));
  const FittedModel bounded = fitPlanned(series_, plan);
  plan.options.bounded.clear();
  const FittedModel counted = fitPlanned(series_, plan);
  EXPECT_NEAR(bounded.fit.parameters.r_discharge, counted.fit.parameters.r_discharge, 1e-4);
}

/// One sample a second, the voltage of which comes half a second late: what it shows of a crank
/// depends on the instant.
TEST_F(RecordingFit, CranksOfSlowSamplesWeighNoMoreThanOthers) {
  constexpr std::size_t kSecond = 100, kLate = 50;  // samples
  const Series fast = test::baseDrive(3, 1200.0);
  Series slow;
  for (std::size_t n = kSecond; n < fast.size(); n += kSecond)
    slow.append({fast.time[n], fast.current[n], fast.voltage[n - kLate]});
  request_.from = slow.time.front();
  request_.to = slow.time.back();
  request_.options.effects = {"time_skew"};
  FitPlan plan = planFit(slow, request_);
  EXPECT_EQ(plan.options.crank_weight, 1.0);
  plan.options.source.reset();  // which has a cost of its own
  const auto errorOfResistance = [&] {
    const FittedModel fitted = fitPlanned(slow, plan);
    return std::abs(fitted.fit.parameters.r_discharge - test::drivenBattery().r_discharge);
  };
  const double without_weight = errorOfResistance();
  plan.options.crank_weight = 10.0;
  EXPECT_LT(without_weight, 0.5 * errorOfResistance());
}

TEST_F(RecordingFit, FastCranksAndThePapersStartKeepTheWeightOfCranks) {
  EXPECT_EQ(planFit(series_, request_).options.crank_weight, 10.0);
  request_.options.start = FitStart::kPaper;
  EXPECT_EQ(planFit(test::everyNth(series_, 100), request_).options.crank_weight, 10.0);
}

TEST_F(RecordingFit, ASearchThatNeverMovedIsNoModel) {
  Fit fit;
  fit.window.samples = 900;
  fit.iterations = 0;
  requirePlausible(fit);
  EXPECT_EQ(fit.status, FitStatus::kImplausible);
  EXPECT_NE(fit.message.find("did not move"), std::string::npos);
}

TEST_F(RecordingFit, StandardErrorsThatNoDataCanGiveAreAFailedFit) {
  const FittedModel sound = fitPlanned(series_, planFit(series_, request_));
  ASSERT_EQ(sound.fit.status, FitStatus::kConverged) << sound.fit.message;
  Fit fit = sound.fit;
  fit.estimates[0].std = 1e-14;
  requirePlausible(fit);
  EXPECT_EQ(fit.status, FitStatus::kImplausible);
  EXPECT_NE(fit.message.find("r_discharge"), std::string::npos) << fit.message;
  EXPECT_FALSE(isUsable(fit));
}

/// Even without noise: what rounding leaves is an error that data can give.
TEST_F(RecordingFit, ADriveWithoutNoiseIsAModel) {
  const Series clean = test::baseDrive(2, 300.0, 0.0);
  const FittedModel model = fitPlanned(clean, planFit(clean, request_));
  EXPECT_EQ(model.fit.status, FitStatus::kConverged) << model.fit.message;
}

TEST_F(RecordingFit, ASearchThatTheLimitStoppedIsNoModel) {
  request_.options.max_iterations = 1;
  request_.options.initial = {0.05, 0.05, 200.0, 100.0};
  const FittedModel model = fitPlanned(series_, planFit(series_, request_));
  EXPECT_EQ(model.fit.status, FitStatus::kIterationLimit) << model.fit.message;
  EXPECT_FALSE(isUsable(model.fit));
}

}  // namespace
}  // namespace battery_sof
