#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace battery_sof_simulator {

/// A kind of scenario and what is in it: "effect gassing", "out_of_catalogue acid pore_diffusion".
struct ScenarioKind {
  std::string kind;
  std::string id = "-";         ///< what is added; "-" in kinds that have no ids
  std::string mechanism = "-";  ///< of out_of_catalogue: where its law belongs
};

constexpr char kOutOfCatalogue[] = "out_of_catalogue", kControl[] = "control",
               kRecorderControl[] = "control_with_recorder", kUnlistedLaw[] = "unlisted_law",
               kDeepCycle[] = "deep_cycle";

/// All kinds of scenarios that a diagnosis can be tried on (docs/validation.md).
///
/// Of the catalogue's equations: base_control: the base circuit. structural_control: another
/// structure, no tier-P effect. porous_control: a porous-electrode model, in which acid transport
/// and u_0 over charge are always there. effect: one effect on the base circuit. instrument_fault:
/// one instrument fault on it. unlisted_law: one law on it that is in no catalogue.
/// structural_effect, porous_effect: a tier-P effect on these truths. masked: two additions on the
/// base circuit that act against one another, "first+second". absent: an effect that only the
/// second half of the drive can show.
///
/// Of other equations: out_of_catalogue: a law of a form that no catalogue has. control,
/// control_with_recorder: nothing on such drives, the latter through a realistic recorder.
/// deep_cycle: a porous block that is run down and charged on a bench.
const std::vector<ScenarioKind>& scenarioKinds();

/// What to draw. Empty or missing: of catalogue kinds a default, else what the seed chooses.
struct Order {
  ScenarioKind what{"", "", ""};  ///< id and mechanism may be empty
  std::uint64_t seed = 1;
  std::optional<double> duration;  ///< [s]
  std::optional<double> rate;      ///< of the recording [Hz], 1000 over a whole number
  std::string drive;               ///< of kLawDrives; not of catalogue kinds
  /// times the strength of what is added; one number is every addition's
  std::vector<double> scale{1.0};
  bool quiet = false;  ///< recorded without noise and quantisation; of catalogue kinds
  /// The drive exercises a mechanism or effect of chance and not what is added: its current says
  /// nothing of it. Of laws and controls it lasts 60 to 3600 s unless asked otherwise.
  bool independent_drive = false;
  /// Another drive of the same battery, with the same law and strength: of out_of_catalogue.
  std::optional<std::uint64_t> drive_seed;
};

/// @return whether a kind is drawn from the catalogue's equations.
bool isOfCatalogue(const ScenarioKind& kind);

/// @return all of scenarioKinds() that an order may mean. @throws std::invalid_argument if none.
std::vector<ScenarioKind> meantBy(const ScenarioKind& asked);

/// @throws std::invalid_argument for scales that cannot be or a duration outside these bounds [s].
void requireSound(const Order& order, double shortest, double longest);

/// @return ids of what a kind adds: none, one, or two of masked.
std::vector<std::string> additionsOf(const ScenarioKind& kind);

/// @return how long a catalogue kind is unless asked otherwise [s].
double usualDuration(const ScenarioKind& kind);

}  // namespace battery_sof_simulator
