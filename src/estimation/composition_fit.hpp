#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "estimation/capacity_prior.hpp"
#include "estimation/parameter_space.hpp"
#include "model/simulation.hpp"
#include "recording/events.hpp"
#include "regression/levenberg_marquardt.hpp"
#include "regression/residual_regression.hpp"
#include "state/fitted_model.hpp"
#include "state/noise_model.hpp"

namespace battery_sof {

/// [1], share of the samples that count as independent where errors last for minutes
inline constexpr double kIndependentShare = 0.01;

/**
 * @brief Errors of both channels, for a cost that is well posed whichever of them is the input.
 *
 *     sigma_i^2 = s_i^2 + (G s_u)^2 + (q i)^2  [A^2]  of a current,   sigma_u^2 = sigma_i^2 / G^2  [V^2]  of a voltage
 *
 * with G = di/du of a current held over the sample's interval, at the search's start. An error of z
 * sigmas costs 2 k^2 (sqrt(1 + z^2 / k^2) - 1), k = robust (docs/model.md).
 */
struct ChannelErrors {
  double voltage_std = 0.012;   ///< s_u [V], half a step of a vehicle's sensor
  double current_std = 0.5;     ///< s_i [A], offset and what a slow sampling misses
  double current_share = 0.15;  ///< q [1], what the model misses of a current
  /// [1], sigmas from which an error counts by its magnitude (Huber 1964, smooth)
  double robust = 2.0;
  double independent = kIndependentShare;  ///< [1]
};

/// What a residual costs.
struct FitCost {
  /// whitened by it; none: weighted as in eq. 3
  std::optional<NoiseModel> noise;
  /// W of eq. 3 below crank_weight_current [1]; without noise only
  double crank_weight = 10.0;
  double crank_weight_current = kCrankCurrent;  ///< [A]
  /// with what is known beforehand of parameters and first states
  bool priors = true;
  /// errors in both variables, in place of eq. 3's weights
  std::optional<ChannelErrors> channels = std::nullopt;
  std::vector<KnownParameter> known = {};  ///< priors in place of the catalogue's
  /// [Ah], nominal, where it is known (CapacityPrior)
  std::optional<double> capacity = std::nullopt;
};

/// Sums of squares over search coordinates, whatever evaluates them. Coordinates in which the
/// residual is linear can be solved for the others (variable projection).
class LeastSquaresProblem : public ParameterSpace {
 public:
  /// of the cost: half a standard error in 24,000 samples
  static constexpr double kNegligibleShare = 1e-5;

  using ParameterSpace::ParameterSpace;
  virtual ~LeastSquaresProblem() = default;

  /// One pass. @return false when the model has no finite voltage there.
  virtual bool evaluate(const Eigen::VectorXd& x, NormalEquations& equations) const = 0;
  /// Share of the cost that half a standard error is worth: what a stalled search may still
  /// promise.
  virtual double negligibleShare() const { return kNegligibleShare; }
};

/**
 * @brief A composition, its inputs and a cost as a least-squares problem in search coordinates.
 *
 *     E(x) = sum_n w_n e_n^2 + sum_j ((x_j - x_j0) / s_j)^2 E_0     or   E(x) = sum_n v_n^2 + sum_j ((x_j - x_j0) / s_j)^2
 *     or, with errors in both variables,   E(x) = sum_n rho(e_n / sigma_n) + sum_j ((x_j - x_j0) / s_j)^2 / independent
 *
 * with e = u_b - u_m, w = W^2 times the samples averaged, v the innovations of e (Whitening), E_0 =
 * (10 mV)^2 times the samples that 5 s of correlation hold.
 *
 * One pass goes through the sequence once: simulation, sensitivities, whitening and normal
 * equations, nothing stored but the sums. Holds references to model and inputs.
 */
class CompositionProblem final : public LeastSquaresProblem {
 public:
  /// @param fixed as of ParameterSpace.  @param precision weights of ChannelErrors, as of another
  /// composition's problem over the same rows, so that costs can be compared; empty: those of the
  /// start.  @throws std::invalid_argument likewise, and for an empty sequence.
  CompositionProblem(const BatteryModel& model, const InputSequence& inputs, const FitCost& cost,
                     const CompositionPoint& start, const std::vector<std::string>& fixed = {},
                     std::vector<double> precision = {});

  bool evaluate(const Eigen::VectorXd& x, NormalEquations& equations) const override;

  /// One pass as evaluate()'s, summed by parts of the rows and without priors.
  /// @param parts one after the other, the first from row 0.  @return likewise.
  bool evaluateParts(const Eigen::VectorXd& x, const std::vector<IndexRange>& parts,
                     std::vector<NormalEquations>& equations) const;
  /// What the priors add.
  void addPriors(const Eigen::VectorXd& x, NormalEquations& equations) const;
  /// What a row's residual costs, without whitening. @param k of the sequence's samples.
  double costOf(std::size_t k, double residual) const;

  /// Residual at x [V], or [A] where the voltage is the input, one a sample, not whitened.
  Eigen::VectorXd residual(const Eigen::VectorXd& x) const;

  /// The priors' J'J, without priorWeight().
  Eigen::MatrixXd priorInformation(const Eigen::VectorXd& x) const;
  double priorWeight() const { return prior_weight_; }
  /// W^2 times the samples averaged [1]; with ChannelErrors 1 / sigma^2 times them. @param k of the
  /// sequence's samples.
  double weightOf(std::size_t k) const;
  double negligibleShare() const override;
  /// Takes the weights of ChannelErrors at a point; they are those of the start until then.
  void reweigh(const CompositionPoint& point);
  /// [1 / A^2] or [1 / V^2], one a row: weights of ChannelErrors; empty without these.
  const std::vector<double>& precision() const { return precision_; }

 private:
  const BatteryModel& model_;
  const InputSequence& inputs_;
  FitCost cost_;
  std::optional<Whitening> whitening_;
  std::vector<double> precision_;  // 1 / sigma^2 of ChannelErrors
  double prior_weight_ = 1.0;
  std::optional<CapacityPrior> of_capacity_;
};

/// One pass with derivatives over a sequence, kept whole.
struct ModelPass {
  Eigen::MatrixXd jacobian;  ///< samples x tangents
  Eigen::VectorXd residual;  ///< as CompositionProblem::residual()
  Eigen::MatrixXd at_end;    ///< d(parameters, last state) / d(tangents)
};

/// @param seeds as of Simulation.
ModelPass passOver(const BatteryModel& model, const InputSequence& inputs,
                   const CompositionPoint& point, const Eigen::MatrixXd& seeds);

/// How a composition is searched.
struct CompositionSearch {
  int max_iterations = 60;
  int more_starts = 0;  ///< added to the given ones, spread over the bounds of what is not linear
  int threads = 1;      ///< 0: as many as the machine has; the result is the same
  /// stop when a step promises less than this share of the cost, see MinimizeOptions
  double tolerance = 1e-8;
  /// a last step that promises less than this share of the cost is taken unseen: 0.15 standard
  /// errors in 24,000 samples
  double trusted_gain = 1e-6;
  /// Called before every pass, from the pass's thread; what it throws ends the search.
  std::function<void()> pulse = nullptr;
};

struct CompositionFit {
  CompositionPoint point;
  Eigen::VectorXd x;
  NormalEquations at;  ///< at the optimum, all coordinates
  FitStatus status = FitStatus::kConverged;
  int iterations = 0;  ///< a last step that was taken unseen counts
  int passes = 0;
  int best_start = 0;
};

/**
 * @brief Minimises a LeastSquaresProblem by Levenberg-Marquardt inside the bounds, from every start,
 * and keeps the best.
 *
 * A search never ends above its start: with a nested model's optimum among the starts, its new
 * strengths zero (embedded()), the cost is at most the nested one's.
 *
 * @param starts at least one; search.more_starts are added. Those where the cost has no finite value
 * are left out.
 * @return nothing where none is left.
 */
std::optional<CompositionFit> fitFromStarts(const LeastSquaresProblem& problem,
                                            const std::vector<CompositionPoint>& starts,
                                            const CompositionSearch& search = {});

/// The same. @throws std::invalid_argument where the cost has no finite value at any start.
CompositionFit fitComposition(const LeastSquaresProblem& problem,
                              const std::vector<CompositionPoint>& starts,
                              const CompositionSearch& search = {});

/// @return a nested model's optimum as a point of the larger composition: what is new stands where
/// it vanishes or, when it has none such, at its magnitude.
CompositionPoint embedded(const BatteryModel& nested, const CompositionPoint& point,
                          const BatteryModel& larger);

/// Moves a point's parameters and states to those that another composition has, too.
void takeShared(const BatteryModel& from, const CompositionPoint& there, const BatteryModel& model,
                CompositionPoint& point);

/// @return base parameters at Table I's magnitudes, u_dc from the mean voltage, everything
/// else typical and at rest.
CompositionPoint typicalStart(const BatteryModel& model, const InputSequence& inputs);

/// The equations' course through a window: what a regression is fitted to, and what is modelled.
struct Course : ResidualSamples {
  std::vector<double> voltage, current;  ///< modelled; measured where it is the input [V], [A]
  InputMemory memory;                    ///< at the end
};

/// @return one entry a sample. @param start at the inputs' first time.
Course courseOf(const BatteryModel& model, const ModelPoint& start, const InputSequence& inputs);

/**
 * @brief Runs work(0) to work(count - 1) on up to `threads` threads.
 *
 * Every call writes to its own place, so results do not depend on the number of threads. The first
 * exception, by index, is thrown again once all have ended.
 *
 * @param threads at least 1; 0 for as many as the machine has.
 */
void parallelFor(std::size_t count, int threads, const std::function<void(std::size_t)>& work);

}  // namespace battery_sof
