// What the nominal capacity says of where a discharge ends.

#include "estimation/capacity_prior.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "estimation/composition_fit.hpp"

namespace {

using namespace battery_sof;

const BatteryModel kDischarged({"ocv_soc", "end_of_discharge"});
constexpr double kNominal = 60.0;         // [Ah]
constexpr double kRated = 20.0 * 3600.0;  // [s]
constexpr double kLength = 4.0 * 3600.0;  // [s], of a window

double& valueOf(CompositionPoint& point, const char* name) {
  return point.parameters[*kDischarged.parameterRow(name)];
}

/// A point at which 0.95 of the nominal capacity takes a full battery to U_E in 20 h.
CompositionPoint asRated() {
  CompositionPoint point{kDischarged.typicalParameters(), kDischarged.restState()};
  valueOf(point, "exhaustion_voltage") = 11.5;
  valueOf(point, "pore_delay") = 3000.0;
  valueOf(point, "ocv_slope") = (12.9 - 11.5) / (0.95 * kNominal * (1.0 + 3000.0 / kRated));
  return point;
}

CapacityPrior::Residual at(const CompositionPoint& point) {
  const ParameterSpace space(kDischarged, point, kLength, {});
  return CapacityPrior::of(kDischarged, kNominal)->at(space, space.coordinatesOf(point));
}

TEST(CapacityPrior, SaysNothingOfAModelWhoseDischargeHasNoEnd) {
  EXPECT_FALSE(CapacityPrior::of(BatteryModel(), kNominal));
  EXPECT_FALSE(CapacityPrior::of(BatteryModel({"ocv_soc"}), kNominal));
  EXPECT_TRUE(CapacityPrior::of(kDischarged, kNominal));
}

TEST(CapacityPrior, IsMetWhereTheRatedDischargeEndsAtTheEnd) {
  EXPECT_NEAR(at(asRated()).z, 0.0, 1e-12);
}

/// 0.2 V are one standard deviation: of U_E, and of what k_s makes of the capacity.
TEST(CapacityPrior, CountsVoltsAtTheEndOfTheRatedDischarge) {
  CompositionPoint higher = asRated();
  valueOf(higher, "exhaustion_voltage") += 0.2;
  EXPECT_NEAR(at(higher).z, -1.0, 1e-9);
  CompositionPoint steeper = asRated();
  valueOf(steeper, "ocv_slope") *= 1.1;  // a tenth less capacity over 1.4 V
  EXPECT_NEAR(at(steeper).z, -0.1 * 1.4 / 0.2, 1e-9);
}

TEST(CapacityPrior, HasTheSlopesOfItsResidual) {
  const CompositionPoint point = asRated();
  const ParameterSpace space(kDischarged, point, kLength, {});
  const CapacityPrior prior = *CapacityPrior::of(kDischarged, kNominal);
  const Eigen::VectorXd x = space.coordinatesOf(point);
  const Eigen::VectorXd slopes = prior.at(space, x).slopes;
  int moved = 0;
  for (Eigen::Index k = 0; k < space.size(); ++k) {
    constexpr double kStep = 1e-6;
    Eigen::VectorXd up = x, down = x;
    up[k] += kStep;
    down[k] -= kStep;
    const double slope = (prior.at(space, up).z - prior.at(space, down).z) / (2.0 * kStep);
    EXPECT_NEAR(slopes[k], slope, 1e-6 * (1.0 + std::abs(slope))) << "coordinate " << k;
    moved += slopes[k] != 0.0;
  }
  EXPECT_EQ(moved, 3);
}

/// A problem without rows that say anything of them has the priors' cost and slopes.
TEST(CapacityPrior, IsAPartOfTheProblem) {
  const CompositionPoint point = asRated();
  InputSequence inputs;
  inputs.samples.resize(2);
  for (std::size_t n = 0; n < 2; ++n) {
    inputs.samples[n].step.time = static_cast<double>(n);
    inputs.samples[n].step.duration = 1.0;
    inputs.samples[n].voltage = 12.5;
    inputs.samples[n].count = 1.0;
  }
  CompositionPoint away = point;
  valueOf(away, "exhaustion_voltage") += 0.2;
  const auto priorsOf = [&](std::optional<double> capacity) {
    FitCost cost;
    cost.capacity = capacity;
    const CompositionProblem problem(kDischarged, inputs, cost, away);
    const Eigen::Index n = problem.size();
    NormalEquations priors{0.0, Eigen::VectorXd::Zero(n), Eigen::MatrixXd::Zero(n, n)};
    problem.addPriors(problem.coordinatesOf(away), priors);
    const Eigen::MatrixXd information =
        problem.priorWeight() * problem.priorInformation(problem.coordinatesOf(away));
    EXPECT_TRUE(priors.hessian.isApprox(information, 1e-12));
    return std::pair<NormalEquations, double>(priors, problem.priorWeight());
  };
  const auto [without, weight] = priorsOf(std::nullopt);
  const auto [with, same] = priorsOf(kNominal);
  EXPECT_NEAR(with.cost - without.cost, weight * 1.0, 1e-9 * weight);
  const ParameterSpace space(kDischarged, away, kLength, {});
  const CapacityPrior::Residual residual = at(away);
  EXPECT_TRUE(
      (with.gradient - without.gradient).isApprox(weight * residual.z * residual.slopes, 1e-9));
  EXPECT_TRUE((with.hessian - without.hessian)
                  .isApprox(weight * residual.slopes * residual.slopes.transpose(), 1e-9));
}

}  // namespace
