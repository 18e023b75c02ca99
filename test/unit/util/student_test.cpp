#include "util/student.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace battery_sof {
namespace {

TEST(StudentQuantile, IsTheClosedFormOfOneTwoAndFourDegrees) {
  // One degree is Cauchy's; two and four: W. T. Shaw, J. Computational Finance 9 (2006), eqs. 35
  // and 36.
  for (const double p : {0.05, 0.3, 0.6, 0.95, 0.975}) {
    EXPECT_NEAR(studentQuantile(p, 1.0), std::tan(M_PI * (p - 0.5)), 1e-12) << p;
    const double a = 4.0 * p * (1.0 - p);
    EXPECT_NEAR(studentQuantile(p, 2.0), 2.0 * (p - 0.5) * std::sqrt(2.0 / a), 1e-12) << p;
    const double q = 4.0 / std::sqrt(a) * std::cos(std::acos(std::sqrt(a)) / 3.0);
    EXPECT_NEAR(studentQuantile(p, 4.0), std::copysign(std::sqrt(q - 4.0), p - 0.5), 1e-12) << p;
  }
}

TEST(StudentQuantile, IsThatOfTheNormalDistributionForManyDegrees) {
  EXPECT_NEAR(studentQuantile(0.975, 1e9), 1.959963984540054, 1e-7);
  EXPECT_NEAR(studentQuantile(0.95, 1e9), 1.6448536269514722, 1e-7);
}

TEST(StudentQuantile, RefusesWhatIsNoProbabilityAndNoDegrees) {
  EXPECT_THROW(studentQuantile(0.0, 3.0), std::invalid_argument);
  EXPECT_THROW(studentQuantile(1.0, 3.0), std::invalid_argument);
  EXPECT_THROW(studentQuantile(std::nan(""), 3.0), std::invalid_argument);
  EXPECT_THROW(studentQuantile(0.9, 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace battery_sof
