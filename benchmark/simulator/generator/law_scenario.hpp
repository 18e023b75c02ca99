#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "simulator/generator/imperfect_recorder.hpp"
#include "simulator/generator/law_battery.hpp"
#include "simulator/generator/scenario_kind.hpp"

namespace battery_sof_simulator {

/// Kinds of drives.
constexpr std::array<const char*, 5> kLawDrives{"city", "start_stop", "bench", "motorway", "turns"};

/// Gives a scenario a drive of a kind, with what a mechanism needs to be seen all through it. city:
/// stop and go with recuperation. start_stop: a crank after every stop. bench: pulses and rests of
/// a test stand. motorway: long charges at the limit and loads between them. turns: charge and
/// discharge in quick turns. The same things happen in the last quarter as before it.
/// @param scenario its duration is set.  @param mechanism a label's; "-" adds nothing to the kind.
/// @throws std::invalid_argument for an unknown kind.
void drawLawDrive(Scenario& scenario, const std::string& kind, const std::string& mechanism,
                  Dice& dice);

/// RMS before the split and after it [V].
struct SplitRms {
  double training = 0.0, holdout = 0.0;
};

/// RMS of a voltage error, plain about its training mean, and with the base circuit's parameters
/// moved to follow it (linear regression on BaseAnswer::columns in the training part).
struct ErrorSize {
  SplitRms plain, visible;
  /// most that a crank's minimum moves (below -100 A), parameters as they are
  double crank_v = 0.0;
};
ErrorSize errorSize(const std::vector<double>& error, const BaseAnswer& base);

/// A recording of a law, or of a control, and what is true of it.
struct LawScenario {
  Order order;        ///< with everything filled in
  Scenario scenario;  ///< base circuit, drive, limit
  std::vector<RecordedSample> samples;
  double strength = 0.0;     ///< of the law, scale included
  ErrorSize size;            ///< recorded less base circuit under the recorded current
  double steps_rms_v = 0.0;  ///< of a recorder: the voltage's steps and converter nonlinearity
  NoiseOptions voltage_noise, current_noise;
  double voltage_step_v = 0.0, current_step_a = 0.0;
  std::optional<ImperfectRecorder> recorder;
  int attempt = 0;  ///< draws that were not taken
};

/// Share of the samples that teach; the rest is held out (as `sof diagnose` splits).
constexpr double kTrainingShare = 0.75;
/// Bounds of a law's visible RMS [V], and how many times the white noise it is at least.
constexpr Range kVisible{4e-3, 60e-3};
constexpr double kMinOverNoise = 3.0;
/// What a recorder's filters, jitter, current channel and smooth structure leave at most [V].
constexpr double kMaxImperfection = 0.7e-3;
/// The same for a crank's minimum [V]: below what matters to who asks for a crank (10 mV).
constexpr double kMaxCrankImperfection = 8e-3;
/// Dice of a law's constants.
constexpr std::uint32_t kLawStream = 23;

/// A scenario of out_of_catalogue, control or control_with_recorder (docs/validation.md). The
/// currents are those of a source with a voltage limit and the true battery, made linear between
/// samples. A law's strength is searched until its visible RMS in the training part is the one
/// drawn; draws that cannot be seen, or not in the hold-out, are not taken, nor are recorders above
/// kMaxImperfection or kMaxCrankImperfection.
/// @param order duration 60 to 7200 s (drawn: 600 to 3600), rate 1 to 1000 Hz (drawn: 1, 10, 100).
/// @throws std::invalid_argument for an order that cannot be; NoSolution when twenty draws fail.
LawScenario drawLawScenario(const Order& order);

/// The label of a law, or of a control:
///     {"mechanism","drive","attempt","strength","scale","rms_v":{"training","holdout"},
///      "visible_rms_v":{"training","holdout"},"crank_v","noise":{..},"base":{..},
///      "voltage_limit_v","recorder":{..}}
/// id and mechanism are null of controls, recorder of all but control_with_recorder.
std::string labelOf(const LawScenario& one);

}  // namespace battery_sof_simulator
