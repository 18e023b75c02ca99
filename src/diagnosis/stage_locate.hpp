#pragma once

#include <vector>

#include "diagnosis/regimes.hpp"
#include "stage_prepare.hpp"

namespace battery_sof {

/// Where the base circuit and the training part part.
struct Located {
  std::vector<Regime> regimes;  ///< one a sample of Prepared::quiet
  std::vector<RegimeFinding> findings;
  std::vector<ParameterBias> parameter_bias;
};

Located locateErrors(const Prepared& prepared);

}  // namespace battery_sof
