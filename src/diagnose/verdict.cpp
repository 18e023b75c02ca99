#include "battery_sof/diagnose/verdict.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace battery_sof {
namespace {

constexpr double kBeyondInstruments = 12.0;  // z_O beyond what a fault leaves once it is masked: at most 6.5 on 24 decoys of seeds 3001 to 3006
constexpr double kExplained = 0.7;   // share of the mismatch below which the catalogue does not explain it (PHYSICS 2.3)

std::string withUnit(double value, const char* format, const char* unit) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return std::string(text) + " " + unit;
}

std::string joined(const std::vector<std::string>& parts, const std::string& last) {
  std::string text;
  for (std::size_t k = 0; k < parts.size(); ++k)
    text += (k == 0 ? "" : k + 1 == parts.size() ? last : ", ") + parts[k];
  return text;
}

std::string withoutStop(std::string sentence) {
  while (!sentence.empty() && (sentence.back() == '.' || sentence.back() == ' ')) sentence.pop_back();
  if (!sentence.empty() && sentence[0] >= 'A' && sentence[0] <= 'Z') sentence[0] = static_cast<char>(sentence[0] - 'A' + 'a');
  return sentence;
}

std::string named(const std::string& id) {
  for (const EffectInfo& info : effectCatalogue())
    if (info.id == id) return id + " (" + info.title + ")";
  return id;
}

bool isInstrument(const std::string& id) {
  for (const EffectInfo& info : effectCatalogue())
    if (info.id == id) return info.tier() == 'I';
  return true;
}

std::string gainSentence(const Diagnosis& diagnosis) {
  const ErrorMetrics& before = diagnosis.fit.base_holdout;
  const ErrorMetrics& after = diagnosis.fit.extended_holdout;
  const std::string course = after.rmse < before.rmse ? "falls" : "does not fall: it goes";
  return "; on the part that was held out the error " + course + " from " + withUnit(1e3 * before.rmse, "%.1f", "mV") + " to " +
         withUnit(1e3 * after.rmse, "%.1f", "mV") + " RMS";
}

/// What was accepted and yet explains too little to be the verdict's name.
std::string partOfIt(const Diagnosis& diagnosis) {
  std::vector<std::string> ids;
  for (const Candidate& candidate : diagnosis.candidates)
    if (candidate.rejected_because.empty()) ids.push_back(named(candidate.id));
  return ids.empty() ? "" : "; " + joined(ids, " and ") + (ids.size() == 1 ? " is" : " are") + " part of it";
}

bool somethingRemains(const Remainder& remainder, const DiagnosisThresholds& thresholds) {
  return remainder.extended_omnibus > thresholds.omnibus || remainder.has_tone;
}

std::string whereSentence(const Diagnosis& diagnosis) {
  const RegimeFinding* worst = nullptr;
  for (const RegimeFinding& finding : diagnosis.regimes)
    if (finding.alarm && finding.statistic == "mean" && (!worst || std::abs(finding.value) > std::abs(worst->value)))
      worst = &finding;
  if (!worst) return "";
  return "; measured and base model part most in " + worst->regime + ", by " +
         withUnit(1e3 * worst->value, "%+.0f", "mV");
}

}  // namespace

double leastGainToExplain(const Remainder& remainder, const DiagnosisThresholds& thresholds) {
  if (!somethingRemains(remainder, thresholds)) return 0.0;
  return std::max(0.0, kExplained / (1.0 - kExplained) * remainder.left - remainder.gained);
}

std::string describe(Verdict verdict) {
  switch (verdict) {
    case Verdict::kNoMismatch: return "no_mismatch";
    case Verdict::kNamed: return "named";
    case Verdict::kSeveral: return "several";
    case Verdict::kAmbiguous: return "ambiguous";
    case Verdict::kUnknown: return "unknown";
    case Verdict::kSensorFault: return "sensor_fault";
    case Verdict::kInsufficientData: return "insufficient_data";
  }
  return "insufficient_data";
}

Verdict judge(const Naming& naming, const InstrumentScreen& instruments, const Remainder& remainder,
              const DiagnosisThresholds& thresholds) {
  const bool remains = somethingRemains(remainder, thresholds);
  if (naming.accepted.empty()) {
    // Worth a name by its evidence and yet not to be named. At edges the current's own noise has such evidence (docs/decisions/0007).
    const bool is_unnamed = std::any_of(naming.candidates.begin(), naming.candidates.end(), [&](const Candidate& candidate) {
      return candidate.evidence > thresholds.name_evidence && !effectInfo(candidate.id).acts_at_edges;
    });
    // Coarse steps and cut-off peaks do not make currents and their memory explain what is left.
    if (!instruments.faults.empty() && remainder.extended_omnibus <= kBeyondInstruments && !remainder.has_tone)
      return Verdict::kSensorFault;
    return remains || is_unnamed ? Verdict::kUnknown : Verdict::kNoMismatch;
  }
  if (remains && remainder.explained < kExplained) return Verdict::kUnknown;
  bool tied = false, instrumental = true;
  for (const Accepted& accepted : naming.accepted) {
    instrumental = instrumental && isInstrument(accepted.id);
    for (const std::string& id : accepted.tied) {
      tied = true;
      instrumental = instrumental && isInstrument(id);
    }
  }
  if (instrumental) return Verdict::kSensorFault;
  if (tied) return Verdict::kAmbiguous;
  return naming.accepted.size() == 1 ? Verdict::kNamed : Verdict::kSeveral;
}

std::vector<std::string> outsideWhatSignalsShow() {
  return {"a gain error of the current sensor that is alike in both directions",
          "gain and offset of the voltage channel",
          "a constant resistance of cables and contacts",
          "whether a constant small current is the sensor's offset or a load behind it"};
}

std::string nextExperiment(const Diagnosis& diagnosis) {
  switch (diagnosis.verdict) {
    case Verdict::kInsufficientData:
      return "Record at least five minutes of driving with both charge and discharge, a rest of a minute and a crank.";
    case Verdict::kUnknown:
      return "Repeat one charge and one discharge of the same size after a minute's rest each, at half and at full current: it "
             "shows whether what is missing follows the current, the charge or the time.";
    case Verdict::kSensorFault:
      return "Record a minute with the battery disconnected from its loads (zero current) and compare with a second sensor.";
    case Verdict::kNoMismatch: {
      for (const Detectable& one : diagnosis.detectable)
        if (!one.visible && effectInfo(one.id).tier() == 'P')
          return "This recording could not have shown " + named(one.id) + "; it would take " + effectInfo(one.id).tells_apart + ".";
      return "Nothing is open; the same recording at another temperature would widen what the model is good for.";
    }
    default: break;
  }
  for (const NamedEffect& effect : diagnosis.effects)
    if (!effect.tied_with.empty() && !effectInfo(effect.id).tells_apart.empty())
      return "To tell " + effect.id + " from " + joined(effect.tied_with, " and ") + ": " + effectInfo(effect.id).tells_apart + ".";
  const std::string& id = diagnosis.effects.front().id;
  return "To confirm " + id + ": " + effectInfo(id).tells_apart + ".";
}

std::string summaryOf(const Diagnosis& diagnosis) {
  std::vector<std::string> ids;
  for (const NamedEffect& effect : diagnosis.effects) ids.push_back(named(effect.id));
  switch (diagnosis.verdict) {
    case Verdict::kNoMismatch:
      return "Model and measurement agree as well as this recording can tell (" +
             withUnit(1e3 * diagnosis.fit.base_holdout.rmse, "%.1f", "mV") + " RMS on the part that was held out).";
    case Verdict::kNamed:
      return "The base model lacks " + ids.front() + gainSentence(diagnosis) + whereSentence(diagnosis) + ".";
    case Verdict::kSeveral:
      return "The base model lacks " + joined(ids, " and ") + gainSentence(diagnosis) + whereSentence(diagnosis) + ".";
    case Verdict::kAmbiguous:
      return "The base model lacks " + joined(ids, " or ") + ", some of which this recording cannot tell apart" +
             gainSentence(diagnosis) + whereSentence(diagnosis) + ".";
    case Verdict::kUnknown:
      return "Model and measurement part in a way that the catalogue does not explain" +
             partOfIt(diagnosis) + (diagnosis.force ? ": " + withoutStop(diagnosis.force->description) : std::string()) + whereSentence(diagnosis) + ".";
    case Verdict::kSensorFault:
      return "The instruments explain the mismatch: " + joined(ids, " and ") + ".";
    case Verdict::kInsufficientData: break;
  }
  return diagnosis.summary;
}

}  // namespace battery_sof
