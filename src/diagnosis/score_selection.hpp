#pragma once

#include <string>
#include <vector>

#include "diagnosis/diagnose.hpp"
#include "estimation/block_score.hpp"

namespace battery_sof {

/// The circuit and what was selected in addition, as identify() fits both to the training part.
struct ScoreSelection {
  FittedModel circuit, extended;    ///< the same where nothing was selected
  BlockScore circuit_score, score;  ///< of both
  std::vector<SelectedTerm> terms;  ///< largest gain first
  std::vector<WeighedMember> weighed;
};

/**
 * @brief Selects effects by how well a composition predicts left-out blocks.
 *
 * In each step the effects that promise most (promiseOf()) are scored (scoreBlocks()); the one of
 * largest gain is fitted as identify() does, and joins where its gain exceeds two standard errors
 * and the relevance. Then each member must be worth its place once more with the others. What does
 * as well in a member's step is reported as indistinguishable from it. Where a tenth of the capacity
 * was moved (movedCharge()), the open-circuit voltage is known to have moved: kMovedByCharge is taken
 * of those that do as well, stays, and the others are not reported; what needs it is weighed, too.
 * A fit begins where its effects were chosen, or at the optimum of the best known composition inside;
 * where the current is the input, at typical values, too.
 *
 * @param series, train, fit as of identify().  @param ids effects to weigh.
 * @param options where effects are given they are taken without a test, and nothing else is.
 */
ScoreSelection selectByScore(const Series& series, IndexRange train, const IdentifyOptions& fit,
                             const std::vector<std::string>& ids, const DiagnoseOptions& options);

}  // namespace battery_sof
