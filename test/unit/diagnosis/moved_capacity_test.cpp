#include <gtest/gtest.h>

#include <cmath>

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

}  // namespace
}  // namespace battery_sof
