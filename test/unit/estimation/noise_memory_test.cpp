#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>

#include "estimation/identification.hpp"
#include "support/base_drive.hpp"
#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

/// Noise with a memory, in addition to white noise of 2 mV.
struct Memory {
  double deviation;  // [V]
  double time;       // [s]
};

void addNoise(const Memory& memory, std::uint64_t seed, Series& series) {
  test::Random random(seed);
  double state = memory.deviation * random.normal();
  for (std::size_t n = 1; n < series.size(); ++n) {
    const double kept = std::exp(-(series.time[n] - series.time[n - 1]) / memory.time);
    state = kept * state + memory.deviation * std::sqrt(1.0 - kept * kept) * random.normal();
    series.voltage[n] += state;
  }
}

class NoiseMemory : public testing::TestWithParam<Memory> {};

/// Four minutes at 100 Hz. By the correlation of neighbouring samples alone 45 to 81 % are inside.
TEST_P(NoiseMemory, IsInTheStandardErrors) {
  constexpr int kSeeds = 40, kParameters = 4;
  const BaseParameters truth = test::drivenBattery();
  const std::array<double, kParameters> values = {truth.r_discharge, truth.r_charge, truth.c2,
                                                  truth.beta};
  int inside = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Series series = test::baseDrive(seed, 240.0);
    addNoise(GetParam(), 100 + seed, series);
    const FittedModel model = identify(series, {0, series.size()});
    ASSERT_TRUE(isUsable(model.fit)) << model.fit.message;
    for (int j = 0; j < kParameters; ++j) {
      const ParameterEstimate& estimate = model.fit.estimates[j];
      ASSERT_TRUE(estimate.std) << estimate.name;
      inside += std::abs(estimate.value - values[j]) < 1.96 * *estimate.std;
    }
  }
  const double share = static_cast<double>(inside) / (kSeeds * kParameters);
  std::printf("noise of %g mV that lasts %g s: %.0f %% of 95 %% intervals hold the truth\n",
              1e3 * GetParam().deviation, GetParam().time, 100.0 * share);
  EXPECT_GT(share, 0.88);
}

INSTANTIATE_TEST_SUITE_P(Noise, NoiseMemory,
                         testing::Values(Memory{0.0, 1.0}, Memory{0.002, 0.1}, Memory{0.002, 2.0},
                                         Memory{0.002, 20.0}));

}  // namespace
}  // namespace battery_sof
