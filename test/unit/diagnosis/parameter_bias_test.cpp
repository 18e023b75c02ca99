#include "diagnosis/parameter_bias.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "support/null_fits.hpp"

namespace battery_sof {
namespace {

using test::fitOf;
using test::nullFit;
using test::tenMinutes;

double largest(const std::vector<ParameterBias>& map) {
  double most = 0.0;
  for (const ParameterBias& entry : map) most = std::max(most, std::abs(entry.z));
  return most;
}

const ParameterBias* entryOf(const std::vector<ParameterBias>& map, const std::string& parameter,
                             const std::string& regime) {
  for (const ParameterBias& entry : map)
    if (entry.parameter == parameter && entry.regime == regime) return &entry;
  return nullptr;
}

/// A parameter's own signature in one part alone [V].
template <typename InPart>
Eigen::VectorXd changedWhere(Eigen::Index column, double by, InPart&& in_part) {
  Eigen::VectorXd effect = by * nullFit(1).jacobian.col(column);
  for (Eigen::Index n = 0; n < effect.size(); ++n)
    if (!in_part(static_cast<std::size_t>(n))) effect[n] = 0.0;
  return effect;
}

TEST(ParameterBiases, NoParameterWantsAnotherValueAnywhereWhenTheModelIsRight) {
  const auto regimes = regimesOf(tenMinutes());
  int above = 0;
  double squares = 0.0, entries = 0.0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const auto map = parameterBiases(nullFit(seed), tenMinutes(), regimes);
    if (largest(map) > 4.0) ++above;
    for (const ParameterBias& entry : map) squares += entry.z * entry.z;
    entries += static_cast<double>(map.size());
  }
  EXPECT_LE(above, 1);
  EXPECT_NEAR(squares / entries, 1.0, 0.25);
  EXPECT_GT(entries, 40 * 25.0);
}

TEST(ParameterBiases, ChargingResistanceThatRisesInLongChargesIsSeenThereByAsMuchAsItRises) {
  const auto regimes = regimesOf(tenMinutes());
  const Eigen::VectorXd effect = changedWhere(
      kRowRCharge, 0.1, [&](std::size_t n) { return regimes[n] == Regime::kLongCharge; });
  const auto map = parameterBiases(fitOf(effect, 2), tenMinutes(), regimes);
  const ParameterBias* entry = entryOf(map, "r_charge", "long charge");
  ASSERT_NE(entry, nullptr);
  EXPECT_GT(entry->z, 5.0);
  const double magnitude = BatteryModel().parameters()[kRowRCharge].magnitude;
  EXPECT_NEAR(entry->change, 0.1 * magnitude / test::drivenBattery().r_charge, 0.04);
}

TEST(ParameterBiases, AChangeStaysInsideTheParametersBounds) {
  const auto regimes = regimesOf(tenMinutes());
  for (const double by : {-20.0, 200.0}) {
    const Eigen::VectorXd effect = changedWhere(
        kRowRCharge, by, [&](std::size_t n) { return regimes[n] == Regime::kLongCharge; });
    const WhitenedFit fit = fitOf(effect, 2);
    for (const ParameterBias& entry : parameterBiases(fit, tenMinutes(), regimes)) {
      if (entry.parameter != "r_charge") continue;
      const ParameterInfo& info = BatteryModel().parameters()[kRowRCharge];
      const double value = fit.point.parameters[kRowRCharge] * (1.0 + entry.change);
      EXPECT_GE(value, info.lower * (1.0 - 1e-9)) << entry.regime;
      EXPECT_LE(value, info.upper * (1.0 + 1e-9)) << entry.regime;
    }
  }
}

TEST(ParameterBiases, ACapacityThatFallsOverTheDriveIsSeenInItsThirds) {
  const double middle = 0.5 * tenMinutes().samples.back().step.time;
  const Eigen::VectorXd effect = changedWhere(
      kRowC2, -0.15, [&](std::size_t n) { return tenMinutes().samples[n].step.time > middle; });
  const auto map = parameterBiases(fitOf(effect, 3), tenMinutes(), regimesOf(tenMinutes()));
  ASSERT_NE(entryOf(map, "c2", "last third"), nullptr);
  EXPECT_LT(entryOf(map, "c2", "last third")->z, -4.0);
  EXPECT_GT(entryOf(map, "c2", "first third")->z, 4.0);
}

TEST(ParameterBiases, AParameterHasNoEntryWhereItDoesNothing) {
  const auto map = parameterBiases(nullFit(1), tenMinutes(), regimesOf(tenMinutes()));
  EXPECT_EQ(entryOf(map, "r_charge", "crank"), nullptr);
  EXPECT_EQ(entryOf(map, "r_charge", "long discharge"), nullptr);
  std::set<std::string> parameters;
  for (const ParameterBias& entry : map) parameters.insert(entry.parameter);
  EXPECT_EQ(parameters, (std::set<std::string>{"r_discharge", "r_charge", "c2", "beta", "u_dc"}));
}

struct TwoHalves {
  InputSequence first, second;
  WhitenedFit first_fit, second_fit;
};

TwoHalves fittedHalves() {
  const Series series = test::baseDrive(8, 240.0);
  const InputSequence first = compressedInputs(series, {0, 12000}),
                      second = compressedInputs(series, {12000, 24000});
  const BatteryModel model;
  return {first, second, fitWhitened(model, first, {typicalStart(model, first)}, std::nullopt),
          fitWhitened(model, second, {typicalStart(model, second)}, std::nullopt)};
}

TEST(OptimiserFailed, AConvergedFitIsNotBeatenByTheOtherHalfs) {
  const TwoHalves halves = fittedHalves();
  EXPECT_FALSE(optimiserFailed(halves.first, halves.first_fit, halves.second_fit.point.parameters));
  EXPECT_FALSE(
      optimiserFailed(halves.second, halves.second_fit, halves.first_fit.point.parameters));
}

TEST(OptimiserFailed, AFitThatStoppedEarlyIsBeaten) {
  TwoHalves halves = fittedHalves();
  halves.second_fit.point.parameters[kRowC2] *= 1.3;
  EXPECT_TRUE(optimiserFailed(halves.second, halves.second_fit, halves.first_fit.point.parameters));
}

}  // namespace
}  // namespace battery_sof
