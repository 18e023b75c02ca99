#include "estimation/block_score.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "estimation/composition_fit.hpp"
#include "estimation/fit_window.hpp"
#include "support/sourced_drive.hpp"

namespace battery_sof {
namespace {

using namespace test;

BlockScore scoreOf(const std::vector<double>& errors) { return {{errors}, {errors}}; }

TEST(ScoreGain, IsTheMeanLogarithmOfTheErrorsRatioWithItsScatter) {
  const ScoreGain gain = gainOf(scoreOf({0.1, 0.2}), scoreOf({0.2, 0.2}));
  EXPECT_NEAR(0.5 * std::log(2.0), gain.value, 1e-12);
  EXPECT_NEAR(0.5 * std::log(2.0), gain.std_error, 1e-12);  // half the difference of two
  EXPECT_FALSE(gain.isAbove(0.0));
  const ScoreGain alike = gainOf(scoreOf({0.1, 0.3}), scoreOf({0.2, 0.6}));
  EXPECT_NEAR(std::log(2.0), alike.value, 1e-12);
  EXPECT_TRUE(alike.isAbove(0.06));
  EXPECT_FALSE(alike.isAbove(0.7));
}

TEST(ScoreGain, CountsTheEquationsAloneAndWithTheRegressionInEqualParts) {
  const BlockScore less{{{0.4, 0.4}}, {{0.2, 0.2}}}, more{{{0.1, 0.1}}, {{0.2, 0.2}}};
  EXPECT_NEAR(0.5 * std::log(4.0), gainOf(more, less).value, 1e-12);
}

TEST(ScoreGain, ABlockThatIsMissedCompletelyCountsOneMoreThanTheMedian) {
  const BlockScore less = scoreOf({50.0, 0.2, 0.2, 0.2}), more = scoreOf({0.1, 0.12, 0.1, 0.12});
  const double small = std::log(0.2 / 0.12), large = std::log(2.0);
  const double first = 0.5 * (small + large) + 1.0;
  EXPECT_NEAR((first + large + 2.0 * small) / 4.0, gainOf(more, less, 1.0).value, 1e-12);
  EXPECT_NEAR(-gainOf(more, less, 1.0).value, gainOf(less, more, 1.0).value, 1e-12);
  EXPECT_TRUE(gainOf(more, less, 1.0).isAbove(0.06));
  EXPECT_FALSE(gainOf(more, less).isAbove(0.06));
}

TEST(ScoreGain, IsAsLargeAsItIsWhereAllBlocksGainMuch) {
  const ScoreGain gain = gainOf(scoreOf({0.001, 0.002}), scoreOf({0.2, 0.3}), 1.0);
  EXPECT_NEAR(0.5 * (std::log(200.0) + std::log(150.0)), gain.value, 1e-12);
}

TEST(ScoreGain, RefusesBlocksThatAreNotTheSame) {
  EXPECT_THROW(gainOf(scoreOf({0.1, 0.2}), scoreOf({0.1})), std::invalid_argument);
  EXPECT_THROW(gainOf(scoreOf({0.1}), scoreOf({0.1})), std::invalid_argument);
}

TEST(BlockErrors, ExplainTheShareThatTheirMeanLeaves) {
  EXPECT_NEAR(0.5, (BlockErrors{{0.1, 0.4}}).share(), 1e-12);
}

/// A drive of a known law: every block is predicted almost as well as the noise lets it, and a
/// wrong model of it is not.
TEST(ScoreBlocks, OfTheLawThatMadeTheDriveIsNearAllOfTheVariation) {
  const Series series = sourcedDrive(1200, typicalBattery({"fresh_sulphate"}), 5);
  IdentifyOptions options;
  options.source = chargerControl(series).value();
  const IndexRange all{0, series.size()};
  const FittedModel circuit = identify(series, all, options);
  options.effects = {"fresh_sulphate"};
  const FittedModel law = identify(series, all, options);
  const BlockScore of_law =
      scoreBlocks(BatteryModel({"fresh_sulphate"}), optimumOf(law), series, all, options, 4);
  const BlockScore of_circuit =
      scoreBlocks(BatteryModel(), optimumOf(circuit), series, all, options, 4);
  ASSERT_EQ(4u, of_law.equations.relative.size());
  EXPECT_GT(of_law.equations.share(), 0.8);
  EXPECT_LT(of_circuit.equations.share(), of_law.equations.share() - 0.1);
  EXPECT_TRUE(gainOf(of_law, of_circuit).isAbove(0.06));
}

TEST(PromiseOf, TheLawThatMadeTheDriveIsLargestAndMoreStepsPromiseNoLess) {
  const Series series = sourcedDrive(900, typicalBattery({"fresh_sulphate"}), 5);
  IdentifyOptions options;
  options.source = chargerControl(series).value();
  const IndexRange all{0, series.size()};
  const FittedModel circuit = identify(series, all, options);
  const FittedCost cost = fittedCost(circuit, series, all, options);
  const Promise law = promiseOf(circuit, cost, {"fresh_sulphate"}, series, all, options, 3);
  for (const char* id : {"fast_arc", "current_gain", "ocv_soc"})
    EXPECT_LT(promiseOf(circuit, cost, {id}, series, all, options, 3).gain, law.gain) << id;
  const Promise more =
      promiseOf(circuit, cost, {"fresh_sulphate"}, series, all, options, 8, &law.point);
  EXPECT_GE(more.gain, law.gain);
}

/// Costs are compared with the weights of the circuit's.
void expectNoneWorseThanTheCircuit(const Series& series, IdentifyOptions options) {
  const IndexRange all{0, series.size()};
  const FittedModel circuit = identify(series, all, options);
  const FittedCost limit = fittedCost(circuit, series, all, options);
  const InputSequence inputs = fitWindow(series, all, options).inputs;
  for (const EffectInfo& effect : effectCatalogue()) {
    if (!effect.overrides.empty() || !effect.needs.empty()) continue;
    options.effects = {effect.id};
    const BatteryModel model(options.effects);
    options.starts = startsInLarger(BatteryModel(), optimumOf(circuit), model);
    const CompositionPoint optimum = optimumOf(identify(series, all, options));
    const CompositionProblem problem(model, inputs, fitCost(options), optimum, {}, limit.precision);
    NormalEquations at;
    ASSERT_TRUE(problem.evaluate(problem.coordinatesOf(optimum), at)) << effect.id;
    EXPECT_LE(at.cost, 1.001 * limit.cost) << effect.id;
  }
}

TEST(Identify, FromTheCircuitsOptimumEndsNoWorseThanTheCircuitWithAnyEffect) {
  const Series sourced = sourcedDrive(600, typicalBattery({"ocv_soc"}), 5);
  IdentifyOptions options;
  options.source = chargerControl(sourced).value();
  expectNoneWorseThanTheCircuit(sourced, options);
  expectNoneWorseThanTheCircuit(everyNth(cleanDrive(2), 10), {});
}

TEST(Identify, SearchesFromTheGivenStartsAloneWhereThatIsAsked) {
  const Series drive = sourcedDrive(900, typicalBattery({"fresh_sulphate"}), 5);
  IdentifyOptions options;
  options.source = chargerControl(drive).value();
  const IndexRange all{0, drive.size()};
  const CompositionPoint circuit = optimumOf(identify(drive, all, options));
  // Of this drive its cost has two valleys.
  options.effects = {"contact_resistance"};
  options.starts = {embedded(BatteryModel(), circuit, BatteryModel(options.effects))};
  const auto missed = [&] {
    return equationErrors(identify(drive, all, options), drive, all, options).norm();
  };
  const double from_typical_too = missed();
  options.only_starts = true;
  EXPECT_GT(missed(), 1.05 * from_typical_too);
}

/// Mean squared error of the last block in units of the variances, of a model of identify().
double errorOfLastBlock(const FittedModel& model, const Series& series,
                        const IdentifyOptions& options, std::size_t blocks) {
  const Eigen::VectorXd errors = equationErrors(model, series, {0, series.size()}, options);
  const std::size_t first = series.size() * (blocks - 1) / blocks;
  double sums[2][3] = {};  // of voltage and current: number, sum, squares
  for (std::size_t n = 0; n < series.size(); ++n) {
    const bool of_current = options.source->voltage_controlled[n];
    const double x = of_current ? series.current[n] : series.voltage[n];
    sums[of_current][0] += 1.0, sums[of_current][1] += x, sums[of_current][2] += x * x;
  }
  double error = 0.0;
  for (std::size_t n = first; n < series.size(); ++n) {
    const bool of_current = options.source->voltage_controlled[n];
    const auto& [count, sum, squares] = sums[of_current];
    const double missed = errors[n] / (of_current ? kOhmsOfCurrentError : 1.0);
    error += missed * missed / (squares / count - std::pow(sum / count, 2));
  }
  return error / static_cast<double>(series.size() - first);
}

TEST(ScoreBlocks, PredictAsAFitThatNeverSawTheBlock) {
  const Series series = sourcedDrive(1200, typicalBattery({"fresh_sulphate"}), 5);
  IdentifyOptions options;
  options.source = chargerControl(series).value();
  const IndexRange all{0, series.size()};
  const FittedModel seen = identify(series, all, options);
  constexpr std::size_t kBlocks = 4;
  const BlockScore score =
      scoreBlocks(BatteryModel(), optimumOf(seen), series, all, options, kBlocks);
  IdentifyOptions unseen = options;
  unseen.masked.assign(series.size(), 0);
  std::fill(unseen.masked.begin() + series.size() * (kBlocks - 1) / kBlocks, unseen.masked.end(),
            1);
  const double in_sample = errorOfLastBlock(seen, series, options, kBlocks),
               left_out = errorOfLastBlock(identify(series, all, unseen), series, options, kBlocks);
  ASSERT_GT(left_out, 1.1 * in_sample);
  EXPECT_NEAR(score.equations.relative.back(), left_out, 0.5 * (left_out - in_sample));
}

TEST(ScoreBlocks, NeedsTwoBlocksInEitherDirection) {
  const Series series = sourcedDrive(900, knownModel({}), 5);
  IdentifyOptions options;
  options.source = chargerControl(series).value();
  const FittedModel circuit = identify(series, {0, series.size()}, options);
  EXPECT_THROW(
      scoreBlocks(BatteryModel(), optimumOf(circuit), series, {0, series.size()}, options, 1),
      std::invalid_argument);
  options.source.reset();
  const FittedModel from_current = identify(series, {0, series.size()}, options);
  const BlockScore score =
      scoreBlocks(BatteryModel(), optimumOf(from_current), series, {0, series.size()}, options, 4);
  EXPECT_EQ(score.equations.relative.size(), 4U);
}

}  // namespace
}  // namespace battery_sof
