#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/mechanism_evidence.hpp"
#include "diagnosis/row_simulation.hpp"
#include "estimation/block_score.hpp"
#include "regression/discrepancy_fit.hpp"

namespace battery_sof {

class ExplanationFits;
struct DiagnoseOptions;

/// One piece of an explanation: an effect of the catalogue, or a mechanism's regressors where none
/// of its effects does.
struct SelectedTerm {
  Mechanism mechanism = Mechanism::kStructure;
  std::string member;  ///< id; empty: the mechanism's regressors
  /// of ln evidence, by which the whole would be worse without it [1]
  double gain = 0.0;
  /// [V], what it adds over the training rows that the base circuit cannot
  double rms = 0.0;
  std::vector<std::string> indistinguishable;  ///< ids that would do as well in its place
  double probability = 0.0;                    ///< of its mechanism, where it is reported [0, 1]
  std::vector<double> half_gains = {};         ///< the gain on each half-sample of the rows [1]
};

/// An effect that was fitted in some step.
struct WeighedMember {
  std::string id;
  double gain = 0.0;  ///< of ln evidence over what had been accepted before, at best [1]
  /// on left-out blocks, over what had been accepted before; none where it was not scored
  std::optional<ScoreGain> score = std::nullopt;
};

/// Notes the gain of an effect, of one that was fitted before the larger of the two.
void addWeighed(std::vector<WeighedMember>& weighed, const std::string& id, double gain);

/// A battery's own law is never quite the catalogue's: a smaller share of what something explains
/// is not reported of anything else [1].
constexpr double kCatalogueTolerance = 0.1;

/// @param terms largest gain first.  @return gain of ln evidence below which one of a mechanism is
/// not named in addition to them.
inline double leastNamed(const std::vector<SelectedTerm>& terms, Mechanism mechanism) {
  if (terms.empty() || terms.front().mechanism == mechanism)
    return -std::numeric_limits<double>::infinity();
  return kCatalogueTolerance * terms.front().gain;
}

/// [V], RMS that instruments may leave of a recording apart from white noise and rounding
constexpr double kPlausible = 0.01;

/// What a part has to add to be worth telling, in the currency of those who ask: any of the three.
struct Relevance {
  /// [V], RMS over the training part; half the noise where that is more
  double rmse = 0.001;
  /// [V], mean magnitude while cranking; half the noise where that is more
  double crank = 0.010;
  double charge_share = 0.03;  ///< [1], of the charging current
};

constexpr double kMinGain = 12.0;  ///< of ln evidence that a component must bring
constexpr double kTie = 6.0;       ///< of ln evidence; what is closer is as good

/// The smallest strength at which this recording would have led to an effect's name (explain()).
struct DetectionLimit {
  std::string id, parameter, unit;
  /// in unit; none: at no strength within the catalogue's range, or the residual is not noise alone
  std::optional<double> strength;
  double typical = 0.0;  ///< the catalogue's order of magnitude, in unit
  bool visible = false;  ///< strength <= typical
};

/// What the library would still take in addition to an explanation, and the limits below which
/// nothing is reported.
struct UnexplainedPart {
  double rmse = 0.0;          ///< [V]
  double crank = 0.0;         ///< [V], mean magnitude while cranking
  double charge_share = 0.0;  ///< [1], of the charging current
  Relevance limits;           ///< rmse: as it was used, with the noise
  /// [V], RMS of the residual of a row after all that explains it; away from edges of the current
  /// where these are noisier
  double noise = 0.0;
  /// Whether the residual is noise of instruments, and nothing in it exceeds the relevance
  /// threshold. Where it is not, any effect may be in it: no strength of one is reported.
  bool isNoise() const { return noise <= kPlausible && rmse < limits.rmse; }
};

/// What explains the rows' errors of a base circuit.
struct Explanation {
  std::vector<SelectedTerm> terms;  ///< largest gain first
  /// in addition to the base circuit alone, by each half-sample of the rows
  std::vector<MechanismEvidence> mechanisms;
  BatteryModel model = BatteryModel();  ///< the base circuit with the effects among the components
  CompositionPoint point;               ///< of it
  double evidence = 0.0;                ///< ln evidence, scaled by the fraction
  double base_evidence = 0.0;           ///< of the base circuit alone
  /// share of rows that count as independent once all that can be estimated is taken out
  double effective_sample_fraction = 1.0;
  double edge_jitter = 0.0;  ///< q of TimingJitterNoise [1/A^2]
  UnexplainedPart unexplained;
  std::vector<WeighedMember> weighed;  ///< in the order in which they came
  /// of every effect that is not in it, linearised
  std::vector<DetectionLimit> detection_limits;
};

/**
 * @brief Explains errors by mechanisms first: in each step the mechanism of greatest evidence, by
 * one of its effects or by its regressors, whichever the data support; then what was selected
 * is weighed again with the rest.
 *
 * Evidence is that of LinearProblem at one fraction for all: a composition stands by its errors at
 * its best parameters and the directions these may move in (Laplace), regressors by one strength a
 * group. Every set is fitted whole, the base circuit with it.
 *
 * @param fits to the rows, with these options; nothing else was explained by them.
 * @param ids effects that may be named.  @param options where effects are given they are taken
 * without a test, and nothing else is looked for.
 */
Explanation explain(ExplanationFits& fits, const std::vector<std::string>& ids,
                    const DiagnoseOptions& options);

/**
 * @brief What the rows say, linearised, of a selection that was made in another way
 * (selectByScore()): of each mechanism's regressors in addition to the circuit, and of the residual.
 *
 * Terms, evidence and weighed members are the selection's and stay empty.
 * @param circuit, point where the circuit and the composition with the effects were fitted.
 */
Explanation explanationAround(ExplanationFits& fits, const CompositionPoint& circuit,
                              const BatteryModel& model, const CompositionPoint& point,
                              const DiagnoseOptions& options);

/// @return what the rows say for each mechanism; parameters as explain()'s.
MechanismEvidence mechanismEvidence(ExplanationFits& fits, const std::vector<std::string>& ids);

}  // namespace battery_sof
