#pragma once

#include <string>
#include <vector>

#include "estimation/base_normal_equations.hpp"
#include "model/base_model.hpp"

namespace ceres {
class CostFunction;
}

namespace battery_sof_bench {

/// Where a contender's search ended.
struct Optimum {
  battery_sof::BaseParameters parameters;
  double u_c2_first = 0.0;  ///< [V]
  double cost = 0.0;        ///< eq. 3 [V^2]
  /// passes over the window, with or without derivatives; 0 when not counted
  int evaluations = 0;
};

/// How the model is written down for Ceres.
enum class CeresForm {
  kPlain,  ///< u_c2 is the state; every term of the step is of the differentiated type
  kTuned,  ///< exp(beta u_c2 / 2) is the state, as in our own sweep; what depends on the current
           ///< alone stays a double
};

/// How Ceres is asked to search.
struct CeresSettings {
  CeresForm form = CeresForm::kPlain;
  bool cholesky = false;  ///< DENSE_NORMAL_CHOLESKY instead of DENSE_QR
  /// Table I's, by SetParameterLowerBound; without them Ceres evaluates half as often.
  bool bounds = true;
};

/// @return "Ceres autodiff, plain, QR, bounds", and so on.
std::string toString(const CeresSettings& settings);

/// @return every combination, the one a first version would use in front.
std::vector<CeresSettings> allCeresSettings();

using Samples = std::vector<battery_sof::BaseNormalEquations::Sample>;

/// @return eq. 3 over the window, a function of the six normalised unknowns; the caller owns it.
ceres::CostFunction* makeCostFunction(const Samples& samples, CeresForm form);

/**
 * @brief Minimises eq. 3 with Ceres, derivatives by its Jets, one thread, from Table I's magnitudes
 * like ours.
 *
 * Six unknowns: r_discharge, r_charge, c2, beta (normalised by Table I's magnitudes), u_dc, u_c2 at
 * the first sample.
 * @throws std::runtime_error when Ceres does not report convergence.
 */
Optimum fitWithCeres(const Samples& samples, const CeresSettings& settings);

}  // namespace battery_sof_bench
