#pragma once

#include "estimation/base_normal_equations.hpp"
#include "estimation/composition_fit.hpp"
#include "estimation/identification.hpp"

namespace battery_sof {

/**
 * @brief Default search: c2, beta (as logarithms) and the first state by Levenberg-Marquardt inside
 * Table I's bounds; r_discharge, r_charge and u_dc solved exactly, inside their bounds, at every
 * point (variable projection, Kaufman 1975). Long windows are first approached on averages of twenty
 * samples.
 *
 * A last step that promises less than 1e-5 of the cost (0.5 standard errors in 24,000 samples) is
 * taken on the strength of the linearised model; its error is of second order. The optimum is that
 * of all samples to better than 1e-4.
 *
 * @param equations of the samples.
 */
CompositionFit searchWindow(const WindowSamples& samples, const BaseNormalEquations& equations,
                            const IdentifyOptions& options);

/**
 * @brief The paper's search: four normalised tunables, eqs. 3, 4 and 5, exponential penalty beyond
 * the bounds.
 *
 * The first sample sets the state (eq. 5) and is left out of the sums (n = 2 to N in eqs. 3 and 4).
 *
 * The penalty adds the squared residual (exp(10 d) - 1) 1 V for a relative excess d beyond a bound.
 * The paper gives no constants: ten per cent beyond a bound costs as much as one sample wrong by
 * 1.7 V.
 * @return of `at` the cost alone.
 */
CompositionFit searchAsInPaper(const WindowSamples& samples, const IdentifyOptions& options,
                               const Sample& first);

}  // namespace battery_sof
