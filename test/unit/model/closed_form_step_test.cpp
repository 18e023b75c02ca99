#include "model/closed_form_step.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <random>
#include <unsupported/Eigen/AutoDiff>

namespace battery_sof {
namespace {

using Four = Eigen::AutoDiffScalar<Eigen::Vector4d>;

TEST(ClosedFormSlopes, EqualTheStepInAutomaticDifferentiation) {
  std::mt19937_64 random(17);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int n = 0; n < 2000; ++n) {
    const double w = between(-20.0, 20.0),
                 current = between(-1.0, 1.0) * std::pow(10.0, between(-3.0, 2.5));
    const double i0 = std::pow(10.0, between(-2.0, 1.5)),
                 half_rate = std::pow(10.0, between(-5.0, 0.5));
    const ClosedFormSlopes ours = closedFormSlopes(w, current, i0, half_rate);
    const Four theirs = closedFormAdvance(Four(w, 4, 0), Four(current, 4, 1), Four(i0, 4, 2),
                                          Four(half_rate, 4, 3));
    const Eigen::Vector4d slopes(ours.to_w, ours.to_current, ours.to_i0, ours.to_half_rate);
    // Both take 1 - D of a D near one and differences of exponentials: what rounding makes of them.
    const double rounding = 1e-13 * std::exp(std::abs(w)) + 1e-12;
    EXPECT_NEAR(ours.w, theirs.value(), 1e-12 * (1.0 + std::abs(w)));
    for (int k = 0; k < 4; ++k)
      EXPECT_NEAR(slopes[k], theirs.derivatives()[k],
                  (1e-10 + rounding * 1e-6) * (1.0 + std::abs(slopes[k])))
          << "w " << w << " i " << current << " i0 " << i0 << " half rate " << half_rate
          << ", derivative " << k;
  }
}

TEST(ClosedFormSlopes, AreThoseOfRestWhereNothingPasses) {
  const ClosedFormSlopes still = closedFormSlopes(3.0, -20.0, 1.0, 0.0);
  EXPECT_NEAR(still.w, 3.0, 1e-14);
  EXPECT_NEAR(still.to_w, 1.0, 1e-14);
  EXPECT_EQ(still.to_current, 0.0);
  EXPECT_EQ(still.to_i0, 0.0);
}

}  // namespace
}  // namespace battery_sof
