#include <gtest/gtest.h>

#include <cstdio>

#include "estimation/identification.hpp"
#include "support/composed.hpp"

namespace battery_sof {
namespace {

using namespace test;

constexpr int kSeeds = 60;

/// Five minutes at 10 Hz of a composition, with white noise and noise that is correlated over two
/// seconds.
Series drawnDrive(const BatteryModel& model, const Eigen::VectorXd& truth, std::uint64_t seed) {
  constexpr double kInterval = 0.1, kWhite = 0.002, kColored = 0.002;
  Series series;
  series.current = dataSetOneCurrent(300.0, kInterval, seed);
  for (std::size_t n = 0; n < series.current.size(); ++n)
    series.time.push_back(kInterval * static_cast<double>(n));
  series.voltage.assign(series.time.size(), 0.0);
  series.voltage = voltages(model, pointOf(model, truth), inputSequence(series, whole(series)));
  Random random(seed * 31 + 7);
  const double kept = std::exp(-kInterval / 2.0);
  double colored = kColored * random.normal();
  for (double& u : series.voltage) {
    u += colored + kWhite * random.normal();
    colored = kept * colored + kColored * std::sqrt(1.0 - kept * kept) * random.normal();
  }
  return series;
}

TEST(IdentifyWithEffects, TwoStandardErrorsHoldTheTruthNineTimesInTenOverAllParameters) {
  const BatteryModel model({"current_dependent_resistance", "acid_transport"});
  const Eigen::VectorXd truth = typicalPoint(model);
  IdentifyOptions options;
  options.effects = model.effects();
  options.more_starts = 0;
  const auto count = static_cast<std::size_t>(truth.size());
  std::vector<int> inside(count, 0), known(count, 0);
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const Series series = drawnDrive(model, truth, static_cast<std::uint64_t>(seed));
    const FittedModel fit = identify(series, whole(series), options);
    for (std::size_t j = 0; j < count; ++j) {
      const ParameterEstimate& e = fit.fit.estimates[j];
      if (e.held || !e.std) continue;
      ++known[j];
      inside[j] += std::abs(e.value - truth[static_cast<Eigen::Index>(j)]) < 2.0 * *e.std;
    }
  }
  double all = 0.0, of = 0.0;
  for (std::size_t j = 0; j < count; ++j) {
    if (known[j] == 0) continue;
    std::printf("%-24s within 2 standard errors in %5.1f %% of %d drives with a standard error\n",
                model.parameters()[j].name.c_str(), 100.0 * inside[j] / known[j], known[j]);
    EXPECT_GE(inside[j], 0.78 * known[j]) << model.parameters()[j].name;
    all += inside[j];
    of += known[j];
  }
  EXPECT_GE(all, 0.9 * of);
}

}  // namespace
}  // namespace battery_sof
