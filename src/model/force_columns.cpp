#include "battery_sof/model/force_columns.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "force_kernel.hpp"

#include "battery_sof/recording/words.hpp"

namespace battery_sof {
namespace {

constexpr std::array<double, 10> kTimes = {0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0, 10000.0};  // [s]
constexpr std::array<double, 6> kEdgeTimes = {0.005, 0.01, 0.02, 0.05, 0.1, 0.15};                             // [s]
constexpr double kFastest = 0.06;     // [s]; sampled more slowly, edges are single samples
constexpr double kSlowMemory = 30.0;  // [s]; double layers forget within 10 s: from here on a memory is the acid's
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

struct KindInfo {
  ForceKind kind;
  const char* id;
  ForceGroup group;
  bool scale_first;   ///< the words hold the scale, then the time; else the other way round, or neither
  const char* words;  ///< a pattern of printf
};

constexpr KindInfo kKinds[] = {
    {ForceKind::kChargeMemory, "charge_memory", ForceGroup::kCharge, false, "memory of charging over %g s"},
    {ForceKind::kDischargeMemory, "discharge_memory", ForceGroup::kDischarge, false, "memory of discharging over %g s"},
    {ForceKind::kMemory, "memory", ForceGroup::kCurrent, false, "memory of the current over %g s"},
    {ForceKind::kLogChargeMemory, "log_charge_memory", ForceGroup::kCharge, false, "memory of charging over %g s"},
    {ForceKind::kLogDischargeMemory, "log_discharge_memory", ForceGroup::kDischarge, false, "memory of discharging over %g s"},
    {ForceKind::kCompressedMemory, "compressed_memory", ForceGroup::kCurrent, false, "memory of the current over %g s"},
    {ForceKind::kMemoryOfCompressed, "memory_of_compressed", ForceGroup::kCurrent, false, "memory of the current over %g s"},
    {ForceKind::kMemoryOfCharging, "memory_of_charging", ForceGroup::kCharge, false, "memory of charging over %g s"},
    {ForceKind::kFresh, "fresh", ForceGroup::kCharge, false, "what was discharged in the last %g s (%g As)"},
    {ForceKind::kFreshCharging, "fresh_charging", ForceGroup::kCharge, false, "what was discharged in the last %g s (%g As)"},
    {ForceKind::kAcceptanceReserve, "acceptance_reserve", ForceGroup::kCharge, true,
     "a reserve of %g As that charging empties and %g s refill"},
    {ForceKind::kDischargeReserve, "discharge_reserve", ForceGroup::kDischarge, true,
     "a reserve of %g As that discharging empties and %g s refill"},
    {ForceKind::kSinceCharge, "since_charge", ForceGroup::kDischarge, true, "the first %g As of a discharge"},
    {ForceKind::kCompressed, "compressed", ForceGroup::kStatic, true, "a static curve of the current, bent at %g A"},
    {ForceKind::kSaturating, "saturating", ForceGroup::kStatic, true, "a static curve of the current, bent at %g A"},
    {ForceKind::kLogMagnitude, "log_magnitude", ForceGroup::kStatic, true, "a static curve of the current, bent at %g A"},
    {ForceKind::kSmallCurrent, "small_current", ForceGroup::kStatic, true, "a static curve of the current, bent at %g A"},
    {ForceKind::kRest, "rest", ForceGroup::kStatic, true, "a static curve of the current, bent at %g A"},
    {ForceKind::kCharge, "charge", ForceGroup::kChargeCounted, false, "charge moved"},
    {ForceKind::kChargeSquared, "charge_squared", ForceGroup::kChargeCounted, false, "charge moved"},
    {ForceKind::kSlowCharge, "slow_charge", ForceGroup::kChargeCounted, false, "charge moved, %g s late"},
    {ForceKind::kPath, "path", ForceGroup::kChargeCounted, true, "the direction of the last %g As"},
    {ForceKind::kEdge, "edge", ForceGroup::kEdges, false, "edges of the current within %g s"},
    {ForceKind::kChange, "change", ForceGroup::kEdges, false, "edges of the current"},
    {ForceKind::kChangeBefore, "change_before", ForceGroup::kEdges, false, "edges of the current"},
    {ForceKind::kOverpotentialMagnitude, "overpotential_magnitude", ForceGroup::kKinetics, false, "curvature of the kinetics"},
    {ForceKind::kOverpotentialSquared, "overpotential_squared", ForceGroup::kKinetics, false, "curvature of the kinetics"},
    {ForceKind::kOverpotentialCubed, "overpotential_cubed", ForceGroup::kKinetics, false, "curvature of the kinetics"},
    {ForceKind::kOverpotentialLogCosh, "overpotential_log_cosh", ForceGroup::kKinetics, false, "curvature of the kinetics"},
    {ForceKind::kHighOverpotential, "high_overpotential", ForceGroup::kHighVoltage, false, "high voltage"},
    {ForceKind::kHighMemory, "high_memory", ForceGroup::kHighVoltage, false, "high voltage"},
    {ForceKind::kHighSum, "high_sum", ForceGroup::kHighVoltage, false, "high voltage"},
    {ForceKind::kTimeCurrent, "time_current", ForceGroup::kTime, false, "a resistance that drifts"},
    {ForceKind::kTimeMagnitude, "time_magnitude", ForceGroup::kTime, false, "a resistance that drifts"},
    {ForceKind::kTimeSquaredCurrent, "time_squared_current", ForceGroup::kTime, false, "a resistance that drifts"},
    {ForceKind::kTimeOverpotential, "time_overpotential", ForceGroup::kTime, false, "kinetics that drift"},
    {ForceKind::kWarmCurrent, "warm_current", ForceGroup::kTime, false, "a resistance that follows the heat of %g s"},
    {ForceKind::kTime, "time", ForceGroup::kTime, false, "a drift of the voltage"},
    {ForceKind::kStepCurrent, "step_current", ForceGroup::kTime, false, "a resistance that steps at %g s"},
};

const KindInfo& infoOf(ForceKind kind) {
  for (const KindInfo& info : kKinds)
    if (info.kind == kind) return info;
  throw std::logic_error("a column of an unknown kind");
}

}  // namespace

std::string kindId(ForceKind kind) { return infoOf(kind).id; }

std::vector<ForceKind> allForceKinds() {
  std::vector<ForceKind> kinds;
  for (const KindInfo& info : kKinds) kinds.push_back(info.kind);
  return kinds;
}

ForceGroup groupOf(ForceKind kind) { return infoOf(kind).group; }

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
  const KindInfo& info = infoOf(column.kind);
  return sentence(info.words, info.scale_first ? column.scale : column.time, info.scale_first ? column.time : column.scale);
}

}  // namespace battery_sof
