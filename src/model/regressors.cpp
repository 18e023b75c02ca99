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

  void add(Mechanism mechanism, RegressorKind kind, double time = 0.0, double scale = 0.0,
           double charge = 0.0) {
    regressors_.push_back({kind, mechanism, time, scale, charge});
  }

  void takeMemories() {
    for (const double time : kTimes) {
      if (!fits(time)) continue;
      add(Mechanism::kAcceptance, RegressorKind::kChargeMemory, time);
      add(Mechanism::kAcid, RegressorKind::kDischargeMemory, time);
      takeMemory(time >= kSlowMemory ? Mechanism::kAcid : Mechanism::kStructure, time);
      if (time == 3.0 || time == 30.0 || time == 300.0 || time == 3000.0) {
        add(Mechanism::kAcceptance, RegressorKind::kLogChargeMemory, time, 5.0);
        add(Mechanism::kAcid, RegressorKind::kLogDischargeMemory, time, 20.0);
        add(Mechanism::kAcceptance, RegressorKind::kMemoryOfCharging, time, 2.0);
      }
    }
  }

  /// Alike in both directions of the current.
  void takeMemory(Mechanism mechanism, double time) {
    add(mechanism, RegressorKind::kMemory, time);
    if (time != 1.0 && time != 10.0 && time != 100.0 && time != 1000.0) return;
    add(mechanism, RegressorKind::kCompressedMemory, time, 5.0);
    add(mechanism, RegressorKind::kMemoryOfCompressed, time, 5.0);
  }

  void takeReserves() {
    for (const double time : {10.0, 100.0, 1000.0})
      for (const double scale : {50.0, 500.0}) {
        if (!fits(time)) continue;
        add(Mechanism::kAcceptance, RegressorKind::kFresh, time, scale);
        add(Mechanism::kAcceptance, RegressorKind::kFreshCharging, time, scale);
      }
    for (const double scale : {50.0, 200.0, 800.0})
      for (const double time : {20.0, 60.0, 200.0})
        if (fits(time)) add(Mechanism::kAcceptance, RegressorKind::kAcceptanceReserve, time, scale);
    for (const double scale : {500.0, 2000.0})
      for (const double time : {30.0, 300.0})
        if (fits(time)) add(Mechanism::kAcid, RegressorKind::kDischargeReserve, time, scale);
    for (const double scale : {10.0, 30.0, 100.0, 300.0, 1000.0})
      add(Mechanism::kOpenCircuit, RegressorKind::kSinceCharge, 0.0, scale);
  }

  void takeStatic() {
    for (const double scale : {1.0, 5.0, 25.0})
      add(Mechanism::kStructure, RegressorKind::kCompressed, 0.0, scale);
    add(Mechanism::kStructure, RegressorKind::kSaturating, 0.0, 3.0);
    for (const double scale : {5.0, 50.0})
      add(Mechanism::kStructure, RegressorKind::kLogMagnitude, 0.0, scale);
    add(Mechanism::kStructure, RegressorKind::kSmallCurrent, 0.0, 10.0);
    add(Mechanism::kStructure, RegressorKind::kRest, 0.0, 5.0);
  }

  void takeCharge() {
    add(Mechanism::kOpenCircuit, RegressorKind::kCharge);
    add(Mechanism::kOpenCircuit, RegressorKind::kChargeSquared);
    for (const double time : {100.0, 1000.0})
      if (fits(time)) add(Mechanism::kOpenCircuit, RegressorKind::kSlowCharge, time);
    for (const double scale : {100.0, 400.0, 1600.0})
      add(Mechanism::kOpenCircuit, RegressorKind::kPath, 0.0, scale);
  }

  void takeEdges() {
    add(Mechanism::kInstrument, RegressorKind::kChange);
    add(Mechanism::kInstrument, RegressorKind::kChangeBefore);
    if (context_.interval >= kFastest) return;
    for (const double time : kEdgeTimes)
      if (time >= 0.4 * context_.interval) add(Mechanism::kStructure, RegressorKind::kEdge, time);
  }

  void takeOverpotential() {
    const double scale = context_.beta / 4.0;
    add(Mechanism::kStructure, RegressorKind::kOverpotentialMagnitude);
    add(Mechanism::kStructure, RegressorKind::kOverpotentialSquared, 0.0, scale);
    add(Mechanism::kStructure, RegressorKind::kOverpotentialCubed, 0.0, scale);
    add(Mechanism::kStructure, RegressorKind::kOverpotentialLogCosh, 0.0, scale);
    for (const double widths : kOnsets) takeHigh(context_.high + widths * context_.high_width);
  }

  /// Where a side reaction sets in is the electrode's and the acid's: several voltages.
  void takeHigh(double onset) {
    add(Mechanism::kSideReactions, RegressorKind::kHighOverpotential, onset, context_.high_width);
    for (const double time : {3.0, 10.0, 30.0, 100.0, 300.0})
      if (fits(time))
        add(Mechanism::kSideReactions, RegressorKind::kHighMemory, onset, context_.high_width,
            time);
    add(Mechanism::kSideReactions, RegressorKind::kHighSum, onset, context_.high_width);
  }

  void takeTime() {
    for (const RegressorKind kind :
         {RegressorKind::kTimeCurrent, RegressorKind::kTimeMagnitude,
          RegressorKind::kTimeSquaredCurrent, RegressorKind::kTimeOverpotential})
      add(Mechanism::kAgeing, kind, 0.0, context_.span);
    for (const double time : {300.0, 1000.0, 3000.0})
      if (fits(time)) add(Mechanism::kAgeing, RegressorKind::kWarmCurrent, time);
    add(Mechanism::kInstrument, RegressorKind::kTime, 0.0, context_.span);
    for (int k = 1; k <= kSteps; ++k)
      add(Mechanism::kInstrument, RegressorKind::kStepCurrent, context_.span * k / (kSteps + 1.0));
  }

  RegressorContext context_;
  std::vector<Regressor> regressors_;
};

struct KindInfo {
  RegressorKind kind;
  const char* id;
  RegressorGroup group;
  /// the words hold the scale, then the time; else the other way round, or neither
  bool scale_first;
  const char* words;  ///< a pattern of printf
};

constexpr KindInfo kKinds[] = {
    {RegressorKind::kChargeMemory, "charge_memory", RegressorGroup::kCharge, false,
     "memory of charging over %g s"},
    {RegressorKind::kDischargeMemory, "discharge_memory", RegressorGroup::kDischarge, false,
     "memory of discharging over %g s"},
    {RegressorKind::kMemory, "memory", RegressorGroup::kCurrent, false,
     "memory of the current over %g s"},
    {RegressorKind::kLogChargeMemory, "log_charge_memory", RegressorGroup::kCharge, false,
     "memory of charging over %g s"},
    {RegressorKind::kLogDischargeMemory, "log_discharge_memory", RegressorGroup::kDischarge, false,
     "memory of discharging over %g s"},
    {RegressorKind::kCompressedMemory, "compressed_memory", RegressorGroup::kCurrent, false,
     "memory of the current over %g s"},
    {RegressorKind::kMemoryOfCompressed, "memory_of_compressed", RegressorGroup::kCurrent, false,
     "memory of the current over %g s"},
    {RegressorKind::kMemoryOfCharging, "memory_of_charging", RegressorGroup::kCharge, false,
     "memory of charging over %g s"},
    {RegressorKind::kFresh, "fresh", RegressorGroup::kCharge, false,
     "what was discharged in the last %g s (%g As)"},
    {RegressorKind::kFreshCharging, "fresh_charging", RegressorGroup::kCharge, false,
     "what was discharged in the last %g s (%g As)"},
    {RegressorKind::kAcceptanceReserve, "acceptance_reserve", RegressorGroup::kCharge, true,
     "a reserve of %g As that charging empties and %g s refill"},
    {RegressorKind::kDischargeReserve, "discharge_reserve", RegressorGroup::kDischarge, true,
     "a reserve of %g As that discharging empties and %g s refill"},
    {RegressorKind::kSinceCharge, "since_charge", RegressorGroup::kDischarge, true,
     "the first %g As of a discharge"},
    {RegressorKind::kCompressed, "compressed", RegressorGroup::kStatic, true,
     "a static curve of the current, bent at %g A"},
    {RegressorKind::kSaturating, "saturating", RegressorGroup::kStatic, true,
     "a static curve of the current, bent at %g A"},
    {RegressorKind::kLogMagnitude, "log_magnitude", RegressorGroup::kStatic, true,
     "a static curve of the current, bent at %g A"},
    {RegressorKind::kSmallCurrent, "small_current", RegressorGroup::kStatic, true,
     "a static curve of the current, bent at %g A"},
    {RegressorKind::kRest, "rest", RegressorGroup::kStatic, true,
     "a static curve of the current, bent at %g A"},
    {RegressorKind::kCharge, "charge", RegressorGroup::kChargeCounted, false, "charge moved"},
    {RegressorKind::kChargeSquared, "charge_squared", RegressorGroup::kChargeCounted, false,
     "charge moved"},
    {RegressorKind::kSlowCharge, "slow_charge", RegressorGroup::kChargeCounted, false,
     "charge moved, %g s late"},
    {RegressorKind::kPath, "path", RegressorGroup::kChargeCounted, true,
     "the direction of the last %g As"},
    {RegressorKind::kEdge, "edge", RegressorGroup::kEdges, false,
     "edges of the current within %g s"},
    {RegressorKind::kChange, "change", RegressorGroup::kEdges, false, "edges of the current"},
    {RegressorKind::kChangeBefore, "change_before", RegressorGroup::kEdges, false,
     "edges of the current"},
    {RegressorKind::kOverpotentialMagnitude, "overpotential_magnitude", RegressorGroup::kKinetics,
     false, "curvature of the kinetics"},
    {RegressorKind::kOverpotentialSquared, "overpotential_squared", RegressorGroup::kKinetics,
     false, "curvature of the kinetics"},
    {RegressorKind::kOverpotentialCubed, "overpotential_cubed", RegressorGroup::kKinetics, false,
     "curvature of the kinetics"},
    {RegressorKind::kOverpotentialLogCosh, "overpotential_log_cosh", RegressorGroup::kKinetics,
     false, "curvature of the kinetics"},
    {RegressorKind::kHighOverpotential, "high_overpotential", RegressorGroup::kHighVoltage, false,
     "high voltage"},
    {RegressorKind::kHighMemory, "high_memory", RegressorGroup::kHighVoltage, false,
     "high voltage"},
    {RegressorKind::kHighSum, "high_sum", RegressorGroup::kHighVoltage, false, "high voltage"},
    {RegressorKind::kTimeCurrent, "time_current", RegressorGroup::kTime, false,
     "a resistance that drifts"},
    {RegressorKind::kTimeMagnitude, "time_magnitude", RegressorGroup::kTime, false,
     "a resistance that drifts"},
    {RegressorKind::kTimeSquaredCurrent, "time_squared_current", RegressorGroup::kTime, false,
     "a resistance that drifts"},
    {RegressorKind::kTimeOverpotential, "time_overpotential", RegressorGroup::kTime, false,
     "kinetics that drift"},
    {RegressorKind::kWarmCurrent, "warm_current", RegressorGroup::kTime, false,
     "a resistance that follows the heat of %g s"},
    {RegressorKind::kTime, "time", RegressorGroup::kTime, false, "a drift of the voltage"},
    {RegressorKind::kStepCurrent, "step_current", RegressorGroup::kTime, false,
     "a resistance that steps at %g s"},
};

const KindInfo& infoOf(RegressorKind kind) {
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

RegressorMemory::RegressorMemory(std::vector<Regressor> regressors, RegressorContext context)
    : regressors_(std::move(regressors)),
      context_(context),
      state_(freshRegressorStates(regressors_)) {}

void RegressorMemory::setState(const std::vector<double>& state) {
  if (state.size() != state_.size())
    throw std::invalid_argument("a discrepancy model's memory has " + std::to_string(state.size()) +
                                " numbers, expected " + std::to_string(state_.size()));
  state_ = state;
}

void RegressorMemory::advance(const RegressorInput& moment, Eigen::Ref<Eigen::VectorXd> values) {
  if (moment.duration != share_duration_) {
    share_duration_ = moment.duration;
    takeShares(regressors_, moment.duration, share_);
  }
  RegressorKernel<double>{regressors_, context_, share_, state_.data()}.advance(moment,
                                                                                values.data());
}

std::string toString(const Regressor& regressor) {
  const KindInfo& info = infoOf(regressor.kind);
  return format(info.words, info.scale_first ? regressor.scale : regressor.time,
                info.scale_first ? regressor.time : regressor.scale);
}

}  // namespace battery_sof
