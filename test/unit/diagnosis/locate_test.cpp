#include "diagnosis/locate.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/null_fits.hpp"

namespace battery_sof {
namespace {

// A memory of half a minute and a walk of 1 mV a minute: neighbouring episodes err alike.
const NoiseModel kNoise{0.002, 0.003, 30.0, 0.001 / std::sqrt(60.0)};

struct Ground {
  InputSequence inputs;
  std::vector<Regime> regimes;
  test::NullFits fits;
  explicit Ground(const InputSequence& d) : inputs(d), regimes(regimesOf(inputs)), fits(inputs) {}
};

const Ground& tenMinutes() {
  static const Ground ground(test::exactInputs(600.0));
  return ground;
}

const Ground& halfAnHour() {
  static const Ground ground(test::exactInputs(1800.0));
  return ground;
}

/// 1 in a regime, 0 elsewhere.
Eigen::VectorXd inside(const Ground& ground, Regime regime) {
  Eigen::VectorXd effect = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(ground.regimes.size()));
  for (std::size_t n = 0; n < ground.regimes.size(); ++n)
    if (ground.regimes[n] == regime) effect[static_cast<Eigen::Index>(n)] = 1.0;
  return effect;
}

WhitenedFit fitOf(const Ground& ground, const Eigen::VectorXd& effect, std::uint64_t seed) {
  return ground.fits.of(test::drawnNoise(kNoise, ground.inputs, seed) + effect);
}

WhitenedFit nullFit(const Ground& ground, std::uint64_t seed) {
  return fitOf(ground, Eigen::VectorXd::Zero(static_cast<Eigen::Index>(ground.regimes.size())),
               seed);
}

const RegimeFinding* findingOf(const std::vector<RegimeFinding>& findings,
                               const std::string& regime, const std::string& statistic) {
  for (const RegimeFinding& finding : findings)
    if (finding.regime == regime && finding.statistic == statistic) return &finding;
  return nullptr;
}

/// Measured voltages with noise and an effect.
InputSequence measured(const Ground& ground, const Eigen::VectorXd& effect, std::uint64_t seed) {
  InputSequence inputs = ground.inputs;
  const Eigen::VectorXd error = test::drawnNoise(kNoise, inputs, seed) + effect;
  for (std::size_t n = 0; n < inputs.samples.size(); ++n)
    inputs.samples[n].voltage += error[static_cast<Eigen::Index>(n)];
  return inputs;
}

std::vector<MismatchSegment> segmentsOf(const InputSequence& inputs,
                                        const std::vector<Regime>& regimes) {
  return mismatchSegments(inputs, typicalStart(BatteryModel(), inputs), regimes, 0.001);
}

/// That one stretch is found, which shares at least two thirds of its own time with the true one,
/// and covers two thirds of that.
void expectStretch(const std::vector<MismatchSegment>& segments, double from, double to) {
  ASSERT_EQ(segments.size(), 1u);
  const double shared = std::min(segments[0].to, to) - std::max(segments[0].from, from);
  EXPECT_GE(shared, 2.0 / 3.0 * (to - from)) << segments[0].from << " to " << segments[0].to;
  EXPECT_GE(shared, 2.0 / 3.0 * (segments[0].to - segments[0].from))
      << segments[0].from << " to " << segments[0].to;
  EXPECT_LE(segments[0].p_value, 0.02);
}

/// A function of the step from one time to another [s], 0 elsewhere.
template <typename Law>
Eigen::VectorXd between(const Ground& ground, double from, double to, Law&& law) {
  Eigen::VectorXd effect = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(ground.regimes.size()));
  for (std::size_t n = 0; n < ground.regimes.size(); ++n) {
    const InputStep& step = ground.inputs.samples[n].step;
    if (step.time >= from && step.time < to) effect[static_cast<Eigen::Index>(n)] = law(step);
  }
  return effect;
}

TEST(Locate, SlowNoiseAloneRaisesNoAlarm) {
  int alarmed = 0, segmented = 0, small = 0, all = 0;
  const Eigen::VectorXd nothing =
      Eigen::VectorXd::Zero(static_cast<Eigen::Index>(tenMinutes().regimes.size()));
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const WhitenedFit fit = nullFit(tenMinutes(), seed);
    const auto findings = regimeFindings(fit, tenMinutes().inputs, tenMinutes().regimes);
    alarmed += std::any_of(findings.begin(), findings.end(),
                           [](const auto& finding) { return finding.is_significant; });
    segmented += !segmentsOf(measured(tenMinutes(), nothing, seed), tenMinutes().regimes).empty();
    for (const RegimeFinding& finding : findings) small += finding.p_value <= 0.1;
    all += static_cast<int>(findings.size());
  }
  EXPECT_LE(alarmed, 2);
  EXPECT_LE(segmented, 2);
  // Without mismatch every p is as likely as any other.
  EXPECT_NEAR(static_cast<double>(small) / all, 0.1, 0.04);
}

TEST(RegimeFindings, AnErrorInLongChargesIsFoundThereWithItsSizeAndSign) {
  const Ground& ground = halfAnHour();
  const WhitenedFit fit = fitOf(ground, 0.01 * inside(ground, Regime::kLongCharge), 3);
  const auto findings = regimeFindings(fit, ground.inputs, ground.regimes);
  const RegimeFinding* mean = findingOf(findings, "long charge", "mean");
  ASSERT_NE(mean, nullptr);
  EXPECT_TRUE(mean->is_significant);
  EXPECT_GE(mean->episodes, 20u);
  // The parameters took up a part.
  EXPECT_GT(mean->lower, 0.001);
  EXPECT_LT(mean->upper, 0.01);
  EXPECT_LE(mean->p_value, 0.001);
}

TEST(RegimeFindings, AnErrorThatGrowsDuringDischargesShowsAsTheirSlope) {
  const Ground& ground = halfAnHour();
  Eigen::VectorXd effect = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(ground.regimes.size()));
  for (const Episode& episode : episodesOf(ground.inputs, ground.regimes))
    if (episode.regime == Regime::kDischarge)
      for (std::size_t n = episode.range.first; n < episode.range.last; ++n)
        effect[static_cast<Eigen::Index>(n)] =
            -0.002 * (ground.inputs.samples[n].step.time -
                      ground.inputs.samples[episode.range.first].step.time);
  const auto findings = regimeFindings(fitOf(ground, effect, 4), ground.inputs, ground.regimes);
  const RegimeFinding* slope = findingOf(findings, "discharge", "slope");
  ASSERT_NE(slope, nullptr);
  EXPECT_TRUE(slope->is_significant);
  EXPECT_LT(slope->upper, 0.0);
  EXPECT_NEAR(slope->value, -0.002, 0.001);
}

/// As few as cranks are in half an hour: flipping the signs of six episodes has no p below 1/32.
TEST(RegimeFindings, AClearErrorInSixEpisodesIsSignificant) {
  const Ground& ground = halfAnHour();
  InputSequence inputs = ground.inputs;
  std::vector<Regime> regimes = ground.regimes;
  std::size_t kept = 0;
  for (const Episode& episode : episodesOf(inputs, regimes))
    if (episode.regime == Regime::kLongCharge && ++kept > 6)
      for (std::size_t n = episode.range.first; n < episode.range.last; ++n)
        regimes[n] = Regime::kShortCharge;
  Eigen::VectorXd effect = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(regimes.size()));
  for (std::size_t n = 0; n < regimes.size(); ++n)
    if (regimes[n] == Regime::kLongCharge) effect[static_cast<Eigen::Index>(n)] = 0.03;
  const auto findings = regimeFindings(fitOf(ground, effect, 7), inputs, regimes);
  const RegimeFinding* mean = findingOf(findings, "long charge", "mean");
  ASSERT_NE(mean, nullptr);
  EXPECT_EQ(mean->episodes, 6u);
  EXPECT_TRUE(mean->is_significant) << mean->p_value;
  EXPECT_GT(mean->lower, 0.01);
}

TEST(RegimeFindings, FewerThanFiveEpisodesAreNotJudged) {
  const auto findings =
      regimeFindings(nullFit(halfAnHour(), 1), halfAnHour().inputs, halfAnHour().regimes);
  EXPECT_EQ(findingOf(findings, "long discharge", "mean"), nullptr);
  for (const RegimeFinding& finding : findings) EXPECT_GE(finding.episodes, 5u);
}

/// What comes slowly and stays for minutes, which the circuit could take up in part.
TEST(MismatchSegments, AnErrorThatComesSlowlyIsFoundForAllOfItsTime) {
  const Ground& ground = halfAnHour();
  for (const double sign : {1.0, -1.0}) {
    const Eigen::VectorXd effect = between(ground, 700.0, 900.0, [&](const InputStep& step) {
      return sign * 0.04 * -std::expm1((700.0 - step.time) / 30.0);
    });
    const auto segments = segmentsOf(measured(ground, effect, 5), ground.regimes);
    expectStretch(segments, 700.0, 900.0);
    ASSERT_FALSE(segments.empty());
    EXPECT_NEAR(segments[0].mean_error, sign * 0.035, 0.015);
    EXPECT_GE(std::abs(segments[0].peak_error), std::abs(segments[0].mean_error));
  }
}

TEST(MismatchSegments, AResistanceOfTwoMinutesIsFoundWhereItIs) {
  const Ground& ground = halfAnHour();
  const Eigen::VectorXd effect =
      between(ground, 1200.0, 1320.0, [](const InputStep& step) { return 0.006 * step.current; });
  const auto segments = segmentsOf(measured(ground, effect, 6), ground.regimes);
  expectStretch(segments, 1200.0, 1320.0);
}

/// Where every minute errs alike there is no stretch: regimes say where the error is.
TEST(MismatchSegments, AnErrorOfTheWholeRecordingIsNoStretch) {
  const Ground& ground = halfAnHour();
  const Eigen::VectorXd effect = between(
      ground, 0.0, 1e9, [](const InputStep& step) { return 0.05 * std::sin(0.3 * step.time); });
  EXPECT_TRUE(segmentsOf(measured(ground, effect, 7), ground.regimes).empty());
}

/// In half an hour a minute stands out from four times the usual error on: P(F(1, 29) > 16) is
/// 0.0004, of which there are thirty.
TEST(MismatchSegments, TwoMinutesOfSixTimesTheUsualErrorStandOutAndOfThreeTimesDoNot) {
  const Ground& ground = halfAnHour();
  const NoiseModel white{0.01, 0.0, 1.0, 0.0};
  const Eigen::VectorXd noise = test::drawnNoise(white, ground.inputs, 11);
  for (const double times : {3.0, 6.0}) {
    InputSequence inputs = ground.inputs;
    for (std::size_t n = 0; n < inputs.samples.size(); ++n) {
      const double time = inputs.samples[n].step.time;
      const bool is_inside = time >= 700.0 && time < 820.0;
      inputs.samples[n].voltage += (is_inside ? times : 1.0) * noise[static_cast<Eigen::Index>(n)];
    }
    EXPECT_EQ(segmentsOf(inputs, ground.regimes).empty(), times < 4.0) << times;
  }
}

/// What is no measurement belongs to no stretch, however near.
TEST(MismatchSegments, MaskedSamplesBeforeAStretchAreNoPartOfIt) {
  const Ground& ground = halfAnHour();
  InputSequence inputs =
      measured(ground, between(ground, 700.0, 900.0, [](const InputStep&) { return 0.04; }), 5);
  for (InputSample& sample : inputs.samples)
    if (sample.step.time >= 640.0 && sample.step.time < 700.0) sample.count = 0.0;
  const auto segments = segmentsOf(inputs, ground.regimes);
  expectStretch(segments, 700.0, 900.0);
  ASSERT_FALSE(segments.empty());
  EXPECT_GE(segments[0].from, 700.0);
}

TEST(MismatchSegments, AStretchEndsAtAGap) {
  const Ground& ground = halfAnHour();
  InputSequence inputs =
      measured(ground, between(ground, 700.0, 900.0, [](const InputStep&) { return 0.04; }), 5);
  for (InputSample& sample : inputs.samples)
    if (sample.step.time >= 760.0 && sample.step.time < 840.0) sample.count = 0.0;
  const auto segments = segmentsOf(inputs, ground.regimes);
  ASSERT_EQ(segments.size(), 2u);
  EXPECT_LT(segments[0].to, 760.0);
  EXPECT_GE(segments[1].from, 840.0);
}

TEST(MismatchSegments, OneWildSampleMakesNone) {
  InputSequence inputs = measured(
      tenMinutes(), between(tenMinutes(), 0.0, 0.0, [](const InputStep&) { return 0.0; }), 9);
  inputs.samples[1500].voltage += 0.2;
  EXPECT_TRUE(segmentsOf(inputs, tenMinutes().regimes).empty());
}

TEST(MismatchSegments, WhatIsSmallerThanWhatMattersIsNotReported) {
  const Ground& ground = halfAnHour();
  const InputSequence inputs =
      measured(ground, between(ground, 700.0, 900.0, [](const InputStep&) { return 0.04; }), 5);
  const CompositionPoint start = typicalStart(BatteryModel(), inputs);
  EXPECT_EQ(mismatchSegments(inputs, start, ground.regimes, 0.001).size(), 1u);
  EXPECT_TRUE(mismatchSegments(inputs, start, ground.regimes, 0.1).empty());
}

/// A charger holds the voltage, so that the current errs.
TEST(MismatchSegments, ACurrentThatErrsWhereTheVoltageIsControlledIsFound) {
  const Ground& ground = halfAnHour();
  InputSequence inputs =
      measured(ground, between(ground, 0.0, 0.0, [](const InputStep&) { return 0.0; }), 8);
  for (InputSample& sample : inputs.samples) {
    sample.voltage_controlled = true;
    if (sample.step.time >= 700.0 && sample.step.time < 900.0) sample.step.current += 20.0;
  }
  const auto segments = segmentsOf(inputs, ground.regimes);
  expectStretch(segments, 700.0, 900.0);
  ASSERT_FALSE(segments.empty());
  EXPECT_LT(segments[0].mean_error, -0.1);
}

TEST(Locate, WhatAMaskedSampleReadsDoesNotMatter) {
  InputSequence inputs = tenMinutes().inputs;
  for (std::size_t n = 500; n < 700; ++n) inputs.samples[n].count = 0.0;
  const test::NullFits fits(inputs);
  const WhitenedFit clean = fits.of(test::drawnNoise(kNoise, inputs, 3));
  WhitenedFit fit = clean;
  fit.residual.segment(500, 200).setConstant(5.0);
  const auto expected = regimeFindings(clean, inputs, tenMinutes().regimes);
  const auto findings = regimeFindings(fit, inputs, tenMinutes().regimes);
  ASSERT_EQ(findings.size(), expected.size());
  for (std::size_t k = 0; k < findings.size(); ++k) {
    EXPECT_DOUBLE_EQ(findings[k].value, expected[k].value);
    EXPECT_DOUBLE_EQ(findings[k].p_value, expected[k].p_value);
  }
  for (std::size_t n = 500; n < 700; ++n) inputs.samples[n].voltage += 5.0;
  EXPECT_TRUE(segmentsOf(inputs, tenMinutes().regimes).empty());
}

}  // namespace
}  // namespace battery_sof
