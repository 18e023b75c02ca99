#include "battery_sof/diagnose/unseen_current.hpp"

#include <gtest/gtest.h>

#include "support/base_drive.hpp"

namespace battery_sof {
namespace {

/// A step of 20 A between the third and the fourth sample.
Series stepped(double interval) {
  Series series;
  for (int n = 0; n < 40; ++n) {
    series.time.push_back(n * interval);
    series.current.push_back(n < 3 ? -30.0 : -10.0);
    series.voltage.push_back(12.6);
  }
  return series;
}

struct Shifted {
  explicit Shifted(double interval, double skew) : drive(fullDrive(stepped(interval), {0, 40})) {
    point = typicalStart(model, drive);
    point.parameters[*model.parameterRow("channel_skew")] = skew;
    const BatteryModel circuit;
    const CompositionPoint base = typicalStart(circuit, drive);
    response = baseResponse(circuit, {base.parameters, base.state, drive.first_time, drive.first_time}, drive, drive.samples.size());
  }
  BatteryModel model = BatteryModel({"time_skew"});
  Drive drive;
  CompositionPoint point;
  BaseResponse response;
};

TEST(UnseenCurrent, AStepAtAnUnknownInstantIsWidestHalfwayBetweenTwoSamples) {
  const Shifted shifted(1.0, 0.5);
  const double ohmic = 0.5 * (shifted.point.parameters[kRowRDischarge] + shifted.point.parameters[kRowRCharge]);
  const Eigen::VectorXd variance = unseenVariance(shifted.drive, shifted.response, shifted.model, shifted.point);
  ASSERT_EQ(40, variance.size());
  for (Eigen::Index row = 0; row < 40; ++row) EXPECT_NEAR(row == 3 ? 0.25 * 400.0 * ohmic * ohmic : 0.0, variance[row], 1e-12) << row;
}

TEST(UnseenCurrent, AShiftByWholeSamplesAsksForNothingThatWasNotSampled) {
  const Shifted shifted(1.0, 1.0);
  EXPECT_NEAR(0.0, unseenVariance(shifted.drive, shifted.response, shifted.model, shifted.point).maxCoeff(), 1e-9);
}

TEST(UnseenCurrent, AFastRecordingSeesItsSteps) {
  const Shifted shifted(0.01, 0.005);
  EXPECT_EQ(0, unseenVariance(shifted.drive, shifted.response, shifted.model, shifted.point).size());
}

TEST(UnseenCurrent, AModelThatShiftsNothingKnowsItsCurrent) {
  const Shifted shifted(1.0, 0.5);
  const BatteryModel circuit;
  EXPECT_EQ(0, unseenVariance(shifted.drive, shifted.response, circuit, typicalStart(circuit, shifted.drive)).size());
}

TEST(UnseenCurrent, ASampleAsWideAsTheNoiseCountsHalf) {
  const Shifted shifted(1.0, 0.5);
  const double ohmic = 0.5 * (shifted.point.parameters[kRowRDischarge] + shifted.point.parameters[kRowRCharge]);
  const Drive counted = withUnseen(shifted.drive, shifted.model, shifted.point, 0.5 * 20.0 * ohmic);
  for (std::size_t n = 0; n < counted.samples.size(); ++n) EXPECT_NEAR(n == 3 ? 0.5 : 1.0, counted.samples[n].count, 1e-12) << n;
}

}  // namespace
}  // namespace battery_sof
