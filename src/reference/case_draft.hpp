#pragma once

#include <map>
#include <string>
#include <vector>

#include "reference/case_catalogue.hpp"
#include "reference/simulation.hpp"

namespace battery_sof_reference {

/// A case while it is being drawn, and what is known about it.
struct CaseDraft {
  Scenario scenario;
  std::string structure = "base";  ///< of the truth: base, or a structure of drawStructure()
  std::map<std::string, double> strength;  ///< of what was added, by key of the scenario
  std::vector<std::string> effects;        ///< true effects, ids of PHYSICS
};

/// The base circuit with its parameters, noise and quantisation drawn (PHYSICS 3.1).
void drawBase(CaseDraft& draft, Dice& dice);

/// Another structure in place of the base circuit's, without any tier-P effect: two_electrodes,
/// full_circuit (Fig. 4 without gassing, u_0 constant), porous_line or kinetics.
void drawStructure(CaseDraft& draft, Dice& dice);

/// A random drive with rests and cranks in its duration, voltage-limited at 13.5 to 14.6 V.
void drawDrive(CaseDraft& draft, Dice& dice);

/// Adds what is needed to see an effect, e.g. rests for acid transport. @param id of PHYSICS.
void exercise(CaseDraft& draft, const std::string& id, Dice& dice);

/// Switches an effect, fault or unlisted force on, at a strength in the upper half of its typical
/// range (PHYSICS 1.1 to 1.3).
/// @throws std::invalid_argument for an id that is not one of caseKinds().
void addEffect(CaseDraft& draft, const std::string& id, Dice& dice);

/**
 * @brief A case of a kind.
 * @param duration [s], 60 to 14400.  @param rate of the recording [Hz], 1000 over a whole number.
 * @throws std::invalid_argument for a kind that is not one of caseKinds(), or values outside.
 */
CaseDraft drawCase(const CaseKind& kind, std::uint64_t seed, double duration, double rate);

}  // namespace battery_sof_reference
