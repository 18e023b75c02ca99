#include "diagnosis/verdict.hpp"

#include <algorithm>
#include <cmath>

#include "util/text.hpp"

namespace battery_sof {
namespace {

std::string joined(const std::vector<std::string>& parts, const std::string& last) {
  std::string text;
  for (std::size_t k = 0; k < parts.size(); ++k)
    text += (k == 0 ? "" : k + 1 == parts.size() ? last : ", ") + parts[k];
  return text;
}

/// An effect in words; the id of what has none.
std::string titleOrId(const std::string& id) {
  for (const EffectInfo& info : effectCatalogue())
    if (info.id == id) return info.title;
  return id;
}

std::string capitalised(std::string sentence) {
  if (!sentence.empty() && sentence[0] >= 'a' && sentence[0] <= 'z')
    sentence[0] = static_cast<char>(sentence[0] - 'a' + 'A');
  return sentence;
}

/// The mechanisms in words, then the effects that represent them.
std::string missing(const Diagnosis& diagnosis, const std::string& last) {
  std::vector<std::string> mechanisms, effects;
  for (const NamedEffect& effect : diagnosis.effects) {
    const std::string mechanism = mechanismSentence(mechanismOf(effect.id));
    if (!contains(mechanisms, mechanism)) mechanisms.push_back(mechanism);
    effects.push_back(titleOrId(effect.id));
  }
  return capitalised(joined(mechanisms, " and ")) + " (" + joined(effects, last) + ")";
}

/// By explained variation where a charger controls the voltage: the extended model answers there
/// in current.
std::string gainSentence(const Diagnosis& diagnosis) {
  const ErrorMetrics& before = diagnosis.fit.base_holdout;
  const std::optional<double> explained = diagnosis.fit.extended_holdout.share_percent;
  if (before.share_percent && explained)
    return "; on the part that was held out the explained variation of current and voltage goes "
           "from " +
           format("%.0f %% to %.0f %%", *before.share_percent, *explained);
  const double after = diagnosis.withheld_rmse.value_or(diagnosis.fit.extended_holdout.rmse);
  const std::string course = after < before.rmse ? "falls" : "does not fall: it goes";
  return "; on the part that was held out the error " + course + " from " +
         format("%.1f mV", 1e3 * before.rmse) + " to " + format("%.1f mV", 1e3 * after) + " RMS" +
         (diagnosis.withheld_rmse ? ", so the base model is given" : "");
}

/// A mechanism whose regressors do not hold, and that the evidence makes likelier.
std::string orRather(const Diagnosis& diagnosis) {
  if (diagnosis.mechanisms.empty() || diagnosis.mechanisms.front().mechanism == diagnosis.mechanism)
    return "";
  return "; " + mechanismId(diagnosis.mechanisms.front().mechanism) + " is at least as likely";
}

/// Effects found in a mechanism that only its regressors represent.
std::string partOfIt(const Diagnosis& diagnosis) {
  std::vector<std::string> ids;
  for (const Candidate& candidate : diagnosis.candidates)
    if (candidate.rejected_because.empty()) ids.push_back(titleOrId(candidate.id));
  return ids.empty()
             ? ""
             : "; " + joined(ids, " and ") + (ids.size() == 1 ? " is" : " are") + " part of it";
}

std::string discrepancySentence(const Diagnosis& diagnosis) {
  if (!diagnosis.discrepancy || !diagnosis.discrepancy->is_used)
    return "; nothing that could be estimated from the currents predicts it";
  return "; what was estimated of it is in the extended model" + gainSentence(diagnosis);
}

/// The largest mean of the table of regimes whose 95 % interval excludes zero, marked there or not:
/// few episodes are never marked.
std::string whereSentence(const Diagnosis& diagnosis) {
  const RegimeFinding* worst = nullptr;
  for (const RegimeFinding& finding : diagnosis.regimes)
    if (finding.statistic == "mean" && finding.lower * finding.upper > 0.0 &&
        (!worst || std::abs(finding.value) > std::abs(worst->value)))
      worst = &finding;
  if (!worst) return "";
  return "; the base model's mean error is largest in " + worst->regime +
         format(": %+.0f mV (95 %% %+.0f to %+.0f mV, %zu episodes)", 1e3 * worst->value,
                1e3 * worst->lower, 1e3 * worst->upper, worst->episodes);
}

}  // namespace

std::string toString(Verdict verdict) {
  switch (verdict) {
    case Verdict::kNoMismatch: return "no_mismatch";
    case Verdict::kEffect: return "effect";
    case Verdict::kSeveral: return "several";
    case Verdict::kAmbiguous: return "ambiguous";
    case Verdict::kMechanism: return "mechanism";
    case Verdict::kUnexplained: return "unexplained";
    case Verdict::kSensorFault: return "sensor_fault";
    case Verdict::kInsufficientData: return "insufficient_data";
  }
  return "insufficient_data";
}

Verdict judge(const Explanation& explanation, const InstrumentScreen& instruments,
              const Unexplained& rest) {
  if (explanation.terms.empty()) {
    const bool is_left = rest.has_discrepancy || rest.is_tone || rest.rmse > kPlausible;
    if (!instruments.faults.empty() && !rest.is_tone) return Verdict::kSensorFault;
    return is_left ? Verdict::kUnexplained : Verdict::kNoMismatch;
  }
  const auto& all = explanation.terms;
  const bool instrumental = std::all_of(all.begin(), all.end(), [](const SelectedTerm& one) {
    return one.mechanism == Mechanism::kInstrument;
  });
  if (all.front().member.empty())
    return instrumental && !instruments.faults.empty() ? Verdict::kSensorFault
                                                       : Verdict::kUnexplained;
  if (instrumental) return Verdict::kSensorFault;
  const auto named = std::count_if(all.begin(), all.end(),
                                   [](const SelectedTerm& one) { return !one.member.empty(); });
  const bool indistinguishable = std::any_of(all.begin(), all.end(), [](const SelectedTerm& one) {
    return !one.indistinguishable.empty();
  });
  if (indistinguishable) return Verdict::kAmbiguous;
  return named == 1 ? Verdict::kEffect : Verdict::kSeveral;
}

std::vector<std::string> outsideWhatSignalsShow() {
  return {"a gain error of the current sensor that is alike in both directions",
          "gain and offset of the voltage channel", "a constant resistance of cables and contacts",
          "whether a constant small current is the sensor's offset or a load behind it"};
}

std::string nextExperiment(const Diagnosis& diagnosis) {
  switch (diagnosis.verdict) {
    case Verdict::kInsufficientData:
      return "Record at least five minutes of driving with both charge and discharge, a rest of a "
             "minute and a crank.";
    case Verdict::kMechanism:
    case Verdict::kUnexplained:
      return "Repeat one charge and one discharge of the same size after a minute's rest each, at "
             "half and at full current: it "
             "shows whether what is missing follows the current, the charge or the time.";
    case Verdict::kSensorFault:
      return "Record a minute with the battery disconnected from its loads (zero current) and "
             "compare with a second sensor.";
    case Verdict::kNoMismatch: {
      for (const DetectionLimit& one : diagnosis.detection_limits)
        if (!one.visible && effectInfo(one.id).tier() == 'P')
          return "This recording could not have shown " + one.id + " (" + titleOrId(one.id) +
                 "); it would take " + effectInfo(one.id).distinguished_by + ".";
      return "Nothing is open; the same recording at another temperature would widen what the "
             "model is good for.";
    }
    default: break;
  }
  for (const NamedEffect& effect : diagnosis.effects)
    if (!effect.indistinguishable_from.empty() && !effectInfo(effect.id).distinguished_by.empty())
      return "To distinguish " + effect.id + " from " +
             joined(effect.indistinguishable_from, " and ") + ": " +
             effectInfo(effect.id).distinguished_by + ".";
  const std::string& id = diagnosis.effects.front().id;
  return "To confirm " + id + ": " + effectInfo(id).distinguished_by + ".";
}

std::string summaryOf(const Diagnosis& diagnosis) {
  std::vector<std::string> ids;
  for (const NamedEffect& effect : diagnosis.effects) ids.push_back(titleOrId(effect.id));
  switch (diagnosis.verdict) {
    case Verdict::kNoMismatch:
      return "Model and measurement agree as far as this recording shows (" +
             format("%.1f mV", 1e3 * diagnosis.fit.base_holdout.rmse) +
             " RMS on the part that was held out).";
    case Verdict::kEffect:
    case Verdict::kSeveral:
      return missing(diagnosis, " and ") + gainSentence(diagnosis) + whereSentence(diagnosis) + ".";
    case Verdict::kAmbiguous:
      return missing(diagnosis, " or ") + ", some of which this recording cannot distinguish" +
             gainSentence(diagnosis) + whereSentence(diagnosis) + ".";
    case Verdict::kMechanism:
    case Verdict::kUnexplained:
      return (diagnosis.mechanism
                  ? "Missing mechanism, of which no equation of the catalogue fits: " +
                        mechanismSentence(*diagnosis.mechanism) + orRather(diagnosis)
                  : std::string("Model and measurement deviate, and no mechanism explains how")) +
             partOfIt(diagnosis) + discrepancySentence(diagnosis) + whereSentence(diagnosis) + ".";
    case Verdict::kSensorFault:
      return "The instruments explain the mismatch: " + joined(ids, " and ") + ".";
    case Verdict::kInsufficientData: break;
  }
  return diagnosis.summary;
}

}  // namespace battery_sof
