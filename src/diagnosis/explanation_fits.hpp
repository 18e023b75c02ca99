#pragma once

#include <Eigen/Cholesky>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <thread>
#include <utility>

#include "diagnosis/diagnose.hpp"
#include "diagnosis/timing_jitter_noise.hpp"
#include "model/effect.hpp"
#include "util/text.hpp"

namespace battery_sof {

constexpr double kWideStrength = 2.0;  // standard deviation of a strength, in magnitudes

/// A composition somewhere, with what it leaves of the counted rows, and the mechanisms whose
/// regressors are added to it.
struct ExplanationState {
  BatteryModel model = BatteryModel();
  CompositionPoint point;
  std::vector<FitCoordinate> coordinates;
  Eigen::VectorXd error;
  Eigen::MatrixXd sensitivity;
  std::set<Mechanism> estimated;
  std::vector<std::string> members;  // named ones, without what they need
  LinearFit fit;
  double evidence = -std::numeric_limits<double>::infinity();
  double structure_gain = 0.0;            // of ln evidence, by the structure taken in
  std::map<Mechanism, double> explained;  // [V], by the mechanisms taken in

  /// Whether an effect is in its composition.
  bool has(const std::string& id) const { return contains(model.effects(), id); }
};

/// What an effect adds to the base circuit at one point of its grid.
struct EffectGridPoint {
  std::string id;
  CompositionPoint point;  // of the base circuit with it
  bool one_sided;
  Eigen::VectorXd added;  // counted rows [V]
};

/// @return a composition with one effect more, and what that one needs.
BatteryModel enlarged(const BatteryModel& model, const std::string& id);

/// What a state's linear fit stands on: its own columns, and some of the free ones, which are many
/// and are not copied.
struct ExplanationColumns {
  Eigen::MatrixXd own;             // rows x known
  const Eigen::MatrixXd* free;     // rows x all free columns
  std::vector<Eigen::Index> used;  // of these

  /// @return the columns times z, one row a column that is used.
  Eigen::MatrixXd times(const Eigen::MatrixXd& z) const;
  Eigen::MatrixXd ofRows(IndexRange rows) const;
  /// @return the inner products of the columns with v.
  Eigen::VectorXd along(const Eigen::VectorXd& v) const;
};

/// Counted rows of a range.
inline auto rowsOf(IndexRange range) {
  return Eigen::seqN(static_cast<Eigen::Index>(range.first),
                     static_cast<Eigen::Index>(range.size()));
}

/// ExplanationSums over the counted rows for a state's linear fit.
struct ExplanationSums {
  LinearProblem problem;
  // innovations of TimingJitterNoise, as long as the fits keep their noise
  ExplanationColumns columns;
  Eigen::VectorXd targets;  // likewise
};

/**
 * @brief Fits of compositions and of mechanisms' regressors with them to the rows of one sequence,
 * at one effective sample fraction for all.
 *
 * A set of parts has one fit: the best that any path has come to (optimize()).
 */
class ExplanationFits {
 public:
  static constexpr int kMaxIterations = 12;

  /// @param inputs not needed afterwards.  @param base circuit fitted to them.
  ExplanationFits(const InputSequence& inputs, const CompositionPoint& base,
                  const DiagnoseOptions& options);
  ExplanationFits(const ExplanationFits&) = delete;  // rows_ has a reference to response_
  ExplanationFits& operator=(const ExplanationFits&) = delete;

  /// The base circuit where it was fitted; the first call takes its noise. @throws
  /// std::invalid_argument if it has no finite voltage there.
  ExplanationState baseState();
  std::vector<FitCoordinate> coordinatesOf(const BatteryModel& model) const;
  /// Prior means from where a state stands. @param std of the priors.
  static Eigen::VectorXd expectedFrom(const ExplanationState& state, Eigen::VectorXd& std);
  /// Simulates a state where it stands. @return whether the model has a voltage there that does not
  /// diverge.
  bool linearize(ExplanationState& state) const;
  ExplanationSums sumsOf(const ExplanationState& state, bool all) const;
  /// @return the sums that it stands on.
  ExplanationSums evaluateEvidence(ExplanationState& state) const;
  /// Gauss-Newton steps in all coordinates within their bounds, the columns solved along, while ln
  /// evidence grows.
  /// @param state with its evidence.  @param settled ln evidence that a step has to gain.
  void improve(ExplanationState& state, int iterations = kMaxIterations,
               double settled = 0.1) const;
  /// The first steps of a search.
  void begin(ExplanationState& state, int iterations) const;
  /// Fits a state to the end, from where it stands or from the best that another path has come to
  /// with the same parts.
  void optimize(ExplanationState& state);
  /// Takes what edges of the current add to the rows' noise (TimingJitterNoise), and the effective
  /// sample fraction: of greatest evidence with all that can be estimated in addition to a state.
  void takeNoise(const ExplanationState& state);
  /// Takes the share of rows that count as independent once all that can be estimated in addition
  /// to a state is taken out. @return that fit.
  LinearFit takeEffectiveSampleFraction(const ExplanationState& state);
  /// RMS of the counted rows once all that can be estimated with the base circuit is taken out
  /// [V]; infinite without a finite voltage.
  double minError();
  /// Fits a state closely and takes the effective sample fraction there: one score for one set,
  /// whichever way led to it.
  void refine(ExplanationState& state);
  /// A state with a mechanism's regressors added; the circuit moves along once they are taken.
  ExplanationState withRegressors(const ExplanationState& state, Mechanism mechanism) const;
  /// A state without some of its parts, fitted to the end.
  /// @param state moves to where they are added to that, if it does better there: what a part is
  /// worth does not depend on the way that led to either.
  ExplanationState withoutMembers(ExplanationState& state, const std::set<std::string>& ids);
  ExplanationState withoutRegressors(ExplanationState& state, Mechanism mechanism);
  /// A column of the counted rows as innovations of TimingJitterNoise.
  Eigen::VectorXd whitened(const Eigen::VectorXd& column) const { return noise_.whitened(column); }
  /// The columns' products with their priors, in units of the scaled noise.
  Eigen::MatrixXd penalised(const ExplanationSums& sums, const ExplanationState& state) const;
  /// What a state says of the counted rows, up to what is common to all [V].
  Eigen::VectorXd modelled(const ExplanationState& state) const;
  /// What the library would take in addition to a state, of the mechanisms that it has not [V].
  Eigen::VectorXd unexplainedPart(const ExplanationState& state) const;
  /// What of a part of the counted rows the base circuit's parameters cannot take up [V].
  Eigen::VectorXd beyondBase(const Eigen::VectorXd& part) const;
  static double rms(const Eigen::VectorXd& part) {
    return std::sqrt(part.squaredNorm() / static_cast<double>(part.size()));
  }
  /// Mean magnitude of a part of the counted rows while cranking [V]; 0 without a crank.
  double crankOf(const Eigen::VectorXd& part) const;
  /// A part of the counted rows as a share of the charging current [1].
  double chargeShareOf(const Eigen::VectorXd& part) const;
  LinearFit fitOf(const LinearProblem& problem) const;
  /// Whether the training part is so short that an event may come in it once.
  bool isShort() const;
  /// Sums of every two quarters of the rows: six halves of them.
  std::vector<LinearProblem> halfSamples(const ExplanationSums& sums) const;
  /// ln evidence that a state has over another on each of these.
  std::vector<double> halfSampleGains(const ExplanationState& more,
                                      const ExplanationState& less) const;
  /// The sums of a state with all regressors, without those of other mechanisms.
  LinearProblem restricted(const LinearProblem& all, const std::set<Mechanism>& mechanisms) const;
  /// ln evidence that a state has over another without any one quarter of the rows: the least.
  double leastGain(const ExplanationState& more, const ExplanationState& less) const;
  /// What the fit of a state explains beyond that of another [V].
  static double beyond(const ExplanationState& more, const ExplanationState& less);

  const CompositionPoint& base() const { return base_; }
  const Linearization& response() const { return response_; }
  /// rows that are estimated from and have a measurement
  const std::vector<Eigen::Index>& counted() const { return counted_; }
  double effectiveSampleFraction() const { return effective_sample_fraction_; }
  const TimingJitterNoise& timingJitterNoise() const { return noise_; }
  /// Relevance threshold of an RMS in addition to a state [V].
  double relevanceLimit(const ExplanationState& state) const {
    return std::max(relevant_, 0.5 * state.fit.noise);
  }
  /// Errors of the counted rows [V]; empty where the composition has no voltage.
  Eigen::VectorXd errorsOf(const BatteryModel& model, const CompositionPoint& point) const;

 private:
  class StepCost;

  /// The counted rows of the table, and a voltage channel's random walk: ramps one after the other,
  /// each of a random height.
  void takeFree();
  /// What an RMS has to be to matter: of a voltage as it is, of a current that a source draws out
  /// its share of the current.
  void takeRelevance();
  const std::optional<ExplanationState>& placedBase();
  void takeWhitening(const TimingJitterNoise& noise);
  /// DiagnoseOptions::pulse, from the thread that constructed this alone.
  void pulse() const;
  /// Takes a fit of the same parts from elsewhere where it does better, to its end.
  void takeBetter(ExplanationState& state, ExplanationState again);
  const Eigen::MatrixXd& whitenedFree() const { return noise_.isWhite() ? free_ : whitened_; }
  /// A point of a composition that holds all of another's parameters and states, as a point of the
  /// other.
  CompositionPoint movedTo(const BatteryModel& model, const BatteryModel& from,
                           const CompositionPoint& there) const;

  using Parts = std::pair<std::set<std::string>, std::set<Mechanism>>;
  /// Moves a state to the best fit of its parts so far. @return whether there is one.
  bool takeKnown(const Parts& parts, ExplanationState& state);

  DiagnoseOptions options_;
  CompositionPoint base_;
  Linearization response_;
  DesignMatrix table_;  // its values are moved to free_
  RowSimulation rows_;
  std::vector<Eigen::Index> counted_;
  Eigen::MatrixXd free_;  // the table's regressors and the random walk's ramps
  // the same as innovations, empty where they are; products of what is used
  Eigen::MatrixXd whitened_, free_products_;
  Eigen::MatrixXd white_products_;  // free_products_ of white noise
  std::optional<ExplanationState> base_state_;
  TimingJitterNoise noise_;
  double max_random_walk_ = 0.0, relevant_ = 0.0;  // [V]
  double effective_sample_fraction_ = 1.0;
  std::map<Parts, std::pair<BatteryModel, CompositionPoint>> known_;  // best fits
  std::mutex known_mutex_;
  std::thread::id caller_ = std::this_thread::get_id();
};

}  // namespace battery_sof
