#pragma once

#include <array>
#include <string>
#include <vector>

namespace battery_sof {

/// Kinds of physics, or of the instruments, that a model can lack.
enum class Family {
  kAcceptance,     ///< charge is accepted more slowly than it is offered
  kSideReactions,  ///< current that leaves no charge: gassing, oxygen cycle
  kAcid,           ///< acid moves between pores, plates and separator
  kOpenCircuit,    ///< the open-circuit voltage moves with charge and its path
  kStructure,      ///< double layers, kinetics and resistances other than the base circuit's
  kAgeing,         ///< parameters that change with time or temperature
  kInstrument,     ///< sensors, cables, what the sensors do not see
};

constexpr std::size_t kFamilies = 7;
constexpr std::array<Family, kFamilies> kAllFamilies = {Family::kAcceptance,  Family::kSideReactions, Family::kAcid,
                                                        Family::kOpenCircuit, Family::kStructure,     Family::kAgeing,
                                                        Family::kInstrument};

/// @return "acceptance", "side_reactions", "acid", "open_circuit", "structure", "ageing", "instrument".
std::string familyId(Family family);

/// @return what the battery does, as a clause for a reader: "charging is limited by ...".
std::string familySentence(Family family);

/// @return whether a family's name speaks of the chemistry of lead-acid cells: acceptance, side reactions, acid.
bool isOfLeadAcid(Family family);

/// @return family of an effect or of a fault of an instrument. @throws std::invalid_argument for an unknown id.
Family familyOf(const std::string& effect);

/// @return ids of the catalogue's effects of a family, in its order.
std::vector<std::string> membersOf(Family family);

/// @return everything familyOf() knows of a family: its effects, and faults that are no equations.
std::vector<std::string> namesOf(Family family);

}  // namespace battery_sof
