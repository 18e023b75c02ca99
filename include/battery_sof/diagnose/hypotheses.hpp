#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "battery_sof/diagnose/whitened_fit.hpp"

namespace battery_sof {

/**
 * @brief What an effect would add to a fit's voltage, as far as the fit's parameters cannot take it up.
 *
 *     s_j = [u_m(strength j at its magnitude) - u_m] ,   S = (1 - Q Q') K [s_1 ...],   score = |P_S v|^2 - (columns - 1)
 *
 * P_S v is the projection of the innovations on S with coefficients of the signs that the bounds allow; the score is
 * z^2 for one strength and stays comparable for several (PHYSICS 2.3). Time constants are tried over a star-shaped grid
 * around their magnitudes, instants over the recording; the best counts.
 */
struct Signature {
  std::string id;
  double score = 0.0;
  double sensitivity = 0.0;   ///< |S| at the magnitudes: the z that a typical strength would have [1]
  CompositionPoint start;     ///< of the larger composition, strengths as the projection estimates them
};

/// @return the fit's composition with one effect more, and what that one needs.
BatteryModel enlarged(const BatteryModel& model, const std::string& id);

/// @return ids of the catalogue that can be added to a composition.
std::vector<std::string> addable(const BatteryModel& model, const std::vector<std::string>& hypotheses);

/// Scores every hypothesis beside a fit, in the order of `ids`. The result does not depend on `threads`.
std::vector<Signature> screen(const WhitenedFit& fit, const Drive& drive, const std::vector<std::string>& ids,
                              int threads);

/// @return the fit with one effect more, from the nested optimum and from the signature's estimate.
WhitenedFit refit(const WhitenedFit& nested, const Drive& drive, const Signature& signature,
                  const WhitenedSearch& search);

}  // namespace battery_sof
