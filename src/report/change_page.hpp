#pragma once

#include <string>
#include <vector>

#include "battery_sof/series.hpp"
#include "diagnosis/change.hpp"

namespace battery_sof {

/// What is drawn of one side of a comparison.
struct ComparedSide {
  std::vector<std::string> names;  ///< of recordings and model files
  std::vector<Series> series;      ///< of the recordings; none of a model file
};

/**
 * @brief A comparison with a reference as one HTML document that opens from disk: style, drawings and
 * the result as JSON (dataHtml()) inside, no script, no network.
 *
 * Both sides stand next to each other with the same axes, and each change has a picture: every
 * quantity that was compared, now and in the reference with the change put in, as its distance from
 * the reference in standard deviations of the difference of two sound trips.
 */
std::string changePage(const ChangeDiagnosis& diagnosis, const ComparedSide& then,
                       const ComparedSide& now);

}  // namespace battery_sof
