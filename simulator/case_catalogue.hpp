#pragma once

#include <string>
#include <vector>

namespace battery_sof_reference {

/// A kind of case: "null -", "effect gassing", ...
struct CaseKind {
  std::string mechanism;
  std::string id;  ///< "-" in families that have no ids
};

/**
 * @brief All kinds of cases a diagnosis can be tried on (docs/physics.md#cases-with-known-truth).
 *
 * null: the base circuit. structural_null: another structure, no tier-P effect. effect: one effect
 * on the base circuit. decoy: one instrument fault on it. unknown: a force outside the catalogue.
 * structural_effect: a tier-P effect on another structure. porous_null, porous_effect: the same
 * with a porous-electrode model, in which acid transport and u_0 over charge are always there.
 * masked: two additions on the base circuit that act against one another, "first+second". absent:
 * an effect that only the second half of the drive can show.
 */
const std::vector<CaseKind>& caseKinds();

/// @return ids of what a kind adds: none, one, or two of masked.
std::vector<std::string> additionsOf(const CaseKind& kind);

/// @return how long a case is unless asked otherwise [s].
double usualDuration(const CaseKind& kind);

/// What a kind is when nothing is left of its additions but what they need.
/// @param effects that are true nevertheless, ids of the catalogue.
CaseKind nestedKind(const CaseKind& kind, const std::vector<std::string>& effects);

/// What a good diagnosis may say to a case.
struct Expectation {
  std::vector<std::string> verdicts;  ///< any of them
  std::vector<std::string> effects;   ///< those that are true
  /// those that cannot be reported from them
  /// (docs/physics.md#effects-that-cannot-be-distinguished)
  std::vector<std::string> ties;
};

/// @param kind one of caseKinds().  @param effects true ones, ids of the catalogue.
Expectation expectationOf(const CaseKind& kind, const std::vector<std::string>& effects);

}  // namespace battery_sof_reference
