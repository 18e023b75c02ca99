#include "model/regressors.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <stdexcept>

#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

constexpr double kStep = 0.1;  // [s]

RegressorContext tenMinutes() {
  RegressorContext context;
  context.interval = kStep;
  context.span = 600.0;
  context.high = 0.15;
  return context;
}

/// Held currents of some seconds, cranks among them, and an hour's gap in the middle.
std::vector<RegressorInput> drive(std::size_t count, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<RegressorInput> moments;
  double current = 0.0, time = 0.0;
  for (std::size_t n = 0; n < count; ++n) {
    const double before = current;
    if (random.uniform(0.0, 1.0) < 0.03)
      current = random.uniform(0.0, 1.0) < 0.2 ? random.uniform(-800.0, -200.0)
                                               : random.uniform(-80.0, 80.0);
    const bool gap = n == count / 2;
    const double duration = n == 0 ? 0.0 : gap ? 3600.0 : kStep;
    time += duration;
    moments.push_back({duration, current, gap ? 0.0 : 0.5 * (before + current), gap,
                       random.uniform(-0.4, 0.4), time});
  }
  return moments;
}

std::vector<RegressorInput> held(double current, std::size_t count) {
  std::vector<RegressorInput> moments = {{}};
  for (std::size_t n = 1; n < count; ++n)
    moments.push_back({kStep, current, current, false, 0.0, kStep * static_cast<double>(n)});
  return moments;
}

TEST(RegressorLibrary, NumbersThatAKindHasNotAreZero) {
  for (const Regressor& one : regressorLibrary(tenMinutes()))
    EXPECT_TRUE(one.kind == RegressorKind::kHighMemory || one.charge == 0.0) << kindId(one.kind);
}

/// A row a moment.
Eigen::MatrixXd valuesAlong(RegressorMemory& memory, const std::vector<RegressorInput>& moments) {
  Eigen::MatrixXd values(static_cast<Eigen::Index>(memory.regressors().size()),
                         static_cast<Eigen::Index>(moments.size()));
  for (std::size_t n = 0; n < moments.size(); ++n)
    memory.advance(moments[n], values.col(static_cast<Eigen::Index>(n)));
  return values.transpose();
}

/// The last value of one regressor.
double lastOf(const Regressor& regressor, const std::vector<RegressorInput>& moments) {
  RegressorMemory memory({regressor}, tenMinutes());
  return valuesAlong(memory, moments).bottomRows(1)(0, 0);
}

/// How long a regressor remembers [s]; 0 for one whose numbers mean something else.
double slowness(const Regressor& regressor) {
  switch (regressor.kind) {
    case RegressorKind::kHighMemory: return regressor.charge;
    case RegressorKind::kHighOverpotential:
    case RegressorKind::kHighSum:
    case RegressorKind::kStepCurrent: return 0.0;
    default: return regressor.time;
  }
}

TEST(Regressors, LowPassesAnswerAStepByTheirClosedForm) {
  const std::size_t count = 301;
  const double time = kStep * static_cast<double>(count - 1), rise = -std::expm1(-time / 20.0);
  EXPECT_NEAR(30.0 * rise,
              lastOf({RegressorKind::kMemory, Mechanism::kStructure, 20.0}, held(30.0, count)),
              1e-10);
  EXPECT_NEAR(-30.0 * rise,
              lastOf({RegressorKind::kMemory, Mechanism::kStructure, 20.0}, held(-30.0, count)),
              1e-10);
  EXPECT_NEAR(
      30.0 * rise,
      lastOf({RegressorKind::kChargeMemory, Mechanism::kAcceptance, 20.0}, held(30.0, count)),
      1e-10);
  EXPECT_EQ(0.0, lastOf({RegressorKind::kChargeMemory, Mechanism::kAcceptance, 20.0},
                        held(-30.0, count)));
  EXPECT_NEAR(30.0 * rise,
              lastOf({RegressorKind::kDischargeMemory, Mechanism::kAcid, 20.0}, held(-30.0, count)),
              1e-10);
  EXPECT_NEAR(30.0 * (1.0 - rise),
              lastOf({RegressorKind::kEdge, Mechanism::kStructure, 20.0}, held(30.0, count)),
              1e-10);
  EXPECT_NEAR(std::log1p(30.0 * rise / 5.0),
              lastOf({RegressorKind::kLogChargeMemory, Mechanism::kAcceptance, 20.0, 5.0},
                     held(30.0, count)),
              1e-10);
}

TEST(Regressors, AReserveIsEmptiedAndFilledByItsClosedForm) {
  const double current = 20.0, time = 60.0, charge = 200.0;
  const double filling = 1.0 / time, emptying = current / charge,
               end = filling / (filling + emptying);
  const double left = end + (1.0 - end) * std::exp(-30.0 * (filling + emptying));
  const Regressor reserve{RegressorKind::kAcceptanceReserve, Mechanism::kAcceptance, time, charge};
  EXPECT_NEAR(-std::log(left), lastOf(reserve, held(current, 301)), 1e-10);
  EXPECT_NEAR(0.0, lastOf(reserve, held(-current, 301)), 1e-12) << "a full reserve stays full";
  EXPECT_NEAR(std::log(left),
              lastOf({RegressorKind::kDischargeReserve, Mechanism::kAcid, time, charge},
                     held(-current, 301)),
              1e-10);
}

TEST(Regressors, ChargeIsCountedInAmpereHoursAndItsPathByWhatFlowed) {
  const double hours = 30.0 / 3600.0;
  EXPECT_NEAR(40.0 * hours,
              lastOf({RegressorKind::kCharge, Mechanism::kOpenCircuit}, held(40.0, 301)), 1e-12);
  EXPECT_NEAR(1.0 - std::exp(-40.0 * 30.0 / 400.0),
              lastOf({RegressorKind::kPath, Mechanism::kOpenCircuit, 0.0, 400.0}, held(40.0, 301)),
              1e-10);
  EXPECT_NEAR(
      std::exp(-10.0 * 30.0 / 300.0),
      lastOf({RegressorKind::kSinceCharge, Mechanism::kOpenCircuit, 0.0, 300.0}, held(-10.0, 301)),
      1e-10);
}

/// What has drifted stays as the training part left it: its clock runs from 0 to the span and no
/// further.
TEST(Regressors, AClockStandsStillBeforeAndBehindWhatWasLearntFrom) {
  const auto at = [](RegressorKind kind, double time) {
    return lastOf({kind, Mechanism::kAgeing}, {{kStep, 30.0, 30.0, false, 0.2, time}});
  };
  for (const RegressorKind kind : {RegressorKind::kTimeCurrent, RegressorKind::kTimeMagnitude,
                                   RegressorKind::kTimeSquaredCurrent}) {
    EXPECT_NEAR(30.0, at(kind, 600.0), 1e-12);
    EXPECT_EQ(at(kind, 600.0), at(kind, 6000.0)) << "kind " << kindId(kind);
    EXPECT_EQ(0.0, at(kind, -50.0)) << "kind " << kindId(kind);
  }
  EXPECT_NEAR(0.1, at(RegressorKind::kTimeOverpotential, 300.0), 1e-12);
  EXPECT_EQ(1.0, at(RegressorKind::kTime, 1e9));
}

TEST(Regressors, AGapIsARestThatMovesNoCharge) {
  std::vector<RegressorInput> moments = held(30.0, 301);
  moments.push_back({20.0, 30.0, 0.0, true, 0.0, 50.0});
  const double before = -30.0 * std::expm1(-30.0 / 20.0);
  EXPECT_NEAR(before * std::exp(-1.0),
              lastOf({RegressorKind::kMemory, Mechanism::kStructure, 20.0}, moments), 1e-10);
  EXPECT_NEAR(30.0 * 30.0 / 3600.0,
              lastOf({RegressorKind::kCharge, Mechanism::kOpenCircuit}, moments), 1e-12);
}

TEST(RegressorMemory, BeginsAtTheFirstSamplesValue) {
  EXPECT_EQ(25.0, lastOf({RegressorKind::kMemory, Mechanism::kStructure, 100.0},
                         {{0.0, 25.0, 25.0, false, 0.0, 0.0}}));
  EXPECT_EQ(0.0, lastOf({RegressorKind::kEdge, Mechanism::kStructure, 0.1},
                        {{0.0, 25.0, 25.0, false, 0.0, 0.0}}));
  EXPECT_EQ(0.0, lastOf({RegressorKind::kChange, Mechanism::kInstrument},
                        {{0.0, 25.0, 25.0, false, 0.0, 0.0}}));
}

TEST(RegressorMemory, ALaterSampleChangesNoEarlierValue) {
  std::vector<RegressorInput> moments = drive(1000, 5), others = moments;
  const std::vector<RegressorInput> elsewhere = drive(1000, 6);
  std::copy(elsewhere.begin() + 600, elsewhere.end(), others.begin() + 600);
  RegressorMemory one(regressorLibrary(tenMinutes()), tenMinutes()), other = one;
  const Eigen::MatrixXd a = valuesAlong(one, moments), b = valuesAlong(other, others);
  EXPECT_TRUE(a.topRows(600) == b.topRows(600));
  EXPECT_FALSE(a.bottomRows(400) == b.bottomRows(400));
}

TEST(RegressorMemory, EveryValueOfARandomDriveIsFinite) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    RegressorMemory memory(regressorLibrary(tenMinutes()), tenMinutes());
    const Eigen::MatrixXd values = valuesAlong(memory, drive(3000, seed));
    for (Eigen::Index k = 0; k < values.cols(); ++k)
      EXPECT_TRUE(values.col(k).allFinite())
          << toString(memory.regressors()[static_cast<std::size_t>(k)]) << ", seed " << seed;
  }
}

TEST(RegressorLibrary, HoldsNoColumnSlowerThanAThirdOfTheSpanNorOneFasterThanTheSampling) {
  for (const double span : {30.0, 299.0, 3600.0, 86400.0})
    for (const double interval : {0.01, 0.1, 1.0, 10.0}) {
      RegressorContext context = tenMinutes();
      context.span = span;
      context.interval = interval;
      for (const Regressor& regressor : regressorLibrary(context)) {
        EXPECT_LT(slowness(regressor), span / 3.0) << toString(regressor) << ", span " << span;
        if (slowness(regressor) > 0.0 && regressor.kind != RegressorKind::kEdge) {
          EXPECT_GE(slowness(regressor), 0.9 * interval) << toString(regressor);
        }
        if (regressor.kind == RegressorKind::kStepCurrent) {
          EXPECT_LT(regressor.time, span);
        }
      }
    }
}

TEST(RegressorLibrary, HoldsEveryKindEveryFamilyAndEveryGroupOfALongDrive) {
  RegressorContext context = tenMinutes();
  context.interval = 0.01;
  context.span = 40000.0;
  std::set<RegressorKind> kinds;
  std::set<Mechanism> mechanisms;
  std::set<RegressorGroup> groups;
  for (const Regressor& regressor : regressorLibrary(context)) {
    kinds.insert(regressor.kind);
    mechanisms.insert(regressor.mechanism);
    groups.insert(groupOf(regressor.kind));
    EXPECT_FALSE(toString(regressor).empty());
  }
  EXPECT_EQ(static_cast<std::size_t>(RegressorKind::kStepCurrent) + 1, kinds.size());
  EXPECT_EQ(kMechanisms, mechanisms.size());
  EXPECT_EQ(static_cast<std::size_t>(kRegressorGroups), groups.size());
}

}  // namespace
}  // namespace battery_sof
