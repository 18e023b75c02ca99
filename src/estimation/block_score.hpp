#pragma once

#include <Eigen/Core>
#include <cmath>
#include <string>
#include <vector>

#include "estimation/identification.hpp"

namespace battery_sof {

/// Blocks of a score: two in each quarter of the rows, whose pairs are the half-samples of
/// mechanism_evidence.hpp.
inline constexpr std::size_t kScoreBlocks = 8;
/// Of block gains while a charger holds the voltage [1], see blockGains().
inline constexpr double kMostApart = 1.0;

/// What a composition misses of blocks of its window that its fit did not see.
struct BlockErrors {
  /// one a block: mean over its rows of the squared error, in units of the quantity's variance over
  /// the window [1]
  std::vector<double> relative;

  /// Explained variation of all blocks together [1]: 1 - sqrt(mean of relative).
  double share() const;
};

/// The same of the equations alone, and with the residual regression that is fitted to what they
/// leave of the other blocks.
struct BlockScore {
  BlockErrors equations, with_regression;
};

/// By how much one composition predicts left-out blocks better than another.
struct ScoreGain {
  /// mean over blocks of ln(squared error of the other / squared error of the one) [1], of the
  /// equations alone and with the regression in equal parts: an equation has to explain by itself,
  /// and more than a regression would. 0.06 is an error that is 3 % less.
  double value = 0.0;
  double std_error = 0.0;  ///< of the mean, from the scatter over blocks [1]
  /// Whether it exceeds two standard errors and `least`.
  bool isAbove(double least) const { return value > 2.0 * std_error && value > least; }
};

/// @param most_apart [1], of a block's gain and the median of all: a block that is missed completely
/// then neither decides alone nor sets the scatter.
/// @return one a block, of which ScoreGain::value is the mean. @throws std::invalid_argument for
/// different numbers of blocks.
std::vector<double> blockGains(const BlockScore& more, const BlockScore& less,
                               double most_apart = HUGE_VAL);

/// @param most_apart as of blockGains().
/// @return gain of `more` over `less`; both over the same blocks, two or more.
/// @throws std::invalid_argument for different numbers of blocks, or fewer than two.
ScoreGain gainOf(const BlockScore& more, const BlockScore& less, double most_apart = HUGE_VAL);

/**
 * @brief Score(S) of a composition: each block in turn is predicted by a fit to the others.
 *
 * Every fit is the Gauss-Newton step from the composition's own optimum, inside the bounds, which
 * suffices as a block is a small part; all of them come from one pass with derivatives. The rows of
 * the left-out block still drive the model, so its state there is that of a model that runs through
 * them; they cost nothing and the regression does not see them.
 *
 * @param optimum of the composition over the range.  @param options with the source, or without one
 * for the current as the input.  @param blocks of as many samples each, at least two.
 * @throws std::invalid_argument for fewer than two blocks, or an optimum without a finite voltage.
 */
BlockScore scoreBlocks(const BatteryModel& composition, const CompositionPoint& optimum,
                       const Series& series, IndexRange range, const IdentifyOptions& options,
                       std::size_t blocks);

/// @return the point at which a model of identify() stands, at its window's first sample.
CompositionPoint optimumOf(const FittedModel& model);

/// A fitted composition's cost, with the weights that its rows have at its optimum.
struct FittedCost {
  double cost = 0.0;              ///< [1]
  std::vector<double> precision;  ///< CompositionProblem::precision()
};

/// @param model of identify() over the range.
FittedCost fittedCost(const FittedModel& model, const Series& series, IndexRange range,
                      const IdentifyOptions& options);

/// What effects added to a composition promise.
struct Promise {
  /// fall of the cost, as ln likelihood of the rows that count as independent [1], >= 0; 0 also
  /// where the larger composition has no finite cost at its start
  double gain = 0.0;
  CompositionPoint point;  ///< where the fit stands, in the larger composition
};

/// @param model of identify() over the range.  @param nested its own cost, whose weights are used.
/// @param larger effects, those of the model among them.  @param steps of the fit, from
/// startsInLarger() or from `start`.
Promise promiseOf(const FittedModel& model, const FittedCost& nested,
                  const std::vector<std::string>& larger, const Series& series, IndexRange range,
                  const IdentifyOptions& options, int steps,
                  const CompositionPoint* start = nullptr);

/// What the equations alone leave of the range's rows: [A] where the voltage is the input, times
/// kOhmsOfCurrentError, and [V] elsewhere.
Eigen::VectorXd equationErrors(const FittedModel& model, const Series& series, IndexRange range,
                               const IdentifyOptions& options);

}  // namespace battery_sof
