#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "battery_sof/series.hpp"
#include "estimation/fit_quality.hpp"
#include "estimation/parameter_space.hpp"
#include "estimation/window.hpp"
#include "recording/control_mode.hpp"
#include "recording/events.hpp"
#include "recording/fit_mask.hpp"
#include "recording/voltage_repair.hpp"
#include "state/fitted_model.hpp"

namespace battery_sof {

/// A source whose voltage is to be the input, and what must be put right in the channel for that.
struct ChargerControl : ControlModes {
  VoltageRepair repair;
};

/// How the state at the window's first sample is obtained.
enum class FitStart {
  kRobust,  ///< estimated with the parameters; u_dc too
  kPaper,   ///< from the first sample alone (paper, eq. 5); u_dc as the mean difference (eq. 4)
};

/// Settings of an identification; the defaults are the paper's, but for the start.
struct IdentifyOptions {
  FitStart start = FitStart::kRobust;
  double crank_weight = 10.0;            ///< W of eq. 3 at high-rate discharge [1], >= 1
  double crank_current = kCrankCurrent;  ///< [A], W applies below, and a crank falls to it or below
  /// paper, section V; from 20 on, a window below 4000 samples may take 25 times as many
  int max_iterations = 20;
  /// Start values r_discharge [Ohm], r_charge [Ohm], c2 [F], beta [1/V]; Table I's magnitudes when
  /// not set.
  std::array<double, 4> initial = {0.008, 0.010, 1000.0, 20.0};

  /// Samples of the series that are no measurement, 1 each: they are inputs of the model and cost
  /// nothing. Empty for none.
  std::vector<char> masked = {};  ///< see InstrumentLimits
  /// Samples at which the current is cut off, 1 each: the true one lay beyond, so that the model's
  /// voltage at the limit bounds the measured one. They cost something where that is violated.
  std::vector<char> bounded = {};
  /// [A], where the sensor's range of discharge ends; goes into ExcitedRange
  std::optional<double> sensor_min_current = std::nullopt;

  /// Operating mode in the series. Set: where the voltage is controlled it is the input, the fit
  /// has errors in both variables (ChannelErrors), what the equations miss is estimated
  /// (ResidualRegression) and past events are kept (EventHistory). None: the current is the input
  /// throughout, as in the paper.
  std::optional<ChargerControl> source = std::nullopt;

  /// Without `effects`, with the physics that the window's charge calls for
  /// (identifyWithChosenPhysics()).
  bool chooses_effects = false;
  /// [Ah], nominal: decides what is deep (chooses_effects; none: kTypicalCapacity), and says where a
  /// discharge ends (CapacityPrior)
  std::optional<double> capacity = std::nullopt;
  /// ids of further physics, see effectCatalogue(); "discrepancy" with `discrepancy`
  std::vector<std::string> effects = {};
  /// estimated before (fitDiscrepancy()); its factors are fitted
  std::shared_ptr<const DiscrepancyModel> discrepancy = nullptr;
  /// What is known; the population with the fit's own effects serves. The base circuit driven
  /// by the current alone has none.
  std::vector<KnownPopulation> priors = {};
  /// of a composition, in addition to the base model's optimum and the effects' magnitudes; none
  /// where a source controls the voltage
  int more_starts = 2;
  int threads = 1;  ///< for the starts; 0: as many as the machine has; the result is the same
  /// Starts in addition, in the composition of `effects`, such as the optimum of a composition inside
  /// it (embedded()).
  std::vector<CompositionPoint> starts = {};
  /// Where a source controls the voltage: none but `starts`, where there are any. A discharge under
  /// one load keeps its typical values.
  bool only_starts = false;
};

/// @return what counts as a crank, and where it is cut off.
inline CrankLimits crankLimitsOf(const IdentifyOptions& options) {
  return {options.crank_current, options.sensor_min_current};
}

/**
 * @brief Fits the base model, or a composition of it with effects, to a window by
 * Levenberg-Marquardt (paper, section IV).
 *
 *     E(theta) = sum_n [ W(n) (u_b(n) - u_m(theta, n)) ]^2                                              (eq. 3)
 *
 * kRobust estimates r_discharge, r_charge, u_dc, c2, beta and the state at the first sample. The
 * first three enter linearly once u_c2 is known and are eliminated in every iteration (variable
 * projection); c2 and beta are searched as logarithms inside Table I's bounds. With effects, and where
 * the current ramps within a sampling interval (InputStep::rampPieces()), fitComposition() does the
 * same for the composition, from the base model's optimum, or
 * from typical values where a source controls the voltage, and from options.starts; long windows of
 * a driven current are compressed (compressedInputs); up to 100,000 samples the search ends at full
 * rate, and standard errors come from it. kPaper searches the four tunables,
 * normalised by Table I's magnitudes, with an exponential penalty beyond the bounds, eq. 4 for u_dc
 * and eq. 5 for the state, u_dc in eq. 5 being the previous iteration's.
 *
 * A current that is cut off (options.bounded) is a bound: the residual of such a sample costs
 * something only where it has the sign that the true current could not give it.
 *
 * Standard errors are those of the sandwich J'W^2J with the memory of the residual's noise
 * (sandwichParts()), so neither the weights nor errors that last make them look smaller than they
 * are.
 *
 * @param series recording; @param range window; gaps inside are taken as rests.
 * @return the model with its state at the window's last sample; never throws for poor data: see
 * FitStatus.
 * @throws std::invalid_argument for options outside their ranges, unknown effects, effects or
 * a source with kPaper, or a range outside the series.
 */
FittedModel identify(const Series& series, IndexRange range, const IdentifyOptions& options = {});

/**
 * @brief identify() for options with effects or a source; same arguments, checked by
 * identify().
 *
 * Starts: the base model's optimum with the new strengths at zero, the same with them at their
 * magnitudes or an instant at four, and options.more_starts; at a source the magnitudes;
 * options.starts, and with options.only_starts no other.
 *
 * @param base the base model's optimum under eq. 3; not read for effects at a source, which start
 * at their magnitudes.
 */
FittedModel identifyComposition(const Series& series, IndexRange range,
                                const IdentifyOptions& options, const CompositionPoint& base);

/**
 * @brief The model of an optimum that was found elsewhere: scores, standard errors, state at the
 * end.
 * @param options effects and masked are used.  @param optimum in the composition of
 * options.effects.
 */
FittedModel completedModel(const Series& series, IndexRange range, const IdentifyOptions& options,
                           const CompositionPoint& optimum);

/**
 * @brief Operating mode, where a fit is to use it.
 *
 * A source is seen, and samples are a quarter of a second or more apart: then the current between
 * them is not known, and its error grows in a blocked electrode
 * (docs/decisions/0009-operating-mode.md). Faster current is as good as exact and is the only input.
 *
 * @param last samples from here on are not looked at and are marked as driven by the current.
 */
std::optional<ChargerControl> chargerControl(const Series& series,
                                             std::optional<std::size_t> last = std::nullopt,
                                             const EventLimits& limits = {});

/// What a fit takes of a recording's instruments: samples that are no measurement, currents that
/// are cut off as bounds, and, but for the paper's start, no weight of cranks where samples are
/// 0.25 s or more apart: what such a sample shows of a crank depends on when it was taken.
void takeInstrument(IdentifyOptions& options, const Series& series, const InstrumentLimits& limits);

/**
 * @brief Carries the state of a model forward to the sample at `last` (inclusive), its covariance
 * and residual state with it.
 * @param series the recording the model stands in: model.state.time must be the time of one of its
 * samples.
 */
void carryState(FittedModel& model, const Series& series, std::size_t last);

/// Options of an identification of a recording, for the command and for whoever links the core.
struct FitRequest {
  std::optional<double> from;   ///< [s], recording's clock; none: its first sample
  std::optional<double> to;     ///< [s]; none: its last sample
  bool chooses_window = false;  ///< the best window inside from..to even where both are given
  bool anyway = false;  ///< a recording with a problem (findProblems()) is fitted all the same
  /// masked and source are found from the recording.
  IdentifyOptions options;
  /// [A], below 0, what counts as an engine start; none: as the recording shows it
  /// (findCrankCurrent())
  std::optional<double> crank_current = std::nullopt;
};

/// What is fitted, and how.
struct FitPlan {
  WindowChoice window;  ///< without a range there is nothing to fit; its message says why
  /// with what the recording says of its instrument and of operating mode
  IdentifyOptions options;
  std::string refusal = {};  ///< why the recording must not be fitted as it is; empty for none
};

/**
 * @brief The window and the settings of a fit: the whole of from..to where both are given, else the
 * best window inside (chooseWindow()); stuck and repeated samples are masked and currents that are
 * cut off taken as bounds (instrumentLimits(), takeInstrument()), the voltage is the input where a source is seen (chargerControl(); not with FitStart::kPaper).
 *
 * A recording with a problem (findProblems()) is refused unless the request says anyway.
 *
 * @param series at the rate to fit at, see atDesignRate(); not empty.
 * @throws std::invalid_argument when there is no sample from `from` to `to`.
 */
FitPlan planFit(const Series& series, const FitRequest& request);

/**
 * @brief Fits what was planned (identify()) and describes its errors (fitErrors()).
 * @return the model with its state at the window's last sample; FitStatus::kRefused for a plan with
 * a refusal, kNotExcited without a window, kImplausible as of requirePlausible().
 */
FittedModel fitPlanned(const Series& series, const FitPlan& plan);

/// Carries a usable model's state to the request's end. @param series as planned with.
void carryToEnd(FittedModel& model, const Series& series, const FitRequest& request);

/// @return samples from `from` to `to` [s], the recording's ends where there is none.
/// @throws std::invalid_argument when the series has none there (the message says what it has) and
/// for a time that is not finite.
IndexRange samplesBetween(const Series& series, std::optional<double> from,
                          std::optional<double> to);

}  // namespace battery_sof
