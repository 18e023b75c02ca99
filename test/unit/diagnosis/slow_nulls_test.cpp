#include <gtest/gtest.h>

#include <algorithm>

#include "diagnosis/diagnose.hpp"
#include "support/base_drive.hpp"
#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

constexpr int kSteps = 50;        // of the truth in a second
constexpr double kNoise = 0.003;  // [V]

/// A bench at one sample a second: charges and discharges of a held current, rests of all lengths,
/// each reached by a second's ramp.
std::vector<double> benchCurrent(std::uint64_t seed, double duration) {
  test::Random random(seed);
  std::vector<double> second = {0.0};
  while (static_cast<double>(second.size()) < duration) {
    const double chance = random.uniform(0.0, 1.0);
    const double level = chance < 0.35  ? 0.0
                         : chance < 0.7 ? random.uniform(10.0, 55.0)
                                        : -random.uniform(5.0, 40.0);
    const auto length = static_cast<std::size_t>(random.uniform(3.0, 50.0));
    second.insert(second.end(), length, level);
  }
  std::vector<double> current;
  for (std::size_t n = 0; n + 1 < second.size(); ++n)
    for (int k = 0; k < kSteps; ++k)
      current.push_back(second[n] + (second[n + 1] - second[n]) * k / kSteps);
  return current;
}

class SlowNull : public testing::TestWithParam<std::uint64_t> {};

TEST_P(SlowNull, OfABenchThatRampsItsCurrentLacksNothing) {
  BaseParameters battery = test::drivenBattery();
  battery.c2 = 380.0;  // fast beside a second while it charges
  const Series truth =
      test::answered(battery, benchCurrent(GetParam(), 300.0), 1.0 / kSteps, kNoise, GetParam());
  const Diagnosis diagnosis = diagnose(test::toRecording(test::everyNth(truth, kSteps)));
  EXPECT_EQ(Verdict::kNoMismatch, diagnosis.verdict) << diagnosis.summary;
  EXPECT_LT(diagnosis.unexplained.noise, 1.1 * kNoise);
  EXPECT_LT(diagnosis.fit.base_train.rmse, 1.25 * kNoise);
  EXPECT_LT(diagnosis.fit.base_holdout.rmse, 1.25 * kNoise);
}

INSTANTIATE_TEST_SUITE_P(Seeds, SlowNull, testing::Range<std::uint64_t>(1, 9));

/// Two hours of the bench, whose open-circuit voltage rises with the charge.
Recording longBench(double slope) {
  BaseParameters battery = test::drivenBattery();
  battery.c2 = 380.0;
  Series truth = test::answered(battery, benchCurrent(5, 7000.0), 1.0 / kSteps, kNoise, 5);
  double charge = 0.0;  // [Ah]
  for (std::size_t n = 0; n < truth.size(); ++n) {
    charge += truth.current[n] / kSteps / 3600.0;
    truth.voltage[n] += slope * charge;
  }
  return test::toRecording(test::everyNth(truth, kSteps));
}

bool isWeighed(const Diagnosis& diagnosis, const std::string& id) {
  return std::any_of(diagnosis.candidates.begin(), diagnosis.candidates.end(),
                     [&](const Candidate& one) { return one.id == id; });
}

TEST(LongAndSlow, ABenchOfTwoHoursLacksNothingAndEveryEffectIsWeighed) {
  const Diagnosis diagnosis = diagnose(longBench(0.0));
  EXPECT_EQ(Verdict::kNoMismatch, diagnosis.verdict) << diagnosis.summary;
  for (const char* id : {"self_heating", "parameter_drift", "sulphate_history", "cpe2"})
    EXPECT_TRUE(isWeighed(diagnosis, id)) << id;
}

TEST(LongAndSlow, AnOpenCircuitVoltageThatMovesWithTheChargeIsFoundAndLowersTheError) {
  const Diagnosis diagnosis = diagnose(longBench(0.03));
  ASSERT_FALSE(diagnosis.effects.empty()) << diagnosis.summary;
  EXPECT_EQ("ocv_soc", diagnosis.effects.front().id);
  EXPECT_LT(diagnosis.fit.extended_holdout.rmse, 0.5 * diagnosis.fit.base_holdout.rmse);
}

}  // namespace
}  // namespace battery_sof
