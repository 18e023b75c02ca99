#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "simulator/generator/scenario_kind.hpp"
#include "simulator/simulation.hpp"

namespace battery_sof_simulator {

/// A scenario of the catalogue's equations while it is being drawn, and what is known about it.
struct CatalogueDraft {
  Order order;  ///< with the scale of each addition filled in
  Scenario scenario;
  std::string structure = "base";          ///< of the truth: base, porous, or of drawStructure()
  std::map<std::string, double> strength;  ///< of what was added, by key of the scenario
  std::vector<std::string> effects;        ///< true effects, ids of the catalogue
  std::optional<double> regime_from;       ///< nothing earlier can show the effect [s]
};

/// A scenario of a catalogue kind (docs/validation.md).
/// @param order duration 60 to 14400 s; a scale for each addition, finite and >= 0, or one for all.
/// @throws std::invalid_argument for an order that cannot be.
CatalogueDraft drawCatalogue(const Order& order);

/// @return a draft's scenario as it is to be recorded: without noise and quantisation when quiet.
Scenario recordedScenario(const CatalogueDraft& draft);

/// A random drive with rests and cranks in its duration, voltage-limited at 13.5 to 14.6 V.
void drawCatalogueDrive(CatalogueDraft& draft, Dice& dice);

/// Adds what is needed to see an effect, e.g. rests for acid transport. @param id of the catalogue.
void exercise(Scenario& scenario, const std::string& id, Dice& dice);

/// A drive whose first half cannot show an effect and whose second half begins with what does.
/// @param id charge_acceptance, gassing, high_rate_depletion or acid_transport.
void drawAbsentDrive(CatalogueDraft& draft, const std::string& id, Dice& dice);

/// Switches an effect, instrument fault or unlisted law on, at a strength in the upper half of its
/// typical range (docs/physics.md) times a scale. The scale acts on the addition's gamma, the
/// measure that is 0 when the addition is gone; at 0 nothing is left of it but what it needs, e.g.
/// charge_acceptance of gassing. What is drawn does not depend on it: one seed gives the same
/// addition at every strength. A porous block has charge_acceptance, acid_transport and gassing.
/// @throws std::invalid_argument for an id that the draft cannot have.
void addEffect(CatalogueDraft& draft, const std::string& id, Dice& dice, double scale = 1.0);

/// The second of two additions, its sign against the first's. gassing without a companion of its
/// own; current_gain while charging and above 1, as a battery that takes the current badly looks;
/// voltage_drift against u_0 over the drive's net charge; time_skew as drawn: no sign acts against.
void addMask(CatalogueDraft& draft, const std::string& id, Dice& dice, double scale = 1.0);

/// An effect that shows only in a drive's second half; gassing with a companion so mild that
/// drawAbsentDrive()'s first half does not show that either.
void addAbsent(CatalogueDraft& draft, const std::string& id, Dice& dice, double scale = 1.0);

/// What a scenario's recording was made from, as JSON (docs/validation.md). All:
/// {"schema","kind","id","seed","duration_s","sample_rate_hz"}. Of catalogue kinds:
///     {"quiet","structure","strength":{..,"scale":[..]},"regime_from_s",
///      "expected":{"verdicts":[..],"effects":[..],"ties":[..]},
///      "truth":{"battery","effects","additions","acquisition","profile","voltage_limit_v",...}}
/// A porous block's truth has "porous" in place of battery, effects and additions. "regime_from_s"
/// is there when a draft has it. truth.acquisition has the scenario's noise, also when "quiet".
/// Keys and units of truth are those of scenario files; a limit that is not there is null.
std::string labelOf(const CatalogueDraft& draft, const Simulation& simulation);

}  // namespace battery_sof_simulator
