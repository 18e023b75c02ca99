#include "recording/check_parts.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "support/synthetic_recording.hpp"

namespace battery_sof::check_parts {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// First-order autoregressive noise of unit innovations; white for memory 0.
std::vector<double> noise(std::size_t samples, double memory, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<double> values(samples);
  double value = 0.0;
  for (double& v : values) v = value = memory * value + random.normal();
  return values;
}

void addTone(std::vector<double>& values, double amplitude, double frequency) {
  for (std::size_t k = 0; k < values.size(); ++k) {
    values[k] += amplitude * std::cos(2.0 * kPi * frequency * static_cast<double>(k) + 0.7);
  }
}

IndexRange whole(const std::vector<double>& values) { return {0, values.size()}; }

TEST(SpectralLine, IsNeverFoundInWhiteOrAutoregressiveNoise) {
  for (const double memory : {-0.5, 0.0, 0.5, 0.9}) {
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
      const auto values = noise(kLineBlocksMin * kLineBlock, memory, seed);
      EXPECT_TRUE(findSpectralLines(values, {whole(values)}).lines.empty()) << memory;
    }
  }
}

TEST(SpectralLine, HasTheFrequencyAndAmplitudeOfTheToneWhereverItLiesBetweenTwoBins) {
  for (const double bin : {20.0, 33.3, 57.5, 80.7, 110.1}) {
    auto values = noise(40 * kLineBlock, 0.0, 7);
    addTone(values, 3.0, bin / kLineBlock);
    const auto lines = findSpectralLines(values, {whole(values)}).lines;
    ASSERT_EQ(lines.size(), 1U) << bin;
    EXPECT_NEAR(lines[0].amplitude, 3.0, 0.1) << bin;
    EXPECT_NEAR(lines[0].frequency * kLineBlock, bin, bin == 57.5 ? 1.0 : 0.02);
    EXPECT_EQ(lines[0].share, 1.0);
    EXPECT_GT(lines[0].steadiness, 0.98);
  }
}

TEST(SpectralLine, IsFoundFromSixTenthsOfTheNoiseOnMostTimesAndAtATenthNever) {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    auto weak = noise(20 * kLineBlock, 0.0, seed), clear = weak;
    addTone(weak, 0.1, 0.2);
    addTone(clear, 0.7, 0.2);
    EXPECT_TRUE(findSpectralLines(weak, {whole(weak)}).lines.empty());
    found += static_cast<int>(findSpectralLines(clear, {whole(clear)}).lines.size());
  }
  EXPECT_GT(found, 35);
}

TEST(SpectralLine, ComesTheGreatestFirst) {
  auto values = noise(20 * kLineBlock, 0.0, 9);
  addTone(values, 1.5, 0.13);
  addTone(values, 4.0, 0.31);
  const auto lines = findSpectralLines(values, {whole(values)}).lines;
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_NEAR(lines[0].frequency, 0.31, 1e-4);
  EXPECT_NEAR(lines[1].frequency, 0.13, 1e-4);
}

TEST(SpectralLine, IsNotLookedForInFewerThanEightBlocks) {
  std::vector<double> values(kLineBlocksMin * kLineBlock - 1);
  addTone(values, 1.0, 0.2);
  const LineSearch search = findSpectralLines(values, {whole(values)});
  EXPECT_EQ(search.blocks, kLineBlocksMin - 1);
  EXPECT_TRUE(search.lines.empty());
}

TEST(SpectralLine, BlocksDoNotReachAcrossRanges) {
  const std::vector<double> values(4 * kLineBlock);
  const std::size_t half = kLineBlock / 2;
  const std::vector<IndexRange> ranges{{0, 3 * half}, {3 * half, 5 * half}, {5 * half, 8 * half}};
  EXPECT_EQ(findSpectralLines(values, ranges).blocks, 3U);
}

TEST(AmplitudeAtAFrequency, IsThatOfTheTone) {
  std::vector<double> values(20 * kLineBlock);
  addTone(values, 2.5, 0.17);
  EXPECT_NEAR(amplitudeAt(values, {whole(values)}, 0.17), 2.5, 0.01);
  EXPECT_NEAR(amplitudeAt(values, {whole(values)}, 0.3), 0.0, 0.01);
  EXPECT_EQ(amplitudeAt(values, {}, 0.17), 0.0);
}

}  // namespace
}  // namespace battery_sof::check_parts
