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

TEST(Locate, SlowNoiseAloneRaisesNoAlarm) {
  int alarmed = 0, segmented = 0, small = 0, all = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const WhitenedFit fit = nullFit(tenMinutes(), seed);
    const auto findings = regimeFindings(fit, tenMinutes().inputs, tenMinutes().regimes);
    alarmed += std::any_of(findings.begin(), findings.end(),
                           [](const auto& finding) { return finding.is_significant; });
    segmented += !mismatchSegments(fit, tenMinutes().inputs, tenMinutes().regimes).empty();
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

TEST(MismatchSegments, AnErrorOfHalfAMinuteIsFoundWhereItIs) {
  const Ground& ground = tenMinutes();
  Eigen::VectorXd effect = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(ground.regimes.size()));
  for (std::size_t n = 0; n < ground.regimes.size(); ++n) {
    const InputStep& step = ground.inputs.samples[n].step;
    if (step.time > 300.0 && step.time < 330.0)
      effect[static_cast<Eigen::Index>(n)] = std::copysign(0.008, step.current);
  }
  const WhitenedFit fit = fitOf(ground, effect, 5);
  const auto segments = mismatchSegments(fit, ground.inputs, ground.regimes, kNoise);
  ASSERT_GE(segments.size(), 1u);
  EXPECT_LE(segments.size(), 3u);
  double inside = 0.0;
  for (const MismatchSegment& segment : segments) {
    EXPECT_GE(segment.from, 285.0);
    EXPECT_LE(segment.to, 350.0);
    EXPECT_LE(segment.p_value, 0.02);
    EXPECT_GE(std::abs(segment.peak_error), std::abs(segment.mean_error));
    inside += std::min(segment.to, 330.0) - std::max(segment.from, 300.0);
  }
  EXPECT_GT(inside, 8.0);
}

TEST(MismatchSegments, ErrorsInLongChargesGiveAboutAsManySegmentsUnderTheNoiseOfTheRightModel) {
  const Ground& ground = halfAnHour();
  const Eigen::VectorXd charges = inside(ground, Regime::kLongCharge);
  const auto segments =
      mismatchSegments(fitOf(ground, 0.01 * charges, 6), ground.inputs, ground.regimes, kNoise);
  EXPECT_GE(segments.size(), 20u);
  EXPECT_LE(segments.size(), 60u);
  double both = 0.0, either = 0.0;
  for (std::size_t n = 0; n < ground.regimes.size(); ++n) {
    const InputStep& step = ground.inputs.samples[n].step;
    const bool true_one = charges[static_cast<Eigen::Index>(n)] > 0.0;
    const bool found =
        std::any_of(segments.begin(), segments.end(), [&](const MismatchSegment& segment) {
          return step.time >= segment.from && step.time <= segment.to;
        });
    both += (true_one && found) * step.duration;
    either += (true_one || found) * step.duration;
  }
  EXPECT_GT(both / either, 0.2);
}

TEST(MismatchSegments, OneWildSampleMakesNone) {
  WhitenedFit fit = nullFit(tenMinutes(), 7);
  fit.innovation[1500] = 200.0;
  EXPECT_TRUE(mismatchSegments(fit, tenMinutes().inputs, tenMinutes().regimes).empty());
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
  EXPECT_TRUE(mismatchSegments(fit, inputs, tenMinutes().regimes, kNoise).empty());
}

}  // namespace
}  // namespace battery_sof
