// The end of a discharge, foretold from its first half: the battery is a porous block, which shares no
// equation with the model.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "battery_sof/model.hpp"
#include "simulator/porous_block.hpp"

namespace {

using namespace battery_sof;
using battery_sof_simulator::PorousBlock;
using battery_sof_simulator::PorousParameters;
using battery_sof_simulator::PorousState;

constexpr double kEnd = 10.5;       // [V]
constexpr double kRow = 60.0;       // [s]
constexpr double kRested = 1800.0;  // [s], before the discharge

struct Discharge {
  Recording recording;
  // [Ah], what the battery had of it when it was new: it gives 0.75 to 1.05 times as much; [A], below 0
  double nominal, current;
  double end;  // [s], when kEnd is reached
};

/// A rest, then a held current down to kEnd, a row a minute with rounded channels.
Discharge discharged(unsigned seed) {
  std::mt19937 dice(seed);
  const auto drawn = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(dice);
  };
  PorousParameters block;
  const double size = drawn(0.3, 2.0);
  block.area_m2 *= size;
  block.grid_ohm /= size;
  block.capacity_ah *= size;
  block.full_acid_mol_per_m3 = drawn(5200.0, 5900.0);
  block.diffusion_factor = drawn(0.6, 1.6);
  Discharge made{{}, block.capacity_ah, -drawn(0.04, 0.2) * block.capacity_ah, 0.0};
  made.nominal /= drawn(0.75, 1.05);
  const PorousBlock battery(block, 1.0, 1.0);
  PorousState state = battery.rested();
  std::normal_distribution<double> noise(0.0, 0.002);
  double voltage = battery.voltage(state);
  for (double t = 0.0; voltage > kEnd; t += 1.0) {
    const double current = t < kRested ? 0.0 : made.current;
    state = battery.advance(state, current);
    voltage = battery.voltage(state);
    if (std::fmod(t, kRow) == 0.0)
      made.recording.series.append({t, std::round(100.0 * current) / 100.0,
                                    std::round(1e3 * (voltage + noise(dice))) / 1e3});
    made.end = t;
  }
  return made;
}

/// What a question says when a share of the discharge is over.
struct Foretold {
  double left;  // [s], truly
  StopTimeAnswer answer;
};

Foretold foretold(const Discharge& discharge, double share) {
  const double now = kRested + share * (discharge.end - kRested);
  Recording seen;
  for (std::size_t n = 0; n < discharge.recording.series.size(); ++n)
    if (discharge.recording.series.time[n] <= now)
      seen.series.append(discharge.recording.series[n]);
  IdentifyRequest request;
  request.capacity = discharge.nominal;
  const Model model = identify(seen, request);
  EXPECT_TRUE(model.usable()) << model.message();
  const StopTimeQuery query{discharge.current, discharge.current, 1.0, kEnd};
  return {discharge.end - seen.series.time.back(),
          predictStopTime(model, query, discharge.nominal)};
}

TEST(Runtime, IsForetoldFromAThirdOfADischargeOn) {
  int asked = 0, valid = 0, inside = 0;
  std::vector<double> errors, by_capacity;  // the product's, and of 0.95 of the nominal capacity
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const Discharge discharge = discharged(seed);
    for (const double share : {0.3, 0.5, 0.7}) {
      const auto [left, answer] = foretold(discharge, share);
      ++asked;
      ASSERT_TRUE(answer.t_stop) << answer.message;
      valid += answer.valid;
      inside += answer.t_stop->lower <= left && left <= answer.t_stop->upper;
      errors.push_back(std::abs(answer.t_stop->value / left - 1.0));
      const double lasts = -0.95 * 3600.0 * discharge.nominal / discharge.current;  // [s]
      by_capacity.push_back(std::abs((lasts - share * (discharge.end - kRested)) / left - 1.0));
      std::printf(
          "%2u: %5.1f Ah at %5.2f A, %2.0f %% over: %6.0f s left, %6.0f (%6.0f to %6.0f)%s\n", seed,
          discharge.nominal, discharge.current, 100.0 * share, left, answer.t_stop->value,
          answer.t_stop->lower, answer.t_stop->upper,
          answer.valid ? "" : (" " + answer.message).c_str());
    }
  }
  std::sort(errors.begin(), errors.end());
  std::sort(by_capacity.begin(), by_capacity.end());
  std::printf("by the nominal capacity alone: error %.0f %% in the middle, %.0f %% at most\n",
              100.0 * by_capacity[by_capacity.size() / 2], 100.0 * by_capacity.back());
  std::printf("%d of %d valid, %d inside; error %.0f %% in the middle, %.0f %% at most\n", valid,
              asked, inside, 100.0 * errors[errors.size() / 2], 100.0 * errors.back());
  EXPECT_EQ(valid, asked);
  EXPECT_GE(inside, 108);
  EXPECT_LE(errors[errors.size() / 2], 0.08);
  EXPECT_LE(errors[errors.size() / 2], 0.5 * by_capacity[by_capacity.size() / 2]);
  EXPECT_LE(errors.back(), 0.25);
}

}  // namespace
