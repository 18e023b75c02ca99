#pragma once

#include <array>
#include <string>
#include <vector>

namespace battery_sof {

/// Why an answer with numbers is not valid, each with the numbers of Reason. Volts are of one block.
enum class ReasonKind {
  kMissedVoltage,    ///< missed, width of its interval [V]: what the model expects at present
  kMissedCrank,      ///< measured, lower and upper end of what was predicted [V]
  kDischarge,        ///< asked, the window's largest [A]
  kCharge,           ///< asked, the window's largest [A]
  kProfile,          ///< lowest and highest asked, lowest and highest of the window [A]
  kVoltage,          ///< asked, the window's highest [V]
  kCapacity,         ///< moved, the battery's [Ah]
  kMovedCharge,      ///< moved, supported [Ah], supported of any battery [%], the battery's [Ah]
  kNoVoltage,        ///< the result, the highest of such a battery [V]
  kWideVoltage,      ///< lower and upper end, highest of such a battery, useful width [V]
  kWideSample,       ///< the same, and which sample of a profile
  kWideCurrent,      ///< lower and upper end, width that is known without a model [A]: subject
  kWideStop,         ///< the same [s]
  kUselessCurrent,   ///< width of its interval, useful width [A]
  kHeldDiscrepancy,  ///< by how much a discrepancy model is held at the end of its range [V]
  kTemperature,      ///< at present, in the window [K]
  kNoWindow,         ///< no window was fitted yet, and charges need one
  kNoAcceptance,     ///< no law of charge acceptance
  kShortCharges,     ///< the window's longest charge, the least that is needed [s]
  kMissedCranks,     ///< cranks of the window, RMS errors of the model and of the baseline [V]
  kWindowQuality,    ///< the window's, the least that is needed [1]
  kUndetermined,     ///< subject: the parameter that the window did not determine
};

/// One reason: a value, rendered where an answer gets its message.
struct Reason {
  ReasonKind kind;
  std::array<double, 5> numbers = {};
  std::string subject = {};  ///< what it is about, where the kind says so
};

using Reasons = std::vector<Reason>;

/// @param series_blocks whose voltages are told.  @return a clause without a full stop.
std::string toString(const Reason& reason, double series_blocks);

/// @return the clauses, joined by "; "; empty for no reason.
std::string toString(const Reasons& reasons, double series_blocks);

}  // namespace battery_sof
