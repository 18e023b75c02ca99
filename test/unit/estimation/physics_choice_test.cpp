// What a window that moved a tenth of the capacity is fitted with.

#include "estimation/physics_choice.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "model/simulation.hpp"
#include "support/composed.hpp"
#include "support/start_stop.hpp"
#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

using Effects = std::vector<std::string>;

/// A battery of 20 Ah in rows of a minute, with noise of 20 mA and 4 mV.
class Bench {
 public:
  /// @param rise of the resistance [1/V], 0: none.
  explicit Bench(double rise)
      : model_({"ocv_soc", "resistance_soc", "acceptance_soc"}), battery_(model_, start(rise)) {}

  Bench& draw(double current, int minutes) {
    for (int n = 0; n < minutes; ++n) battery_.hold(-current, 60.0), append(-current);
    return *this;
  }
  Bench& charge(int minutes) {
    for (int n = 0; n < minutes; ++n) append(battery_.advanceAtVoltage(14.2, 60.0, 4.0));
    return *this;
  }
  /// Loads that change every ten minutes.
  Bench& drawInSteps(int minutes) {
    for (int n = 0; n < minutes; n += 10) draw(n % 20 == 0 ? 1.0 : 5.0, 10);
    return *this;
  }
  const Series& series() const { return series_; }

 private:
  ModelPoint start(double rise) const {
    Eigen::VectorXd p = model_.typicalParameters();
    const auto set = [&](const char* name, double value) { p[*model_.parameterRow(name)] = value; };
    set("u_dc", 12.9);
    set("r_discharge", 0.03);
    set("ocv_slope", 0.06);
    set("resistance_rise", rise);
    set("acceptance_fall", 5.0);
    return test::pointOf(model_, p);
  }
  void append(double current) {
    series_.append({60.0 * static_cast<double>(series_.size()), current + 0.02 * random_.normal(),
                    battery_.voltage() + 0.004 * random_.normal()});
  }

  BatteryModel model_;
  Simulation battery_;
  test::Random random_{3};
  Series series_;
};

Effects chosen(const Series& series, std::optional<ChargerControl> source, double capacity = 20.0) {
  IdentifyOptions options;
  options.capacity = capacity;
  options.source = std::move(source);
  const FittedModel model = identifyWithChosenPhysics(series, {0, series.size()}, options);
  EXPECT_TRUE(isUsable(model.fit)) << model.fit.message;
  return model.fit.effects;
}

Effects chosen(const Series& series, double capacity = 20.0) {
  return chosen(series, chargerControl(series), capacity);
}

TEST(PhysicsChoice, LeftOutBlocksSayWhetherTheResistanceRises) {
  EXPECT_EQ(chosen(Bench(2.0).drawInSteps(240).series()),
            (Effects{"ocv_soc", "resistance_soc", "end_of_discharge"}));
  EXPECT_EQ(chosen(Bench(0.0).drawInSteps(240).series()), (Effects{"ocv_soc", "end_of_discharge"}));
}

TEST(PhysicsChoice, OneLoadShowsNoResistance) {
  EXPECT_EQ(chosen(Bench(2.0).draw(3.0, 240).series()), (Effects{"ocv_soc", "end_of_discharge"}));
}

TEST(PhysicsChoice, AShallowWindowTakesNothingOfTheDepth) {
  EXPECT_EQ(chosen(Bench(2.0).drawInSteps(240).series(), 200.0), Effects());
}

/// How the current fades under a held voltage takes a minute to see.
TEST(PhysicsChoice, APassingTouchOfAHeldVoltageTakesNoPhysicsOfCharging) {
  const BatteryModel fresh({"fresh_sulphate"});
  test::StartStopOptions driven;
  driven.duration = 600.0;
  const test::StartStopDrive drive = test::startStopDrive(fresh, test::freshBattery(fresh), driven);
  ChargerControl source = test::knownSource(drive);
  EXPECT_EQ(chosen(drive.series, source), Effects{"fresh_sulphate"});
  double left = 30.0;  // [s]
  for (std::size_t n = 1; n < drive.series.size(); ++n) {
    if (!source.voltage_controlled[n]) continue;
    left -= drive.series.time[n] - drive.series.time[n - 1];
    if (left < 0.0) source.voltage_controlled[n] = 0;
  }
  EXPECT_EQ(chosen(drive.series, source), Effects());
}

/// A tenth of the capacity went there and back again and again in both.
TEST(PhysicsChoice, LeftOutBlocksDecideWhatRepeatedDeepCyclesLack) {
  Bench bench(0.0);
  for (int day = 0; day < 3; ++day) bench.draw(3.0, 240).draw(0.0, 60).charge(480);
  EXPECT_EQ(chosen(bench.series()), (Effects{"ocv_soc", "end_of_discharge", "acceptance_soc"}));

  const BatteryModel fresh({"fresh_sulphate"});
  test::StartStopOptions driven;
  driven.duration = 900.0;
  driven.current_noise = 0.1;
  driven.voltage_noise = 0.005;
  const test::StartStopDrive drive = test::startStopDrive(fresh, test::freshBattery(fresh), driven);
  // Of 1 Ah every stop moves a tenth.
  EXPECT_EQ(chosen(drive.series, test::knownSource(drive), 1.0), Effects{"fresh_sulphate"});
}

}  // namespace
}  // namespace battery_sof
