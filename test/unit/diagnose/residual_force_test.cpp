#include "battery_sof/diagnose/residual_force.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/null_fits.hpp"

namespace battery_sof {
namespace {

using test::fitOf;
using test::nullFit;
using test::tenMinutes;

Eigen::VectorXd columnOf(const ForceTerm& term) {
  return forceColumns(nullFit(1), tenMinutes(), {term}).col(0);
}

TEST(ResidualForce, NoiseAloneRaisesNoAlarmThoughItsModelWasFittedToIt) {
  double sum = 0.0, squares = 0.0, most = 0.0;
  constexpr int kDraws = 40;
  for (std::uint64_t seed = 1; seed <= kDraws; ++seed) {
    const double z = omnibusZ(nullFit(seed), tenMinutes());
    sum += z;
    squares += z * z;
    most = std::max(most, z);
  }
  // A calibrated z has mean 0 and variance 1; its mean over 40 draws scatters by 0.16.
  EXPECT_NEAR(sum / kDraws, 0.2, 0.5);
  EXPECT_NEAR(squares / kDraws, 1.0, 0.6);
  EXPECT_LT(most, 4.0);
}

TEST(ResidualForce, ResistanceThatRemembersHalfAMinuteIsFoundAndNamed) {
  const ForceTerm truth{Force::kCurrentMagnitude, 30.0};
  const ResidualForce force = describeResidual(fitOf(5e-6 * columnOf(truth)), tenMinutes());
  EXPECT_GT(force.omnibus_z, 20.0);
  ASSERT_EQ(force.terms.size(), 1u);
  EXPECT_NE(force.terms[0].find("on the current times its magnitude, remembered 30 s"), std::string::npos) << force.terms[0];
  EXPECT_NE(force.description.find(force.terms[0]), std::string::npos);
}

TEST(ResidualForce, MemoryOfChargingShowsInTheSpectrumOfChargingAtItsTime) {
  const ResidualForce force = describeResidual(fitOf(2e-3 * columnOf({Force::kCharging, 10.0})), tenMinutes());
  EXPECT_GT(force.omnibus_z, 8.0);
  ASSERT_FALSE(force.charge.empty());
  double charge = 0.0, discharge = 0.0;
  for (const MemoryWeight& m : force.charge)
    if (m.time >= 3.0 && m.time <= 30.0) charge += m.weight;
  for (const MemoryWeight& m : force.discharge) discharge = std::max(discharge, std::abs(m.weight));
  EXPECT_NEAR(charge, 2e-3, 0.8e-3);
  EXPECT_LT(discharge, 0.4e-3);
}

TEST(ResidualForce, RmsIsThatOfWhatTheParametersCannotTakeUp) {
  const Eigen::VectorXd effect = 5e-6 * columnOf({Force::kCurrentMagnitude, 30.0});
  const WhitenedFit fit = fitOf(effect), without = nullFit(1);
  const Eigen::VectorXd left = fit.residual - without.residual;
  const double rms = std::sqrt(left.squaredNorm() / static_cast<double>(left.size()));
  EXPECT_NEAR(describeResidual(fit, tenMinutes()).rms, rms, 0.6 * rms);
}

TEST(ResidualForce, TheLibraryRemembersNoLongerThanAThirdOfTheDrive) {
  for (const ForceTerm& term : forceLibrary(tenMinutes())) EXPECT_LE(term.time, 200.0);
}

TEST(ResidualForce, WhatAMaskedSampleReadsDoesNotMatter) {
  Drive drive = tenMinutes();
  for (std::size_t n = 200; n < 400; ++n) drive.samples[n].count = 0.0;
  const test::NullFits fits(drive);
  Eigen::VectorXd error = test::drawnNoise(test::kDrawnNoise, drive, 3);
  const double clean = omnibusZ(fits.of(error), drive);
  error.segment(200, 200).setConstant(5.0);
  EXPECT_NEAR(omnibusZ(fits.of(error), drive), clean, 1e-9);
}

}  // namespace
}  // namespace battery_sof
