#pragma once

#include "estimation/fitted_model.hpp"

namespace battery_sof {

/// An error of a model and how it follows from the directions in which parameters and state are
/// uncertain.
struct Innovation {
  /// F, of parameters and states where the measurement was taken: F F' is their covariance
  Eigen::MatrixXd factor;
  double error = 0.0;        ///< measured less modelled [V], [A]
  Eigen::VectorXd modelled;  ///< h, d (modelled) / d (column of F) [V], [A]
  double std_error = 0.0;    ///< of what the model misses with the right parameters [V], [A], > 0
  /// rows of the parameters that may move; the others count as uncertain only. Empty: all, and the
  /// states
  std::vector<Eigen::Index> rows = {};
};

/**
 * @brief Takes a measurement into parameters and state: an extended Kalman filter's update.
 *
 *     K = F h / S,   S = h'h + sigma^2,   x <- x + K e,   V <- V - K (F h)' - (F h) K' + S K K'
 *
 * with K zero in the rows that may not move (a Schmidt-Kalman filter).
 *
 * x holds parameters and states, V their covariance (Fit::covariance). Parameters that are above zero by nature move by
 * p exp(dp / p); all stay inside their bounds. An error beyond four standard deviations of what is
 * expected counts as four. Parameters without a variance stay.
 *
 * @param model its state stands where the measurement was taken.
 * @return the error that remains, linearly [V], [A].
 */
double takeIn(FittedModel& model, const Innovation& innovation);

/// @return a voltage's error in standard deviations of what was expected, at least 0.1 V each [1].
double surpriseOf(const Innovation& innovation);

/**
 * @brief The model after the battery was parked: what may have changed meanwhile is known less.
 *
 *     sigma^2 <- sigma^2 + (s p)^2 (1 - exp(-t / T))   of resistances, capacitance and slope
 *     sigma^2 <- sigma^2 + s_u^2 (1 - exp(-t / T))     of the open-circuit voltage
 *
 * The constants stand with their sources in docs/model.md#from-trip-to-trip.
 *
 * @param duration [s] from the model's state to the first sample of the new trip, >= 0.
 */
FittedModel parked(FittedModel model, double duration);

/**
 * @brief What is known of a lead-acid battery before anything was measured: the base circuit with
 * the magnitudes of the paper's Table I, wide intervals and no window.
 *
 * Resistances scale with 1 / capacity, the capacitance with the capacity (50 Ah as in Table I).
 * The open-circuit voltage is that of six cells, 12.6 +- 0.3 V of a block.
 *
 * @param capacity [Ah], nominal, above 0.  @param at where the first sample stands: time [s],
 * current [A], voltage [V].
 */
FittedModel populationPrior(double capacity, double time, double current, double voltage);

/// Error of a sample that a model of another trip or of the population leaves: the root of the
/// window's squares, a crank's own where the current is one [V].
double voltageError(const Fit& fit, double current);

}  // namespace battery_sof
