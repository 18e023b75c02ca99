#include "stage_fit.hpp"

#include <algorithm>

#include "diagnosis/timing_jitter_noise.hpp"

namespace battery_sof {

FinalFit fitExplained(const Prepared& prepared, const Explained& explained) {
  const Explanation& explanation = explained.explanation;
  const std::vector<std::string>& ids = explanation.model.effects();
  const bool is_slow = prepared.screened.slow;
  FinalFit last;
  last.at_edges = !is_slow && std::any_of(ids.begin(), ids.end(), [](const std::string& id) {
    return effectInfo(id).acts_at_edges;
  });
  last.quiet = is_slow ? TimingJitterNoise::weighed(prepared.quiet, explanation.edge_jitter)
                       : prepared.quiet;
  last.fit = ids.empty() || explained.driving
                 ? prepared.base
                 : fitWhitened(explanation.model, last.inputs(prepared), {explanation.point},
                               std::nullopt, prepared.search);
  return last;
}

}  // namespace battery_sof
