#include "estimation/identification.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "support/base_drive.hpp"

namespace battery_sof {
namespace {

class RecordingFit : public ::testing::Test {
 protected:
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

}  // namespace
}  // namespace battery_sof
