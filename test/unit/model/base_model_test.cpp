#include "model/base_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "support/base_drive.hpp"

namespace battery_sof {
namespace {

using test::drivenBattery;

/// Classical Runge-Kutta over an interval, the reference for every step.
double fineReference(const BaseParameters& p, double u,
                     const std::function<double(double)>& current, double dt, int steps) {
  const double h = dt / steps;
  const auto rate = [&](double t, double v) {
    return (current(t) - chargeTransferCurrent(p, v)) / p.c2;
  };
  for (int k = 0; k < steps; ++k) {
    const double t = k * h;
    const double k1 = rate(t, u);
    const double k2 = rate(t + 0.5 * h, u + 0.5 * h * k1);
    const double k3 = rate(t + 0.5 * h, u + 0.5 * h * k2);
    const double k4 = rate(t + h, u + h * k3);
    u += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }
  return u;
}

BaseParameters with(double c2, double beta, double alpha = 0.5) {
  BaseParameters p = drivenBattery();
  p.c2 = c2;
  p.beta = beta;
  p.alpha = alpha;
  return p;
}

std::string messageOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(TableOne, HoldsThePapersMagnitudesAndBounds) {
  const auto& table = tableOne();
  EXPECT_EQ(table[0].name, "r_discharge");
  EXPECT_DOUBLE_EQ(table[0].magnitude, 0.008);
  EXPECT_DOUBLE_EQ(table[1].magnitude, 0.010);
  EXPECT_DOUBLE_EQ(table[2].lower, 100.0);
  EXPECT_DOUBLE_EQ(table[2].upper, 5000.0);
  EXPECT_DOUBLE_EQ(table[3].upper, 1000.0);
}

TEST(ChargeTransferCurrent, IsEquationOne) {
  const BaseParameters p = with(1000.0, 20.0, 0.3);
  const double u = 0.07;
  EXPECT_DOUBLE_EQ(chargeTransferCurrent(p, u),
                   std::exp(0.3 * 20.0 * u) - std::exp(-0.7 * 20.0 * u));
  EXPECT_DOUBLE_EQ(chargeTransferCurrent(p, 0.0), 0.0);
}

TEST(TerminalVoltage, DischargingBatteryReadsBelowRest) {
  EXPECT_LT(terminalVoltage(drivenBattery(), -20.0, 0.0), drivenBattery().u_dc);
  EXPECT_GT(terminalVoltage(drivenBattery(), 20.0, 0.0), drivenBattery().u_dc);
}

TEST(TerminalVoltage, UsesTheResistanceOfTheDirection) {
  EXPECT_DOUBLE_EQ(terminalVoltage(drivenBattery(), -100.0, 0.1), 12.7 - 0.6 + 0.1);
  EXPECT_DOUBLE_EQ(terminalVoltage(drivenBattery(), 100.0, 0.1), 12.7 + 0.85 + 0.1);
}

TEST(RequireValid, NamesTheParameterAndItsValue) {
  BaseParameters p = drivenBattery();
  p.c2 = -3.0;
  const std::string message = messageOf([&] { requireValid(p); });
  EXPECT_NE(message.find("c2"), std::string::npos);
  EXPECT_NE(message.find("-3"), std::string::npos);
  p = drivenBattery();
  p.alpha = 1.0;
  EXPECT_NE(messageOf([&] { requireValid(p); }).find("alpha"), std::string::npos);
  p = drivenBattery();
  p.u_dc = std::nan("");
  EXPECT_NE(messageOf([&] { requireValid(p); }).find("u_dc"), std::string::npos);
}

TEST(SettledOverpotential, BalancesTheCurrentForAnySymmetry) {
  for (double alpha : {0.2, 0.5, 0.71})
    for (double current : {-300.0, -5.0, 0.0, 0.3, 80.0}) {
      const BaseParameters p = with(1000.0, 22.0, alpha);
      EXPECT_NEAR(chargeTransferCurrent(p, settledOverpotential(p, current)), current, 1e-6);
    }
}

TEST(OverpotentialStep, TwoHalfStepsAreOneStep) {
  for (double beta : {1.0, 20.0, 1000.0})
    for (double current : {-300.0, -1.0, 0.0, 40.0}) {
      const OverpotentialStep step(with(700.0, beta));
      const double whole = step.advance(0.05, current, 0.4);
      EXPECT_NEAR(step.advance(step.advance(0.05, current, 0.2), current, 0.2), whole, 1e-13);
    }
}

TEST(OverpotentialStep, IsOddInStateAndCurrent) {
  const OverpotentialStep step(drivenBattery());
  for (double current : {-200.0, -3.0, 0.0, 60.0})
    EXPECT_NEAR(step.advance(-0.08, -current, 0.3), -step.advance(0.08, current, 0.3), 1e-15);
}

TEST(OverpotentialStep, StaysBetweenStateAndSettledValueOverTheWholeBox) {
  for (double c2 : {100.0, 1000.0, 5000.0})
    for (double beta : {1.0, 20.0, 1000.0})
      for (double dt : {1e-3, 1e-2, 1.0, 60.0})
        for (double current : {-2000.0, -300.0, 0.0, 0.01, 300.0})
          for (double u : {-1.5, -0.2, 0.0, 0.3, 1.5}) {
            const BaseParameters p = with(c2, beta);
            const double settled = settledOverpotential(p, current);
            const double next = OverpotentialStep(p).advance(u, current, dt);
            EXPECT_GE(next, std::min(u, settled) - 1e-12)
                << c2 << " F " << beta << " 1/V " << dt << " s";
            EXPECT_LE(next, std::max(u, settled) + 1e-12)
                << c2 << " F " << beta << " 1/V " << dt << " s";
          }
}

TEST(OverpotentialStep, SettlesUnderALongHeldCurrent) {
  for (double current : {-300.0, -20.0, 5.0, 120.0})
    EXPECT_NEAR(OverpotentialStep(drivenBattery()).advance(0.4, current, 3600.0),
                settledOverpotential(drivenBattery(), current), 1e-12);
}

TEST(OverpotentialStep, IsExactUnderAHeldCurrent) {
  const BaseParameters p = drivenBattery();
  for (double current : {-300.0, -40.0, 0.0, 30.0}) {
    const double reference = fineReference(
        p, 0.03, [&](double) { return current; }, 1.0, 20000);
    EXPECT_NEAR(OverpotentialStep(p).advance(0.03, current, 1.0), reference, 1e-11);
  }
}

TEST(OverpotentialStep, StaysWithinOneMillivoltOfAHundredfoldFinerReferenceOnAPaperLikeDrive) {
  const BaseParameters p = drivenBattery();
  const double dt = 0.01;
  const auto current = test::dataSetOneCurrent(120.0, dt, 3);
  const OverpotentialStep step(p);
  double u = 0.0, reference = 0.0, largest = 0.0;
  for (std::size_t n = 1; n < current.size(); ++n) {
    const double before = current[n - 1], after = current[n];
    u = step.advance(u, 0.5 * (before + after), dt);
    reference = fineReference(
        p, reference, [&](double t) { return before + (after - before) * t / dt; }, dt, 100);
    largest = std::max(largest, std::abs(u - reference));
  }
  EXPECT_LT(largest, 1e-3);
  RecordProperty("largest_error_uV", std::to_string(1e6 * largest));
}

TEST(OverpotentialStep, WithUnevenSymmetryFollowsTheFineReference) {
  for (double alpha : {0.3, 0.7})
    for (double current : {-250.0, -10.0, 0.0, 60.0})
      for (double dt : {0.01, 1.0, 60.0}) {
        const BaseParameters p = with(900.0, 25.0, alpha);
        const double reference = fineReference(
            p, 0.04, [&](double) { return current; }, dt, 200000);
        EXPECT_NEAR(OverpotentialStep(p).advance(0.04, current, dt), reference, 2e-5)
            << alpha << " " << current;
      }
}

TEST(OverpotentialStep, WithUnevenSymmetryIsStableOverTheWholeBox) {
  for (double c2 : {100.0, 5000.0})
    for (double beta : {1.0, 1000.0})
      for (double dt : {1e-3, 60.0})
        for (double current : {-300.0, 0.0, 300.0})
          for (double u : {-1.5, 0.0, 1.5}) {
            const BaseParameters p = with(c2, beta, 0.4);
            const double settled = settledOverpotential(p, current);
            const double next = OverpotentialStep(p).advance(u, current, dt);
            EXPECT_GE(next, std::min(u, settled) - 5e-5);
            EXPECT_LE(next, std::max(u, settled) + 5e-5);
          }
}

TEST(OverpotentialStep, ImplicitAndClosedFormMeetAtEvenSymmetry) {
  for (double current : {-200.0, 0.0, 50.0})
    EXPECT_NEAR(OverpotentialStep(with(1000.0, 20.0, 0.5 + 1e-12)).advance(0.02, current, 1.0),
                OverpotentialStep(with(1000.0, 20.0)).advance(0.02, current, 1.0), 2e-6);
}

/// Central difference of a step in one of its inputs.
double centralDifference(const std::function<double(double)>& f, double x, double h) {
  return (f(x + h) - f(x - h)) / (2.0 * h);
}

TEST(OverpotentialStep, DerivativesMatchCentralDifferencesInsideAndAtTheBounds) {
  for (double alpha : {0.5, 0.35})
    for (double c2 : {100.0, 1100.0, 5000.0})
      for (double beta : {1.0, 22.0, 1000.0})
        for (double current : {-250.0, -1e-3, 0.0, 30.0}) {
          const double u = 0.3 / beta, dt = 0.5;
          const Overpotential after = OverpotentialStep(with(c2, beta, alpha))
                                          .advance(Overpotential{u, 1.0, 0.0, 0.0}, current, dt);
          const auto of_c2 = [&](double x) {
            return OverpotentialStep(with(x, beta, alpha)).advance(u, current, dt);
          };
          const auto of_beta = [&](double x) {
            return OverpotentialStep(with(c2, x, alpha)).advance(u, current, dt);
          };
          const auto of_u = [&](double x) {
            return OverpotentialStep(with(c2, beta, alpha)).advance(x, current, dt);
          };
          // step control moves between differences
          const double tolerance = alpha == 0.5 ? 1e-6 : 2e-3;
          const double scale = std::abs(after.value) + u;
          EXPECT_NEAR(after.d_c2 * c2, centralDifference(of_c2, c2, 1e-4 * c2) * c2,
                      tolerance * scale);
          EXPECT_NEAR(after.d_beta * beta, centralDifference(of_beta, beta, 1e-4 * beta) * beta,
                      tolerance * scale);
          EXPECT_NEAR(after.d_initial * u, centralDifference(of_u, u, 1e-4 * u) * u,
                      tolerance * scale);
        }
}

TEST(OverpotentialStep, RefusesValuesThatAreNotFiniteAndNegativeIntervals) {
  const OverpotentialStep step(drivenBattery());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(step.advance(nan, 0.0, 1.0), std::invalid_argument);
  EXPECT_THROW(step.advance(0.0, nan, 1.0), std::invalid_argument);
  EXPECT_THROW(step.advance(0.0, 0.0, -1.0), std::invalid_argument);
  EXPECT_NE(messageOf([&] { step.advance(0.0, 1.0, -1.0); }).find("-1"), std::string::npos);
}

}  // namespace
}  // namespace battery_sof
