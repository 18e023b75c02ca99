#include "simulator/drive_plan.hpp"

#include "simulator/fields.hpp"
#include "simulator/simulation.hpp"

namespace battery_sof_simulator {
namespace {

constexpr std::uint32_t kPlanStream = 1, kPulseStream = 4;
constexpr double kPulseScatter = 0.28;  // of a pulse's share of the time
constexpr double kTurnsLean = 10.0;     // per Ah: a factor of two for every 0.1 Ah
constexpr double kCityLean = 3.0;       // per Ah
constexpr double kDischargeLean = 3.0;  // towards long discharges between long charges
// current at the end of braking, of that at its beginning
constexpr double kBrakingFall = 0.6;
constexpr double kPulseFreeEnd = 240.0;    // [s] before data set 2's last minute
constexpr double kFinalApproach = 150.0;   // [s], room for one long charge and its preparation
constexpr double kMinAcceptance = 0.6;     // of a wanted charge when the voltage limit acts
constexpr double kChargeTolerance = 10.0;  // [As]

/// The pulses of a drive, in order of time.
class Pulses {
 public:
  Pulses(const PulseOptions& options, double duration, std::uint64_t seed)
      : options_(options), dice_(seed, kPulseStream) {
    const double share = duration / std::max(options.count, 1);
    for (int k = 0; k < options.count; ++k)
      times_.push_back(share * (k + 0.5 + kPulseScatter * (dice_.share() - 0.5)));
  }
  bool due(double time) const { return !times_.empty() && time >= times_.front(); }
  Phase next() {
    times_.pop_front();
    return steady(options_.duration_s, -dice_.between(options_.current_a));
  }

 private:
  PulseOptions options_;
  Dice dice_;
  std::deque<double> times_;
};

/// Charge and discharge in turn, with rests between.
class Turns {
 public:
  Turns(const AlternatingOptions& options, std::uint64_t seed)
      : options_(options), dice_(seed, kPlanStream) {}

  /// @param lean towards long discharges (positive) or long charges (negative).
  Phase next(double lean) {
    if (!rested_ && dice_.share() < options_.rest_share) {
      rested_ = true;
      return steady(dice_.between(options_.rest_s), 0.0);
    }
    rested_ = false;
    charging_ = !charging_;
    if (charging_)
      return steady(dice_.leaning(options_.turn_s, lean), dice_.between(options_.charge_a));
    return steady(dice_.leaning(options_.turn_s, -lean), -dice_.between(options_.discharge_a));
  }
  Phase near(double charge_ah, double target_ah) {
    return next(kTurnsLean * (charge_ah - target_ah));
  }
  Dice& dice() { return dice_; }

 private:
  AlternatingOptions options_;
  Dice dice_;
  bool charging_ = false;
  bool rested_ = false;
};

class LongChargesPlan {
 public:
  LongChargesPlan(const LongChargesOptions& options, double duration, std::uint64_t seed)
      : options_(options),
        final_start_(duration - options.final_s - options.final_rest_s),
        turns_(options.turns, seed),
        pulses_(options.turns.pulses, final_start_ - kPulseFreeEnd, seed) {
    drawLongCharge();
  }

  Phase operator()(const Situation& now) {
    if (now.time >= final_start_) return finalPhase();
    if (pulses_.due(now.time)) return pulses_.next();
    if (discharge_next_) return dischargeAfter();
    if (now.time < options_.from_s)
      return turns_.near(now.charge_ah, options_.turns.charge_target_ah);
    const double left = final_start_ - now.time;
    if (left < kFinalApproach + long_charge_.duration + options_.after_s.high)
      return approachFinal(now, left);
    if (now.charge_ah + chargeOf(long_charge_) <= options_.highest_charge_ah)
      return startLongCharge();
    return turns_.next(kDischargeLean);
  }

 private:
  static double chargeOf(const Phase& phase) {
    return phase.duration * phase.begin / kSecondsPerHour;
  }

  void drawLongCharge() {
    const double current = turns_.dice().between(options_.long_charge_a);
    long_charge_ = steady(turns_.dice().between(options_.long_charge_s), current);
  }
  Phase startLongCharge() {
    const Phase chosen = long_charge_;
    drawLongCharge();
    discharge_next_ = true;
    return chosen;
  }
  Phase dischargeAfter() {
    discharge_next_ = false;
    const double current = -turns_.dice().between(options_.after_a);
    return steady(turns_.dice().between(options_.after_s), current);
  }
  /// Turns, then charge up to the highest charge, then rest until the last minute begins.
  Phase approachFinal(const Situation& now, double left) {
    const double missing = (options_.highest_charge_ah - now.charge_ah) * kSecondsPerHour;
    const double current = long_charge_.begin;
    final_charge_ |= left - missing / (kMinAcceptance * current) < options_.turns.turn_s.high;
    if (!final_charge_) return turns_.near(now.charge_ah, 0.0);
    if (missing < kChargeTolerance) return steady(left, 0.0);
    return steady(std::min(left, missing / current), current);
  }
  Phase finalPhase() {
    switch (final_phase_++) {
      case 0: return steady(options_.final_hold_s, -options_.final_hold_a);
      case 1:
        return {options_.final_s - options_.final_hold_s, -options_.final_hold_a,
                -options_.final_peak_a};
      default: return steady(std::max(options_.final_rest_s, 1.0), 0.0);
    }
  }

  LongChargesOptions options_;
  double final_start_;
  Turns turns_;
  Pulses pulses_;
  Phase long_charge_{};
  bool discharge_next_ = false;
  bool final_charge_ = false;
  int final_phase_ = 0;
};

class CityPlan {
 public:
  CityPlan(const CityOptions& options, double duration, std::uint64_t seed)
      : options_(options), duration_(duration), dice_(seed, kPlanStream) {}

  Phase operator()(const Situation& now) {
    if (waiting_.empty()) planCycle(now);
    const Phase phase = waiting_.front();
    waiting_.pop_front();
    return phase;
  }

 private:
  void planCycle(const Situation& now) {
    const bool early = cycles_++ < options_.early_cranks;
    waiting_.push_back(steady(dice_.between(early ? earlyStop() : options_.stop_s),
                              -dice_.between(options_.stop_a)));
    waiting_.push_back(steady(options_.inrush_s, -dice_.between(options_.inrush_a)));
    waiting_.push_back(steady(dice_.between(options_.crank_s), -dice_.between(options_.crank_a)));
    const double wanted = options_.net_charge_ah * std::min(now.time / duration_, 1.0);
    const double lean = kCityLean * (now.charge_ah - wanted);
    const double left = early ? cycles_ * options_.early_s / options_.early_cranks - now.time : 0.0;
    if (left > plannedTime()) return fillUntil(left, lean);
    const Range faces{options_.rounds.low, options_.rounds.high + 1.0};
    const int rounds = static_cast<int>(dice_.between(faces));
    for (int k = 0; k < rounds; ++k) appendRound(lean);
  }
  /// Short stops, so that there is some driving in an early cycle.
  Range earlyStop() const {
    const double third = options_.early_s / options_.early_cranks / 3.0;
    return {std::min(options_.stop_s.low, third), std::min(options_.stop_s.high, third)};
  }
  /// Rounds that make the waiting phases exactly as long as said [s].
  void fillUntil(double length, double lean) {
    while (plannedTime() < length) appendRound(lean);
    while (plannedTime() > length) {
      const double surplus = plannedTime() - length;
      if (waiting_.back().duration > surplus) {
        waiting_.back().duration -= surplus;
        return;
      }
      waiting_.pop_back();
    }
  }
  void appendRound(double lean) {
    waiting_.push_back(
        steady(dice_.between(options_.accelerate_s), -dice_.between(options_.accelerate_a)));
    waiting_.push_back(
        steady(dice_.between(options_.cruise_s), dice_.leaning(options_.cruise_a, lean)));
    if (dice_.share() > options_.braking_share) return;
    const double current = dice_.leaning(options_.braking_a, lean);
    waiting_.push_back({dice_.leaning(options_.braking_s, lean), current, kBrakingFall * current});
  }
  double plannedTime() const {
    double time = 0.0;
    for (const Phase& phase : waiting_) time += phase.duration;
    return time;
  }

  CityOptions options_;
  double duration_;
  Dice dice_;
  std::deque<Phase> waiting_;
  int cycles_ = 0;
};

}  // namespace

void appendCrank(std::vector<Phase>& phases, const CrankRanges& ranges, Dice& dice) {
  phases.push_back(steady(kInrush, -dice.between(ranges.inrush_a)));
  phases.push_back(steady(dice.between(ranges.plateau_s), -dice.between(ranges.plateau_a)));
}

DrivePlan planDrive(const ProfileOptions& profile, double duration, std::uint64_t seed) {
  if (const auto* options = std::get_if<AlternatingOptions>(&profile))
    return [target = options->charge_target_ah, turns = Turns(*options, seed),
            pulses = Pulses(options->pulses, duration, seed)](const Situation& now) mutable {
      return pulses.due(now.time) ? pulses.next() : turns.near(now.charge_ah, target);
    };
  if (const auto* charges = std::get_if<LongChargesOptions>(&profile))
    return LongChargesPlan(*charges, duration, seed);
  if (const auto* city = std::get_if<CityOptions>(&profile)) return CityPlan(*city, duration, seed);
  return [phases = std::get<ListedPhases>(profile).phases,
          n = std::size_t{0}](const Situation&) mutable {
    if (n < phases.size()) return phases[n++];
    if (phases.empty()) return rest(1.0);
    return Phase{1.0, phases.back().end, phases.back().end, phases.back().voltage_limit};
  };
}

std::vector<std::string> faultsOf(const ProfileOptions& profile) {
  auto faults = std::visit([](const auto& options) { return fieldFaults(options); }, profile);
  const auto* charges = std::get_if<LongChargesOptions>(&profile);
  if (charges != nullptr && charges->final_hold_s >= charges->final_s)
    faults.push_back("final_hold_s is not below final_s, which counts hold and ramp together");
  return faults;
}

constexpr double kStep = FullBattery::kStep;  // [s]; phases count in it
constexpr double kSameTime = 1e-9;            // [s], what rounding leaves of a difference

DriveFollower::DriveFollower(const Scenario& scenario, double duration)
    : plan_(planDrive(scenario.profile,
                      scenario.later ? scenario.later->from : std::max(duration, scenario.duration),
                      scenario.seed)),
      change_at_(std::numeric_limits<long>::max()),
      inserts_(scenario.inserts.begin(), scenario.inserts.end()),
      voltage_limit_(scenario.voltage_limit) {
  if (!scenario.later) return;
  const LaterPart& later = *scenario.later;
  const double left = std::max(duration, scenario.duration) - later.from;
  // Other random numbers than the first profile's.
  later_plan_ = planDrive(later.profile, left, ~scenario.seed);
  later_voltage_limit_ = later.voltage_limit;
  change_at_ = std::lround(later.from / kStep);
}

Demand DriveFollower::next(double charge_ah) {
  if (steps_ == change_at_) changePlan(charge_ah);
  while (inside_ >= length_) begin(charge_ah);
  ++inside_;
  ++steps_;
  const double share = static_cast<double>(inside_) / static_cast<double>(length_);
  const bool own_limit = std::isfinite(phase_.voltage_limit);
  return {phase_.begin + share * (phase_.end - phase_.begin),
          own_limit ? phase_.voltage_limit : voltage_limit_};
}

void DriveFollower::changePlan(double charge_ah) {
  const double time = static_cast<double>(steps_) * kStep;
  plan_ = std::move(later_plan_);
  plan_began_ = {time, charge_ah};
  voltage_limit_ = later_voltage_limit_;
  waiting_.clear();
  while (!inserts_.empty() && inserts_.front().at < time - kSameTime) inserts_.pop_front();
  inside_ = length_;
}

void DriveFollower::begin(double charge_ah) {
  const double time = static_cast<double>(steps_) * kStep;
  if (waiting_.empty() && !inserts_.empty() && time >= inserts_.front().at - kSameTime) {
    waiting_.assign(inserts_.front().phases.begin(), inserts_.front().phases.end());
    inserts_.pop_front();
  }
  const Situation now{time - plan_began_.time, charge_ah - plan_began_.charge_ah};
  phase_ = waiting_.empty() ? plan_(now) : waiting_.front();
  if (!waiting_.empty()) waiting_.pop_front();
  length_ = std::max(1L, std::lround(phase_.duration / kStep));
  inside_ = 0;
}

}  // namespace battery_sof_simulator
