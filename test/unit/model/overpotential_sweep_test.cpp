#include "model/overpotential_sweep.hpp"

#include <gtest/gtest.h>

#include "model/input_sequence.hpp"
#include "support/base_drive.hpp"

namespace battery_sof {
namespace {

std::vector<Overpotential> stepByStep(const std::vector<HeldCurrent>& held, const BaseParameters& p,
                                      double first) {
  const test::BaseStep step(p);
  std::vector<Overpotential> states;
  Overpotential state{first, 1.0, 0.0, 0.0};
  for (const HeldCurrent& h : held) {
    state = step.advance(state, h.current, h.duration);
    states.push_back(state);
  }
  return states;
}

std::vector<HeldCurrent> heldCurrents(const Series& series) {
  std::vector<HeldCurrent> held = {{series.current[0], 0.0}};
  for (std::size_t n = 1; n < series.size(); ++n)
    held.push_back(heldCurrent(series.time[n - 1], series.current[n - 1], series.time[n],
                               series.current[n], 5.0));
  return held;
}

OverpotentialSweep drivenBy(const std::vector<HeldCurrent>& held) {
  OverpotentialSweep sweep(held.size());
  for (Eigen::Index block = 0; block < sweep.blocks(); ++block) {
    HeldBlock in_lanes = {};
    for (int k = 0; k < kBlockSize; ++k) {
      const auto n = static_cast<std::size_t>(block * kBlockSize + k);
      if (n >= held.size()) break;
      in_lanes.current[lanePosition(k)] = held[n].current;
      in_lanes.duration[lanePosition(k)] = held[n].duration;
    }
    sweep.drive(block, in_lanes, 1.0);
  }
  return sweep;
}

TEST(HeldCurrent, IsTheMeanOfItsEndsAndRestAcrossAGap) {
  EXPECT_DOUBLE_EQ(heldCurrent(1.0, -10.0, 1.5, 20.0, 5.0).current, 5.0);
  EXPECT_DOUBLE_EQ(heldCurrent(1.0, -10.0, 1.5, 20.0, 5.0).duration, 0.5);
  EXPECT_DOUBLE_EQ(heldCurrent(1.0, -10.0, 9.0, 20.0, 5.0).current, 0.0);
}

TEST(OverpotentialSweep, EqualsTheStepSampleBySample) {
  // 1000 samples: three whole blocks and a part of one; a gap in the middle; a start away from
  // zero.
  Series series = test::baseDrive(2, 10.0);
  for (std::size_t n = 500; n < series.size(); ++n) series.time[n] += 30.0;
  const auto held = heldCurrents(series);
  for (double beta : {1.0, 22.0, 1000.0}) {
    BaseParameters p = test::drivenBattery();
    p.beta = beta;
    p.c2 = 300.0;
    const double first = 0.5 / beta;
    const auto expected = stepByStep(held, p, first);
    drivenBy(held).run({p.c2, p.beta, first}, widestInstructionSet(),
                       [&](Eigen::Index block, const OverpotentialStates& states) {
                         for (int j = 0; j < kBlockSize; ++j) {
                           const auto n = static_cast<std::size_t>(block * kBlockSize + j);
                           if (n >= expected.size()) break;
                           const int k = lanePosition(j);
                           const double scale = 1.0 / beta;
                           EXPECT_NEAR(states.u_c2[k], expected[n].value, 1e-11 * scale);
                           EXPECT_NEAR(states.d_log_c2[k], expected[n].d_c2 * p.c2, 1e-9 * scale);
                           EXPECT_NEAR(states.d_log_beta[k], expected[n].d_beta * p.beta,
                                       1e-9 * scale);
                           EXPECT_NEAR(states.d_initial[k], expected[n].d_initial, 1e-9);
                         }
                       });
  }
}

TEST(OverpotentialSweep, StaysInRangeWhenEverySampleTurnsTheStateRound) {
  // Within each second the state goes from one end to the other: D underflows, x and y shrink by
  // I_0 / R a step.
  std::vector<HeldCurrent> held;
  for (int n = 0; n < 600; ++n) held.push_back({n % 2 == 0 ? 5000.0 : -5000.0, 1.0});
  BaseParameters p;
  p.beta = 1000.0;
  p.c2 = 100.0;
  const auto expected = stepByStep(held, p, -0.6);
  const double rounding = 1e-8;  // of 1 - charging, which is (I_0 / R)^2 = 4e-8 here
  drivenBy(held).run(
      {p.c2, p.beta, -0.6}, widestInstructionSet(),
      [&](Eigen::Index block, const OverpotentialStates& states) {
        for (int j = 0; j < kBlockSize; ++j) {
          const auto n = static_cast<std::size_t>(block * kBlockSize + j);
          if (n >= expected.size()) break;
          const int k = lanePosition(j);
          EXPECT_NEAR(states.u_c2[k], expected[n].value, rounding / p.beta) << n;
          EXPECT_NEAR(states.d_log_beta[k], expected[n].d_beta * p.beta, rounding / p.beta) << n;
          EXPECT_NEAR(states.d_initial[k], expected[n].d_initial, 1e-9) << n;
        }
      });
}

TEST(OverpotentialSweep, IsTheSameOnEveryInstructionSetOfThisProcessor) {
  const Series series = test::baseDrive(2, 10.0);
  const auto held = heldCurrents(series);
  const OverpotentialSweep sweep = drivenBy(held);
  const OverpotentialSweep::Point point{900.0, 25.0, 0.03};
  std::vector<OverpotentialStates> expected;
  sweep.run(point, InstructionSet::kPlain,
            [&](Eigen::Index, const auto& states) { expected.push_back(states); });
  for (const auto set : {InstructionSet::kAvx2, InstructionSet::kAvx512}) {
    if (set > widestInstructionSet()) continue;
    sweep.run(point, set, [&](Eigen::Index block, const OverpotentialStates& states) {
      const OverpotentialStates& plain = expected[static_cast<std::size_t>(block)];
      for (int k = 0; k < kBlockSize; ++k) {
        EXPECT_NEAR(states.u_c2[k], plain.u_c2[k], 1e-12);
        EXPECT_NEAR(states.d_log_c2[k], plain.d_log_c2[k], 1e-11);
        EXPECT_NEAR(states.d_log_beta[k], plain.d_log_beta[k], 1e-11);
        EXPECT_NEAR(states.d_initial[k], plain.d_initial[k], 1e-11);
      }
    });
  }
}

}  // namespace
}  // namespace battery_sof
