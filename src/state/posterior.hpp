#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "state/fitted_model.hpp"

namespace battery_sof {

/// What other batteries say of a parameter before this one is measured, in place of the catalogue's
/// prior.
struct KnownParameter {
  std::string name;
  double value = 0.0;  ///< in the parameter's unit
  /// of the logarithm when logarithmic, else in the parameter's unit; > 0
  double std = 0.0;
  bool logarithmic = false;  ///< then value is the geometric mean
};

/// What a population says, of fits with the same effects.
struct KnownPopulation {
  std::vector<std::string> effects;  ///< ids, in any order
  std::vector<KnownParameter> parameters;
};

/// @return what is known of a composition's parameters: of the population of exactly these effects,
/// in any order; empty without one.
std::vector<KnownParameter> knownOf(const std::vector<KnownPopulation>& populations,
                                    const std::vector<std::string>& effects);

/// @return what is known of a parameter; nullptr: nothing.
const KnownParameter* find(const std::vector<KnownParameter>& known, const std::string& name);

/// @return the standard error below which a parameter counts as determined: half of its value, 0.5 V
/// of u_dc.
double determinedBelow(const Fit& fit, std::size_t row);

/// Takes standard errors from the covariance, and what they determine (determinedBelow()). One without a variance stays as it is.
void takeStandardErrors(Fit& fit);

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

/**
 * @brief How far the beginning of a trip is from what a model expects: its rested voltage and its
 * first two cranks together.
 *
 *     |z_1 + ... + z_n| / sqrt(n),   n = 1, 2, 3
 *
 * Errors that were taken in one after the other are independent, so each of these is standard
 * normal. Another battery misses them all on one side.
 */
struct Surprise {
  static constexpr int kMost = 3;
  double sum = 0.0;
  int count = 0;
  double largest = 0.0;  ///< of the n so far

  void add(double z) {
    if (count == kMost) return;
    sum += z;
    largest = std::max(largest, std::abs(sum) / std::sqrt(++count));
  }
};

/// [K], up to which a window and past events describe a battery of another temperature.
inline constexpr double kTemperatureReach = 10.0;

/**
 * @brief The model after the battery was parked: what may have changed meanwhile is known less.
 *
 *     sigma^2 <- sigma^2 + p^2 (s^2 (1 - exp(-t / T)) + (k dT)^2)     of resistances, capacitance, slope
 *     sigma^2 <- sigma^2 + s_u^2 (1 - exp(-t / T)) + (k_u dT)^2       of the open-circuit voltage
 *
 * dT is the temperature less that of the model's window, 0 where either is not known. What is known
 * then holds at the new temperature (ExcitedRange::temperature). Past events of a temperature more
 * than kTemperatureReach away say nothing of the new one and are forgotten, so that an answer is as
 * wide as the covariance makes it. The constants stand with their sources in
 * docs/model.md#from-trip-to-trip.
 *
 * @param duration [s] from the model's state to the first sample of the new trip, >= 0.
 * @param temperature [K], of the battery at that sample, when known.
 */
FittedModel parked(FittedModel model, double duration, std::optional<double> temperature);

/**
 * @brief Carries what an earlier model saw of cranks over to a fit whose window had none.
 *
 * The range of discharge (ExcitedRange::min_current) is then the earlier one's too. By what both
 * differ at that current, and what the earlier one missed of cranks, is the fit's crank error:
 *
 *     sigma^2 = sigma_before^2 + ((r_d - r_d,before) i + u_dc - u_dc,before)^2
 */
void carryCranks(Fit& fit, const Fit& before);

/**
 * @brief What is known of a lead-acid battery before anything was measured: the base circuit with
 * the magnitudes of the paper's Table I, wide intervals and no window.
 *
 * Resistances scale with 1 / capacity, the capacitance with the capacity (50 Ah as in Table I).
 * The open-circuit voltage is that of six cells, 12.6 +- 0.3 V of a block.
 *
 * @param fleet means and spreads in place of these, of the parameters that it names, capacity apart.
 * @param capacity [Ah], nominal, above 0.  @param at where the first sample stands: time [s],
 * current [A], voltage [V].
 */
FittedModel populationPrior(double capacity, const std::vector<KnownParameter>& fleet, double time,
                            double current, double voltage);

}  // namespace battery_sof
