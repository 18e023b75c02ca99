#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "diagnosis/diagnose.hpp"
#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

/// A bench that draws 10 A for five hours, with three short rests: the open-circuit voltage falls
/// with the charge, and a slow voltage follows the current.
Recording fiveHours() {
  test::Random random(3);
  Recording bench;
  for (int n = 0; n < 4000; ++n) {
    const double time = 5.0 * n, since = std::max(0.0, time - 2000.0);
    const bool rests = n < 400 || (n % 2000 > 1500 && n % 2000 < 1560);
    const double slow = rests ? 0.0 : 0.3 * (1.0 - std::exp(-since / 640.0));
    bench.series.append({time, (rests ? 0.0 : -10.0) + 0.01 * random.normal(),
                         13.2 - 0.014 * since / 360.0 - slow + 0.010 * random.normal()});
  }
  return bench;
}

/// A bench with a resistance that is doubled by the first half of a discharge and halved by the charge
/// that follows, with pulses throughout.
Recording thereAndBack() {
  constexpr double kSlope = 0.027, kRise = 1.0;         // [V/Ah], [1/V]
  const double drawn = std::log(2.0) / kRise / kSlope;  // [Ah], which doubles the resistance
  test::Random random(4);
  Recording bench;
  double charge = 0.0;  // [Ah]
  bool is_down = true;
  for (int n = 0; n < 5000; ++n) {
    is_down = is_down && charge > -drawn;
    const double mean = is_down ? -15.0 : 12.0, current = n % 40 < 4 ? mean - 20.0 : mean;
    charge += current * 4.0 / 3600.0;
    const double moved = kSlope * charge;
    const double voltage = 12.7 + moved + 0.010 * std::exp(-kRise * moved) * current;
    bench.series.append(
        {4.0 * n, current + 0.01 * random.normal(), voltage + 0.004 * random.normal()});
  }
  return bench;
}

DiagnoseOptions ofTwo(double capacity) {
  DiagnoseOptions options;
  options.hypotheses = {"ocv_soc", "cpe2"};
  options.capacity = capacity;
  options.lists_detection_limits = false;
  return options;
}

TEST(MovedCapacity, ATenthOfItTellsTheOpenCircuitVoltageFromWhatExplainsNoMore) {
  const Diagnosis found = diagnose(fiveHours(), ofTwo(50.0));
  ASSERT_FALSE(found.effects.empty()) << found.summary;
  EXPECT_EQ(found.effects.front().id, "ocv_soc");
  EXPECT_TRUE(found.effects.front().indistinguishable_from.empty());
  EXPECT_EQ(found.mechanism, Mechanism::kOpenCircuit);
}

TEST(MovedCapacity, LessOfItLeavesTheTieATie) {
  const Diagnosis found = diagnose(fiveHours(), ofTwo(1000.0));
  EXPECT_EQ(found.verdict, Verdict::kAmbiguous) << found.summary;
}

TEST(MovedCapacity, ThatMovesTheResistanceIsToldFromTime) {
  DiagnoseOptions options = ofTwo(50.0);
  options.hypotheses = {"ocv_soc", "parameter_drift"};
  const Diagnosis found = diagnose(thereAndBack(), options);
  std::vector<std::string> ids;
  for (const NamedEffect& effect : found.effects) ids.push_back(effect.id);
  EXPECT_EQ(ids, (std::vector<std::string>{"ocv_soc", "resistance_soc"})) << found.summary;
  // The circuit has a double layer, which this bench lacks.
  EXPECT_NEAR(found.effects.back().parameters.at(0).value, 1.0, 0.05);
}

}  // namespace
}  // namespace battery_sof
