#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
#include <string>
#include <variant>
#include <vector>

#include "simulator/dice.hpp"
#include "simulator/power_source.hpp"

namespace battery_sof_simulator {

constexpr double kScenarioVoltageLimit = std::numeric_limits<double>::infinity();

/// A stretch of a drive: the wanted current goes linearly from begin to end.
struct Phase {
  double duration;                               ///< [s]; counted in whole milliseconds
  double begin, end;                             ///< [A]
  double voltage_limit = kScenarioVoltageLimit;  ///< [V]; infinite: the scenario's
};

inline Phase steady(double duration, double current) { return {duration, current, current}; }
inline Phase rest(double duration) { return steady(duration, 0.0); }
/// A charge [Ah] taken up, or given out when negative, at a current counted positive [A].
inline Phase swing(double charge_ah, double current) {
  return steady(std::abs(charge_ah) * kSecondsPerHour / current, std::copysign(current, charge_ah));
}

/// What a crank is drawn from: inrush for kInrush, then a plateau; currents counted positive.
struct CrankRanges {
  Range inrush_a, plateau_s, plateau_a;
};
constexpr double kInrush = 0.12;  // [s] (docs/physics.md#drives)
void appendCrank(std::vector<Phase>& phases, const CrankRanges& ranges, Dice& dice);

/// Where a drive stands when its next phase is chosen.
struct Situation {
  double time;       ///< since the start [s]
  double charge_ah;  ///< taken up by the battery since the start [Ah]
};

/// Chooses a drive's phases one after the other.
using DrivePlan = std::function<Phase(const Situation&)>;

/// Short high-rate discharges over a drive, each in the middle 28 % of its share of the time.
struct PulseOptions {
  int count = 14;                 ///< within the scenario's duration; 0: none (paper: 14 in 60 min)
  Range current_a{150.0, 300.0};  ///< discharge (paper, V-A)
  double duration_s = 1.0;        ///< (paper, V-A)
};

/// Data set 1 (paper, V-A; docs/physics.md#drives): charge and discharge in quick turns, a share of
/// rests, pulses. The turns' lengths lean so that the charge stays near charge_target_ah, by a
/// factor of two in the exponent of Dice::leaning() for every 0.1 Ah.
struct AlternatingOptions {
  Range charge_a{8.0, 42.0};
  Range discharge_a{8.0, 60.0};  ///< discharge current, counted positive
  Range turn_s{2.0, 9.0};
  double rest_share = 0.15;  ///< of phases [1], 0 to 1
  Range rest_s{0.5, 4.0};
  double charge_target_ah = 0.0;
  PulseOptions pulses;
};

/// Data set 2 (paper, V-B; docs/physics.md#drives): data set 1 with long charges in the second half
/// and a last discharge. From from_s on, each long charge begins when it will end at or below
/// highest_charge_ah, is followed by a discharge, and then by turns that lean to discharging until
/// the next one fits. The last minute begins at highest_charge_ah, reached by one more long charge:
/// final_hold_s at final_hold_a, then a ramp to final_peak_a at final_s, then rest. Holding for 18
/// s would take 1.1 Ah out, more than the paper's 1 % of 50 Ah; 31 s keep within it.
struct LongChargesOptions {
  AlternatingOptions turns;
  double from_s = 1800.0;
  Range long_charge_a{30.0, 42.0};
  Range long_charge_s{20.0, 60.0};
  Range after_a{35.0, 60.0};  ///< discharge after a long charge, counted positive
  Range after_s{10.0, 25.0};
  double highest_charge_ah = 0.478;
  double final_hold_a = 45.0;  ///< discharge, counted positive
  double final_hold_s = 31.0;
  double final_peak_a = 130.0;  ///< discharge, counted positive
  double final_s = 55.0;        ///< hold and ramp together
  double final_rest_s = 5.0;
};

/// Data set 3 (paper, V-C; docs/physics.md#drives): a start-stop car in town. Stop, crank (inrush,
/// then plateau), and rounds of acceleration, cruise and braking (recuperation falling to 60 %),
/// again and again. While early_cranks last, each of these cycles takes early_s / early_cranks.
/// Cruise and braking lean so that the charge follows a straight line to net_charge_ah.
struct CityOptions {
  Range stop_a{15.0, 35.0};  ///< discharge, counted positive
  Range stop_s{8.0, 40.0};
  Range inrush_a{230.0, 300.0};  ///< discharge, counted positive
  double inrush_s = 0.12;
  Range crank_a{120.0, 180.0};  ///< discharge, counted positive
  Range crank_s{0.3, 0.7};
  Range rounds{2.0, 4.0};         ///< whole numbers, both ends included
  Range accelerate_a{0.0, 30.0};  ///< discharge, counted positive
  Range accelerate_s{3.0, 12.0};
  Range cruise_a{3.0, 20.0};
  Range cruise_s{4.0, 25.0};
  double braking_share = 0.8;  ///< of rounds that end with braking [1]
  Range braking_a{45.0, 80.0};
  Range braking_s{4.0, 15.0};
  double net_charge_ah = 1.0;  ///< at the scenario's duration
  int early_cranks = 0;
  double early_s = 360.0;
};

/// Phases one after the other; the last current is kept after them. May be empty: rest.
struct ListedPhases {
  std::vector<Phase> phases;
};

using ProfileOptions =
    std::variant<AlternatingOptions, LongChargesOptions, CityOptions, ListedPhases>;

/// A plan of the given profile.
/// @param duration of the scenario [s], > 0; the same drive is obtained when it is cut short later.
DrivePlan planDrive(const ProfileOptions& profile, double duration, std::uint64_t seed);

/// @return one sentence for every fault of a profile; empty when all is well.
std::vector<std::string> faultsOf(const ProfileOptions& profile);

/// Phases that come between those of a profile, as soon as one of its phases ends after `at`.
struct Insert {
  double at = 0.0;  ///< [s], >= 0
  std::vector<Phase> phases;
};

/// From an instant on another profile and set point; the rest of a phase or insert is dropped.
struct LaterPart {
  double from = 0.0;            ///< [s], > 0
  double voltage_limit = 14.2;  ///< [V], > 0
  ProfileOptions profile;       ///< of a drive of its own, from there to the scenario's duration
};

struct Scenario;

/// Follows a scenario's profile, its later part and inserts in whole steps of FullBattery::kStep.
class DriveFollower {
 public:
  /// @param duration of what is simulated [s]; shorter than the scenario's: the same drive, cut.
  DriveFollower(const Scenario& scenario, double duration);

  /// What is wanted at the end of the next step. @param charge_ah taken up so far [Ah].
  Demand next(double charge_ah);

 private:
  void begin(double charge_ah);
  /// Takes up the later part when its time has come.
  void changePlan(double charge_ah);

  DrivePlan plan_, later_plan_;
  double later_voltage_limit_ = 0.0;
  long change_at_;                  // in steps; the largest number: never
  Situation plan_began_{0.0, 0.0};  // what a plan is reported counts from there
  std::deque<Insert> inserts_;
  std::deque<Phase> waiting_;
  double voltage_limit_;
  Phase phase_{};
  long length_ = 0, inside_ = 0, steps_ = 0;
};

}  // namespace battery_sof_simulator
