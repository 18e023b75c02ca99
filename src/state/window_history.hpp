#pragma once

#include "model/input_sequence.hpp"
#include "state/fitted_model.hpp"

namespace battery_sof {

/**
 * @brief What a fitted window gives in addition to the parameters: the baseline predictors,
 * the residual regression, past cranks and charges.
 *
 * Sets baseline, source, residual_regression and event_history, and the state's memory. Of the
 * window's own charges `modelled` holds what the equations and a regression without the charge's
 * block say, so that past errors are not those of a fit to itself.
 *
 * @param model fitted to the range, with its first_state.  @param inputs of the range, as it was
 * fitted.
 */
void followWindow(FittedModel& model, const Series& series, IndexRange range,
                  const InputSequence& inputs, const ControlModes& source);

}  // namespace battery_sof
