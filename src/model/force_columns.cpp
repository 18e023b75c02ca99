#include "battery_sof/model/force_columns.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "force_kernel.hpp"

#include "battery_sof/recording/number_text.hpp"

namespace battery_sof {
namespace {

constexpr std::array<double, 10> kTimes = {0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0, 10000.0};  // [s]
constexpr std::array<double, 6> kEdgeTimes = {0.005, 0.01, 0.02, 0.05, 0.1, 0.15};                             // [s]
constexpr double kFastest = 0.06;                                  // [s]; sampled more slowly, edges are single samples
constexpr double kSlowMemory = 100.0;                              // [s]; a memory of the current that lasts longer is the acid's
constexpr std::array<double, 4> kOnsets = {-4.0, -2.0, 0.0, 2.0};  // widths from what is high
constexpr int kSteps = 6;                                          // instants at which a contact may have changed

class Library {
 public:
  explicit Library(const ForceContext& context) : context_(context) {}

  std::vector<ForceColumn> take() {
    takeMemories();
    takeReserves();
    takeStatic();
    takeCharge();
    takeEdges();
    takeOverpotential();
    takeTime();
    return std::move(columns_);
  }

 private:
  bool fits(double time) const { return time >= 0.9 * context_.interval && time < context_.span / 3.0; }

  void add(Family family, ForceKind kind, double time = 0.0, double scale = 0.0, double charge = 0.0) {
    columns_.push_back({kind, family, time, scale, charge});
  }

  void takeMemories() {
    for (const double time : kTimes) {
      if (!fits(time)) continue;
      add(Family::kAcceptance, ForceKind::kChargeMemory, time);
      add(Family::kAcid, ForceKind::kDischargeMemory, time);
      takeMemory(time >= kSlowMemory ? Family::kAcid : Family::kStructure, time);
      if (time == 3.0 || time == 30.0 || time == 300.0 || time == 3000.0) {
        add(Family::kAcceptance, ForceKind::kLogChargeMemory, time, 5.0);
        add(Family::kAcid, ForceKind::kLogDischargeMemory, time, 20.0);
        add(Family::kAcceptance, ForceKind::kMemoryOfCharging, time, 2.0);
      }
    }
  }

  /// Alike in both directions of the current.
  void takeMemory(Family family, double time) {
    add(family, ForceKind::kMemory, time);
    if (time != 1.0 && time != 10.0 && time != 100.0 && time != 1000.0) return;
    add(family, ForceKind::kCompressedMemory, time, 5.0);
    add(family, ForceKind::kMemoryOfCompressed, time, 5.0);
  }

  void takeReserves() {
    for (const double time : {10.0, 100.0, 1000.0})
      for (const double scale : {50.0, 500.0}) {
        if (!fits(time)) continue;
        add(Family::kAcceptance, ForceKind::kFresh, time, scale);
        add(Family::kAcceptance, ForceKind::kFreshCharging, time, scale);
      }
    for (const double scale : {50.0, 200.0, 800.0})
      for (const double time : {20.0, 60.0, 200.0})
        if (fits(time)) add(Family::kAcceptance, ForceKind::kAcceptanceReserve, time, scale);
    for (const double scale : {500.0, 2000.0})
      for (const double time : {30.0, 300.0})
        if (fits(time)) add(Family::kAcid, ForceKind::kDischargeReserve, time, scale);
    for (const double scale : {10.0, 30.0, 100.0, 300.0, 1000.0}) add(Family::kOpenCircuit, ForceKind::kSinceCharge, 0.0, scale);
  }

  void takeStatic() {
    for (const double scale : {1.0, 5.0, 25.0}) add(Family::kStructure, ForceKind::kCompressed, 0.0, scale);
    add(Family::kStructure, ForceKind::kSaturating, 0.0, 3.0);
    for (const double scale : {5.0, 50.0}) add(Family::kStructure, ForceKind::kLogMagnitude, 0.0, scale);
    add(Family::kStructure, ForceKind::kSmallCurrent, 0.0, 10.0);
    add(Family::kStructure, ForceKind::kRest, 0.0, 5.0);
  }

  void takeCharge() {
    add(Family::kOpenCircuit, ForceKind::kCharge);
    add(Family::kOpenCircuit, ForceKind::kChargeSquared);
    for (const double time : {100.0, 1000.0})
      if (fits(time)) add(Family::kOpenCircuit, ForceKind::kSlowCharge, time);
    for (const double scale : {100.0, 400.0, 1600.0}) add(Family::kOpenCircuit, ForceKind::kPath, 0.0, scale);
  }

  void takeEdges() {
    add(Family::kInstrument, ForceKind::kChange);
    add(Family::kInstrument, ForceKind::kChangeBefore);
    if (context_.interval >= kFastest) return;
    for (const double time : kEdgeTimes)
      if (time >= 0.4 * context_.interval) add(Family::kStructure, ForceKind::kEdge, time);
  }

  void takeOverpotential() {
    const double scale = context_.beta / 4.0;
    add(Family::kStructure, ForceKind::kOverpotentialMagnitude);
    add(Family::kStructure, ForceKind::kOverpotentialSquared, 0.0, scale);
    add(Family::kStructure, ForceKind::kOverpotentialCubed, 0.0, scale);
    add(Family::kStructure, ForceKind::kOverpotentialLogCosh, 0.0, scale);
    for (const double widths : kOnsets) takeHigh(context_.high + widths * context_.high_width);
  }

  /// Where a side reaction sets in is the electrode's and the acid's: several voltages.
  void takeHigh(double onset) {
    add(Family::kSideReactions, ForceKind::kHighOverpotential, onset, context_.high_width);
    for (const double time : {3.0, 10.0, 30.0, 100.0, 300.0})
      if (fits(time)) add(Family::kSideReactions, ForceKind::kHighMemory, onset, context_.high_width, time);
    add(Family::kSideReactions, ForceKind::kHighSum, onset, context_.high_width);
  }

  void takeTime() {
    for (const ForceKind kind :
         {ForceKind::kTimeCurrent, ForceKind::kTimeMagnitude, ForceKind::kTimeSquaredCurrent, ForceKind::kTimeOverpotential})
      add(Family::kAgeing, kind, 0.0, context_.span);
    for (const double time : {300.0, 1000.0, 3000.0})
      if (fits(time)) add(Family::kAgeing, ForceKind::kWarmCurrent, time);
    add(Family::kInstrument, ForceKind::kTime, 0.0, context_.span);
    for (int k = 1; k <= kSteps; ++k) add(Family::kInstrument, ForceKind::kStepCurrent, context_.span * k / (kSteps + 1.0));
  }

  ForceContext context_;
  std::vector<ForceColumn> columns_;
};

const std::vector<std::pair<ForceKind, const char*>>& kindIds() {
  using Kind = ForceKind;
  static const std::vector<std::pair<ForceKind, const char*>> ids = {
      {Kind::kChargeMemory, "charge_memory"},
      {Kind::kDischargeMemory, "discharge_memory"},
      {Kind::kMemory, "memory"},
      {Kind::kLogChargeMemory, "log_charge_memory"},
      {Kind::kLogDischargeMemory, "log_discharge_memory"},
      {Kind::kCompressedMemory, "compressed_memory"},
      {Kind::kMemoryOfCompressed, "memory_of_compressed"},
      {Kind::kMemoryOfCharging, "memory_of_charging"},
      {Kind::kFresh, "fresh"},
      {Kind::kFreshCharging, "fresh_charging"},
      {Kind::kAcceptanceReserve, "acceptance_reserve"},
      {Kind::kDischargeReserve, "discharge_reserve"},
      {Kind::kSinceCharge, "since_charge"},
      {Kind::kCompressed, "compressed"},
      {Kind::kSaturating, "saturating"},
      {Kind::kLogMagnitude, "log_magnitude"},
      {Kind::kSmallCurrent, "small_current"},
      {Kind::kRest, "rest"},
      {Kind::kCharge, "charge"},
      {Kind::kChargeSquared, "charge_squared"},
      {Kind::kSlowCharge, "slow_charge"},
      {Kind::kPath, "path"},
      {Kind::kEdge, "edge"},
      {Kind::kChange, "change"},
      {Kind::kChangeBefore, "change_before"},
      {Kind::kOverpotentialMagnitude, "overpotential_magnitude"},
      {Kind::kOverpotentialSquared, "overpotential_squared"},
      {Kind::kOverpotentialCubed, "overpotential_cubed"},
      {Kind::kOverpotentialLogCosh, "overpotential_log_cosh"},
      {Kind::kHighOverpotential, "high_overpotential"},
      {Kind::kHighMemory, "high_memory"},
      {Kind::kHighSum, "high_sum"},
      {Kind::kTimeCurrent, "time_current"},
      {Kind::kTimeMagnitude, "time_magnitude"},
      {Kind::kTimeSquaredCurrent, "time_squared_current"},
      {Kind::kTimeOverpotential, "time_overpotential"},
      {Kind::kWarmCurrent, "warm_current"},
      {Kind::kTime, "time"},
      {Kind::kStepCurrent, "step_current"},
  };
  return ids;
}

}  // namespace

std::string kindId(ForceKind kind) {
  for (const auto& [known, id] : kindIds())
    if (known == kind) return id;
  throw std::logic_error("a column of an unknown kind");
}

std::vector<ForceKind> allForceKinds() {
  std::vector<ForceKind> kinds;
  for (const auto& each : kindIds()) kinds.push_back(each.first);
  return kinds;
}

ForceGroup groupOf(ForceKind kind) {
  switch (kind) {
    case ForceKind::kChargeMemory:
    case ForceKind::kLogChargeMemory:
    case ForceKind::kMemoryOfCharging:
    case ForceKind::kFresh:
    case ForceKind::kFreshCharging:
    case ForceKind::kAcceptanceReserve: return ForceGroup::kCharge;
    case ForceKind::kDischargeMemory:
    case ForceKind::kLogDischargeMemory:
    case ForceKind::kDischargeReserve:
    case ForceKind::kSinceCharge: return ForceGroup::kDischarge;
    case ForceKind::kMemory:
    case ForceKind::kCompressedMemory:
    case ForceKind::kMemoryOfCompressed: return ForceGroup::kCurrent;
    case ForceKind::kCompressed:
    case ForceKind::kSaturating:
    case ForceKind::kLogMagnitude:
    case ForceKind::kSmallCurrent:
    case ForceKind::kRest: return ForceGroup::kStatic;
    case ForceKind::kCharge:
    case ForceKind::kChargeSquared:
    case ForceKind::kSlowCharge:
    case ForceKind::kPath: return ForceGroup::kChargeCounted;
    case ForceKind::kEdge:
    case ForceKind::kChange:
    case ForceKind::kChangeBefore: return ForceGroup::kEdges;
    case ForceKind::kOverpotentialMagnitude:
    case ForceKind::kOverpotentialSquared:
    case ForceKind::kOverpotentialCubed:
    case ForceKind::kOverpotentialLogCosh: return ForceGroup::kKinetics;
    case ForceKind::kHighOverpotential:
    case ForceKind::kHighMemory:
    case ForceKind::kHighSum: return ForceGroup::kHighVoltage;
    case ForceKind::kTimeCurrent:
    case ForceKind::kTimeMagnitude:
    case ForceKind::kTimeSquaredCurrent:
    case ForceKind::kTimeOverpotential:
    case ForceKind::kWarmCurrent:
    case ForceKind::kTime:
    case ForceKind::kStepCurrent: return ForceGroup::kTime;
  }
  throw std::logic_error("a column of an unknown kind");
}

std::vector<ForceColumn> forceLibrary(const ForceContext& context) { return Library(context).take(); }

ForceMemory::ForceMemory(std::vector<ForceColumn> columns, ForceContext context)
    : columns_(std::move(columns)), context_(context), state_(freshColumnStates(columns_)) {}

void ForceMemory::setState(const std::vector<double>& state) {
  if (state.size() != state_.size())
    throw std::invalid_argument("a learnt force's memory has " + std::to_string(state.size()) + " numbers, expected " +
                                std::to_string(state_.size()));
  state_ = state;
}

void ForceMemory::advance(const ForceMoment& moment, Eigen::Ref<Eigen::VectorXd> values) {
  if (moment.duration != share_duration_) {
    share_duration_ = moment.duration;
    takeShares(columns_, moment.duration, share_);
  }
  ColumnKernel<double>{columns_, context_, share_, state_.data()}.advance(moment, values.data());
}

std::string describe(const ForceColumn& column) {
  const auto text = [](const char* format, double one, double two = 0.0) {
    char buffer[120];
    printClassic(buffer, sizeof buffer, format, one, two);
    return std::string(buffer);
  };
  switch (column.kind) {
    case ForceKind::kChargeMemory:
    case ForceKind::kLogChargeMemory:
    case ForceKind::kMemoryOfCharging: return text("memory of charging over %g s", column.time);
    case ForceKind::kDischargeMemory:
    case ForceKind::kLogDischargeMemory: return text("memory of discharging over %g s", column.time);
    case ForceKind::kMemory:
    case ForceKind::kCompressedMemory:
    case ForceKind::kMemoryOfCompressed: return text("memory of the current over %g s", column.time);
    case ForceKind::kFresh:
    case ForceKind::kFreshCharging: return text("what was discharged in the last %g s (%g As)", column.time, column.scale);
    case ForceKind::kAcceptanceReserve: return text("a reserve of %g As that charging empties and %g s refill", column.scale, column.time);
    case ForceKind::kDischargeReserve:
      return text("a reserve of %g As that discharging empties and %g s refill", column.scale, column.time);
    case ForceKind::kSinceCharge: return text("the first %g As of a discharge", column.scale);
    case ForceKind::kCompressed:
    case ForceKind::kSaturating:
    case ForceKind::kLogMagnitude:
    case ForceKind::kSmallCurrent:
    case ForceKind::kRest: return text("a static curve of the current, bent at %g A", column.scale);
    case ForceKind::kCharge:
    case ForceKind::kChargeSquared: return "charge moved";
    case ForceKind::kSlowCharge: return text("charge moved, %g s late", column.time);
    case ForceKind::kPath: return text("the direction of the last %g As", column.scale);
    case ForceKind::kEdge: return text("edges of the current within %g s", column.time);
    case ForceKind::kChange:
    case ForceKind::kChangeBefore: return "edges of the current";
    case ForceKind::kOverpotentialMagnitude:
    case ForceKind::kOverpotentialSquared:
    case ForceKind::kOverpotentialCubed:
    case ForceKind::kOverpotentialLogCosh: return "curvature of the kinetics";
    case ForceKind::kHighOverpotential:
    case ForceKind::kHighMemory:
    case ForceKind::kHighSum: return "high voltage";
    case ForceKind::kTimeCurrent:
    case ForceKind::kTimeMagnitude:
    case ForceKind::kTimeSquaredCurrent: return "a resistance that drifts";
    case ForceKind::kTimeOverpotential: return "kinetics that drift";
    case ForceKind::kWarmCurrent: return text("a resistance that follows the heat of %g s", column.time);
    case ForceKind::kTime: return "a drift of the voltage";
    case ForceKind::kStepCurrent: return text("a resistance that steps at %g s", column.time);
  }
  throw std::logic_error("a column of an unknown kind");
}

}  // namespace battery_sof
