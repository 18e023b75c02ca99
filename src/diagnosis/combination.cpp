#include "diagnosis/combination.hpp"

#include <algorithm>

#include "util/text.hpp"

namespace battery_sof {
namespace {

bool has(const std::vector<MechanismProbability>& mechanisms, Mechanism mechanism) {
  return std::any_of(mechanisms.begin(), mechanisms.end(),
                     [&](const MechanismProbability& one) { return one.mechanism == mechanism; });
}

/// Whether one mechanism is likely in all of them.
bool haveOneInCommon(const std::vector<const Diagnosis*>& recordings) {
  return std::any_of(kAllMechanisms.begin(), kAllMechanisms.end(), [&](Mechanism mechanism) {
    return std::all_of(recordings.begin(), recordings.end(),
                       [&](const Diagnosis* one) { return has(one->mechanisms, mechanism); });
  });
}

/// What all recordings share where none has a mechanism.
std::string withoutMechanism(const std::vector<Diagnosis>& recordings) {
  const auto areAll = [&](std::initializer_list<Verdict> verdicts) {
    return std::all_of(recordings.begin(), recordings.end(), [&](const Diagnosis& one) {
      return std::count(verdicts.begin(), verdicts.end(), one.verdict) > 0;
    });
  };
  if (areAll({Verdict::kInsufficientData})) return "No recording can answer.";
  if (areAll({Verdict::kNoMismatch, Verdict::kInsufficientData}))
    return "Model and measurement agree as far as these recordings show.";
  return "The mechanism is not stated: no recording has one.";
}

}  // namespace

CombinedDiagnosis combine(const std::vector<Diagnosis>& recordings) {
  CombinedDiagnosis combined;
  std::vector<const Diagnosis*> with_mechanism;
  for (const Diagnosis& one : recordings)
    if (!one.mechanisms.empty() && !one.mechanism_evidence.empty()) with_mechanism.push_back(&one);
  const double share = 1.0 / static_cast<double>(std::max<std::size_t>(with_mechanism.size(), 1));
  std::vector<MechanismEvidence> mean;
  for (const Diagnosis* one : with_mechanism) {
    mean.resize(one->mechanism_evidence.size());
    for (std::size_t half = 0; half < mean.size(); ++half)
      for (std::size_t k = 0; k < kMechanisms; ++k)
        for (const auto part : {&MechanismSupport::alone, &MechanismSupport::lost,
                                &MechanismSupport::effect, &MechanismSupport::accepted})
          mean[half][k].*part += share * one->mechanism_evidence[half][k].*part;
  }
  if (with_mechanism.empty()) {
    combined.summary = withoutMechanism(recordings);
  } else if (!haveOneInCommon(with_mechanism)) {
    combined.summary =
        "The mechanism is not stated: the recordings have no likely mechanism in common.";
  } else {
    combined.mechanisms = likelyMechanisms(mean);
    combined.mechanism = combined.mechanisms.front().mechanism;
    combined.summary =
        "Missing: " + mechanismSentence(*combined.mechanism) +
        format(", probability %.2f, by %zu of %zu recordings.",
               combined.mechanisms.front().probability, with_mechanism.size(), recordings.size());
  }
  return combined;
}

}  // namespace battery_sof
