#include "model/regressors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "regressor_kernel.hpp"

#include "util/text.hpp"

namespace battery_sof {
namespace {

using Kind = RegressorKind;
using Group = RegressorGroup;

// [s]
constexpr std::array<double, 10> kTimes = {0.3,   1.0,   3.0,    10.0,   30.0,
                                           100.0, 300.0, 1000.0, 3000.0, 10000.0};
// [s]
constexpr std::array<double, 6> kEdgeTimes = {0.005, 0.01, 0.02, 0.05, 0.1, 0.15};
constexpr double kFastest = 0.06;  // [s]; sampled more slowly, edges are single samples
// [s]; double layers forget within 10 s: from here on a memory is the acid's
constexpr double kSlowMemory = 30.0;
constexpr std::array<double, 4> kOnsets = {-4.0, -2.0, 0.0, 2.0};  // widths from what is high
// instants at which a contact may have changed
constexpr int kSteps = 6;

class Library {
 public:
  explicit Library(const RegressorContext& context) : context_(context) {}

  std::vector<Regressor> take() {
    takeMemories();
    takeReserves();
    takeStatic();
    takeCharge();
    takeEdges();
    takeOverpotential();
    takeTime();
    return std::move(regressors_);
  }

 private:
  bool fits(double time) const {
    return time >= 0.9 * context_.interval && time < context_.span / 3.0;
  }

  void add(Mechanism mechanism, Kind kind, double time = 0.0, double scale = 0.0,
           double charge = 0.0) {
    regressors_.push_back({kind, mechanism, time, scale, charge});
  }

  void takeMemories() {
    for (const double time : kTimes) {
      if (!fits(time)) continue;
      add(Mechanism::kAcceptance, Kind::kChargeMemory, time);
      add(Mechanism::kAcid, Kind::kDischargeMemory, time);
      takeMemory(time >= kSlowMemory ? Mechanism::kAcid : Mechanism::kStructure, time);
      if (time == 3.0 || time == 30.0 || time == 300.0 || time == 3000.0) {
        add(Mechanism::kAcceptance, Kind::kLogChargeMemory, time, 5.0);
        add(Mechanism::kAcid, Kind::kLogDischargeMemory, time, 20.0);
        add(Mechanism::kAcceptance, Kind::kMemoryOfCharging, time, 2.0);
      }
    }
  }

  /// Alike in both directions of the current.
  void takeMemory(Mechanism mechanism, double time) {
    add(mechanism, Kind::kMemory, time);
    if (time != 1.0 && time != 10.0 && time != 100.0 && time != 1000.0) return;
    add(mechanism, Kind::kCompressedMemory, time, 5.0);
    add(mechanism, Kind::kMemoryOfCompressed, time, 5.0);
  }

  void takeReserves() {
    for (const double time : {10.0, 100.0, 1000.0})
      for (const double scale : {50.0, 500.0}) {
        if (!fits(time)) continue;
        add(Mechanism::kAcceptance, Kind::kFresh, time, scale);
        add(Mechanism::kAcceptance, Kind::kFreshCharging, time, scale);
      }
    for (const double scale : {50.0, 200.0, 800.0})
      for (const double time : {20.0, 60.0, 200.0})
        if (fits(time)) add(Mechanism::kAcceptance, Kind::kAcceptanceReserve, time, scale);
    for (const double scale : {500.0, 2000.0})
      for (const double time : {30.0, 300.0})
        if (fits(time)) add(Mechanism::kAcid, Kind::kDischargeReserve, time, scale);
    for (const double scale : {10.0, 30.0, 100.0, 300.0, 1000.0})
      add(Mechanism::kOpenCircuit, Kind::kSinceCharge, 0.0, scale);
  }

  void takeStatic() {
    for (const double scale : {1.0, 5.0, 25.0})
      add(Mechanism::kStructure, Kind::kCompressed, 0.0, scale);
    add(Mechanism::kStructure, Kind::kSaturating, 0.0, 3.0);
    for (const double scale : {5.0, 50.0})
      add(Mechanism::kStructure, Kind::kLogMagnitude, 0.0, scale);
    add(Mechanism::kStructure, Kind::kSmallCurrent, 0.0, 10.0);
    add(Mechanism::kStructure, Kind::kRest, 0.0, 5.0);
  }

  void takeCharge() {
    add(Mechanism::kOpenCircuit, Kind::kCharge);
    add(Mechanism::kOpenCircuit, Kind::kChargeSquared);
    for (const double time : {100.0, 1000.0})
      if (fits(time)) add(Mechanism::kOpenCircuit, Kind::kSlowCharge, time);
    for (const double scale : {100.0, 400.0, 1600.0})
      add(Mechanism::kOpenCircuit, Kind::kPath, 0.0, scale);
  }

  void takeEdges() {
    add(Mechanism::kInstrument, Kind::kChange);
    add(Mechanism::kInstrument, Kind::kChangeBefore);
    if (context_.interval >= kFastest) return;
    for (const double time : kEdgeTimes)
      if (time >= 0.4 * context_.interval) add(Mechanism::kStructure, Kind::kEdge, time);
  }

  void takeOverpotential() {
    const double scale = context_.beta / 4.0;
    add(Mechanism::kStructure, Kind::kOverpotentialMagnitude);
    add(Mechanism::kStructure, Kind::kOverpotentialSquared, 0.0, scale);
    add(Mechanism::kStructure, Kind::kOverpotentialCubed, 0.0, scale);
    add(Mechanism::kStructure, Kind::kOverpotentialLogCosh, 0.0, scale);
    for (const double widths : kOnsets) takeHigh(context_.high + widths * context_.high_width);
  }

  /// Where a side reaction sets in is the electrode's and the acid's: several voltages.
  void takeHigh(double onset) {
    add(Mechanism::kSideReactions, Kind::kHighOverpotential, onset, context_.high_width);
    for (const double time : {3.0, 10.0, 30.0, 100.0, 300.0})
      if (fits(time))
        add(Mechanism::kSideReactions, Kind::kHighMemory, onset, context_.high_width, time);
    add(Mechanism::kSideReactions, Kind::kHighSum, onset, context_.high_width);
  }

  void takeTime() {
    for (const Kind kind : {Kind::kTimeCurrent, Kind::kTimeMagnitude, Kind::kTimeSquaredCurrent,
                            Kind::kTimeOverpotential})
      add(Mechanism::kAgeing, kind, 0.0, context_.span);
    for (const double time : {300.0, 1000.0, 3000.0})
      if (fits(time)) add(Mechanism::kAgeing, Kind::kWarmCurrent, time);
    add(Mechanism::kInstrument, Kind::kTime, 0.0, context_.span);
    for (int k = 1; k <= kSteps; ++k)
      add(Mechanism::kInstrument, Kind::kStepCurrent, context_.span * k / (kSteps + 1.0));
  }

  RegressorContext context_;
  std::vector<Regressor> regressors_;
};

struct KindInfo {
  Kind kind;
  const char* id;
  RegressorGroup group;
  /// the words hold the scale, then the time; else the other way round, or neither
  bool scale_first;
  const char* words;  ///< a pattern of printf
};

constexpr KindInfo kKinds[] = {
    {Kind::kChargeMemory, "charge_memory", Group::kCharge, false, "memory of charging over %g s"},
    {Kind::kDischargeMemory, "discharge_memory", Group::kDischarge, false,
     "memory of discharging over %g s"},
    {Kind::kMemory, "memory", Group::kCurrent, false, "memory of the current over %g s"},
    {Kind::kLogChargeMemory, "log_charge_memory", Group::kCharge, false,
     "memory of charging over %g s"},
    {Kind::kLogDischargeMemory, "log_discharge_memory", Group::kDischarge, false,
     "memory of discharging over %g s"},
    {Kind::kCompressedMemory, "compressed_memory", Group::kCurrent, false,
     "memory of the current over %g s"},
    {Kind::kMemoryOfCompressed, "memory_of_compressed", Group::kCurrent, false,
     "memory of the current over %g s"},
    {Kind::kMemoryOfCharging, "memory_of_charging", Group::kCharge, false,
     "memory of charging over %g s"},
    {Kind::kFresh, "fresh", Group::kCharge, false, "what was discharged in the last %g s (%g As)"},
    {Kind::kFreshCharging, "fresh_charging", Group::kCharge, false,
     "what was discharged in the last %g s (%g As)"},
    {Kind::kAcceptanceReserve, "acceptance_reserve", Group::kCharge, true,
     "a reserve of %g As that charging empties and %g s refill"},
    {Kind::kDischargeReserve, "discharge_reserve", Group::kDischarge, true,
     "a reserve of %g As that discharging empties and %g s refill"},
    {Kind::kSinceCharge, "since_charge", Group::kDischarge, true, "the first %g As of a discharge"},
    {Kind::kCompressed, "compressed", Group::kStatic, true,
     "a static curve of the current, bent at %g A"},
    {Kind::kSaturating, "saturating", Group::kStatic, true,
     "a static curve of the current, bent at %g A"},
    {Kind::kLogMagnitude, "log_magnitude", Group::kStatic, true,
     "a static curve of the current, bent at %g A"},
    {Kind::kSmallCurrent, "small_current", Group::kStatic, true,
     "a static curve of the current, bent at %g A"},
    {Kind::kRest, "rest", Group::kStatic, true, "a static curve of the current, bent at %g A"},
    {Kind::kCharge, "charge", Group::kChargeCounted, false, "charge moved"},
    {Kind::kChargeSquared, "charge_squared", Group::kChargeCounted, false, "charge moved"},
    {Kind::kSlowCharge, "slow_charge", Group::kChargeCounted, false, "charge moved, %g s late"},
    {Kind::kPath, "path", Group::kChargeCounted, true, "the direction of the last %g As"},
    {Kind::kEdge, "edge", Group::kEdges, false, "edges of the current within %g s"},
    {Kind::kChange, "change", Group::kEdges, false, "edges of the current"},
    {Kind::kChangeBefore, "change_before", Group::kEdges, false, "edges of the current"},
    {Kind::kOverpotentialMagnitude, "overpotential_magnitude", Group::kKinetics, false,
     "curvature of the kinetics"},
    {Kind::kOverpotentialSquared, "overpotential_squared", Group::kKinetics, false,
     "curvature of the kinetics"},
    {Kind::kOverpotentialCubed, "overpotential_cubed", Group::kKinetics, false,
     "curvature of the kinetics"},
    {Kind::kOverpotentialLogCosh, "overpotential_log_cosh", Group::kKinetics, false,
     "curvature of the kinetics"},
    {Kind::kHighOverpotential, "high_overpotential", Group::kHighVoltage, false, "high voltage"},
    {Kind::kHighMemory, "high_memory", Group::kHighVoltage, false, "high voltage"},
    {Kind::kHighSum, "high_sum", Group::kHighVoltage, false, "high voltage"},
    {Kind::kTimeCurrent, "time_current", Group::kTime, false, "a resistance that drifts"},
    {Kind::kTimeMagnitude, "time_magnitude", Group::kTime, false, "a resistance that drifts"},
    {Kind::kTimeSquaredCurrent, "time_squared_current", Group::kTime, false,
     "a resistance that drifts"},
    {Kind::kTimeOverpotential, "time_overpotential", Group::kTime, false, "kinetics that drift"},
    {Kind::kWarmCurrent, "warm_current", Group::kTime, false,
     "a resistance that follows the heat of %g s"},
    {Kind::kTime, "time", Group::kTime, false, "a drift of the voltage"},
    {Kind::kStepCurrent, "step_current", Group::kTime, false, "a resistance that steps at %g s"},
};

const KindInfo& infoOf(Kind kind) {
  for (const KindInfo& info : kKinds)
    if (info.kind == kind) return info;
  throw std::logic_error("a regressor of an unknown kind");
}

}  // namespace

std::string kindId(RegressorKind kind) { return infoOf(kind).id; }

std::vector<RegressorKind> allRegressorKinds() {
  std::vector<RegressorKind> kinds;
  for (const KindInfo& info : kKinds) kinds.push_back(info.kind);
  return kinds;
}

RegressorGroup groupOf(RegressorKind kind) { return infoOf(kind).group; }

std::vector<Regressor> regressorLibrary(const RegressorContext& context) {
  return Library(context).take();
}

void LowPassShares::take(const std::vector<Regressor>& regressors, double of_duration) {
  if (of_duration == duration) return;
  duration = of_duration;
  share.resize(regressors.size());
  for (std::size_t k = 0; k < regressors.size(); ++k) {
    const Regressor& regressor = regressors[k];
    const double time =
        regressor.kind == RegressorKind::kHighMemory ? regressor.charge : regressor.time;
    share[k] = time > 0.0 ? -std::expm1(-duration / time) : 0.0;
  }
}

RegressorMemory::RegressorMemory(std::vector<Regressor> regressors, RegressorContext context)
    : regressors_(std::move(regressors)),
      context_(context),
      state_(freshRegressorStates(regressors_)) {}

void RegressorMemory::advance(const RegressorInput& moment, Eigen::Ref<Eigen::VectorXd> values) {
  RegressorKernel<double>{regressors_, context_, shares_, state_.data()}.advance(moment,
                                                                                 values.data());
}

std::string toString(const Regressor& regressor) {
  const KindInfo& info = infoOf(regressor.kind);
  return format(info.words, info.scale_first ? regressor.scale : regressor.time,
                info.scale_first ? regressor.time : regressor.scale);
}

}  // namespace battery_sof
