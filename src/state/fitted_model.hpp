#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "baseline/baseline_predictor.hpp"
#include "battery_sof/parameter_estimate.hpp"
#include "battery_sof/series.hpp"
#include "model/battery_model.hpp"
#include "model/simulation.hpp"
#include "recording/control_mode.hpp"
#include "recording/events.hpp"
#include "regression/levenberg_marquardt.hpp"
#include "regression/residual_regression.hpp"
#include "state/noise_model.hpp"

namespace battery_sof {

struct ResponseTable;  // diagnosis/response_table.hpp

/// An event of the battery's own past, and what was to be expected of it.
struct PastEvent {
  enum class Kind { kCrank, kCharge, kStop };
  static constexpr double kStopAge = 10.0;  ///< [s], of a stop when its voltage is compared

  Kind kind = Kind::kCrank;
  double time = 0.0;      ///< [s], of a crank's minimum; else of the beginning
  double duration = 0.0;  ///< [s], a charge's, over which it is averaged; a stop's so far; else 0
  double current = 0.0;   ///< [A], a crank's lowest; a stop's when it was compared
  double voltage = 0.0;   ///< [V], of a charge: mean
  double first_voltage = 0.0;  ///< [V], of a charge: at its first sample
  /// [V], of a crank the lowest, as the sensor showed it, of a stop the last; [A], of a charge: mean
  double measured = 0.0;
  /// the same by the equations; of a charge and a stop with what was estimated without this one
  double modelled = 0.0;

  /// What it is reported by: a crank's lowest current [A], a charge's mean voltage [V].
  double stimulus() const { return kind == Kind::kCharge ? voltage : current; }
};

/// @return a crank as it was measured. @param range its samples.
PastEvent measuredCrank(const Series& series, IndexRange range);

/// @return a charge's beginning as it was measured. @param samples of it.  @param duration [s], by
/// which it is reported.
PastEvent measuredCharge(const Series& series, IndexRange samples, double duration);

/// What a model will miss of a voltage.
struct ErrorForecast {
  double mean = 0.0;      ///< measured minus modelled [V]
  double variance = 0.0;  ///< [V^2]
};

/// Events of the battery's own past that a model was compared with: what corrects it, and what
/// supports it.
struct EventHistory {
  static constexpr std::size_t kMost = 40;  ///< of each kind are kept, the newest; twice of charges

  std::vector<PastEvent> cranks, charges, stops;  ///< each in order of time

  void add(const PastEvent& event);
  void moveBy(double moved);  ///< puts every event onto a clock that jumped. @param moved [s]

  /**
   * @brief What the next stop's level will be: a random walk from stop to stop, seen with noise.
   *
   *     level_k = level_k-1 + N(0, q^2),   measured - modelled = level_k + N(0, r^2)
   *
   * @param usual_error [V], what the model misses of a voltage: the level's before the first stop.
   */
  ErrorForecast nextStop(double usual_error) const;
};

/// @return "converged", "iteration_limit", "stalled", "window_too_short", "not_excited",
/// "implausible", "refused".
std::string toString(FitStatus status);

/// What the model misses at the load that flows, and how far such errors missed later voltages;
/// see PresentErrorFilter.
struct PresentError {
  std::optional<double> current = std::nullopt;  ///< [A], the load; none: the voltage is controlled
  double since = 0.0;                            ///< [s], that this load has lasted
  double level = 0.0;                            ///< [V], measured minus modelled
  double largest = 0.0;                          ///< [A], current that was seen
  /// [V^2], mean squares over the next sample, 30 and 120 s, and the comparisons that they count as
  std::array<double, 3> squares = {}, weights = {};
};

/// What the model was seen to miss when its state stands where it does; see ResidualFilter.
struct ResidualState {
  double drift = 0.0;                         ///< d [V], of the random walk
  double colored = 0.0;                       ///< a [V], of the AR(1)
  double p_dd = 0.0, p_da = 0.0, p_aa = 0.0;  ///< their covariance [V^2]
  PresentError present = {};
};

/// Where the model's state stands, and what it was seen to miss there; the event of a query begins
/// here.
struct LiveState {
  double time = 0.0;     ///< [s], the recording's clock
  double current = 0.0;  ///< [A], current at that time
  /// in the order of BatteryModel::states(): u_c2 [V], then the effects'
  Eigen::VectorXd states = Eigen::VectorXd::Zero(1);
  ResidualState residual_state = {};  ///< at that time
  /// of a discrepancy model, see Simulation::regressorMemory()
  std::vector<double> regressor_memory = {};
  /// [K], of the battery at that time, when known
  std::optional<double> temperature = std::nullopt;
  /// what drove it lately; begun only where something was estimated
  InputMemory memory = {};
  /// of the discharge under way; a file does not have it
  MissedCrank missed_crank = {};
};

/// The part of a recording that was fitted.
struct FitWindow {
  double from = 0.0;  ///< [s]
  double to = 0.0;    ///< [s]
  std::size_t samples = 0;
};

/// How well the fit follows its own window.
struct FitScores {
  double q_dyn_percent = 0.0;  ///< paper, eq. 6
  /// [V], unweighted; where the voltage is the input nothing is counted. Of a window that is all
  /// such: current_rmse times 10 mOhm
  double rmse = 0.0;
  /// [A], where the voltage is the input; none where it never is
  std::optional<double> current_rmse = std::nullopt;
  /// Share of the variation explained in the direction that was controlled [%], both quantities
  /// together, what was estimated from the window's other blocks alone; none where the voltage
  /// is never the input.
  std::optional<double> left_out_share_percent = std::nullopt;
  /// [V], RMS error of the cranks' minima; rmse when there was no crank
  double crank_error_std = 0.0;
  int cranks = 0;                          ///< cranks in the window
  double residual_correlation_time = 0.0;  ///< [s], integral time scale of the residual
};

/// What the window drove the battery through; a query far outside is an extrapolation.
struct ExcitedRange {
  double min_current = 0.0;        ///< [A]
  double max_current = 0.0;        ///< [A]
  double min_voltage = 0.0;        ///< [V]
  double max_voltage = 0.0;        ///< [V]
  double discharge_time = 0.0;     ///< [s], total
  double charge_time = 0.0;        ///< [s], total
  double longest_charge = 0.0;     ///< [s]
  double longest_discharge = 0.0;  ///< [s]
  /// [Ah], between the highest and the lowest charge counted; gaps count as none
  double charge_swing = 0.0;
  std::optional<double> temperature;  ///< [K], mean
  /// [A], below 0: where the current sensor's range ends, as the recording shows it. A current there
  /// is a bound: the true one is this or more.
  std::optional<double> sensor_min_current;
};

/// How far beyond the currents of its window a model is relied on [1].
inline constexpr double kCurrentReach = 1.25;

/// Factor on the width of a kind of interval, from its own past; see update().
struct IntervalCalibration {
  double factor = 1.0;  ///< [1]
  int events = 0;       ///< intervals that were followed by the event
  int inside = 0;       ///< of those the event fell into
};

/// What was identified from a window: the model, how well it is known, and its valid range.
struct Fit {
  BaseParameters parameters;
  std::vector<ParameterEstimate> estimates;  ///< in the order of BatteryModel::parameters()
  /// Covariance of (parameters, states at LiveState::time) in the orders of BatteryModel [units
  /// squared]; zero rows where nothing is known. 6 x 6 for the base model: r_discharge, r_charge,
  /// c2, beta, u_dc, u_c2.
  Eigen::MatrixXd covariance;
  std::vector<std::string> effects;  ///< ids of further physics; empty for the base model
  /// what the effect "discrepancy" is; none without it
  std::shared_ptr<const DiscrepancyModel> discrepancy;
  /// where the voltage is controlled it is the input; none: the current is throughout
  std::optional<ControlModeRule> source;
  /// [samples], by which the voltage channel is behind the current
  std::size_t voltage_lag = 0;
  /// at the window's first sample; not stored in MODEL.yaml
  Eigen::VectorXd first_state;
  FitWindow window;
  ExcitedRange excited;
  double crank_current = kCrankCurrent;                   ///< [A], a crank falls to this or below
  std::optional<double> nominal_capacity = std::nullopt;  ///< [Ah], as it was given
  FitStatus status = FitStatus::kConverged;
  std::string message;  ///< one sentence
  std::string start;    ///< "robust" or "paper"
  int iterations = 0;
  FitScores scores;
  /// [0, 1], of the window alone: windowQuality(); with a source FitScores::left_out_share_percent
  /// as a share, at least 0.
  double window_quality = 0.0;
  /// of the residual over the window; none: fitErrors() was not called
  std::optional<NoiseModel> noise;
  BaselinePredictor baseline;  ///< what the same window says without physics
  /// what the equations miss in the well-posed direction; empty when nothing was estimated
  ResidualRegression residual_regression;
  /// 12 V blocks in series: all else here is of one of them, queries and answers are of the row
  /// (recording/series_blocks.hpp).
  double series_blocks = 1.0;
};

struct IntervalCalibrations {
  IntervalCalibration cranks, charges;
};

/// An answer that its event missed by more than the whole interval that was given.
struct MissedAnswer {
  double time = 0.0;                ///< [s]
  double measured = 0.0;            ///< [V]
  double lower = 0.0, upper = 0.0;  ///< [V]
};

/// Calibration of the intervals of answers by past events.
struct IntervalLearning {
  IntervalCalibrations calibrations;
  /// at a source: cranks, charges, stops of the window and since, with what was expected of them
  EventHistory event_history;
  /// the last crank's, where that was missed
  std::optional<MissedAnswer> missed_answer;
};

/// Where a model comes from.
struct Provenance {
  std::string recording;       ///< file name or topic
  std::string recording_hash;  ///< "sha256:..." of the file, empty when there is no file
  std::string serial_number;   ///< of the battery, empty when unknown
  double fit_ms = 0.0;         ///< [ms] wall time, filled in by the caller that holds a clock
};

/// Everything an identification found; what MODEL.yaml stores and every query reads. A function
/// takes the part it needs.
struct FittedModel {
  /// stays until the next identification, but for the states' rows of its covariance; until the
  /// first one state/posterior moves its parameters
  Fit fit;
  LiveState state;             ///< moves with every sample
  IntervalLearning intervals;  ///< moves with every crank, charge and (at a source) stop
  Provenance provenance;
  /// what a later recording is compared with; none: nothing was kept of the recording
  std::shared_ptr<const ResponseTable> responses;
};

/// Rows of a base model's covariance behind the parameters (BaseRow).
enum BaseCovarianceRow { kRowState = kBaseRows, kCovarianceRows };

inline constexpr double kTypicalCapacity = 50.0;  ///< [Ah], of a start-stop car's battery

/// @return [Ah], nominal: as given, else kTypicalCapacity.
inline double nominalCapacity(std::optional<double> given) {
  return given.value_or(kTypicalCapacity);
}

/// @return [Ah], nominal: as given, else as it was given to the fit, else kTypicalCapacity.
double capacityFor(const Fit& fit, std::optional<double> given);

/// @return true when the fit may be used for predictions: it converged, or nothing was fitted yet
/// (populationPrior()). Standard errors are those of an optimum: a search that the iteration limit
/// stopped before it has none.
bool isUsable(const Fit& fit);

/// @return the composition a model was fitted with.
BatteryModel compositionOf(const Fit& fit);

/// @return its parameters and its state; drifts count from the window's first sample.
ModelPoint pointOf(const FittedModel& model);

/**
 * @brief Directions in the space of (parameters, states) whose squares add up to the covariance: L
 * with L L' = V.
 *
 * Scaled eigenvectors, those of relative variance below 1e-10 left out; at most
 * Simulation::kMaxTangents columns.
 */
Eigen::MatrixXd covarianceFactor(const Eigen::MatrixXd& covariance);

/// @return the model with its state at its window's first sample (Fit::first_state, which it must
/// have). @param current [A], of that sample.
FittedModel atFirstState(FittedModel model, double current = 0.0);

/// @return a simulation that begins at the model's state, for values alone.
Simulation simulationOf(const FittedModel& model);

/// @return the same with covarianceFactor() as seeds: the squared derivatives of any output add up
/// to its variance.
Simulation uncertainSimulationOf(const FittedModel& model);

/// @return the model after a rest so long that every state is known to be at rest.
FittedModel rested(FittedModel model);

/// Puts a simulation's state and its covariance into the model it was begun with. @param simulation
/// from uncertainSimulationOf(), or without tangents: the covariance then stays.
void takeState(FittedModel& model, const Simulation& simulation, double current);

}  // namespace battery_sof
