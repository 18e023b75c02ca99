#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "simulator/case_catalogue.hpp"
#include "simulator/porous_block.hpp"
#include "simulator/simulation.hpp"

namespace battery_sof_reference {

/// A case while it is being drawn, and what is known about it.
struct CaseDraft {
  Scenario scenario;
  std::optional<PorousParameters> porous;  ///< stands in for the scenario's battery
  std::string structure = "base";          ///< of the truth: base, porous, or of drawStructure()
  std::map<std::string, double> strength;  ///< of what was added, by key of the scenario
  std::vector<double> scale;               ///< times which each addition was made
  std::vector<std::string> effects;        ///< true effects, ids of the catalogue
  std::optional<double> regime_from;       ///< nothing earlier can show the effect [s]
  bool quiet = false;                      ///< recorded without noise and quantisation
};

/// The base circuit with its parameters, noise and quantisation drawn
/// (docs/physics.md#cases-with-known-truth).
void drawBase(CaseDraft& draft, Dice& dice);

/// Another structure in place of the base circuit's, without any tier-P effect: two_electrodes,
/// full_circuit (Fig. 4 without gassing, u_0 constant), porous_line or kinetics.
void drawStructure(CaseDraft& draft, Dice& dice);

/// A porous block in place of the circuit, with dissolved Pb2+ and gassing left out.
void drawPorous(CaseDraft& draft, Dice& dice);

/// A random drive with rests and cranks in its duration, voltage-limited at 13.5 to 14.6 V.
void drawDrive(CaseDraft& draft, Dice& dice);

/// Adds what is needed to see an effect, e.g. rests for acid transport. @param id of the catalogue.
void exercise(CaseDraft& draft, const std::string& id, Dice& dice);

/// Keeps a drawn drive's charge within about 0.5 Ah.
void keepChargeNear(CaseDraft& draft);

/// A drive whose first half cannot show an effect and whose second half begins with what does.
/// @param id charge_acceptance, gassing, high_rate_depletion or acid_transport.
void drawAbsentDrive(CaseDraft& draft, const std::string& id, Dice& dice);

/// Gives a drive what the second of two effects needs to act against the first: for voltage_drift
/// a charge that rises or falls all the time.
void exerciseMask(CaseDraft& draft, const std::string& id, Dice& dice);

/**
 * @brief Switches an effect, fault or unlisted force on, at a strength in the upper half of its
 * typical range (docs/physics.md) times a scale.
 *
 * The scale acts on gamma (class Strength); at 0 nothing is left of it but what it needs, e.g.
 * charge_acceptance of gassing. What is drawn does not depend on it.
 *
 * @throws std::invalid_argument for an id that is not one of caseKinds().
 */
void addEffect(CaseDraft& draft, const std::string& id, Dice& dice, double scale = 1.0);

/// addEffect() of a porous block: charge_acceptance, acid_transport or gassing.
void addPorousEffect(CaseDraft& draft, const std::string& id, Dice& dice, double scale = 1.0);

/**
 * @brief The second of two additions, its sign against the first's.
 *
 * gassing without a companion of its own; current_gain while charging and above 1, as a battery
 * that takes the current badly looks; voltage_drift against u_0 over the drive's net charge;
 * time_skew as it is drawn: no sign of it acts against a resistance.
 */
void addMask(CaseDraft& draft, const std::string& id, Dice& dice, double scale = 1.0);

/// An effect that shows only in a drive's second half; gassing with a companion so mild that
/// drawAbsentDrive()'s first half does not show that either.
void addAbsent(CaseDraft& draft, const std::string& id, Dice& dice, double scale = 1.0);

/**
 * @brief A case of a kind.
 * @param duration [s], 60 to 14400.  @param rate of the recording [Hz], 1000 over a whole number.
 * @param scale of each addition, finite and >= 0; one number is every addition's.
 * @throws std::invalid_argument for a kind that is not one of caseKinds(), or values outside.
 */
CaseDraft drawCase(const CaseKind& kind, std::uint64_t seed, double duration, double rate,
                   const std::vector<double>& scale = {1.0});

/// @return a case's scenario as it is to be recorded: without noise and quantisation when quiet.
Scenario recordedScenario(const CaseDraft& draft);

}  // namespace battery_sof_reference
