#include "simulator/generator/physical_difference.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "simulator/generator/law_injection.hpp"
#include "simulator/recording_output.hpp"
#include "support/drawn_scenarios.hpp"

namespace battery_sof_simulator {
namespace {

/// Rest, a load, and a charge behind a regulator, 20 s each; a sample a second.
std::vector<RecordedSample> drive() {
  std::vector<RecordedSample> samples;
  for (int n = 0; n < 180; ++n) {
    const int part = n / 20 % 3;
    samples.push_back({double(n),
                       part == 0   ? 0.0
                       : part == 1 ? -30.0
                                   : 12.0,
                       part == 0   ? 12.7
                       : part == 1 ? 12.3
                                   : 14.2});
  }
  return samples;
}

std::vector<RecordedSample> with(const std::string& id, double strength) {
  return withDifference(drive(), {{{id, strength}}, 50.0});
}

TEST(PhysicalDifference, WithoutStrengthTheRecordingStaysAsItIs) {
  const auto before = drive();
  for (const PhysicalCause& cause : physicalCauses()) {
    const auto after = with(cause.id, 0.0);
    ASSERT_EQ(before.size(), after.size());
    for (std::size_t n = 0; n < after.size(); ++n) {
      EXPECT_NEAR(before[n].current, after[n].current, 1e-3) << cause.id;
      EXPECT_NEAR(before[n].voltage, after[n].voltage, 1e-5) << cause.id;
    }
  }
}

TEST(PhysicalDifference, WhereAChargerRegulatesItGoesIntoTheCurrentElseIntoTheVoltage) {
  const auto before = drive(), after = with("loose_contact", 3.0);
  double current = 0.0, voltage = 0.0;
  for (std::size_t n = 21; n < after.size(); ++n) {
    const double of_current = after[n].current - before[n].current;
    const double of_voltage = after[n].voltage - before[n].voltage;
    if (isRegulated(before[n]) && isRegulated(before[n - 1])) {
      EXPECT_NEAR(0.0, of_voltage, 2e-6) << n;
      current = std::max(current, std::abs(of_current));
    } else if (!isRegulated(before[n])) {
      EXPECT_EQ(0.0, of_current) << n;
      voltage = std::max(voltage, std::abs(of_voltage));
    }
  }
  EXPECT_GT(current, 0.1);
  EXPECT_NEAR(3e-3 * 30.0, voltage, 0.02);
}

TEST(PhysicalDifference, ALooseContactComesLateAndACorrodingGridGrows) {
  const auto before = drive(), late = with("loose_contact", 1.0),
             grown = with("corroding_grid", 1.0);
  EXPECT_EQ(before[30].voltage, late[30].voltage);
  EXPECT_GT(before[150].voltage - late[150].voltage, 0.02);
  EXPECT_GT(before[150].voltage - grown[150].voltage,
            2.0 * (before[30].voltage - grown[30].voltage));
}

TEST(PhysicalDifference, EveryCauseShows) {
  const auto before = drive();
  for (const PhysicalCause& cause : physicalCauses()) {
    const auto after = with(cause.id, 4.0);
    double largest = 0.0;
    for (std::size_t n = 0; n < after.size(); ++n)
      largest = std::max({largest, std::abs(after[n].voltage - before[n].voltage),
                          0.01 * std::abs(after[n].current - before[n].current)});
    EXPECT_GT(largest, 1e-4) << cause.id;
  }
}

class CauseIntoARecording : public DrawInFolder {};

TEST_F(CauseIntoARecording, TheCommandTakesSeveralAndNamesWhatIsWrong) {
  writeRecording(path("measured.csv"), drive(), Digits::kMany);
  const auto put = [&](const std::vector<std::string>& causes) {
    std::vector<std::string> words{"--into", path("measured.csv"), "--out", recording()};
    for (const std::string& one : causes) words.insert(words.end(), {"--cause", one});
    return run(words);
  };
  ASSERT_EQ(0, put({"slow_diffusion=1", "corroding_grid=0.5"})) << err_;
  EXPECT_EQ(drive().size(), readRecording(recording()).size());
  EXPECT_EQ(2, put({"slow_diffusion"}));
  EXPECT_NE(err_.find("expected ID=STRENGTH"), std::string::npos) << err_;
  EXPECT_EQ(2, put({"bad_luck=1"}));
  EXPECT_NE(err_.find("no cause is \"bad_luck\""), std::string::npos) << err_;
  EXPECT_EQ(2, put({"slow_diffusion=-1"}));
}

}  // namespace
}  // namespace battery_sof_simulator
