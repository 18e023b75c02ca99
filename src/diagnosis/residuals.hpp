#pragma once

#include <string>
#include <vector>

#include "diagnosis/diagnose.hpp"
#include "diagnosis/regimes.hpp"
#include "diagnosis/screening.hpp"
#include "diagnosis/whitened_fit.hpp"
#include "model/input_sequence.hpp"

namespace battery_sof {

// The steps of a diagnosis, in the order of diagnose(): residualsOf(), selectModel(), validate().

/// A recording in two: what is estimated from, and what is compared with at the end.
struct Parts {
  IndexRange train, holdout;
};
/// @param holdout_share of the samples, the last ones.
Parts partsOf(const Series& series, double holdout_share);

/// A training part as it can be fitted, and the base circuit fitted to it.
struct Residuals {
  Parts parts;
  Screening screened;
  InputSequence inputs;  ///< of the training part; long ones compressed
  /// of it, without the surroundings of edges; the same where sampling is slow
  InputSequence quiet;
  WhitenedSearch search;                 ///< how compositions are fitted to them
  WhitenedFit base;                      ///< the base circuit, to quiet
  std::optional<std::string> lack;       ///< lackOfMeasurements(); nothing is fitted then
  double crank_current = kCrankCurrent;  ///< [A], DiagnoseOptions::crank_current
};

/// @param parts the training part holds what lackOf() requires.
Residuals residualsOf(const Recording& recording, const Parts& parts,
                      const DiagnoseOptions& options);

/// Says what begins; a pulse, too.
void tell(const DiagnoseOptions& options, const std::string& stage);

/// DiagnoseOptions::pulse, where one is given.
void pulse(const DiagnoseOptions& options);

}  // namespace battery_sof
