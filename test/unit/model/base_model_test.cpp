#include "model/base_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "model/simulation.hpp"
#include "support/base_drive.hpp"

namespace battery_sof {
namespace {

using test::drivenBattery;

/// Classical Runge-Kutta over an interval, the reference for every step.
double fineReference(const BaseParameters& p, double u,
                     const std::function<double(double)>& current, double dt, int steps) {
  const double h = dt / steps;
  const auto rate = [&](double t, double v) {
    return (current(t) - test::chargeTransferCurrent(p, v)) / p.c2;
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
  EXPECT_DOUBLE_EQ(test::chargeTransferCurrent(p, u),
                   std::exp(0.3 * 20.0 * u) - std::exp(-0.7 * 20.0 * u));
  EXPECT_DOUBLE_EQ(test::chargeTransferCurrent(p, 0.0), 0.0);
}

TEST(TerminalVoltage, DischargingBatteryReadsBelowRest) {
  EXPECT_LT(test::terminalVoltage(drivenBattery(), -20.0, 0.0), drivenBattery().u_dc);
  EXPECT_GT(test::terminalVoltage(drivenBattery(), 20.0, 0.0), drivenBattery().u_dc);
}

TEST(TerminalVoltage, UsesTheResistanceOfTheDirection) {
  EXPECT_DOUBLE_EQ(test::terminalVoltage(drivenBattery(), -100.0, 0.1), 12.7 - 0.6 + 0.1);
  EXPECT_DOUBLE_EQ(test::terminalVoltage(drivenBattery(), 100.0, 0.1), 12.7 + 0.85 + 0.1);
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

TEST(SettledOverpotential, BalancesTheCurrent) {
  for (double current : {-300.0, -5.0, 0.0, 0.3, 80.0}) {
    const BaseParameters p = with(1000.0, 22.0);
    EXPECT_NEAR(test::chargeTransferCurrent(p, test::settledOverpotential(p, current)), current,
                1e-6);
  }
}

TEST(ClosedFormStep, TwoHalfStepsAreOneStep) {
  for (double beta : {1.0, 20.0, 1000.0})
    for (double current : {-300.0, -1.0, 0.0, 40.0}) {
      const test::BaseStep step(with(700.0, beta));
      const double whole = step.advance(0.05, current, 0.4);
      EXPECT_NEAR(step.advance(step.advance(0.05, current, 0.2), current, 0.2), whole, 1e-13);
    }
}

TEST(ClosedFormStep, IsOddInStateAndCurrent) {
  const test::BaseStep step(drivenBattery());
  for (double current : {-200.0, -3.0, 0.0, 60.0})
    EXPECT_NEAR(step.advance(-0.08, -current, 0.3), -step.advance(0.08, current, 0.3), 1e-15);
}

TEST(ClosedFormStep, StaysBetweenStateAndSettledValueOverTheWholeBox) {
  for (double c2 : {100.0, 1000.0, 5000.0})
    for (double beta : {1.0, 20.0, 1000.0})
      for (double dt : {1e-3, 1e-2, 1.0, 60.0})
        for (double current : {-2000.0, -300.0, 0.0, 0.01, 300.0})
          for (double u : {-1.5, -0.2, 0.0, 0.3, 1.5}) {
            const BaseParameters p = with(c2, beta);
            const double settled = test::settledOverpotential(p, current);
            const double next = test::BaseStep(p).advance(u, current, dt);
            EXPECT_GE(next, std::min(u, settled) - 1e-12)
                << c2 << " F " << beta << " 1/V " << dt << " s";
            EXPECT_LE(next, std::max(u, settled) + 1e-12)
                << c2 << " F " << beta << " 1/V " << dt << " s";
          }
}

TEST(ClosedFormStep, SettlesUnderALongHeldCurrent) {
  for (double current : {-300.0, -20.0, 5.0, 120.0})
    EXPECT_NEAR(test::BaseStep(drivenBattery()).advance(0.4, current, 3600.0),
                test::settledOverpotential(drivenBattery(), current), 1e-12);
}

TEST(ClosedFormStep, IsExactUnderAHeldCurrent) {
  const BaseParameters p = drivenBattery();
  for (double current : {-300.0, -40.0, 0.0, 30.0}) {
    const double reference = fineReference(
        p, 0.03, [&](double) { return current; }, 1.0, 20000);
    EXPECT_NEAR(test::BaseStep(p).advance(0.03, current, 1.0), reference, 1e-11);
  }
}

TEST(ClosedFormStep, StaysWithinOneMillivoltOfAHundredfoldFinerReferenceOnAPaperLikeDrive) {
  const BaseParameters p = drivenBattery();
  const double dt = 0.01;
  const auto current = test::dataSetOneCurrent(120.0, dt, 3);
  const test::BaseStep step(p);
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

TEST(ChargeTransfer, WithUnevenSymmetryFollowsTheFineReference) {
  const BatteryModel model({"charge_transfer"});
  for (double alpha : {0.3, 0.7})
    for (double current : {-250.0, -10.0, 0.0, 60.0})
      for (double dt : {0.01, 1.0, 60.0}) {
        const BaseParameters p = with(900.0, 25.0, alpha);
        ModelPoint start{model.typicalParameters(), model.restState()};
        start.parameters.head<kBaseRows>() << p.r_discharge, p.r_charge, p.c2, p.beta, p.u_dc;
        start.parameters.tail<2>() << p.i0, alpha;
        start.state[0] = 0.04;
        Simulation simulation(model, start);
        simulation.advance(inputStep(0.0, current, dt, current, 100.0));
        const double reference = fineReference(
            p, 0.04, [&](double) { return current; }, dt, 200000);
        EXPECT_NEAR(simulation.state()[0], reference, 2e-5) << alpha << " " << current;
      }
}

/// Central difference of a step in one of its inputs.
double centralDifference(const std::function<double(double)>& f, double x, double h) {
  return (f(x + h) - f(x - h)) / (2.0 * h);
}

TEST(ClosedFormStep, DerivativesMatchCentralDifferencesInsideAndAtTheBounds) {
  for (double c2 : {100.0, 1100.0, 5000.0})
    for (double beta : {1.0, 22.0, 1000.0})
      for (double current : {-250.0, -1e-3, 0.0, 30.0}) {
        const double u = 0.3 / beta, dt = 0.5;
        const Overpotential after =
            test::BaseStep(with(c2, beta)).advance(Overpotential{u, 1.0, 0.0, 0.0}, current, dt);
        const auto of_c2 = [&](double x) {
          return test::BaseStep(with(x, beta)).advance(u, current, dt);
        };
        const auto of_beta = [&](double x) {
          return test::BaseStep(with(c2, x)).advance(u, current, dt);
        };
        const auto of_u = [&](double x) {
          return test::BaseStep(with(c2, beta)).advance(x, current, dt);
        };
        const double tolerance = 1e-6 * (std::abs(after.value) + u);
        EXPECT_NEAR(after.d_c2 * c2, centralDifference(of_c2, c2, 1e-4 * c2) * c2, tolerance);
        EXPECT_NEAR(after.d_beta * beta, centralDifference(of_beta, beta, 1e-4 * beta) * beta,
                    tolerance);
        EXPECT_NEAR(after.d_initial * u, centralDifference(of_u, u, 1e-4 * u) * u, tolerance);
      }
}

}  // namespace
}  // namespace battery_sof
