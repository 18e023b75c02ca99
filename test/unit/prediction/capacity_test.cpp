// The capacity that a model of a discharge states, and the nominal one that it keeps.

#include "prediction/capacity.hpp"

#include <gtest/gtest.h>

#include "model/base_model.hpp"
#include "support/known_model.hpp"

namespace battery_sof {
namespace {

/// Of a discharge with 5 A: U_E = 11.5 +- 0.1 V, theta = 1000 s.
class DischargeModel {
 public:
  DischargeModel() : model_(test::typicalBattery({"ocv_soc", "end_of_discharge"})) {
    const Eigen::Index rows = composition().parameterCount() + composition().stateCount();
    model_.fit.covariance = Eigen::MatrixXd::Zero(rows, rows);
    model_.fit.excited.min_current = -5.0;
    set("ocv_slope", 0.02, 0.001);
    set("exhaustion_voltage", 11.5, 0.1);
    set("pore_delay", 1000.0, 0.0);
  }
  DischargeModel& set(const char* name, double value, double std) {
    const Eigen::Index row = rowOf(name);
    ParameterEstimate& one = estimate(name);
    one.value = value;
    one.std = std;
    one.determined = true;
    model_.fit.covariance(row, row) = std * std;
    return *this;
  }
  ParameterEstimate& estimate(const char* name) {
    return model_.fit.estimates[static_cast<std::size_t>(rowOf(name))];
  }
  std::optional<Interval> capacity() const { return estimatedCapacity(model_.fit); }

 private:
  BatteryModel composition() const { return compositionOf(model_.fit); }
  Eigen::Index rowOf(const char* name) const { return *composition().parameterRow(name); }

  FittedModel model_;
};

TEST(EstimatedCapacity, IsTheChargeFromFullToExhaustedUnderTheLoad) {
  const std::optional<Interval> stated = DischargeModel().capacity();
  ASSERT_TRUE(stated);
  EXPECT_NEAR(stated->value, (12.9 - 11.5) / 0.02 - 5.0 * 1000.0 / 3600.0, 1e-9);
  // 3.5 Ah by the slope, 5 by U_E and 5 by the full battery's voltage, 1.645 standard deviations
  EXPECT_NEAR(stated->value - stated->lower, 1.645 * std::sqrt(3.5 * 3.5 + 50.0), 0.02);
}

TEST(EstimatedCapacity, IsNotStatedWhereTheEndIsAtABoundOrNothingIsKnown) {
  DischargeModel at_bound, wide;
  at_bound.estimate("exhaustion_voltage").at_bound = true;
  EXPECT_FALSE(at_bound.capacity());
  EXPECT_FALSE(wide.set("exhaustion_voltage", 11.5, 1.0).capacity()) << "0 Ah is not excluded";
}

TEST(NominalCapacity, IsThatOfTheQueryThenThatOfTheFitThenATypicalOne) {
  Fit fit;
  EXPECT_EQ(capacityFor(fit, std::nullopt), kTypicalCapacity);
  fit.nominal_capacity = 72.0;
  EXPECT_EQ(capacityFor(fit, std::nullopt), 72.0);
  EXPECT_EQ(capacityFor(fit, 100.0), 100.0);
}

}  // namespace
}  // namespace battery_sof
