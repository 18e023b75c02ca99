#include "simulator/generator/imperfect_recorder.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace battery_sof_simulator {
namespace {

constexpr double kStep = FullBattery::kStep;
constexpr double kPi = 3.14159265358979323846;

/// A recorder that changes nothing but for its filters, which lie far above what it is shown.
ImperfectRecorder clear() {
  ImperfectRecorder r;
  r.voltage.corner_hz = r.current.corner_hz = 200.0;
  r.voltage.step = r.current.step = 0.0;
  r.jitter_share = 0.0;
  return r;
}

Course courseOf(double (*voltage)(double), double (*current)(double), double seconds) {
  Course course;
  for (long n = 0; n <= std::lround(seconds / kStep); ++n) {
    course.voltage.push_back(voltage(kStep * static_cast<double>(n)));
    course.current.push_back(current(kStep * static_cast<double>(n)));
  }
  return course;
}

double ramp(double t) { return 12.0 + 0.1 * t; }
double still(double) { return 12.0; }
double none(double) { return 0.0; }
double tone(double t) { return std::sin(2.0 * kPi * 20.0 * t); }

double deviation(const std::vector<double>& values, double mean) {
  double square = 0.0;
  for (double value : values) square += (value - mean) * (value - mean);
  return std::sqrt(square / static_cast<double>(values.size()));
}

TEST(ImperfectRecorder, FiltersOfEveryOrderPassARampUnshifted) {
  for (int poles : {1, 2, 3, 4, 8}) {
    ImperfectRecorder recorder = clear();
    recorder.voltage.poles = poles;
    recorder.voltage.corner_hz = 15.0;
    const auto samples = recordedThrough(recorder, courseOf(ramp, none, 10.0), 10, 1);
    for (std::size_t n = 50; n + 50 < samples.size(); ++n)
      ASSERT_NEAR(samples[n].voltage, ramp(samples[n].time), 2e-5) << poles;
  }
}

TEST(ImperfectRecorder, AtTheCornerAToneKeepsHalfItsPower) {
  for (int poles : {1, 2, 3, 4, 8}) {
    ImperfectRecorder recorder = clear();
    recorder.voltage.poles = poles;
    recorder.voltage.corner_hz = 20.0;
    const auto samples = recordedThrough(recorder, courseOf(tone, none, 10.0), 1, 1);
    double square = 0.0;
    for (std::size_t n = 2000; n < 8000; ++n) square += samples[n].voltage * samples[n].voltage;
    EXPECT_NEAR(square / 6000.0, 0.25, 0.01) << poles;
  }
}

TEST(ImperfectRecorder, ChannelsOfOtherFiltersPartAtEdgesOnly) {
  ImperfectRecorder recorder = clear();
  recorder.voltage.corner_hz = 10.0;
  recorder.current.corner_hz = 40.0;
  Course course;
  for (int n = 0; n <= 10000; ++n) {
    course.current.push_back(n < 5000 ? 0.0 : -50.0);
    course.voltage.push_back(0.01 * course.current.back());
  }
  const auto samples = recordedThrough(recorder, course, 10, 1);
  double most = 0.0;
  for (const RecordedSample& one : samples) {
    const double apart = std::abs(one.voltage - 0.01 * one.current);
    most = std::max(most, apart);
    if (std::abs(one.time - 5.0) > 0.3) {
      EXPECT_LT(apart, 1e-6) << one.time;
    }
  }
  EXPECT_GT(most, 0.05);
}

TEST(ImperfectRecorder, JitterIsAHundredthOfTheIntervalAndPartlyShared) {
  ImperfectRecorder recorder;
  recorder.jitter_apart_share = 0.5;
  const SampleInstants instants = jitteredInstants(recorder, 20000, 3);
  std::vector<double> voltage, apart;
  for (std::size_t n = 0; n < instants.voltage.size(); ++n) {
    voltage.push_back(instants.voltage[n] - static_cast<double>(n));
    apart.push_back(instants.voltage[n] - instants.current[n]);
  }
  EXPECT_NEAR(deviation(voltage, 0.0), 0.01, 0.0003);
  EXPECT_NEAR(deviation(apart, 0.0), 0.01, 0.0003);  // sqrt(2 * 0.5) of it
  recorder.jitter_apart_share = 0.0;
  const SampleInstants shared = jitteredInstants(recorder, 100, 3);
  EXPECT_EQ(shared.voltage, shared.current);
}

TEST(ImperfectRecorder, JitterShowsInASlopeAndNotInTheStamps) {
  ImperfectRecorder recorder = clear();
  recorder.jitter_share = 0.01;
  const auto samples = recordedThrough(recorder, courseOf(ramp, none, 600.0), 100, 1);
  std::vector<double> error;
  for (std::size_t n = 10; n + 10 < samples.size(); ++n) {
    EXPECT_DOUBLE_EQ(samples[n].time, 0.1 * static_cast<double>(n));
    error.push_back(samples[n].voltage - ramp(samples[n].time));
  }
  EXPECT_NEAR(deviation(error, 0.0), 0.1 * 0.01 * 0.1, 0.06e-4);  // slope times 1 ms
}

TEST(ImperfectRecorder, RoundsToStepsAndBendsByHalfAStepAtMost) {
  ImperfectRecorder recorder = clear();
  recorder.voltage.step = 2e-3;
  recorder.voltage.bow_steps = 0.5;
  recorder.voltage.bow_period_steps = 40.0;
  const auto samples = recordedThrough(recorder, courseOf(ramp, none, 60.0), 10, 1);
  double most = 0.0;
  for (std::size_t n = 10; n + 10 < samples.size(); ++n) {
    const double steps = samples[n].voltage / 2e-3;
    ASSERT_NEAR(steps, std::round(steps), 1e-6);
    most = std::max(most, std::abs(samples[n].voltage - ramp(samples[n].time)));
  }
  EXPECT_LE(most, 2.02e-3);  // half a step of rounding, half of the bow
  EXPECT_GT(most, 1.7e-3);
}

TEST(ImperfectRecorder, SmoothStructureHasTheSizeThatWasAsked) {
  Dice dice(9, 1);
  ImperfectRecorder recorder = drawRecorder(10.0, 600.0, dice);
  recorder.smooth_rms_v = 0.3e-3;
  std::vector<double> current(600000);
  for (std::size_t n = 0; n < current.size(); ++n) current[n] = n / 20000 % 2 == 0 ? 20.0 : -30.0;
  const std::vector<double> smooth = smoothStructure(recorder, current);
  EXPECT_NEAR(deviation(smooth, 0.0), 0.3e-3, 1e-9);
  double jump = 0.0;
  for (std::size_t n = 1; n < smooth.size(); ++n)
    jump = std::max(jump, std::abs(smooth[n] - smooth[n - 1]));
  EXPECT_LT(jump, 0.3e-3);
}

TEST(ImperfectRecorder, NoiseHasTheMemoryThatWasAsked) {
  ImperfectRecorder recorder = clear();
  recorder.voltage.noise = {0.0, 2e-3, 2.0, 0.0};
  const auto samples = recordedThrough(recorder, courseOf(still, none, 3000.0), 100, 4);
  double square = 0.0, product = 0.0;
  for (std::size_t n = 20; n < samples.size(); ++n) {
    const double now = samples[n].voltage - 12.0, before = samples[n - 20].voltage - 12.0;
    square += now * now;
    product += now * before;
  }
  EXPECT_NEAR(std::sqrt(square / static_cast<double>(samples.size())), 2e-3, 0.2e-3);
  EXPECT_NEAR(product / square, std::exp(-1.0), 0.1);
}

TEST(ImperfectRecorder, DrawsStayInTheirRanges) {
  bool alike = false, differ = false;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Dice dice(seed, 1);
    const ImperfectRecorder r = drawRecorder(100.0, 1200.0, dice);
    EXPECT_GE(r.voltage.step, 0.5e-3);
    EXPECT_LE(r.voltage.step, 5e-3);
    EXPECT_GE(r.current.step, 10e-3);
    EXPECT_LE(r.current.step, 100e-3);
    EXPECT_LE(r.voltage.bow_steps, 0.5);
    EXPECT_LE(r.voltage.noise.correlated, 2e-3);
    EXPECT_LE(r.voltage.noise.walk_per_sqrt_min, 0.6e-3);
    EXPECT_GE(r.smooth_rms_v, 0.01e-3);
    EXPECT_LE(r.smooth_rms_v, 0.5e-3);
    const bool same =
        r.voltage.corner_hz == r.current.corner_hz && r.voltage.poles == r.current.poles;
    (same ? alike : differ) = true;
  }
  EXPECT_TRUE(alike && differ);
}

TEST(ImperfectRecorder, FiltersThatCannotBeAreRefused) {
  ImperfectRecorder recorder = clear();
  recorder.voltage.poles = 9;
  EXPECT_THROW(recordedThrough(recorder, courseOf(still, none, 1.0), 10, 1), std::invalid_argument);
  recorder = clear();
  recorder.current.corner_hz = 600.0;
  EXPECT_THROW(recordedThrough(recorder, courseOf(still, none, 1.0), 10, 1), std::invalid_argument);
}

}  // namespace
}  // namespace battery_sof_simulator
