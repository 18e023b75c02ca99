#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "simulator/acquisition.hpp"

namespace battery_sof_simulator {

/// A law to put into a recording that was measured, and the base circuit that its law reads.
struct InjectionOrder {
  std::string mechanism, id;                   ///< of lawForms()
  std::uint64_t seed = 1;                      ///< of the law's constants
  double strength = 1.0;                       ///< s, finite
  double r_discharge = 5e-3, r_charge = 7e-3;  ///< [Ohm], > 0
};

/// Longest recording that an instrument's law takes [s]: it needs a course of it, step by step.
constexpr double kLongestForInstrument = 10800.0;

/// A measured recording with an out-of-catalogue law in it.
///     physics:      u + u_s(i) - u_0(i)
///     instruments:  i and u as the instrument shows them
/// u_s, u_0: LawBattery at strength s and 0 under the recorded current, linear between samples, 0
/// in gaps (longer than three times the median interval). Where the clock steps back no time
/// passes. C_2, beta and u_0 are those of BatteryParameters: a law reads their overpotential, its
/// thresholds follow from it (Circumstances).
/// @throws std::invalid_argument for fewer than three samples, a law that does not exist, a
/// strength that is not finite, or an instrument in a recording longer than kLongestForInstrument.
std::vector<RecordedSample> injected(const std::vector<RecordedSample>& measured,
                                     const InjectionOrder& order);

/// Reads a recording under the header time_s,current_a,voltage_v; columns behind are left.
/// @throws std::invalid_argument naming file and line of what is not so.
std::vector<RecordedSample> readRecording(const std::filesystem::path& path);

}  // namespace battery_sof_simulator
