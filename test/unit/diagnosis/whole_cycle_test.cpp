#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "diagnosis/diagnose.hpp"
#include "model/simulation.hpp"
#include "support/composed.hpp"
#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

/// A battery of 60 Ah that lacks 40, in rows of a minute: charged by 8 A to 14.7 V and held there, left
/// alone for two hours, and discharged by 5 A. What the charge left at its plates goes with the first
/// ampere-hours.
Recording filledAndDrawn() {
  const BatteryModel model({"ocv_soc", "acceptance_soc", "end_of_discharge", "surface_charge"});
  Eigen::VectorXd p = model.typicalParameters();
  const auto set = [&](const char* name, double value) { p[*model.parameterRow(name)] = value; };
  set("u_dc", 12.1);
  set("ocv_slope", 0.02);
  set("acceptance_fall", 20.0);
  set("surface_voltage", 0.45);
  set("surface_capacity", 3.0);
  ModelPoint start = test::pointOf(model, p);
  start.state[model.firstState(2)] = 40.0;
  Simulation battery(model, start);
  test::Random random(5);
  Recording bench;
  double time = 0.0;
  const auto append = [&](double current) {
    time += 60.0;
    bench.series.append(
        {time, current + 0.01 * random.normal(), battery.voltage() + 0.003 * random.normal()});
  };
  for (int n = 0; n < 600; ++n) append(battery.advanceAtVoltage(14.7, 60.0, 8.0));
  for (int n = 0; n < 120; ++n) battery.hold(0.0, 60.0), append(0.0);
  for (int n = 0; n < 560; ++n) battery.hold(-5.0, 60.0), append(-5.0);
  return bench;
}

TEST(WholeCycle, WhatACycleCallsForIsFoundTogetherWhereOneByOneItIsNot) {
  DiagnoseOptions options;
  options.capacity = 60.0;
  options.lists_detection_limits = false;
  const Diagnosis found = diagnose(filledAndDrawn(), options);
  std::vector<std::string> ids;
  for (const NamedEffect& effect : found.effects) ids.push_back(effect.id);
  std::sort(ids.begin(), ids.end());
  EXPECT_EQ(ids, (std::vector<std::string>{"acceptance_soc", "end_of_discharge", "ocv_soc",
                                           "surface_charge"}))
      << found.summary;
  EXPECT_LT(found.fit.extended_holdout.rmse, 0.5 * found.fit.base_holdout.rmse);
}

}  // namespace
}  // namespace battery_sof
