#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bag/format/bag_reader.hpp"
#include "bag/format/battery_state_message.hpp"
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

TEST_F(SimulatedBag, WritesABagOfBatteryStatesStampedWithTheTime) {
  ASSERT_EQ(simulate({scenario_, path("out.bag")}).code, 0);
  const battery_sof::BagReader bag(path("out.bag"));
  ASSERT_EQ(bag.connections().size(), 1u);
  EXPECT_EQ(bag.connections().front().topic, "/battery_state");
  std::uint64_t n = 0;
  bag.read(bag.connections().front(), [&n](std::uint64_t time, std::string_view bytes) {
    const auto message = battery_sof::BatteryStateMessage::deserialized(bytes);
    EXPECT_EQ(time, std::max<std::uint64_t>(1, 10000000ULL * n));
    EXPECT_EQ(message.stamp.nsec, 10000000ULL * n++ % 1000000000ULL);
    EXPECT_GT(message.voltage, 9.0f);
    EXPECT_TRUE(std::isnan(message.temperature));
  });
  EXPECT_EQ(n, 2000u);
}

}  // namespace
}  // namespace battery_sof_simulator
