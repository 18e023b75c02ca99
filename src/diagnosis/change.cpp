#include "diagnosis/change.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "diagnosis/model_distance.hpp"
#include "diagnosis/response_comparison.hpp"
#include "estimation/identification.hpp"
#include "model/mechanism.hpp"
#include "prediction/scores.hpp"
#include "recording/checks.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

// of D; see docs/decisions/0021-changes-against-a-reference.md
constexpr double kLeastGain = 7.0;
constexpr double kAlike = 6.0;  // of D: a likelihood twenty times less
constexpr double kClearGain = 2.0 * kLeastGain;
// of D, what a shift of the channels may leave where they look as if the sign were wrong: five times
// what chance leaves of twelve quantities
constexpr double kExplained = 60.0;
constexpr char kNoResponses[] =
    "the reference is a model file without the responses of its recording. It is of an older "
    "version, or its recording has too few changes of current. Identify again (sof identify), or "
    "give the recording itself";

/// What no current and voltage can tell from a change, whatever is recorded.
std::vector<std::string> alwaysAlike(ChangeKind kind, double strength) {
  if (kind == ChangeKind::kContact) return {"r_discharge", "r_charge"};
  if (kind == ChangeKind::kOffset && strength > 0.0) return {"parasitic_load", "gassing"};
  return {};
}

/// The first of the candidates, with those that look like it.
Change changeOf(const ResponseComparison& comparison, const std::vector<WeighedChange>& weighed) {
  const double nothing = comparison.nothing();
  const WeighedChange best = weighed.front();
  double all = std::exp(-0.5 * (nothing - kLeastGain - best.distance)), alike = 0.0;
  Change change;
  for (const WeighedChange& one : weighed) {
    const double weight = std::exp(-0.5 * (one.distance - best.distance));
    all += weight;
    if (one.distance > best.distance + kAlike) continue;
    alike += weight;
    if (one.candidate != best.candidate) change.indistinguishable.push_back(one.candidate->id);
    for (const std::string& id : alwaysAlike(one.candidate->kind, one.strength))
      change.indistinguishable.push_back(id);
  }
  const double unit = best.candidate->isInRows() ? comparison.interval() : 1.0;
  change.id = best.candidate->id;
  change.mechanism = mechanismId(mechanismOf(change.id));
  change.now = unit * best.strength;
  change.unit = best.candidate->unit;
  change.lower = unit * best.lower;
  change.upper = unit * best.upper;
  change.probability = alike / all;
  return change;
}

std::vector<ChangeLimit> limitsOf(const ResponseComparison& comparison) {
  std::vector<ChangeLimit> limits;
  for (const CandidateChange& candidate : candidateChanges()) {
    const double strength = visibleStrength(comparison, candidate, kLeastGain);
    if (std::isfinite(strength))
      limits.push_back({candidate.id, candidate.unit,
                        strength * (candidate.isInRows() ? comparison.interval() : 1.0)});
  }
  return limits;
}

// ---------------------------------------------------------------------------------------------
// models

std::size_t longestOf(const std::vector<Series>& all) {
  const auto longest = std::max_element(
      all.begin(), all.end(), [](const auto& a, const auto& b) { return a.size() < b.size(); });
  return static_cast<std::size_t>(longest - all.begin());
}

/// A model of the samples up to one; none where it cannot be fitted.
std::optional<FittedModel> modelUpTo(const Series& series, std::size_t last) {
  FitRequest request;
  request.from = series.time.front();
  request.to = series.time[last];
  request.anyway = true;  // what must not be compared has been refused
  request.options.chooses_effects = true;
  FittedModel model = fitPlanned(series, planFit(series, request));
  if (!isUsable(model.fit)) return std::nullopt;
  return model;
}

/// The longest of the recordings, fitted as a whole; none where it cannot be.
std::optional<Modelled> fitted(const std::vector<Series>& all) {
  const Series& longest = all[longestOf(all)];
  auto model = modelUpTo(longest, longest.size() - 1);
  if (!model) return std::nullopt;
  return Modelled{longest, *std::move(model)};
}

ModelShare shareOf(const FittedModel& model, const Series& series, IndexRange range) {
  const PredictionReport report = predictRange(model, series, range).report;
  if (!report.both_ways)
    return {report.from_current.q_dyn_percent, std::nullopt, report.from_current.q_dyn_percent};
  const MixedScores& mixed = report.both_ways->mixed;
  return {mixed.share_percent, mixed.current_share_percent, mixed.voltage_share_percent};
}

std::size_t lastQuarterOf(const Series& series) { return series.size() - series.size() / 4; }

ModelShare lastQuarter(const FittedModel& model, const Series& series) {
  return shareOf(model, series, {lastQuarterOf(series), series.size()});
}

/// What a model of all that lies before it explains of the last quarter.
ModelShare ownLastQuarter(const Series& series) {
  const auto model = modelUpTo(series, lastQuarterOf(series) - 1);
  return model ? lastQuarter(*model, series) : ModelShare();
}

using StatedChanges = std::vector<WeighedChange>;

std::vector<Series> changed(std::vector<Series> all, const StatedChanges& by) {
  for (Series& series : all) {
    ResponseRows rows{series.time, series.current, series.voltage, {}, medianInterval(series)};
    rows.excluded.assign(rows.size(), 0);
    for (const WeighedChange& one : by) {
      rows.moved = one.moved;
      rows = withChange(std::move(rows), one.candidate->kind, one.strength);
    }
    series.current = rows.current;
    series.voltage = rows.voltage;
  }
  return all;
}

void keep(ChangeDiagnosis& diagnosis, const std::optional<Modelled>& present,
          const std::vector<Series>& now) {
  if (present) diagnosis.model = present->model;
  diagnosis.modelled = longestOf(now);
}

/// NOW as its instruments would have shown it without the change. A lag is put into the other
/// channel too: what both channels have does not show, and a lag that is taken out adds noise.
Series without(const WeighedChange& change, const Series& now, double reference_interval) {
  WeighedChange opposite = change;
  opposite.strength = change.candidate->kind == ChangeKind::kGain
                          ? 1.0 / (1.0 + change.strength) - 1.0
                          : -change.strength;
  if (change.candidate->isInRows()) opposite.strength *= reference_interval / medianInterval(now);
  return changed({now}, {opposite}).front();
}

/// Fits NOW and runs the reference's model on it, without the change too.
void runReferenceModel(ChangeDiagnosis& diagnosis, const std::vector<Series>& now,
                       const FittedModel& reference, const StatedChanges& stated) {
  const auto present = fitted(now);
  keep(diagnosis, present, now);
  if (!present || !isUsable(reference.fit)) return;
  Series as_then = present->series;
  for (const WeighedChange& change : stated)
    as_then = without(change, as_then, reference.responses->interval);
  diagnosis.own_model = ownLastQuarter(present->series);
  diagnosis.reference_model = lastQuarter(reference, present->series);
  diagnosis.changed_model = lastQuarter(reference, as_then);
}

/// Fits both, the reference with the change in it too, and runs them on each other's recording.
void runModels(ChangeDiagnosis& diagnosis, const std::vector<Series>& now,
               const std::vector<Series>& then, const StatedChanges& stated,
               const ChangeOptions& options) {
  const auto stage = [&](const char* what) {
    if (options.progress) options.progress(what);
  };
  stage("fitting the reference");
  std::vector<std::optional<Modelled>> references = {fitted(then)};
  stage("fitting the recording");
  const auto present = fitted(now);
  keep(diagnosis, present, now);
  if (!stated.empty()) {
    stage("fitting the reference with the change");
    references.push_back(fitted(changed(then, stated)));
  }
  if (!present) return;
  stage("running the models on each other's recording");
  const auto lastQuarterBy = [&](const std::optional<Modelled>& reference) {
    return reference ? lastQuarter(reference->model, present->series) : ModelShare();
  };
  diagnosis.own_model = ownLastQuarter(present->series);
  diagnosis.reference_model = lastQuarterBy(references.front());
  diagnosis.changed_model = lastQuarterBy(references.back());
  for (const auto& reference : references) {
    if (!reference) continue;
    const double distance = modelDistance(*present, *reference);
    diagnosis.model_distance = std::min(distance, diagnosis.model_distance.value_or(distance));
    diagnosis.largest_model_distance =
        largestDistance(present->series, reference->series, diagnosis.gain > kClearGain);
  }
}

// ---------------------------------------------------------------------------------------------
// words

std::string strengthText(double value, const std::string& unit) {
  if (unit == "ohm") return format("%.2g mOhm", 1e3 * value);
  if (unit == "1") return format("%.2g %%", 1e2 * value);
  return format("%.2g ", value) + unit;
}

std::string clauseOf(const Change& change) {
  const std::string by = strengthText(std::abs(change.now), change.unit);
  const bool is_more = change.now > 0.0;
  if (change.id == "contact_resistance")
    return "the ohmic resistance between the points of measurement is " + by +
           (is_more ? " higher" : " lower");
  if (change.id == "current_gain")
    return "the current sensor reads " + by + (is_more ? " more" : " less") + " than before";
  if (change.id == "current_offset")
    return "the zero of the current sensor has moved by " + std::string(is_more ? "+" : "-") + by;
  if (change.id == "time_skew")
    return std::string(is_more ? "the voltage" : "the current") + " comes " + by +
           " later relative to " + (is_more ? "the current" : "the voltage");
  return std::string(is_more ? "the voltage" : "the current") + " follows with a lag of " + by;
}

void conclude(ChangeDiagnosis& diagnosis, ChangeVerdict verdict, std::string summary) {
  diagnosis.verdict = verdict;
  diagnosis.summary = std::move(summary);
}

/// The problems of a recording, that of the sign apart: channels that are shifted against each other
/// can look like a wrong sign.
struct Problems {
  std::vector<Finding> sign, others;
};
Problems problemsOf(const std::vector<Series>& all) {
  Problems problems;
  for (const Series& series : all)
    for (Finding& finding : findProblems(series))
      (finding.id == "sign" ? problems.sign : problems.others).push_back(std::move(finding));
  return problems;
}

std::optional<std::string> tooShort(const std::vector<Series>& all, const char* which) {
  for (const Series& series : all)
    if (series.size() < kFewestRows)
      return format("%s has %zu samples, a comparison needs %zu", which, series.size(),
                    kFewestRows);
  return std::nullopt;
}

std::optional<std::string> problemText(const std::vector<Finding>& problems, const char* which) {
  if (problems.empty()) return std::nullopt;
  return std::string(which) + " has a problem: " + format(problems);
}

std::vector<ComparedFeature> comparedOf(const ResponseComparison& comparison) {
  const ResponseFeatures &then = comparison.reference(), &now = comparison.now();
  std::vector<ComparedFeature> all;
  for (const int k : comparison.compared())
    all.push_back({featureId(k), featureUnit(k), then.value[k], now.value[k], std::nullopt,
                   std::sqrt(now.covariance(k, k) + then.covariance(k, k)),
                   comparison.spreadOf(k)});
  return all;
}

void requireBoth(const std::vector<Series>& now, const ChangeReference& then) {
  if (now.empty()) throw std::invalid_argument("diagnoseChange: no recording of now");
  if (then.recordings.empty() && then.models.empty())
    throw std::invalid_argument("diagnoseChange: no reference");
}

/// @return without a table where a model has none.
std::optional<ResponseReference> referenceOf(const ChangeReference& then) {
  ResponseReference reference{then.recordings, {}};
  for (const FittedModel& model : then.models) {
    if (!model.responses) return std::nullopt;
    reference.tables.push_back(model.responses);
  }
  return reference;
}

std::string nothingText(const ChangeDiagnosis& diagnosis) {
  std::vector<std::string> limits;
  for (const ChangeLimit& limit : diagnosis.detection_limits)
    limits.push_back(limit.id + " of " + strengthText(limit.strength, limit.unit));
  const std::string seen =
      limits.empty() ? "" : " These changes would have been detected: " + join(limits) + ".";
  return "Nothing has changed beyond the usual differences between trips of one sound battery." +
         seen;
}

std::string changedText(const Change& change) {
  std::string text = clauseOf(change) + format(" (%.0f %%)", 100.0 * change.probability);
  if (!change.indistinguishable.empty())
    text += "; these recordings cannot distinguish it from " + join(change.indistinguishable);
  return text + ".";
}

void refuse(ChangeDiagnosis& diagnosis, const std::string& why) {
  conclude(diagnosis, ChangeVerdict::kInsufficientData,
           "The recordings cannot be compared: " + why + ".");
}

/// Every candidate, the likeliest first; none where too little can be compared.
std::vector<WeighedChange> weighed(ChangeDiagnosis& diagnosis,
                                   const ResponseComparison& comparison) {
  diagnosis.compared = comparedOf(comparison);
  if (comparison.compared().size() < kFewestFeatures) {
    refuse(diagnosis, "the recordings have too few changes of current of 8 A and more");
    return {};
  }
  diagnosis.distance = comparison.nothing();
  std::vector<WeighedChange> all = weighChanges(comparison);
  diagnosis.gain = diagnosis.distance - all.front().distance;
  return all;
}

bool hasChanged(const ChangeDiagnosis& diagnosis) { return diagnosis.gain > kLeastGain; }

/// Adds the first candidate to what has changed. @param comparison with those added before in its
/// reference.
void addChange(ChangeDiagnosis& diagnosis, const ResponseComparison& comparison,
               std::vector<WeighedChange> candidates) {
  WeighedChange& best = candidates.front();
  addInterval(comparison, best);
  const ResponseFeatures with_change = comparison.featuresWith(best.candidate->kind, best.strength);
  for (ComparedFeature& one : diagnosis.compared)
    for (const int k : comparison.compared())
      if (one.id == featureId(k)) one.with_change = with_change.value[k];
  diagnosis.changes.push_back(changeOf(comparison, candidates));
}

/// States the likeliest change, or that there is none.
void state(ChangeDiagnosis& diagnosis, const ResponseComparison& comparison,
           std::vector<WeighedChange> candidates) {
  if (!hasChanged(diagnosis)) {
    conclude(diagnosis, ChangeVerdict::kNoChange, nothingText(diagnosis));
    return;
  }
  addChange(diagnosis, comparison, std::move(candidates));
  conclude(diagnosis, ChangeVerdict::kChanged,
           "Since the reference, " + changedText(diagnosis.changes.front()));
}

/// What is weighed with the likeliest change in the reference, the likeliest of another kind first.
struct SecondChange {
  ResponseComparison comparison;
  std::vector<WeighedChange> candidates;
};

/// @param then with the first change in it.  @return none where nothing explains more than chance.
std::optional<SecondChange> secondChange(const std::vector<Series>& now,
                                         const std::vector<Series>& then,
                                         const WeighedChange& first) {
  SecondChange second{ResponseComparison(now, {then, {}}), {}};
  if (second.comparison.compared().size() < kFewestFeatures) return std::nullopt;
  for (WeighedChange& one : weighChanges(second.comparison))
    if (one.candidate != first.candidate) second.candidates.push_back(one);
  if (second.comparison.nothing() - second.candidates.front().distance <= kLeastGain)
    return std::nullopt;
  return second;
}

/// In what one of several recordings differs most from the other references, if by more than sound
/// trips do; empty for none. It moves what all of them are averaged to.
std::string disagreementText(const ResponseReference& reference) {
  double most = kLeastGain;
  std::string text;
  for (std::size_t k = 0; k < reference.recordings.size() && reference.size() > 1; ++k) {
    ResponseReference others = reference;
    others.recordings.erase(others.recordings.begin() + static_cast<std::ptrdiff_t>(k));
    const ResponseComparison comparison({reference.recordings[k]}, others);
    ChangeDiagnosis one;
    const std::vector<WeighedChange> candidates = weighed(one, comparison);
    if (candidates.empty() || one.gain <= most) continue;
    most = one.gain;
    text =
        format(" The references do not agree: in recording %zu of them, compared with the others, ",
               k + 1) +
        clauseOf(changeOf(comparison, candidates)) + ".";
  }
  return text;
}

}  // namespace

std::string toString(ChangeVerdict verdict) {
  switch (verdict) {
    case ChangeVerdict::kNoChange: return "no_change";
    case ChangeVerdict::kChanged: return "changed";
    case ChangeVerdict::kAnotherBattery: return "another_battery";
    case ChangeVerdict::kInsufficientData: break;
  }
  return "insufficient_data";
}

ChangeDiagnosis diagnoseChange(const std::vector<Series>& now, const ChangeReference& then,
                               const ChangeOptions& options) {
  requireBoth(now, then);
  const auto stage = [&](const char* what) {
    if (options.progress) options.progress(what);
  };
  ChangeDiagnosis diagnosis;
  constexpr const char* kNow = "the recording";
  constexpr const char* kThen = "the reference";
  const auto refused = [&](const std::string& why) {
    refuse(diagnosis, why);
    return diagnosis;
  };
  for (const auto& why : {tooShort(now, kNow), tooShort(then.recordings, kThen)})
    if (why) return refused(*why);
  const auto reference = referenceOf(then);
  if (!reference) return refused(kNoResponses);
  const Problems problems = options.anyway ? Problems() : problemsOf(now);
  const Problems before = options.anyway ? Problems() : problemsOf(then.recordings);
  for (const auto& why : {problemText(problems.others, kNow), problemText(before.others, kThen),
                          problemText(before.sign, kThen)})
    if (why) return refused(*why);
  stage("comparing responses");
  const ResponseComparison comparison(now, *reference);
  stage("comparing candidate changes");
  const std::vector<WeighedChange> candidates = weighed(diagnosis, comparison);
  if (candidates.empty()) return diagnosis;
  const WeighedChange& best = candidates.front();
  if (!problems.sign.empty() &&
      !(hasChanged(diagnosis) && best.candidate->isInRows() && best.distance < kExplained))
    return refused(*problemText(problems.sign, kNow));
  diagnosis.detection_limits = limitsOf(comparison);

  StatedChanges stated;
  if (hasChanged(diagnosis)) stated.push_back(best);
  std::optional<SecondChange> second;
  if (!stated.empty() && then.models.empty())
    second = secondChange(now, changed(then.recordings, stated), best);
  if (second) stated.push_back(second->candidates.front());
  if (options.runs_models && !then.recordings.empty()) {
    runModels(diagnosis, now, then.recordings, stated, options);
  } else if (options.runs_models) {
    stage("fitting the recording");
    runReferenceModel(diagnosis, now, then.models.front(), stated);
  }
  if (diagnosis.model_distance > diagnosis.largest_model_distance) {
    conclude(diagnosis, ChangeVerdict::kAnotherBattery,
             format("This is another battery, or another vehicle: the model of each recording "
                    "misses the other recording by %.1f times as much as its own.",
                    std::exp(*diagnosis.model_distance)));
    return diagnosis;
  }
  state(diagnosis, comparison, candidates);
  if (second) {
    addChange(diagnosis, second->comparison, second->candidates);
    diagnosis.summary += " Besides, " + changedText(diagnosis.changes.back());
  }
  diagnosis.summary += disagreementText(*reference);
  return diagnosis;
}

ChangeDiagnosis diagnoseChange(const std::shared_ptr<const ResponseTable>& reference) {
  ChangeDiagnosis diagnosis;
  if (!reference || !reference->since) {
    refuse(diagnosis, reference && reference->sound
                          ? format("%zu of the %zu drives are known that the reference is made of",
                                   reference->sound->drives, kSoundDrives)
                          : "no drive has been compared with the reference yet");
    return diagnosis;
  }
  const ResponseComparison comparison(reference);
  const std::vector<WeighedChange> candidates = weighed(diagnosis, comparison);
  if (candidates.empty()) return diagnosis;
  diagnosis.detection_limits = limitsOf(comparison);
  state(diagnosis, comparison, candidates);
  return diagnosis;
}

}  // namespace battery_sof
