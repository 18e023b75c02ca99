#include "stage_name.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "diagnosis/profile_interval.hpp"
#include "estimation/composition_identification.hpp"
#include "estimation/identification.hpp"
#include "state/state_estimator.hpp"

namespace battery_sof {
namespace {

constexpr double kTwoSided = 1.96;          // standard deviations of a 95 % interval
constexpr double kFaultProbability = 0.95;  // [1], of what the screen found

FittedModel completed(const WhitenedFit& fit, const Prepared& prepared,
                      const std::string& recording) {
  const Screening& screened = prepared.screened;
  IdentifyOptions options;
  options.effects = fit.model.effects();
  options.priors = prepared.search.priors;
  options.discrepancy = fit.model.discrepancy();
  options.masked = screened.limits.masked;
  options.voltage_lsb_std = screened.limits.voltage_lsb_std;
  FittedModel model =
      completedModel(screened.series, prepared.parts.train, options, fit.point, fit.noise);
  fitErrors(model, screened.series, prepared.parts.train);
  model.provenance.recording = recording;
  return model;
}

/// Where a source controls the voltage, both models are fitted in the direction that is controlled;
/// the extended one with what its window teaches.
void takeBothWays(Named& named, const Prepared& prepared, const Explained& explained,
                  const std::string& recording) {
  IdentifyOptions options;
  options.masked = prepared.screened.limits.masked;
  options.source = explained.driving;
  options.priors = prepared.search.priors;
  FittedModel base = identify(prepared.screened.series, prepared.parts.train, options);
  options.effects = explained.explanation.model.effects();
  options.chooses_effects = !explained.hasEffects();
  const bool lacks_something = !explained.explanation.terms.empty();
  named.extended =
      lacks_something ? identify(prepared.screened.series, prepared.parts.train, options) : base;
  named.extended.provenance.recording = recording;
  base.fit.residual_regression = ResidualRegression();
  base.intervals.event_history = EventHistory();
  named.base_both_ways = std::move(base);
}

/// Interval by profile likelihood; by the standard error where the model was fitted in the other
/// direction than `fit`.
DiagnosedParameter withInterval(const ParameterEstimate& estimate, const ParameterInfo& info,
                                const WhitenedFit& fit, const InputSequence& inputs,
                                bool is_driven) {
  DiagnosedParameter parameter{estimate.name, estimate.unit, estimate.value,   estimate.std,
                               std::nullopt,  std::nullopt,  estimate.at_bound};
  const double first = estimate.std ? kTwoSided * *estimate.std : 0.2 * std::abs(estimate.value);
  if (!(first > 0.0) || (is_driven && !estimate.std)) return parameter;
  if (is_driven) {
    parameter.lower = std::max(info.lower, estimate.value - first);
    parameter.upper = std::min(info.upper, estimate.value + first);
    return parameter;
  }
  const ProfileInterval interval = profileInterval(fit, inputs, estimate.name, first);
  // Ends are carried over as distances: the other grid's optimum differs by a share of a standard
  // error.
  const double center = fit.point.parameters[*fit.model.parameterRow(info.name)];
  if (interval.lower)
    parameter.lower = std::max(info.lower, estimate.value - (center - *interval.lower));
  if (interval.upper)
    parameter.upper = std::min(info.upper, estimate.value + (*interval.upper - center));
  return parameter;
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
void takeEffect(Named& named, const SelectedTerm& one, const WhitenedFit& fit,
                const InputSequence& inputs, bool is_driven) {
  NamedEffect effect{one.member,
                     one.probability,
                     biasedParameters(named.base.fit, named.extended.fit),
                     {},
                     one.gain,
                     one.rms,
                     one.indistinguishable,
                     mechanismId(one.mechanism),
                     one.probability};
  for (const ParameterInfo& info : effectInfo(one.member).parameters)
    for (const ParameterEstimate& estimate : named.extended.fit.estimates)
      if (estimate.name == info.name && !estimate.held)
        effect.parameters.push_back(withInterval(estimate, info, fit, inputs, is_driven));
  const double each = one.probability / static_cast<double>(1 + one.indistinguishable.size());
  if (!one.indistinguishable.empty()) effect.confidence = each;
  named.effects.push_back(effect);
  for (const std::string& id : one.indistinguishable) {
    NamedEffect rival{id,
                      each,
                      {},
                      {},
                      one.gain,
                      one.rms,
                      {one.member},
                      mechanismId(mechanismOf(id)),
                      one.probability};
    for (const std::string& other : one.indistinguishable)
      if (other != id) rival.indistinguishable_from.push_back(other);
    named.effects.push_back(rival);
  }
}

}  // namespace

Named nameEffects(const Recording& recording, const Prepared& prepared, const Explained& explained,
                  const FinalFit& last, const EstimatedDiscrepancy& discrepancy,
                  const Judged& judged) {
  Named named;
  named.base = completed(prepared.base, prepared, recording.name);
  if (explained.driving)
    takeBothWays(named, prepared, explained, recording.name);
  else if (discrepancy.with_discrepancy)
    named.extended = completed(*discrepancy.with_discrepancy, prepared, recording.name);
  else
    named.extended =
        explained.hasEffects() ? completed(last.fit, prepared, recording.name) : named.base;
  if (hasNoEquation(judged.verdict) || judged.verdict == Verdict::kNoMismatch) return named;
  for (const SelectedTerm& one : judged.terms)
    if (!one.member.empty())
      takeEffect(named, one, last.fit, last.inputs(prepared), explained.driving.has_value());
  if (judged.verdict == Verdict::kSensorFault)
    for (const std::string& id : prepared.screened.faults)
      named.effects.push_back({id,
                               kFaultProbability,
                               {},
                               {},
                               0.0,
                               0.0,
                               {},
                               mechanismId(Mechanism::kInstrument),
                               kFaultProbability});
  return named;
}

}  // namespace battery_sof
