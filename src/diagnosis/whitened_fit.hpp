#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "estimation/composition_fit.hpp"

namespace battery_sof {

/**
 * @brief A composition fitted to a sequence under its own noise model, with all that tests on its
 * residual need.
 *
 *     e = u_b - u_m,   v = K e   (Whitening),   Q: orthonormal basis of K J, J = d u_m / d coordinates
 *
 * What parameters take up lies in the span of Q: a signature s counts by (1 - Q Q') K s
 * (docs/physics.md#what-the-base-circuit-absorbs).
 */
struct WhitenedFit {
  BatteryModel model = BatteryModel();
  CompositionPoint point;
  NoiseModel noise;
  Eigen::VectorXd residual;    ///< e [V], one a sample of the inputs
  Eigen::VectorXd innovation;  ///< v [1]
  /// J [V], samples x coordinates (CompositionProblem::coordinatesOf)
  Eigen::MatrixXd jacobian;
  Eigen::MatrixXd biased;          ///< Q, samples x rank
  std::vector<Eigen::Index> rows;  ///< of (parameters, first states) that each coordinate moves
  double deviance = 0.0;           ///< -2 ln likelihood with priors
  std::vector<KnownParameter> known = {};  ///< priors in place of the catalogue's
};

struct WhitenedSearch : CompositionSearch {
  WhitenedSearch() { max_iterations = 40; }
  int rounds = 2;                            ///< of noise and parameters in turns
  double min_white = 1e-5;                   ///< [V], see fitNoise()
  std::vector<KnownPopulation> priors = {};  ///< in place of the catalogue's
};

/**
 * @brief Fits parameters and noise in turns, from every start, and keeps what is most likely.
 * @param starts at least one. @param noise of the first round; none: from a fit of unweighted
 * squares.
 */
WhitenedFit fitWhitened(const BatteryModel& model, const InputSequence& inputs,
                        const std::vector<CompositionPoint>& starts,
                        const std::optional<NoiseModel>& noise, const WhitenedSearch& search = {});

/// @param columns [V], samples x columns; taken in place.  @return K s for each.
Eigen::MatrixXd whitened(const WhitenedFit& fit, const InputSequence& inputs,
                         Eigen::MatrixXd columns);

/**
 * @brief The same inputs without the samples around edges of the current: they are inputs and
 * do not count.
 *
 * What happens within a tenth of a second of an edge is the instruments' and the fastest processes'
 * and says nothing of slower physics; for those this hides it.
 *
 * The sequence's beginning, and what follows a gap, is an edge: the current before is not known.
 *
 * Where the current changes sign the resistance changes too, and a filter before the sampling does
 * not commute with that: a fifth of an edge is enough there.
 *
 * @param edge [A], a change between neighbouring samples above it is an edge; infinite: only
 * beginnings.  @param before, after [s] around it.
 */
InputSequence withoutEdges(const InputSequence& inputs, double edge, double before, double after);

/// @return terminal voltage of every sample of the inputs [V].
Eigen::VectorXd simulatedVoltage(const BatteryModel& model, const CompositionPoint& point,
                                 const InputSequence& inputs);

/// Columns as the innovation sees them once the parameters had their share.
struct Signatures {
  Eigen::MatrixXd columns;  ///< (1 - Q Q') K s, samples x columns
  Eigen::VectorXd length;   ///< |K s|
};

/// @param columns as of whitened().
Signatures signaturesOf(const WhitenedFit& fit, const InputSequence& inputs,
                        Eigen::MatrixXd columns);

}  // namespace battery_sof
