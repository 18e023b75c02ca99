#include <gtest/gtest.h>

#include <filesystem>

#include "simulator/simulate_command.hpp"
#include "support/commands.hpp"

namespace battery_sof_simulator {
namespace {

class SimulatedBag : public battery_sof::test::InFolder {
 protected:
  SimulatedBag() : InFolder("simulated bag") {
    scenario_ =
        write("drive.yaml", "{name: drive, seed: 3, duration_s: 20, profile: {kind: city_drive}}");
  }
  static battery_sof::test::Outcome simulate(const std::vector<std::string>& arguments) {
    return battery_sof::test::outcomeOf([](auto&... all) { return runSimulate(all...); },
                                        arguments);
  }
  std::string scenario_;
};

TEST_F(SimulatedBag, IsNotWrittenWithoutRosAndTheReasonIsSaid) {
  const auto outcome = simulate({scenario_, path("out.bag")});
  EXPECT_EQ(outcome.code, 2);
  for (const char* piece : {"out.bag", "has no ROS", "expected a name ending in .csv"})
    EXPECT_NE(outcome.err.find(piece), std::string::npos) << outcome.err;
  EXPECT_FALSE(std::filesystem::exists(path("out.bag")));
}

}  // namespace
}  // namespace battery_sof_simulator
