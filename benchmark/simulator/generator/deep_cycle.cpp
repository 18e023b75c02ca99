#include "simulator/generator/deep_cycle.hpp"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "simulator/power_source.hpp"

namespace battery_sof_simulator {
namespace {

constexpr std::uint32_t kStream = 31;
constexpr double kSecond = 1.0;       // [s], step of the block
constexpr double kAtOnce = 1e9;       // [A/s]
constexpr double kAlmostFull = 0.97;  // state of charge that ends a charge
constexpr double kTaper = 0.02;       // of the capacity an hour, likewise
constexpr double kLongestPhase = 40.0 * kSecondsPerHour;

/// A block on a bench, recorded from its first second on.
class Bench {
 public:
  Bench(DeepCycle& cycle, Dice& dice)
      : cycle_(cycle),
        dice_(dice),
        battery_(cycle.block, cycle.soc_at_start, kSecond),
        state_(battery_.rested()) {}

  void rest(double duration) {
    run(duration, {0.0, HUGE_VAL}, [] { return false; });
  }
  /// @param least [V] at which it ends.  @param most charge that is drawn [Ah].
  void discharge(double least, double most) {
    const double until = battery_.soc(state_) - most / cycle_.block.capacity_ah;
    run(kLongestPhase, {-cycle_.discharge_a, HUGE_VAL},
        [&] { return battery_.voltage(state_) <= least || battery_.soc(state_) <= until; });
  }
  void charge() {
    const double least = kTaper * cycle_.block.capacity_ah;
    run(kLongestPhase, {cycle_.charge_a, cycle_.charge_v},
        [&] { return battery_.soc(state_) >= kAlmostFull || state_.current <= least; });
  }
  double soc() const { return battery_.soc(state_); }

 private:
  template <typename Ends>
  void run(double duration, const Demand& demand, const Ends& ends) {
    for (double passed = 0.0; passed < duration; passed += kSecond, time_ += kSecond) {
      state_ = source_.step(battery_, state_, demand);
      if (std::fmod(time_, cycle_.row_s) == 0.0) record();
      if (ends()) return;
    }
  }
  void record() {
    const double noise = cycle_.voltage_noise * dice_.normal();
    cycle_.samples.push_back({time_, quantised(state_.current, 0.01),
                              quantised(battery_.voltage(state_) + noise, 0.001)});
  }

  DeepCycle& cycle_;
  Dice& dice_;
  PorousBlock battery_;
  PorousState state_;
  PowerSource source_{kAtOnce};
  double time_ = 0.0;
};

/// From full to kEmpty at the discharge's current [Ah].
double usableOf(const DeepCycle& cycle) {
  const PorousBlock battery(cycle.block, 1.0, kSecond);
  PorousState state = battery.rested();
  double drawn = 0.0;
  do {
    state = battery.advance(state, -cycle.discharge_a);
    drawn += cycle.discharge_a * kSecond;
  } while (battery.voltage(state) > kEmpty);
  return drawn / kSecondsPerHour;
}

void drawBlock(DeepCycle& cycle, Dice& dice) {
  PorousParameters& block = cycle.block;
  const double size = dice.logBetween({0.1, 2.0});
  block.capacity_ah *= size;
  block.area_m2 *= size;
  block.grid_ohm *= dice.between({0.8, 1.6}) / size;
  block.full_acid_mol_per_m3 = dice.between({5200.0, 5900.0});
  block.diffusion_factor = dice.between({0.6, 1.6});
  block.negative.exchange_a_per_m2 = dice.logBetween({0.03, 0.12});
  block.positive.exchange_a_per_m2 = dice.logBetween({0.002, 0.008});
  block.gassing = true;
  block.gas_current_a *= size;
}

}  // namespace

DeepCycle drawDeepCycle(const Order& order) {
  if (order.duration || order.rate || !order.drive.empty() || order.scale != std::vector{1.0})
    throw std::invalid_argument("of deep_cycle the seed chooses duration, rate, drive and scale");
  DeepCycle cycle;
  cycle.order = order;
  Dice dice(order.seed, kStream);
  drawBlock(cycle, dice);
  const double capacity = cycle.block.capacity_ah;
  cycle.plan = dice.oneOf(kDeepPlans);
  cycle.discharge_a = dice.logBetween({0.04, 0.25}) * capacity;
  cycle.charge_a = dice.between({0.08, 0.2}) * capacity;
  cycle.charge_v = dice.between({14.1, 14.7});
  cycle.row_s = dice.oneOf(std::array{1.0, 10.0, 30.0, 60.0});
  cycle.voltage_noise = dice.between({0.5e-3, 3e-3});
  cycle.usable_ah = usableOf(cycle);
  if (cycle.plan == kDeepPlans[1]) cycle.soc_at_start = dice.between({0.4, 0.7});
  const double depth = dice.between({0.5, 0.95});
  Bench bench(cycle, dice);
  bench.rest(dice.between({600.0, 3600.0}));
  if (cycle.plan == kDeepPlans[1]) {
    bench.charge();
    bench.rest(dice.between({1200.0, 7200.0}));
  }
  if (cycle.plan == kDeepPlans[2]) {
    bench.discharge(kEmpty, capacity);
    bench.rest(dice.between({1200.0, 7200.0}));
    bench.charge();
    bench.rest(dice.between({1200.0, 7200.0}));
  }
  bench.discharge(kEmpty, depth * cycle.usable_ah);
  bench.rest(dice.between({1200.0, 7200.0}));
  cycle.soc_at_end = bench.soc();
  return cycle;
}

std::string labelOf(const DeepCycle& one) {
  const nlohmann::json json = {{"schema", "battery_sof/scenario/1"},
                               {"kind", one.order.what.kind},
                               {"id", nullptr},
                               {"seed", one.order.seed},
                               {"plan", one.plan},
                               {"mechanisms", {"open_circuit", "acid"}},
                               {"usable_ah", one.usable_ah},
                               {"nominal_ah", one.block.capacity_ah},
                               {"discharge_a", one.discharge_a},
                               {"charge_a", one.charge_a},
                               {"charge_v", one.charge_v},
                               {"row_s", one.row_s},
                               {"soc_at_start", one.soc_at_start},
                               {"soc_at_end", one.soc_at_end}};
  return json.dump(2) + "\n";
}

}  // namespace battery_sof_simulator
