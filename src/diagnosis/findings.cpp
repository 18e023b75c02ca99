#include "diagnosis/model_selection.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "diagnosis/explanation_fits.hpp"
#include "diagnosis/slow_tone.hpp"
#include "diagnosis/timing_jitter_noise.hpp"
#include "diagnosis/verdict.hpp"
#include "state/state_estimator.hpp"
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
    square += count * (std::pow(fit.residual[n], 2) - std::pow(voltage_lsb_std, 2)) -
              std::pow(fit.noise.white_std, 2);
    counted += count;
  }
  return counted > 0.0 && square > 0.0 ? std::sqrt(square / counted) : 0.0;
}

/// What speaks for something in addition where no effect explains.
Unexplained restOf(const Residuals& residuals, double edge_jitter, const Diagnosis& found) {
  const InputSequence inputs = residuals.screened.slow
                                   ? TimingJitterNoise::weighed(residuals.quiet, edge_jitter)
                                   : residuals.quiet;
  Unexplained rest;
  const std::optional<SlowTone> tone = slowTone(residuals.base, inputs);
  // RMS of a tone
  rest.is_tone = tone && tone->amplitude >= std::sqrt(2.0) * found.unexplained.limits.rmse;
  rest.has_discrepancy = found.discrepancy && found.discrepancy->holds();
  // Blocks that are left out are missed by more than what is missing where a short recording hardly
  // determines the parameters.
  if (found.discrepancy)
    rest.rmse = std::min(found.discrepancy->left_out.base,
                         leftOf(residuals.base, inputs, residuals.screened.limits.voltage_lsb_std));
  return rest;
}

/// What is reported of an explanation: effects by their evidence; a mechanism that its regressors
/// alone represent where what they estimated holds on blocks that were left out. Ageing is reported
/// by its evidence: how far it had come in a block the others do not say.
std::vector<SelectedTerm> confirmed(std::vector<SelectedTerm> terms, bool holds) {
  const auto is_untold = [&](const SelectedTerm& one) {
    return one.member.empty() && !holds && one.mechanism != Mechanism::kAgeing;
  };
  terms.erase(std::remove_if(terms.begin(), terms.end(), is_untold), terms.end());
  return terms;
}

std::string rejection(const Candidate& candidate, const std::vector<SelectedTerm>& terms) {
  for (const SelectedTerm& one : terms)
    if (contains(one.indistinguishable, candidate.id))
      return "it fits as well as " + one.member + ", which is in the model";
  if (candidate.evidence < kMinGain) return "its evidence is too small";
  return terms.empty() ? "its effect is too small to matter"
                       : "what was accepted instead explains more of the error";
}

/// Every effect that was fitted, with why it was not taken.
std::vector<Candidate> candidatesOf(const std::vector<WeighedMember>& weighed,
                                    const std::vector<SelectedTerm>& terms) {
  std::vector<Candidate> candidates;
  for (const WeighedMember& one : weighed) {
    Candidate& candidate = candidates.emplace_back();
    candidate.id = one.id;
    candidate.evidence = one.gain;
    candidate.score = one.score;
    candidate.mechanism = mechanismId(mechanismOf(one.id));
    const auto accepted = std::find_if(terms.begin(), terms.end(), [&](const SelectedTerm& term) {
      return term.member == one.id;
    });
    if (accepted == terms.end()) {
      candidate.rejected_because = rejection(candidate, terms);
      continue;
    }
    candidate.evidence = std::max(one.gain, accepted->gain);
    candidate.confidence = accepted->probability;
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) {
                     return std::make_pair(a.rejected_because.empty(), a.evidence) >
                            std::make_pair(b.rejected_because.empty(), b.evidence);
                   });
  return candidates;
}

/// Gain of ln evidence by each mechanism: what was accepted of it, and what does as well.
/// @param half sample of the rows; none: of all.
std::array<double, kMechanisms> gainsOf(const std::vector<SelectedTerm>& terms,
                                        std::optional<std::size_t> half) {
  std::array<double, kMechanisms> gains{};
  for (const SelectedTerm& one : terms) {
    std::set<Mechanism> claimed = {one.mechanism};
    for (const std::string& id : one.indistinguishable) claimed.insert(mechanismOf(id));
    for (const Mechanism mechanism : claimed)
      gains[static_cast<std::size_t>(mechanism)] +=
          std::max(0.0, half ? one.half_gains[*half] : one.gain);
  }
  return gains;
}

/// Likely mechanisms by the evidence and by what was accepted, the square root of a mechanism's
/// share of the gain. The first of them is the finding's, and its effect comes first of the terms;
/// of the others each has its share of what those before it leave. What is no lead-acid battery has
/// none of lead and acid.
/// @param accepted also what is not reported, as it does not hold on left-out blocks.
/// @param terms take their probabilities.
void takeMechanisms(const std::vector<SelectedTerm>& accepted, bool is_lead_acid,
                    std::vector<SelectedTerm>& terms, Diagnosis& found) {
  const std::array<double, kMechanisms> whole = gainsOf(accepted, std::nullopt);
  const auto most = std::max_element(whole.begin(), whole.end()) - whole.begin();
  if (!is_lead_acid && isOfLeadAcid(kAllMechanisms[most])) return;
  for (std::size_t half = 0; half < found.mechanism_evidence.size(); ++half) {
    const std::array<double, kMechanisms> gains = gainsOf(accepted, half);
    const double largest = std::max(*std::max_element(gains.begin(), gains.end()), 1e-12);
    for (std::size_t k = 0; k < kMechanisms; ++k)
      found.mechanism_evidence[half][k].accepted = std::sqrt(gains[k] / largest);
  }
  found.mechanisms = likelyMechanisms(found.mechanism_evidence, is_lead_acid);
  found.mechanism = found.mechanisms.front().mechanism;
  found.probability = found.mechanisms.front().probability;
  std::stable_partition(terms.begin(), terms.end(), [&](const SelectedTerm& one) {
    return one.mechanism == *found.mechanism && !one.member.empty();
  });
  std::map<Mechanism, double> shares;
  for (const MechanismProbability& one :
       mechanismProbabilities(found.mechanism_evidence, is_lead_acid))
    shares[one.mechanism] = one.probability;
  double left = 1.0;
  std::map<Mechanism, double> given;
  for (SelectedTerm& term : terms) {
    const double share = shares[term.mechanism];
    if (given.emplace(term.mechanism, std::min(1.0, share / left)).second)
      left = std::max(left - share, 1e-12);
    term.probability = given[term.mechanism];
  }
}

std::vector<DetectionLimit> detectionLimitsOf(std::vector<DetectionLimit> limits, bool is_noise) {
  for (DetectionLimit& one : limits) {
    if (!is_noise) one.strength.reset();
    one.visible = one.strength && std::abs(*one.strength) <= std::abs(one.typical);
  }
  return limits;
}

constexpr double kTwoSided = 1.96;          // standard deviations of a 95 % interval
constexpr double kFaultProbability = 0.95;  // [1], of what the screen found

FittedModel completed(const Optimum& at, const Residuals& residuals, const std::string& recording) {
  const Screening& screened = residuals.screened;
  IdentifyOptions options;
  options.effects = at.model.effects();
  options.priors = residuals.search.priors;
  options.crank_current = residuals.crank_current;
  options.discrepancy = at.model.discrepancy();
  options.masked = screened.limits.masked;
  FittedModel model = completedModel(screened.series, residuals.parts.train, options, at.point);
  fitErrors(model, screened.series, residuals.parts.train);
  model.provenance.recording = recording;
  return model;
}

/// @param series that it was fitted to.
FittedModel completed(FittedModel model, const Series& series, IndexRange train,
                      const std::string& recording) {
  fitErrors(model, series, train);
  model.provenance.recording = recording;
  return model;
}

/// Interval by the standard error.
DiagnosedParameter withInterval(const ParameterEstimate& estimate, const ParameterInfo& info) {
  DiagnosedParameter parameter{estimate.name, estimate.unit, estimate.value,   estimate.std,
                               std::nullopt,  std::nullopt,  estimate.at_bound};
  if (!estimate.std || !(*estimate.std > 0.0)) return parameter;
  parameter.lower = std::max(info.lower, estimate.value - kTwoSided * *estimate.std);
  parameter.upper = std::min(info.upper, estimate.value + kTwoSided * *estimate.std);
  return parameter;
}

NamedEffect namedEffect(const std::string& id, Mechanism mechanism, double probability) {
  NamedEffect effect;
  effect.id = id;
  effect.confidence = effect.probability = probability;
  effect.mechanism = mechanismId(mechanism);
  return effect;
}

/// Base parameters that moved by more than a tenth, or two standard errors, once the effects were
/// in.
std::vector<std::string> biasedParameters(const Fit& base, const Fit& extended) {
  std::vector<std::pair<double, std::string>> moved;
  for (std::size_t j = 0; j < static_cast<std::size_t>(kRowUDc); ++j) {
    const ParameterEstimate& before = base.estimates[j];
    const ParameterEstimate& after = extended.estimates[j];
    const double by = std::abs(before.value - after.value);
    const double noise = std::hypot(before.std.value_or(0.0), after.std.value_or(0.0));
    if (by > 0.1 * std::abs(before.value) && by > 2.0 * noise)
      moved.push_back({by / std::abs(before.value), before.name});
  }
  std::stable_sort(moved.begin(), moved.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<std::string> names;
  for (const auto& one : moved) names.push_back(one.second);
  return names;
}

/// A component's effect, then those that would do as well.
void takeEffect(const SelectedTerm& one, Diagnosis& found) {
  std::vector<std::string> alike = {one.member};
  alike.insert(alike.end(), one.indistinguishable.begin(), one.indistinguishable.end());
  for (const std::string& id : alike) {
    NamedEffect effect = namedEffect(id, mechanismOf(id), one.probability);
    effect.confidence = one.probability / static_cast<double>(alike.size());
    effect.evidence = one.gain;
    effect.voltage_rms = one.rms;
    std::copy_if(alike.begin(), alike.end(), std::back_inserter(effect.indistinguishable_from),
                 [&](const std::string& other) { return other != id; });
    if (id == one.member) {
      effect.biased_parameters = biasedParameters(found.base.fit, found.extended.fit);
      for (const ParameterInfo& info : effectInfo(id).parameters)
        for (const ParameterEstimate& estimate : found.extended.fit.estimates)
          if (estimate.name == info.name && !estimate.held)
            effect.parameters.push_back(withInterval(estimate, info));
    }
    found.effects.push_back(effect);
  }
}

/// What the screen found; an effect may have found it, too.
void takeFault(const std::string& id, Diagnosis& found) {
  const auto known = std::find_if(found.effects.begin(), found.effects.end(),
                                  [&](const NamedEffect& effect) { return effect.id == id; });
  if (known == found.effects.end())
    found.effects.push_back(namedEffect(id, Mechanism::kInstrument, kFaultProbability));
  else
    known->confidence = known->probability = std::max(known->probability, kFaultProbability);
}

/// @param terms that are reported, the likeliest mechanism's first.
void nameEffects(const Recording& recording, const Residuals& residuals,
                 const std::vector<SelectedTerm>& terms, const ModelSelection& selected,
                 Diagnosis& found) {
  const auto& [driving, explanation, circuit, extended, by_blocks, is_lead_acid] =
      selected.explained;
  const IndexRange train = residuals.parts.train;
  const Series& fitted = by_blocks ? recording.series : residuals.screened.series;
  found.base =
      circuit ? completed(*circuit, recording.series, train, recording.name)
              : completed({residuals.base.model, residuals.base.point}, residuals, recording.name);
  if (selected.with_discrepancy)
    found.extended = completed(*selected.with_discrepancy, residuals, recording.name);
  else
    found.extended = extended ? completed(*extended, fitted, train, recording.name) : found.base;
  if (hasNoEquation(found.verdict) || found.verdict == Verdict::kNoMismatch) return;
  for (const SelectedTerm& one : terms)
    if (!one.member.empty()) takeEffect(one, found);
  if (found.verdict == Verdict::kSensorFault)
    for (const std::string& id : residuals.screened.faults) takeFault(id, found);
}

}  // namespace

void judgeFindings(const Recording& recording, const Residuals& residuals,
                   const DiagnoseOptions& options, ModelSelection& selected, Diagnosis& found) {
  const Explanation& explanation = selected.explained.explanation;
  const bool is_lead_acid = selected.explained.is_lead_acid;
  const Unexplained rest = restOf(residuals, explanation.edge_jitter, found);
  std::vector<SelectedTerm> terms = confirmed(explanation.terms, rest.has_discrepancy);
  if (options.given.empty()) removeSmall(terms);
  found.mechanism_evidence = explanation.mechanisms;
  if (!terms.empty()) takeMechanisms(explanation.terms, is_lead_acid, terms, found);
  found.verdict = judge(terms, residuals.screened.faults, rest);
  if (terms.empty() && found.verdict == Verdict::kUnexplained && rest.has_discrepancy &&
      !found.discrepancy->mechanisms.empty()) {
    SelectedTerm estimated{found.discrepancy->mechanisms.front().mechanism, "", 1.0, 0.0, {}, 0.0};
    estimated.half_gains.assign(found.mechanism_evidence.size(), 1.0);
    takeMechanisms({estimated}, is_lead_acid, terms, found);
  }
  if (!is_lead_acid) found.mechanism_evidence.clear();
  if (found.mechanism) found.verdict = withMechanism(found.verdict, terms, *found.mechanism);
  found.candidates = candidatesOf(explanation.weighed, terms);
  if (options.lists_detection_limits)
    found.detection_limits =
        detectionLimitsOf(explanation.detection_limits, found.unexplained.isNoise());
  pulse(options);
  nameEffects(recording, residuals, terms, selected, found);
}

}  // namespace battery_sof
