#pragma once

#include <array>
#include <string>
#include <vector>

namespace battery_sof {

/// Kinds of physics, or of the instruments, that a model can lack.
enum class Mechanism {
  kAcceptance,     ///< charge is accepted more slowly than it is offered
  kSideReactions,  ///< current that leaves no charge: gassing, oxygen cycle
  kAcid,           ///< acid moves between pores, plates and separator
  kOpenCircuit,    ///< the open-circuit voltage moves with charge and its path
  kStructure,      ///< double layers, kinetics and resistances other than the base circuit's
  kAgeing,         ///< parameters that change with time or temperature
  kInstrument,     ///< sensors, cables, what the sensors do not see
};

constexpr std::size_t kMechanisms = 7;
constexpr std::array<Mechanism, kMechanisms> kAllMechanisms = {
    Mechanism::kAcceptance,  Mechanism::kSideReactions, Mechanism::kAcid,
    Mechanism::kOpenCircuit, Mechanism::kStructure,     Mechanism::kAgeing,
    Mechanism::kInstrument};

/// @return "acceptance", "side_reactions", "acid", "open_circuit", "structure", "ageing",
/// "instrument".
std::string mechanismId(Mechanism mechanism);

/// @return what the battery does, as a clause for a reader: "charging is limited by ...".
std::string mechanismSentence(Mechanism mechanism);

/// @return whether a mechanism's name speaks of the chemistry of lead-acid cells: acceptance, side
/// reactions, acid.
bool isOfLeadAcid(Mechanism mechanism);

/// @return mechanism of an effect or of a fault of an instrument. @throws std::invalid_argument for
/// an unknown id.
Mechanism mechanismOf(const std::string& effect);

/// @return everything mechanismOf() knows of a mechanism: its effects, and faults that are no
/// equations.
std::vector<std::string> namesOf(Mechanism mechanism);

}  // namespace battery_sof
