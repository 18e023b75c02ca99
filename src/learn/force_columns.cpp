#include "battery_sof/learn/force_columns.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace battery_sof {
namespace {

constexpr std::array<double, 10> kTimes = {0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0, 10000.0};  // [s]
constexpr std::array<double, 6> kEdgeTimes = {0.005, 0.01, 0.02, 0.05, 0.1, 0.15};                           // [s]
constexpr double kFastest = 0.06;      // [s]; sampled more slowly, edges are single samples
constexpr double kSlowMemory = 100.0;  // [s]; a memory of the current that lasts longer is the acid's
constexpr double kLeastReserve = 1e-3; // [1], of a reserve that is spent
constexpr double kMostBend = 3.0;      // [1], overpotentials beyond it say nothing more of kinetics
constexpr int kSteps = 6;              // instants at which a contact may have changed
constexpr double kHour = 3600.0;

enum Shared { kChargeState, kDrawnState, kChangeState, kLastCurrent, kBegunState, kSharedStates };

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
      const Family slow = time >= kSlowMemory ? Family::kAcid : Family::kStructure;
      add(Family::kAcceptance, ForceKind::kChargeMemory, time);
      add(Family::kAcid, ForceKind::kDischargeMemory, time);
      add(slow, ForceKind::kMemory, time);
      if (time == 3.0 || time == 30.0 || time == 300.0 || time == 3000.0) {
        add(Family::kAcceptance, ForceKind::kLogChargeMemory, time, 5.0);
        add(Family::kAcid, ForceKind::kLogDischargeMemory, time, 20.0);
        add(Family::kAcceptance, ForceKind::kMemoryOfCharging, time, 2.0);
      }
      if (time == 1.0 || time == 10.0 || time == 100.0 || time == 1000.0) {
        add(slow, ForceKind::kCompressedMemory, time, 5.0);
        add(slow, ForceKind::kMemoryOfCompressed, time, 5.0);
      }
    }
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
    for (const double scale : {30.0, 100.0, 300.0}) add(Family::kOpenCircuit, ForceKind::kSinceCharge, 0.0, scale);
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
    add(Family::kSideReactions, ForceKind::kHighOverpotential, context_.high, context_.high_width);
    for (const double time : {10.0, 100.0})
      if (fits(time)) add(Family::kSideReactions, ForceKind::kHighMemory, context_.high, context_.high_width, time);
    add(Family::kSideReactions, ForceKind::kHighSum, context_.high, context_.high_width);
  }

  void takeTime() {
    for (const ForceKind kind : {ForceKind::kTimeCurrent, ForceKind::kTimeMagnitude, ForceKind::kTimeSquaredCurrent,
                                 ForceKind::kTimeOverpotential})
      add(Family::kAgeing, kind, 0.0, context_.span);
    for (const double time : {300.0, 1000.0, 3000.0})
      if (fits(time)) add(Family::kAgeing, ForceKind::kWarmCurrent, time);
    add(Family::kInstrument, ForceKind::kTime, 0.0, context_.span);
    for (int k = 1; k <= kSteps; ++k)
      add(Family::kInstrument, ForceKind::kStepCurrent, context_.span * k / (kSteps + 1.0));
  }

  ForceContext context_;
  std::vector<ForceColumn> columns_;
};

double softplus(double x) { return x > 30.0 ? x : std::log1p(std::exp(std::max(x, -30.0))); }

double highPart(const ForceColumn& column, double overpotential) {
  return softplus((overpotential - column.time) / column.scale);
}

/// Time constant of a column's low pass [s]; 0 without one.
double lowPassTime(const ForceColumn& column) {
  switch (column.kind) {
    case ForceKind::kHighMemory: return column.charge;
    case ForceKind::kChargeMemory: case ForceKind::kDischargeMemory: case ForceKind::kMemory:
    case ForceKind::kLogChargeMemory: case ForceKind::kLogDischargeMemory: case ForceKind::kCompressedMemory:
    case ForceKind::kMemoryOfCompressed: case ForceKind::kMemoryOfCharging: case ForceKind::kFresh:
    case ForceKind::kFreshCharging: case ForceKind::kSlowCharge: case ForceKind::kEdge: case ForceKind::kWarmCurrent:
      return column.time;
    default: return 0.0;
  }
}

bool isReserve(ForceKind kind) { return kind == ForceKind::kAcceptanceReserve || kind == ForceKind::kDischargeReserve; }

}  // namespace

ForceGroup groupOf(ForceKind kind) {
  switch (kind) {
    case ForceKind::kChargeMemory: case ForceKind::kLogChargeMemory: case ForceKind::kMemoryOfCharging: case ForceKind::kFresh:
    case ForceKind::kFreshCharging: case ForceKind::kAcceptanceReserve: return ForceGroup::kCharge;
    case ForceKind::kDischargeMemory: case ForceKind::kLogDischargeMemory: case ForceKind::kDischargeReserve:
    case ForceKind::kSinceCharge: return ForceGroup::kDischarge;
    case ForceKind::kMemory: case ForceKind::kCompressedMemory: case ForceKind::kMemoryOfCompressed: return ForceGroup::kCurrent;
    case ForceKind::kCompressed: case ForceKind::kSaturating: case ForceKind::kLogMagnitude: case ForceKind::kSmallCurrent:
    case ForceKind::kRest: return ForceGroup::kStatic;
    case ForceKind::kCharge: case ForceKind::kChargeSquared: case ForceKind::kSlowCharge: case ForceKind::kPath:
      return ForceGroup::kChargeCounted;
    case ForceKind::kEdge: case ForceKind::kChange: case ForceKind::kChangeBefore: return ForceGroup::kEdges;
    case ForceKind::kOverpotentialMagnitude: case ForceKind::kOverpotentialSquared: case ForceKind::kOverpotentialCubed:
    case ForceKind::kOverpotentialLogCosh: return ForceGroup::kKinetics;
    case ForceKind::kHighOverpotential: case ForceKind::kHighMemory: case ForceKind::kHighSum: return ForceGroup::kHighVoltage;
    case ForceKind::kTimeCurrent: case ForceKind::kTimeMagnitude: case ForceKind::kTimeSquaredCurrent:
    case ForceKind::kTimeOverpotential: case ForceKind::kWarmCurrent: case ForceKind::kTime: case ForceKind::kStepCurrent:
      return ForceGroup::kTime;
  }
  throw std::logic_error("a column of an unknown kind");
}

std::vector<ForceColumn> forceLibrary(const ForceContext& context) { return Library(context).take(); }

ForceMemory::ForceMemory(std::vector<ForceColumn> columns, ForceContext context)
    : columns_(std::move(columns)), context_(context), state_(columns_.size() + kSharedStates, 0.0), share_(columns_.size(), 0.0) {
  for (std::size_t k = 0; k < columns_.size(); ++k)
    if (isReserve(columns_[k].kind)) state_[k] = 1.0;
}

void ForceMemory::setState(const std::vector<double>& state) {
  if (state.size() != state_.size())
    throw std::invalid_argument("a learnt force's memory has " + std::to_string(state.size()) + " numbers, expected " +
                                std::to_string(state_.size()));
  state_ = state;
}

void ForceMemory::takeShares(double duration) {
  if (duration == share_duration_) return;
  share_duration_ = duration;
  for (std::size_t k = 0; k < columns_.size(); ++k) {
    const double time = lowPassTime(columns_[k]);
    share_[k] = time > 0.0 ? -std::expm1(-duration / time) : 0.0;
  }
}

double ForceMemory::lowPass(std::size_t k, double input) {
  const bool begun = state_[columns_.size() + kBegunState] != 0.0;
  state_[k] = begun ? state_[k] + share_[k] * (input - state_[k]) : input;
  return state_[k];
}

/// c of a reserve that `out` empties and time and `in` fill [1].
double ForceMemory::reserve(std::size_t k, double out, double in, const ForceMoment& moment) {
  const ForceColumn& column = columns_[k];
  const double filling = 1.0 / column.time + in / column.scale, emptying = out / column.scale;
  const double end = filling / (filling + emptying);
  state_[k] = end + (state_[k] - end) * std::exp(-moment.duration * (filling + emptying));
  return std::max(state_[k], kLeastReserve);
}

double ForceMemory::valueOf(std::size_t k, const ForceMoment& moment) {
  const ForceColumn& column = columns_[k];
  const double* shared = state_.data() + columns_.size();
  const double i = moment.current, flowed = moment.gap ? 0.0 : i;  // what memories see: across a gap the battery rests
  const double charging = std::max(flowed, 0.0), discharging = std::max(-flowed, 0.0);
  const double u = moment.overpotential, t = moment.time / context_.span;
  const auto bent = [&] { return std::clamp(column.scale * u, -kMostBend, kMostBend); };
  switch (column.kind) {
    case ForceKind::kChargeMemory: return lowPass(k, charging);
    case ForceKind::kDischargeMemory: return lowPass(k, discharging);
    case ForceKind::kMemory: return lowPass(k, flowed);
    case ForceKind::kLogChargeMemory: return std::log1p(lowPass(k, charging) / column.scale);
    case ForceKind::kLogDischargeMemory: return std::log1p(lowPass(k, discharging) / column.scale);
    case ForceKind::kCompressedMemory: return std::asinh(lowPass(k, flowed) / column.scale);
    case ForceKind::kMemoryOfCompressed: return lowPass(k, std::asinh(flowed / column.scale));
    case ForceKind::kMemoryOfCharging: return lowPass(k, std::asinh(charging / column.scale));
    case ForceKind::kFresh: return column.scale / (column.scale + column.time * lowPass(k, discharging));
    case ForceKind::kFreshCharging:
      return std::max(i, 0.0) * column.scale / (column.scale + column.time * lowPass(k, discharging));
    case ForceKind::kAcceptanceReserve: return -std::log(reserve(k, charging, discharging, moment));
    case ForceKind::kDischargeReserve: return std::log(reserve(k, discharging, charging, moment));
    case ForceKind::kSinceCharge: return i < -1.0 ? std::exp(-shared[kDrawnState] / column.scale) : 0.0;
    case ForceKind::kCompressed: return std::asinh(i / column.scale);
    case ForceKind::kSaturating: return std::tanh(i / column.scale);
    case ForceKind::kLogMagnitude: return std::log1p(std::abs(i) / column.scale);
    case ForceKind::kSmallCurrent: return i * std::exp(-std::abs(i) / column.scale);
    case ForceKind::kRest: return std::exp(-std::abs(i) / column.scale);
    case ForceKind::kCharge: return shared[kChargeState];
    case ForceKind::kChargeSquared: return shared[kChargeState] * shared[kChargeState];
    case ForceKind::kSlowCharge: return lowPass(k, shared[kChargeState]);
    case ForceKind::kPath: {
      const double towards = flowed > 0.0 ? 1.0 : -1.0;
      state_[k] = towards + (state_[k] - towards) * std::exp(-std::abs(flowed) * moment.duration / column.scale);
      return state_[k];
    }
    case ForceKind::kEdge: return i - lowPass(k, i);
    case ForceKind::kChange: return moment.gap ? 0.0 : i - shared[kLastCurrent];
    case ForceKind::kChangeBefore: return shared[kChangeState];
    case ForceKind::kOverpotentialMagnitude: return std::abs(u);
    case ForceKind::kOverpotentialSquared: return bent() * bent();
    case ForceKind::kOverpotentialCubed: return bent() * bent() * bent();
    case ForceKind::kOverpotentialLogCosh: return std::log(std::cosh(std::clamp(column.scale * u, -30.0, 30.0)));
    case ForceKind::kHighOverpotential: return highPart(column, u);
    case ForceKind::kHighMemory: return lowPass(k, highPart(column, u));
    case ForceKind::kHighSum: return state_[k] += moment.duration * highPart(column, u);
    case ForceKind::kTimeCurrent: return t * i;
    case ForceKind::kTimeMagnitude: return t * std::abs(i);
    case ForceKind::kTimeSquaredCurrent: return t * t * i;
    case ForceKind::kTimeOverpotential: return t * u;
    case ForceKind::kWarmCurrent: return i * lowPass(k, flowed * flowed);
    case ForceKind::kTime: return t;
    case ForceKind::kStepCurrent: return moment.time >= column.time ? i : 0.0;
  }
  throw std::logic_error("a column of an unknown kind");
}

void ForceMemory::advance(const ForceMoment& moment, Eigen::Ref<Eigen::VectorXd> values) {
  takeShares(moment.duration);
  double* shared = state_.data() + columns_.size();
  const bool begun = shared[kBegunState] != 0.0;
  if (!begun) shared[kLastCurrent] = moment.current;
  if (!moment.gap) shared[kChargeState] += moment.duration * moment.held / kHour;
  const double flowed = moment.gap ? 0.0 : moment.current;
  shared[kDrawnState] = std::max(0.0, shared[kDrawnState] - moment.duration * flowed);
  for (std::size_t k = 0; k < columns_.size(); ++k) values[static_cast<Eigen::Index>(k)] = valueOf(k, moment);
  shared[kChangeState] = moment.gap ? 0.0 : moment.current - shared[kLastCurrent];
  shared[kLastCurrent] = moment.current;
  shared[kBegunState] = 1.0;
}

std::string describe(const ForceColumn& column) {
  const auto text = [](const char* format, double one, double two = 0.0) {
    char buffer[120];
    std::snprintf(buffer, sizeof buffer, format, one, two);
    return std::string(buffer);
  };
  switch (column.kind) {
    case ForceKind::kChargeMemory: case ForceKind::kLogChargeMemory: case ForceKind::kMemoryOfCharging:
      return text("memory of charging over %g s", column.time);
    case ForceKind::kDischargeMemory: case ForceKind::kLogDischargeMemory:
      return text("memory of discharging over %g s", column.time);
    case ForceKind::kMemory: case ForceKind::kCompressedMemory: case ForceKind::kMemoryOfCompressed:
      return text("memory of the current over %g s", column.time);
    case ForceKind::kFresh: case ForceKind::kFreshCharging:
      return text("what was discharged in the last %g s (%g As)", column.time, column.scale);
    case ForceKind::kAcceptanceReserve: return text("a reserve of %g As that charging empties and %g s refill", column.scale, column.time);
    case ForceKind::kDischargeReserve: return text("a reserve of %g As that discharging empties and %g s refill", column.scale, column.time);
    case ForceKind::kSinceCharge: return text("the first %g As of a discharge", column.scale);
    case ForceKind::kCompressed: case ForceKind::kSaturating: case ForceKind::kLogMagnitude: case ForceKind::kSmallCurrent:
    case ForceKind::kRest: return text("a static curve of the current, bent at %g A", column.scale);
    case ForceKind::kCharge: case ForceKind::kChargeSquared: return "charge moved";
    case ForceKind::kSlowCharge: return text("charge moved, %g s late", column.time);
    case ForceKind::kPath: return text("the direction of the last %g As", column.scale);
    case ForceKind::kEdge: return text("edges of the current within %g s", column.time);
    case ForceKind::kChange: case ForceKind::kChangeBefore: return "edges of the current";
    case ForceKind::kOverpotentialMagnitude: case ForceKind::kOverpotentialSquared: case ForceKind::kOverpotentialCubed:
    case ForceKind::kOverpotentialLogCosh: return "curvature of the kinetics";
    case ForceKind::kHighOverpotential: case ForceKind::kHighMemory: case ForceKind::kHighSum: return "high voltage";
    case ForceKind::kTimeCurrent: case ForceKind::kTimeMagnitude: case ForceKind::kTimeSquaredCurrent:
      return "a resistance that drifts";
    case ForceKind::kTimeOverpotential: return "kinetics that drift";
    case ForceKind::kWarmCurrent: return text("a resistance that follows the heat of %g s", column.time);
    case ForceKind::kTime: return "a drift of the voltage";
    case ForceKind::kStepCurrent: return text("a resistance that steps at %g s", column.time);
  }
  throw std::logic_error("a column of an unknown kind");
}

}  // namespace battery_sof
