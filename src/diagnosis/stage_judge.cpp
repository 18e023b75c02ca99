#include "stage_judge.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "confirmation.hpp"
#include "diagnosis/slow_tone.hpp"
#include "diagnosis/verdict.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

/// RMS of what a fit leaves of its samples apart from white noise and rounding [V]; samples weigh
/// by their count, which edges of a slow sampling make less.
double leftOf(const WhitenedFit& fit, const InputSequence& inputs, double voltage_lsb_std) {
  double square = 0.0, counted = 0.0;
  for (std::size_t n = 0; n < inputs.samples.size(); ++n) {
    const double count = inputs.samples[n].count;
    if (!(count > 0.0)) continue;
    square += count * (std::pow(fit.residual[static_cast<Eigen::Index>(n)], 2) -
                       std::pow(voltage_lsb_std, 2)) -
              std::pow(fit.noise.white_std, 2);
    counted += count;
  }
  return counted > 0.0 && square > 0.0 ? std::sqrt(square / counted) : 0.0;
}

Unexplained restOf(const Prepared& prepared, const FinalFit& last,
                   const EstimatedDiscrepancy& discrepancy) {
  Unexplained rest;
  const std::optional<SlowTone> tone = slowTone(last.fit, last.inputs(prepared));
  // RMS of a tone
  rest.is_tone = tone && tone->amplitude >= std::sqrt(2.0) * discrepancy.unexplained.limits.rmse;
  rest.has_discrepancy = discrepancy.holds();
  // Blocks that are left out are missed by more than what is missing where a short recording hardly
  // determines the parameters.
  if (discrepancy.finding)
    rest.rmse =
        std::min(discrepancy.finding->left_out.base,
                 leftOf(last.fit, last.inputs(prepared), prepared.screened.limits.voltage_lsb_std));
  return rest;
}

/// What is reported an explanation: effects by their evidence; a mechanism that its regressors
/// alone represent where what they estimated holds on blocks that were left out. Ageing is reported
/// by its evidence: how far it had come in a block the others do not say.
Explanation confirmed(Explanation explanation, const EstimatedDiscrepancy& discrepancy) {
  const auto is_untold = [&](const SelectedTerm& one) {
    return one.member.empty() && !discrepancy.holds() && one.mechanism != Mechanism::kAgeing;
  };
  std::vector<SelectedTerm>& all = explanation.terms;
  all.erase(std::remove_if(all.begin(), all.end(), is_untold), all.end());
  return explanation;
}

std::string rejection(const Candidate& candidate, const std::vector<SelectedTerm>& terms) {
  for (const SelectedTerm& one : terms)
    if (contains(one.indistinguishable, candidate.id))
      return "does as well as " + one.member + ", which stands in the model";
  if (candidate.evidence < ExplanationRules().min_gain) return "the recording hardly speaks for it";
  return terms.empty() ? "what it adds is too small to matter"
                       : "what was taken instead explains more of the error";
}

/// Every effect that was fitted once, at its best gain.
std::vector<Candidate> weighedOnce(const std::vector<WeighedMember>& weighed) {
  std::vector<Candidate> candidates;
  for (const WeighedMember& one : weighed) {
    const auto known = std::find_if(candidates.begin(), candidates.end(),
                                    [&](const Candidate& c) { return c.id == one.id; });
    if (known == candidates.end())
      candidates.push_back({one.id, one.gain, 0.0, "", mechanismId(mechanismOf(one.id))});
    else
      known->evidence = std::max(known->evidence, one.gain);
  }
  return candidates;
}

/// The same, with why it was not taken.
std::vector<Candidate> candidatesOf(const std::vector<WeighedMember>& weighed,
                                    const std::vector<SelectedTerm>& terms) {
  std::vector<Candidate> candidates = weighedOnce(weighed);
  for (Candidate& candidate : candidates) {
    const auto accepted = std::find_if(terms.begin(), terms.end(), [&](const SelectedTerm& one) {
      return one.member == candidate.id;
    });
    if (accepted == terms.end()) {
      candidate.rejected_because = rejection(candidate, terms);
      continue;
    }
    candidate.evidence = accepted->gain;
    candidate.confidence = accepted->probability;
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) {
                     return std::make_pair(a.rejected_because.empty(), a.evidence) >
                            std::make_pair(b.rejected_because.empty(), b.evidence);
                   });
  return candidates;
}

/// Mechanisms that were accepted, and those of what does as well.
std::vector<Mechanism> acceptedOf(const std::vector<SelectedTerm>& terms) {
  std::vector<Mechanism> accepted;
  for (const SelectedTerm& one : terms) {
    accepted.push_back(one.mechanism);
    for (const std::string& id : one.indistinguishable) accepted.push_back(mechanismOf(id));
  }
  return accepted;
}

/// Likely mechanisms by the evidence and by what was accepted. The first of them is the finding's,
/// and its effect comes first of the terms; of the others each has its share of what those before
/// it leave. What is no lead-acid battery has none of lead and acid.
void takeMechanisms(Judged& judged, const std::vector<Mechanism>& accepted, bool is_lead_acid) {
  if (accepted.empty() || (!is_lead_acid && isOfLeadAcid(accepted.front()))) return;
  for (const Mechanism one : accepted)
    judged.evidence[static_cast<std::size_t>(one)].accepted = 1.0;
  judged.mechanisms = likelyMechanisms(judged.evidence, is_lead_acid);
  judged.mechanism = judged.mechanisms.front().mechanism;
  judged.probability = judged.mechanisms.front().probability;
  std::stable_partition(judged.terms.begin(), judged.terms.end(), [&](const SelectedTerm& one) {
    return one.mechanism == *judged.mechanism && !one.member.empty();
  });
  std::map<Mechanism, double> shares;
  for (const MechanismProbability& one : mechanismProbabilities(judged.evidence, is_lead_acid))
    shares[one.mechanism] = one.probability;
  double left = 1.0;
  std::map<Mechanism, double> given;
  for (SelectedTerm& term : judged.terms) {
    const double share = shares[term.mechanism];
    if (given.emplace(term.mechanism, std::min(1.0, share / left)).second)
      left = std::max(left - share, 1e-12);
    term.probability = given[term.mechanism];
  }
}

std::vector<DetectionLimit> detectionLimitsOf(const std::vector<LinearDetectionLimit>& all,
                                              const UnexplainedPart& left,
                                              const Confirmation& confirmation,
                                              const DiagnoseOptions& options) {
  std::vector<DetectionLimit> detection_limits;
  for (const LinearDetectionLimit& least : all) {
    if (least.parameter.empty()) continue;
    DetectionLimit one{least.id, least.parameter, least.unit, std::nullopt, least.typical, false};
    if (left.isNoise()) one.strength = least.strength;
    if (contains(options.confirm, one.id))
      one.strength = confirmedStrength(confirmation, one, options);
    one.visible = one.strength && std::abs(*one.strength) <= std::abs(one.typical);
    detection_limits.push_back(one);
  }
  return detection_limits;
}

}  // namespace

Judged judgeFindings(const Recording& recording, const Prepared& prepared,
                     const Explained& explained, const FinalFit& last,
                     const EstimatedDiscrepancy& discrepancy, const DiagnoseOptions& options) {
  const Unexplained rest = restOf(prepared, last, discrepancy);
  Explanation explanation = confirmed(explained.explanation, discrepancy);
  Judged judged;
  judged.terms = explanation.terms;
  judged.evidence = explanation.mechanisms;
  takeMechanisms(judged, acceptedOf(judged.terms), explained.is_lead_acid);
  explanation.terms = judged.terms;
  judged.verdict =
      judge(explanation, {prepared.screened.faults, prepared.screened.sentences}, rest);
  if (judged.terms.empty() && judged.verdict == Verdict::kUnexplained && rest.has_discrepancy &&
      !discrepancy.finding->mechanisms.empty())
    takeMechanisms(judged, {discrepancy.finding->mechanisms.front().mechanism},
                   explained.is_lead_acid);
  if (judged.mechanism)
    judged.verdict = withMechanism(judged.verdict, judged.terms, *judged.mechanism);
  judged.candidates = candidatesOf(explanation.weighed, judged.terms);
  if (options.lists_detection_limits)
    judged.detection_limits =
        detectionLimitsOf(explanation.detection_limits, discrepancy.unexplained,
                          {recording, prepared, last.fit}, options);
  return judged;
}

}  // namespace battery_sof
