#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "estimation/identification.hpp"
#include "support/base_drive.hpp"

namespace battery_sof {
namespace {

constexpr int kSeeds = 200;

std::array<double, 5> valuesOf(const BaseParameters& p) {
  return {p.r_discharge, p.r_charge, p.c2, p.beta, p.u_dc};
}

/// A start anywhere in Table I's box, uniform in the logarithm.
IdentifyOptions randomStart(std::uint64_t seed) {
  test::Random random(seed * 7919);
  IdentifyOptions options;
  for (std::size_t j = 0; j < 4; ++j) {
    const auto& info = tableOne()[j];
    options.initial[j] = info.lower * std::pow(info.upper / info.lower, random.uniform(0.0, 1.0));
  }
  return options;
}

TEST(Identify, ParametersLieWithinTwoStandardErrorsInNineOfTenDrives) {
  std::array<int, 5> inside{};
  const auto truth = valuesOf(test::drivenBattery());
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const Series series = test::baseDrive(seed);
    const FittedModel model = identify(series, {0, series.size()});
    for (std::size_t j = 0; j < 5; ++j)
      inside[j] += std::abs(model.fit.estimates[j].value - truth[j]) <
                   2.0 * model.fit.estimates[j].std.value_or(0.0);
  }
  for (std::size_t j = 0; j < 5; ++j) {
    const std::string name = j < 4 ? tableOne()[j].name : "u_dc";
    std::printf("%-12s within 2 standard errors in %5.1f %% of %d drives\n", name.c_str(),
                100.0 * inside[j] / kSeeds, kSeeds);
    EXPECT_GE(inside[j], 0.90 * kSeeds) << name;
  }
}

TEST(Identify, ReachesTheOptimumFromAlmostAnyStartInTableOnesBox) {
  int reached = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const Series series = test::baseDrive(seed);
    const IndexRange range{0, series.size()};
    const FittedModel usual = identify(series, range);
    const FittedModel other = identify(series, range, randomStart(seed));
    const auto a = valuesOf(usual.fit.parameters), b = valuesOf(other.fit.parameters);
    bool same = other.fit.status == FitStatus::kConverged;
    for (std::size_t j = 0; j < 5; ++j) same = same && std::abs(b[j] / a[j] - 1.0) < 1e-4;
    reached += same;
  }
  std::printf("same optimum (1e-4) from a random start in %5.1f %% of %d drives\n",
              100.0 * reached / kSeeds, kSeeds);
  EXPECT_GE(reached, 0.99 * kSeeds);
}

TEST(Identify, DoesNotDependOnTheClocksOrigin) {
  Series series = test::baseDrive(11);
  const FittedModel before = identify(series, {0, series.size()});
  for (double& t : series.time) t += 4096.0;  // exact in binary
  const FittedModel after = identify(series, {0, series.size()});
  for (std::size_t j = 0; j < 5; ++j)
    EXPECT_NEAR(after.fit.estimates[j].value, before.fit.estimates[j].value,
                1e-6 * before.fit.estimates[j].value);
}

TEST(Identify, ShiftsTheOpenCircuitVoltageWithTheVoltageAndNothingElse) {
  Series series = test::baseDrive(12);
  const FittedModel before = identify(series, {0, series.size()});
  for (double& u : series.voltage) u += 0.75;
  const FittedModel after = identify(series, {0, series.size()});
  EXPECT_NEAR(after.fit.parameters.u_dc, before.fit.parameters.u_dc + 0.75, 1e-6);
  for (std::size_t j = 0; j < 4; ++j)
    EXPECT_NEAR(after.fit.estimates[j].value, before.fit.estimates[j].value,
                1e-5 * before.fit.estimates[j].value);
}

TEST(Identify, FindsBatteriesAllOverTheBox) {
  test::Random random(99);
  for (int k = 0; k < 40; ++k) {
    BaseParameters truth;
    truth.r_discharge = random.uniform(0.003, 0.02);
    truth.r_charge = random.uniform(0.003, 0.02);
    truth.c2 = random.uniform(300.0, 4000.0);
    truth.beta = random.uniform(8.0, 60.0);
    truth.u_dc = random.uniform(11.8, 13.2);
    const Series series =
        test::answered(truth, test::dataSetOneCurrent(240.0, 0.01, 300 + k), 0.01, 0.002, 300 + k);
    const auto found = valuesOf(identify(series, {0, series.size()}).fit.parameters),
               wanted = valuesOf(truth);
    for (std::size_t j = 0; j < 5; ++j)
      EXPECT_NEAR(found[j] / wanted[j], 1.0, 0.02) << k << " parameter " << j;
  }
}

}  // namespace
}  // namespace battery_sof
