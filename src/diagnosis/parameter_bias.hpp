#pragma once

#include <vector>

#include "diagnosis/diagnosis.hpp"
#include "diagnosis/regimes.hpp"
#include "diagnosis/whitened_fit.hpp"

namespace battery_sof {

/**
 * @brief Which base parameter fits better with another value where (docs/physics.md#parameter-bias-by-missing-physics).
 *
 *     s_jg = J_j 1_g,   z = (M K s)' v / (|M K s| s_v),   change = (M K s)' v / |M K s|^2,   M = 1 - Q Q'
 *
 * for r_discharge, r_charge, c2, beta, u_dc and every regime g, and for "first third", "middle
 * third", "last third" of the recording's time; s_v^2 = max(1, mean of v^2). Under the model z is
 * standard normal; the largest of all of a map is below 4 in 99.7 % of cases.
 *
 * @return entries that this recording determines: the parameters together leave more than a
 * hundredth of the signature's length,
 *   and the change is known to better than the value itself (0.5 V for u_dc).
 */
std::vector<ParameterBias> parameterBiases(const WhitenedFit& fit, const InputSequence& inputs,
                                           const std::vector<Regime>& regimes);

/**
 * @brief Whether a part of a recording fits better with another part's parameters than with its
 * own: E_k(theta_j) < E_k(theta_k) - 12.
 *
 * E_k(theta_j): v' v of part k under its own noise at the parameters of part j, from its own fit's
 * first state [1]. That is no physics but an optimiser that stopped early
 * (docs/physics.md#parameter-bias-by-missing-physics). Less than 12 could not be taken for a mismatch.
 *
 * @param part with its own fit.  @param other the other part's parameters, of the same composition.
 */
bool optimiserFailed(const InputSequence& part, const WhitenedFit& own,
                     const Eigen::VectorXd& other);

}  // namespace battery_sof
