#pragma once

#include <optional>

#include "stage_prepare.hpp"

namespace battery_sof {

/// A diagnosis made so far, into whose recording an effect can be injected.
struct Confirmation {
  const Recording& recording;
  const Prepared& prepared;
  const WhitenedFit& fit;  ///< the model to which the effect is added
};

/**
 * @brief Raises a strength until a diagnosis of the recording with the effect put in names it.
 *
 * @param one its strength is where to begin.
 * @return the strength; none where no diagnosis names it.
 */
std::optional<double> confirmedStrength(const Confirmation& confirmation, const DetectionLimit& one,
                                        const DiagnoseOptions& options);

}  // namespace battery_sof
