#include "simulator/acquisition.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "support/refusal.hpp"

namespace battery_sof_simulator {
namespace {

constexpr double kRate = 1000.0;

AcquisitionOptions noiseless() {
  AcquisitionOptions options;
  options.voltage_noise = options.current_noise = {};
  options.voltage_step_v = options.current_step_a = 0.0;
  return options;
}

std::vector<RecordedSample> recorded(const AcquisitionOptions& options, double duration,
                                     const std::function<double(double)>& signal,
                                     std::uint64_t seed = 1) {
  Acquisition acquisition(options, kRate, seed);
  const auto count = static_cast<int>((duration + acquisition.lookAhead()) * kRate) + 1;
  for (int n = 0; n <= count; ++n) acquisition.push(signal(n / kRate), signal(n / kRate));
  return acquisition.recording(duration);
}

double gainAt(double frequency, double cutoff) {
  BesselFilter filter(cutoff, kRate);
  filter.settle(0.0);
  double most = 0.0;
  for (int n = 0; n < 20000; ++n) {
    const double out = filter.push(std::sin(2.0 * M_PI * frequency * n / kRate));
    if (n > 10000) most = std::max(most, std::abs(out));
  }
  return most;
}

TEST(BesselFilter, LosesThreeDecibelAtTheCutOffAndTwentyThreeAtFiftyHertz) {
  EXPECT_NEAR(20.0 * std::log10(gainAt(20.0, 20.0)), -3.01, 0.05);
  EXPECT_NEAR(20.0 * std::log10(gainAt(50.0, 20.0)), -23.0, 1.5);
  EXPECT_NEAR(gainAt(0.5, 20.0), 1.0, 0.002);
}

TEST(BesselFilter, StepDoesNotOvershootByMoreThanHalfAPercent) {
  BesselFilter filter(20.0, kRate);
  filter.settle(0.0);
  double most = 0.0;
  for (int n = 0; n < 1000; ++n) most = std::max(most, filter.push(1.0));
  EXPECT_LT(most, 1.005);
}

TEST(BesselFilter, RefusesACutOffAtHalfTheRate) {
  EXPECT_THROW(BesselFilter(500.0, kRate), std::invalid_argument);
  EXPECT_THROW(BesselFilter(0.0, kRate), std::invalid_argument);
}

TEST(Acquisition, TheFiltersDelayIsTakenOutOfTheStamps) {
  const auto ramp = [](double t) { return 3.0 * t; };
  for (const auto& sample : recorded(noiseless(), 5.0, ramp)) {
    if (sample.time > 0.5) {
      ASSERT_NEAR(sample.voltage, 3.0 * sample.time, 1e-9) << sample.time;
    }
  }
  const double gain = gainAt(3.0, 20.0);
  const auto sine = [](double t) { return std::sin(2.0 * M_PI * 3.0 * t); };
  for (const auto& sample : recorded(noiseless(), 5.0, sine)) {
    if (sample.time > 0.5) {
      ASSERT_NEAR(sample.voltage / gain, sine(sample.time), 2e-3);
    }
  }
}

TEST(Acquisition, SamplesStandOnAGridOf100HertzFromZero) {
  const auto samples = recorded(noiseless(), 2.0, [](double) { return 1.0; });
  ASSERT_EQ(samples.size(), 200u);
  for (std::size_t n = 0; n < samples.size(); ++n) EXPECT_DOUBLE_EQ(samples[n].time, n / 100.0);
}

TEST(Acquisition, CurrentCanBeReportedLate) {
  for (double late : {0.0137, -0.02}) {
    AcquisitionOptions options = noiseless();
    options.current_delay_s = late;
    const auto samples = recorded(options, 5.0, [](double t) { return 3.0 * t; });
    ASSERT_EQ(samples.size(), 500u);
    EXPECT_NEAR(samples[400].current, 3.0 * (samples[400].time - late), 1e-9);
    EXPECT_NEAR(samples[400].voltage, 3.0 * samples[400].time, 1e-9);
  }
}

TEST(Acquisition, OffsetAndGainActOnTheCurrentAlone) {
  AcquisitionOptions options = noiseless();
  options.current_offset_a = 0.5;
  options.current_gain = 1.02;
  const auto sample = recorded(options, 1.0, [](double) { return 10.0; }).back();
  EXPECT_NEAR(sample.current, 10.7, 1e-12);
  EXPECT_NEAR(sample.voltage, 10.0, 1e-12);
}

TEST(Acquisition, ValuesAreWholeMultiplesOfTheQuantisation) {
  AcquisitionOptions options;
  options.voltage_step_v = 0.005;
  options.current_step_a = 0.1;
  for (const auto& s : recorded(options, 2.0, [](double t) { return 12.0 + t; })) {
    ASSERT_NEAR(std::remainder(s.voltage, 0.005), 0.0, 1e-9);
    ASSERT_NEAR(std::remainder(s.current, 0.1), 0.0, 1e-9);
  }
}

TEST(Acquisition, NoiseHasTheStatedDeviations) {
  AcquisitionOptions options = noiseless();
  options.voltage_noise.white = 0.01;
  options.current_noise.correlated = 0.2;
  options.current_noise.correlation_time = 2.0;
  const auto samples = recorded(options, 2000.0, [](double) { return 0.0; });
  double white = 0.0, correlated = 0.0, lagged = 0.0;
  for (std::size_t n = 200; n < samples.size(); ++n) {
    white += samples[n].voltage * samples[n].voltage;
    correlated += samples[n].current * samples[n].current;
    lagged += samples[n].current * samples[n - 200].current;
  }
  const double count = static_cast<double>(samples.size() - 200);
  EXPECT_NEAR(std::sqrt(white / count), 0.01, 2e-4);
  EXPECT_NEAR(std::sqrt(correlated / count), 0.2, 0.02);
  EXPECT_NEAR(lagged / correlated, std::exp(-1.0), 0.1);
}

TEST(Acquisition, RandomWalkGrowsWithTheRootOfTime) {
  AcquisitionOptions options = noiseless();
  options.voltage_noise.walk_per_sqrt_min = 0.01;
  double squares = 0.0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const double end = recorded(
                           options, 30.0, [](double) { return 0.0; }, seed)
                           .back()
                           .voltage;
    squares += end * end;
  }
  EXPECT_NEAR(std::sqrt(squares / 200.0), 0.01 * std::sqrt(0.5), 0.0012);
}

TEST(Acquisition, WithoutAFilterTheSamplesAreTheValuesThemselves) {
  AcquisitionOptions options = noiseless();
  options.cutoff_hz = 0.0;
  for (const auto& s : recorded(options, 2.0, [](double t) { return std::sin(t); }))
    ASSERT_NEAR(s.voltage, std::sin(s.time), 1e-12);
}

TEST(Acquisition, GainMayDifferBetweenChargeAndDischarge) {
  AcquisitionOptions options = noiseless();
  options.cutoff_hz = 0.0;
  options.current_gain_charge = 1.03;
  options.current_gain_discharge = 0.98;
  EXPECT_NEAR(recorded(options, 1.0, [](double) { return 10.0; }).back().current, 10.3, 1e-12);
  EXPECT_NEAR(recorded(options, 1.0, [](double) { return -10.0; }).back().current, -9.8, 1e-12);
}

TEST(Acquisition, ALagDelaysARampByItsTimeConstantOnItsChannelAlone) {
  AcquisitionOptions options = noiseless();
  options.voltage_lag_s = 0.05;
  const auto sample = recorded(options, 5.0, [](double t) { return 3.0 * t; }).back();
  EXPECT_NEAR(sample.voltage, 3.0 * (sample.time - 0.05), 1e-9);
  EXPECT_NEAR(sample.current, 3.0 * sample.time, 1e-9);
}

TEST(Acquisition, TheVoltageDriftsByItsRate) {
  AcquisitionOptions options = noiseless();
  options.voltage_drift_v_per_h = 0.36;
  const auto sample = recorded(options, 10.0, [](double) { return 12.0; }).back();
  EXPECT_NEAR(sample.voltage, 12.0 + 1e-4 * sample.time, 1e-9);
  EXPECT_NEAR(sample.current, 12.0, 1e-9);
}

TEST(Acquisition, ClippedChannelsHaveFlatTops) {
  AcquisitionOptions options = noiseless();
  options.current_limit_a = 2.0;
  options.voltage_floor_v = -1.0;
  options.voltage_ceiling_v = 3.0;
  for (const auto& s : recorded(options, 10.0, [](double t) { return 4.0 * std::sin(t); })) {
    ASSERT_LE(std::abs(s.current), 2.0);
    ASSERT_GE(s.voltage, -1.0);
    ASSERT_LE(s.voltage, 3.0);
  }
}

TEST(Acquisition, LosesTheStatedShareOfSamples) {
  AcquisitionOptions options = noiseless();
  options.lost_share = 0.1;
  const auto samples = recorded(options, 100.0, [](double t) { return t; });
  EXPECT_NEAR(static_cast<double>(samples.size()), 9000.0, 100.0);
  for (const auto& s : samples) {
    if (s.time > 0.5) {
      ASSERT_NEAR(s.voltage, s.time, 1e-9);
    }
  }
}

TEST(Acquisition, FrozenStretchesRepeatTheLastValue) {
  AcquisitionOptions options = noiseless();
  options.frozen_per_min = 6.0;
  options.frozen_s = {0.5, 0.5};
  const auto samples = recorded(options, 600.0, [](double t) { return t; });
  ASSERT_EQ(samples.size(), 60000u);
  int repeated = 0;
  for (std::size_t n = 1; n < samples.size(); ++n)
    repeated += samples[n].voltage == samples[n - 1].voltage ? 1 : 0;
  EXPECT_NEAR(repeated, 60 * 50, 1000);
}

TEST(Acquisition, AToneAboveHalfTheRateAppearsAtItsAlias) {
  AcquisitionOptions options = noiseless();
  options.tone_v = 0.01;
  options.tone_hz = 312.0;
  for (const auto& s : recorded(options, 5.0, [](double) { return 12.0; })) {
    ASSERT_NEAR(s.voltage - 12.0, 0.01 * std::sin(2.0 * M_PI * 12.0 * s.time), 1e-9);
  }
}

TEST(Acquisition, RefusesWrongOptionsNamingAllOfThem) {
  AcquisitionOptions options;
  options.cutoff_hz = -1.0;
  options.sample_rate_hz = 300.0;
  options.current_gain = 0.0;
  const std::string text = battery_sof::test::refusalOf([&] { Acquisition(options, kRate, 1); });
  for (const char* name : {"cutoff_hz", "sample_rate_hz", "current_gain"})
    EXPECT_NE(text.find(name), text.npos) << text;
}

}  // namespace
}  // namespace battery_sof_simulator
