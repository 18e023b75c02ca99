#include "diagnosis/verdict.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "util/text.hpp"

namespace battery_sof {
namespace {

std::string joined(const std::vector<std::string>& parts, const std::string& last) {
  std::string text;
  for (std::size_t k = 0; k < parts.size(); ++k)
    text += (k == 0 ? "" : k + 1 == parts.size() ? last : ", ") + parts[k];
  return text;
}

/// "Two effects are missing: the likelier one (96 %): ...; the other: ...", all of them named.
std::string severalMissing(const std::vector<std::string>& titles, const Diagnosis& diagnosis) {
  static constexpr std::array kCounts = {"Two", "Three", "Four", "Five", "Six"};
  const std::size_t count = titles.size();
  const std::string number =
      count - 2 < kCounts.size() ? kCounts.at(count - 2) : std::to_string(count);
  const std::string sure =
      diagnosis.probability > 0.0 ? format(" (%.0f %%)", 100.0 * diagnosis.probability) : "";
  const auto& effects = diagnosis.effects;
  const bool are_alike = std::all_of(effects.begin(), effects.end(), [&](const NamedEffect& one) {
    return one.probability == effects.front().probability;
  });
  if (are_alike && effects.size() == count && effects.front().probability > 0.0)
    return number + " effects are missing" + sure + ": " + joined(titles, " and ");
  return number + " effects are missing: the " + (count == 2 ? "likelier one" : "likeliest one") +
         sure + ": " + titles.front() + (count == 2 ? "; the other: " : "; the others: ") +
         joined({titles.begin() + 1, titles.end()}, " and ");
}

/// What the circuit is off by on the hold-out, and the extended model: in explained variation where
/// a charger controls the voltage.
std::string costAndGain(const Diagnosis& diagnosis) {
  const ErrorMetrics &base = diagnosis.fit.base_holdout, &extended = diagnosis.fit.extended_holdout;
  const bool is_controlled = base.share_percent && extended.share_percent;
  const bool is_extended =
      !diagnosis.effects.empty() ||
      (!is_controlled &&
       (diagnosis.withheld_rmse || (diagnosis.discrepancy && diagnosis.discrepancy->is_used)));
  const std::string judged =
      diagnosis.withheld_rmse ? ", but this does not improve the prediction" : "";
  if (is_controlled)
    return judged +
           format("; on the hold-out the circuit explains %.0f %% of current and voltage",
                  *base.share_percent) +
           (is_extended ? format(", the extended model %.0f %%", *extended.share_percent) : "");
  return judged + format("; on the hold-out the circuit deviates by %.1f mV RMS", 1e3 * base.rmse) +
         (is_extended ? format(", the extended model by %.1f mV", 1e3 * extended.rmse)
                      : ", and no correction estimated from the currents lowers it");
}

/// "Missing: acid (probability 0.61; next open_circuit 0.30)"
std::string missing(const std::string& what, const Diagnosis& diagnosis) {
  std::string sure;
  if (diagnosis.probability > 0.0) sure = format("probability %.2f", diagnosis.probability);
  if (diagnosis.mechanisms.size() > 1)
    sure += "; next " + mechanismId(diagnosis.mechanisms[1].mechanism) +
            format(" %.2f", diagnosis.mechanisms[1].probability);
  return "Missing: " + what + (sure.empty() ? "" : " (" + sure + ")");
}

constexpr char kSecondInstrument[] = "Record again with a second instrument for each channel.";

/// How to undo a shift between the channels. @param skew [s], if it is known by how much.
std::string afterShift(std::optional<double> skew) {
  const std::string by =
      skew ? format("(sof convert IN OUT --shift-current %.3g)", *skew)
           : "by the time that sof check reports (sof convert IN OUT --shift-current S)";
  return "Shift the current " + by +
         " and diagnose OUT, because nothing else can be judged before.";
}

std::optional<double> skewOf(const NamedEffect& effect) {
  for (const DiagnosedParameter& each : effect.parameters)
    if (each.name == "channel_skew") return each.value;
  return std::nullopt;
}

/// What to do about a fault of sensors or wiring, an effect of class I or what the checks found.
std::string afterFault(const NamedEffect& fault) {
  static const std::map<std::string, const char*> kRemedies = {
      {"inductance",
       "Measure the voltage at the battery's own posts, with wires separate from those of the "
       "load, and record the same edges again."},
      {"parasitic_load",
       "Measure the current at rest with a current clamp around the battery's own cable; a load "
       "that the sensor does not see shows as a difference."},
      {"current_offset",
       "Record a minute with the battery disconnected from its loads; what the sensor reads then "
       "is its offset."},
      {"current_gain",
       "Record a charge and a discharge with a second current sensor in series, and compare."},
      {"sensor_lag",
       "Record both channels with the same filter, or without one, and diagnose again."},
      {"contact_resistance",
       "Measure the voltage between each post and its clamp under load, clean and tighten them, "
       "and record again."},
      {"clipping", "Record with a current sensor whose range covers the current of a crank."},
      {"dropouts",
       "Find out where samples are lost or repeated (bus load, logger), correct that, and record "
       "again."},
      {"quantisation",
       "Record the channel with a finer resolution: its raw values, or a smaller range."},
      {"aliasing", "Record faster, or with an anti-alias filter, and diagnose again."}};
  if (fault.id == "time_skew") return afterShift(skewOf(fault));
  const auto known = kRemedies.find(fault.id);
  return known != kRemedies.end() ? known->second : kSecondInstrument;
}

/// What an equation of the catalogue says of the likeliest mechanism.
std::string byEquation(const Diagnosis& diagnosis) {
  const auto& effects = diagnosis.effects;
  const bool has_one = std::any_of(effects.begin(), effects.end(), [&](const NamedEffect& one) {
    return mechanismOf(one.id) == *diagnosis.mechanism;
  });
  return has_one ? ", for which several equations fit equally well"
                 : ", although the equation that fits belongs to " +
                       mechanismId(mechanismOf(effects.front().id));
}

}  // namespace

std::string toString(Verdict verdict) {
  static constexpr std::array kNames = {"no_mismatch",  "effect",           "several",
                                        "ambiguous",    "mechanism",        "unexplained",
                                        "sensor_fault", "insufficient_data"};
  return kNames.at(static_cast<std::size_t>(verdict));
}

Verdict judge(const std::vector<SelectedTerm>& terms, const std::vector<std::string>& faults,
              const Unexplained& rest) {
  if (terms.empty()) {
    if (rest.is_tone || rest.rmse > kPlausible) return Verdict::kUnexplained;
    if (!faults.empty()) return Verdict::kSensorFault;
    return rest.has_discrepancy ? Verdict::kUnexplained : Verdict::kNoMismatch;
  }
  const bool instrumental = std::all_of(terms.begin(), terms.end(), [](const SelectedTerm& one) {
    return one.mechanism == Mechanism::kInstrument;
  });
  if (terms.front().member.empty())
    return instrumental && !faults.empty() ? Verdict::kSensorFault : Verdict::kUnexplained;
  if (instrumental) return Verdict::kSensorFault;
  const auto named = std::count_if(terms.begin(), terms.end(),
                                   [](const SelectedTerm& one) { return !one.member.empty(); });
  const bool indistinguishable =
      std::any_of(terms.begin(), terms.end(),
                  [](const SelectedTerm& one) { return !one.indistinguishable.empty(); });
  if (indistinguishable) return Verdict::kAmbiguous;
  return named == 1 ? Verdict::kEffect : Verdict::kSeveral;
}

void removeSmall(std::vector<SelectedTerm>& terms) {
  const auto is_small = [all = terms](const SelectedTerm& one) {
    return one.gain < leastNamed(all, one.mechanism);
  };
  terms.erase(std::remove_if(terms.begin(), terms.end(), is_small), terms.end());
}

Verdict withMechanism(Verdict verdict, const std::vector<SelectedTerm>& terms,
                      Mechanism likeliest) {
  if (verdict == Verdict::kUnexplained) return Verdict::kMechanism;
  const bool has_equation = !terms.empty() && !terms.front().member.empty();
  return has_equation && terms.front().mechanism != likeliest ? Verdict::kAmbiguous : verdict;
}

std::vector<std::string> outsideWhatSignalsShow() {
  return {"a gain error of the current sensor that is the same in both directions",
          "gain and offset of the voltage channel", "a constant resistance of cables and contacts",
          "whether a constant small current is the sensor's offset or a load that the sensor does "
          "not see"};
}

std::string nextExperiment(const Diagnosis& diagnosis, std::optional<double> skew) {
  if (skew) return afterShift(skew);
  switch (diagnosis.verdict) {
    case Verdict::kInsufficientData:
      return "Record at least five minutes of driving with both charge and discharge, a rest of a "
             "minute and a crank.";
    case Verdict::kMechanism:
    case Verdict::kUnexplained:
      return "Repeat one charge and one discharge of the same size after a minute's rest each, at "
             "half and at full current: this shows whether what is missing depends on the current, "
             "the charge or the time.";
    case Verdict::kSensorFault:
      for (const NamedEffect& effect : diagnosis.effects)
        if (!catalogued(effect.id) || mechanismOf(effect.id) == Mechanism::kInstrument)
          return afterFault(effect);
      return kSecondInstrument;
    case Verdict::kNoMismatch: {
      for (const DetectionLimit& one : diagnosis.detection_limits)
        if (!one.visible && effectInfo(one.id).tier() == 'P')
          return "This recording could not have shown " + one.id + " (" + titleOf(one.id) +
                 "); it would take " + effectInfo(one.id).distinguished_by + ".";
      return "Nothing is open; a recording at another temperature would extend the range in which "
             "the model is valid.";
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
  for (const NamedEffect& effect : diagnosis.effects) ids.push_back(titleOf(effect.id));
  switch (diagnosis.verdict) {
    case Verdict::kNoMismatch:
      return format(
          "Model and measurement agree as far as this recording shows: %.1f mV RMS on the "
          "hold-out.",
          1e3 * diagnosis.fit.base_holdout.rmse);
    case Verdict::kEffect:
    case Verdict::kSeveral:
      return (ids.size() > 1 ? severalMissing(ids, diagnosis) : missing(ids.front(), diagnosis)) +
             costAndGain(diagnosis) + ".";
    case Verdict::kAmbiguous:
      return missing(mechanismSentence(*diagnosis.mechanism) + byEquation(diagnosis), diagnosis) +
             costAndGain(diagnosis) + ".";
    case Verdict::kMechanism:
    case Verdict::kUnexplained:
      return (diagnosis.mechanism
                  ? missing(mechanismSentence(*diagnosis.mechanism) + ", but no equation fits",
                            diagnosis)
                  : std::string("Something is missing that no mechanism explains")) +
             costAndGain(diagnosis) + ".";
    case Verdict::kSensorFault:
      return "The instruments explain the mismatch: " + joined(ids, " and ") + ".";
    case Verdict::kInsufficientData: break;
  }
  return diagnosis.summary;
}

}  // namespace battery_sof
