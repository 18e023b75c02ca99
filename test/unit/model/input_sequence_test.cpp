#include "model/input_sequence.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "support/composed.hpp"

using namespace battery_sof;
using namespace battery_sof::test;

namespace {

constexpr double kEdgeCurrent = 2.0;  // [A], of compressedInputs()

Series seriesOf(std::vector<double> time, std::vector<double> current) {
  Series series;
  series.voltage.assign(time.size(), 12.0);
  series.time = std::move(time);
  series.current = std::move(current);
  return series;
}

/// Charge of a current that is linear between samples and zero across gaps [As].
double chargeOf(const Series& series, double max_gap) {
  double charge = 0.0;
  for (std::size_t n = 1; n < series.size(); ++n) {
    const double dt = series.time[n] - series.time[n - 1];
    if (dt <= max_gap) charge += 0.5 * (series.current[n - 1] + series.current[n]) * dt;
  }
  return charge;
}

double chargeOf(const InputSequence& inputs) {
  double charge = 0.0;
  for (const InputSample& sample : inputs.samples)
    charge += sample.step.held * sample.step.duration;
  return charge;
}

double countOf(const InputSequence& inputs) {
  double count = 0.0;
  for (const InputSample& sample : inputs.samples) count += sample.count;
  return count;
}

/// Four minutes with a rest of 40 s that the recorder slept through.
Series driveWithAGap() {
  Series series = baseDrive(5, 240.0, 0.001);
  for (std::size_t n = 12000; n < series.size(); ++n) series.time[n] += 40.0;
  return series;
}

}  // namespace

TEST(CurrentTrace, IsLinearBetweenSamplesAndHoldsItsEndsOutside) {
  const Series series = seriesOf({1.0, 2.0, 4.0}, {10.0, 20.0, -20.0});
  const CurrentTrace trace(series, whole(series), 5.0);
  EXPECT_DOUBLE_EQ(trace.at(0.0), 10.0);
  EXPECT_DOUBLE_EQ(trace.at(1.25), 12.5);
  EXPECT_DOUBLE_EQ(trace.at(2.0), 20.0);
  EXPECT_DOUBLE_EQ(trace.at(3.0), 0.0);
  EXPECT_DOUBLE_EQ(trace.at(9.0), -20.0);
}

TEST(CurrentTrace, HasTheSlopeOfTheSegmentThatEndsAtATimeAndNoneOutside) {
  const Series series = seriesOf({1.0, 2.0, 4.0}, {10.0, 20.0, -20.0});
  const CurrentTrace trace(series, whole(series), 5.0);
  EXPECT_DOUBLE_EQ(trace.slopeAt(1.0), 0.0);
  EXPECT_DOUBLE_EQ(trace.slopeAt(1.5), 10.0);
  EXPECT_DOUBLE_EQ(trace.slopeAt(2.0), 10.0);
  EXPECT_DOUBLE_EQ(trace.slopeAt(2.01), -20.0);
  EXPECT_DOUBLE_EQ(trace.slopeAt(4.01), 0.0);
}

TEST(CurrentTrace, MeanOverAnyIntervalIsThatOfItsValues) {
  const Series series = livelyMinute(0.5);
  const CurrentTrace trace(series, whole(series), 5.0);
  for (const auto& [from, to] :
       {std::pair(2.9, 3.4), std::pair(5.0, 9.3), std::pair(-1.0, 70.0), std::pair(6.1, 6.2)}) {
    const int parts = 200000;
    double sum = 0.0;
    for (int k = 0; k < parts; ++k) sum += trace.at(from + (to - from) * (k + 0.5) / parts);
    EXPECT_NEAR(trace.meanBetween(from, to), sum / parts, 2e-3) << from;
  }
}

TEST(CurrentTrace, IsZeroInsideAGap) {
  const Series series = seriesOf({0.0, 1.0, 21.0, 22.0}, {10.0, 10.0, 30.0, 30.0});
  const CurrentTrace trace(series, whole(series), 5.0);
  EXPECT_DOUBLE_EQ(trace.at(11.0), 0.0);
  EXPECT_DOUBLE_EQ(trace.at(21.0), 30.0);
  EXPECT_DOUBLE_EQ(trace.slopeAt(11.0), 0.0);
  EXPECT_DOUBLE_EQ(trace.meanBetween(0.0, 22.0), (10.0 + 30.0) / 22.0);
  EXPECT_DOUBLE_EQ(trace.meanBetween(2.0, 20.0), 0.0);
}

TEST(CurrentTrace, GrowsSampleBySampleAndForgetsWithoutChangingWhatIsLeft) {
  const Series series = baseDrive(1, 60.0);
  const CurrentTrace all(series, whole(series), 5.0);
  CurrentTrace grown;
  EXPECT_TRUE(grown.empty());
  EXPECT_EQ(grown.at(3.0), 0.0);
  for (std::size_t n = 0; n < series.size(); ++n) {
    grown.append(series.time[n], series.current[n], 5.0);
    grown.forgetBefore(series.time[n] - 1.0);
  }
  for (double t = 59.0; t < 60.0; t += 0.0037) {
    ASSERT_EQ(grown.at(t), all.at(t));
    ASSERT_EQ(grown.slopeAt(t), all.slopeAt(t));
    ASSERT_EQ(grown.meanBetween(t - 0.05, t), all.meanBetween(t - 0.05, t));
  }
}

TEST(InputStep, AFastOrFlatCurrentIsOnePieceAndASlowRampSeveral) {
  EXPECT_EQ(inputStep(1.0, -20.0, 1.01, -300.0, 5.0).rampPieces(), 1);
  EXPECT_EQ(inputStep(1.0, 20.0, 2.0, 20.0, 5.0).rampPieces(), 1);
  EXPECT_EQ(inputStep(1.0, 20.6, 2.0, 48.0, 5.0).rampPieces(), 6);
  EXPECT_EQ(inputStep(1.0, 48.0, 2.0, 20.6, 5.0).rampPieces(), 6);
  EXPECT_EQ(inputStep(1.0, -300.0, 4.0, 100.0, 5.0).rampPieces(), 16);
  EXPECT_EQ(inputStep(1.0, -300.0, 31.0, 100.0, 5.0).rampPieces(), 1);
}

TEST(InputStep, HoldsTheMeanOfBothSamplesAndNothingAcrossAGap) {
  const InputStep joined = inputStep(1.0, 10.0, 3.0, 20.0, 5.0);
  EXPECT_DOUBLE_EQ(joined.duration, 2.0);
  EXPECT_DOUBLE_EQ(joined.held, 15.0);
  EXPECT_DOUBLE_EQ(joined.current, 20.0);
  EXPECT_DOUBLE_EQ(joined.slope, 5.0);
  EXPECT_FALSE(joined.gap);
  const InputStep parted = inputStep(1.0, 10.0, 31.0, 20.0, 5.0);
  EXPECT_DOUBLE_EQ(parted.held, 0.0);
  EXPECT_DOUBLE_EQ(parted.current, 20.0);
  EXPECT_DOUBLE_EQ(parted.slope, 0.0);
  EXPECT_TRUE(parted.gap);
}

TEST(FullInputs, IsOneSampleAStepAndConservesCharge) {
  const Series series = driveWithAGap();
  const InputSequence inputs = inputSequence(series, whole(series));
  ASSERT_EQ(inputs.samples.size(), series.size());
  EXPECT_EQ(inputs.samples.front().step.duration, 0.0);
  EXPECT_EQ(inputs.first_time, series.time.front());
  EXPECT_NEAR(chargeOf(inputs), chargeOf(series, gapThreshold(series)), 1e-6);
  for (std::size_t n = 0; n < series.size(); ++n) {
    ASSERT_EQ(inputs.samples[n].step.time, series.time[n]);
    ASSERT_EQ(inputs.samples[n].step.current, series.current[n]);
    ASSERT_EQ(inputs.samples[n].voltage, series.voltage[n]);
    ASSERT_EQ(inputs.samples[n].step.gap, n == 12000);
    ASSERT_EQ(inputs.samples[n].step.trace, inputs.trace.get());
  }
}

TEST(FullInputs, OfNothingIsNothing) {
  const Series series = baseDrive(1, 1.0);
  EXPECT_TRUE(inputSequence(series, {5, 5}).samples.empty());
  EXPECT_TRUE(compressedInputs(series, {5, 5}).samples.empty());
  EXPECT_EQ(compressedInputs(series, {5, 6}).samples.size(), 1u);
}

TEST(CompressedInputs, ConservesChargeBetweenItsFirstAndItsLastMiddle) {
  const Series series = driveWithAGap();
  const InputSequence full = inputSequence(series, whole(series)),
                      compressed = compressedInputs(series, whole(series));
  const double from = compressed.samples.front().step.time,
               to = compressed.samples.back().step.time;
  EXPECT_NEAR(chargeOf(compressed), full.trace->meanBetween(from, to) * (to - from), 1e-6);
}

TEST(CompressedInputs, CountsEverySampleOnceAndKeepsTheMeanVoltage) {
  const Series series = driveWithAGap();
  const InputSequence compressed = compressedInputs(series, whole(series));
  EXPECT_EQ(countOf(compressed), static_cast<double>(series.size()));
  EXPECT_LT(compressed.samples.size(), series.size() / 4);
  double sum = 0.0;
  for (const InputSample& sample : compressed.samples) {
    sum += sample.count * sample.voltage;
    EXPECT_NEAR(sample.step.span, sample.count > 1.0 ? 0.01 * sample.count : 0.0, 1e-9);
  }
  const double all = std::accumulate(series.voltage.begin(), series.voltage.end(), 0.0);
  EXPECT_NEAR(sum, all, 1e-9 * all);
}

TEST(CompressedInputs, IsAtFullRateAroundEveryEdge) {
  const Series series = driveWithAGap();
  const InputSequence compressed = compressedInputs(series, whole(series));
  std::vector<double> single;  // times of samples that stand alone
  for (const InputSample& sample : compressed.samples)
    if (sample.count == 1.0) single.push_back(sample.step.time);
  const auto alone = [&](std::size_t n) {
    return std::binary_search(single.begin(), single.end(), series.time[n]);
  };
  int edges = 0;
  for (std::size_t n = 6; n + 6 < series.size(); ++n) {
    if (std::abs(series.current[n] - series.current[n - 1]) <= kEdgeCurrent) continue;
    ++edges;
    // Five before it; after it until a quarter of the time since then holds a second sample.
    for (std::size_t k = n - 5; k <= n + 3; ++k)
      ASSERT_TRUE(alone(k)) << "edge " << n << " sample " << k;
  }
  EXPECT_GT(edges, 30);
}

TEST(CompressedInputs, AveragesOnlyNearlyHeldCurrentsForHalfASecondAtMost) {
  Series series = baseDrive(3, 120.0);
  Random random(4);
  for (double& i : series.current) i += 0.3 * random.normal();
  const InputSequence compressed = compressedInputs(series, whole(series));
  std::size_t n = 0;
  for (const InputSample& sample : compressed.samples) {
    const auto count = static_cast<std::size_t>(sample.count);
    const auto first = series.current.begin() + static_cast<std::ptrdiff_t>(n);
    const auto [low, high] = std::minmax_element(first, first + static_cast<std::ptrdiff_t>(count));
    ASSERT_LE(*high - *low, kEdgeCurrent);
    ASSERT_EQ(*low < 0.0, *high < 0.0);
    ASSERT_LE(series.time[n + count - 1] - series.time[n], kLongestStretch + 1e-9);
    n += count;
  }
  EXPECT_EQ(n, series.size());
}

TEST(CompressedInputs, MarksAGapAndHoldsNoCurrentAcrossIt) {
  const Series series = driveWithAGap();
  const InputSequence compressed = compressedInputs(series, whole(series));
  int gaps = 0;
  for (std::size_t k = 1; k < compressed.samples.size(); ++k) {
    const InputStep& step = compressed.samples[k].step;
    if (!step.gap) continue;
    ++gaps;
    EXPECT_EQ(step.held, 0.0);
    EXPECT_EQ(step.slope, 0.0);
    EXPECT_NEAR(step.duration, 40.01, 1e-9);
    EXPECT_EQ(compressed.samples[k].count, 1.0);
    EXPECT_EQ(compressed.samples[k - 1].count, 1.0);
  }
  EXPECT_EQ(gaps, 1);
}

TEST(CompressedInputs, GivesTheFullDrivesMeanVoltageToAFewHundredMicrovolts) {
  const Series series = baseDrive(9, 240.0, 0.0);
  const BatteryModel model({"acid_transport", "ocv_hysteresis"});
  const ModelPoint start = pointOf(model, typicalPoint(model));
  const InputSequence full = inputSequence(series, whole(series)),
                      compressed = compressedInputs(series, whole(series));
  const auto fine = voltages(model, start, full), coarse = voltages(model, start, compressed);
  std::size_t n = 0;
  double worst = 0.0;
  for (std::size_t k = 0; k < coarse.size(); ++k) {
    const auto count = static_cast<std::size_t>(compressed.samples[k].count);
    double mean = 0.0;
    for (std::size_t j = n; j < n + count; ++j) mean += fine[j] / static_cast<double>(count);
    n += count;
    worst = std::max(worst, std::abs(mean - coarse[k]));
  }
  EXPECT_LT(worst, 4e-4);
}

TEST(MissedCrank, GivesTheCranksChargeWhereASourceReturnsAfterADischargeThatShowsNone) {
  MissedCrank missed;
  for (int n = 0; n < 20; ++n) EXPECT_EQ(missed.add(1.0, -20.0, false), 0.0);
  EXPECT_DOUBLE_EQ(missed.add(1.0, 30.0, true), MissedCrank::kCharge);
  EXPECT_EQ(missed.add(1.0, 25.0, true), 0.0);
}

TEST(MissedCrank, LeavesOutWhatSamplesShowedOfTheCrank) {
  MissedCrank missed;
  for (int n = 0; n < 20; ++n) missed.add(1.0, -20.0, false);
  missed.add(1.0, -100.0, false);
  EXPECT_DOUBLE_EQ(missed.add(1.0, 30.0, true), MissedCrank::kCharge - 100.0);
  for (int n = 0; n < 20; ++n) missed.add(1.0, -20.0, false);
  missed.add(1.0, -200.0, false);
  EXPECT_EQ(missed.add(1.0, 30.0, true), 0.0);
}

TEST(MissedCrank, ASmallDischargeStartedNoEngine) {
  MissedCrank missed;
  for (int n = 0; n < 7; ++n) missed.add(1.0, -20.0, false);  // 140 As
  EXPECT_EQ(missed.add(1.0, 5.0, true), 0.0);
  // Each discharge counts alone.
  missed.add(1.0, -20.0, false);
  EXPECT_EQ(missed.add(1.0, 5.0, true), 0.0);
}

TEST(MissedCrank, FastSamplingMissesNothing) {
  MissedCrank missed;
  for (int n = 0; n < 4000; ++n) missed.add(0.01, -20.0, false);
  EXPECT_EQ(missed.add(0.01, 30.0, true), 0.0);
}

TEST(MissedCrank, AGapDrawsNoMoreThanTwoSecondsOfItsCurrent) {
  MissedCrank missed;
  missed.add(3600.0, -20.0, false);
  EXPECT_EQ(missed.add(1.0, 30.0, true), 0.0);
}

TEST(FullInputs, CarriesMarksOfTheSourceAndWhatWasMissed) {
  std::vector<double> time, current(31, -20.0);
  for (int n = 0; n < 31; ++n) time.push_back(n);
  current[30] = 40.0;
  const Series series = seriesOf(time, current);
  std::vector<char> controlled(31, 0);
  controlled[30] = 1;
  const InputSequence inputs = inputSequence(series, whole(series), {}, controlled);
  for (std::size_t n = 0; n < 30; ++n) {
    EXPECT_FALSE(inputs.samples[n].voltage_controlled);
    EXPECT_EQ(inputs.samples[n].step.missed, 0.0);
  }
  EXPECT_TRUE(inputs.samples[30].voltage_controlled);
  EXPECT_DOUBLE_EQ(inputs.samples[30].step.missed, MissedCrank::kCharge);
  EXPECT_EQ(inputSequence(series, whole(series)).samples[30].step.missed, 0.0);
}
