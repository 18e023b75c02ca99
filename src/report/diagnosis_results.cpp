#include <algorithm>
#include <cmath>

#include "battery_sof/version.hpp"
#include "descriptions.hpp"
#include "report/results.hpp"
#include "util/text.hpp"
#include "wording.hpp"

namespace battery_sof {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kSegmentsTold = 8;        // of the text's list; JSON has all
constexpr std::size_t kReportedCandidates = 6;  // of the text's list

constexpr char kIndent[] = "             ";

/// Effects found in a mechanism that only its regressors represent.
std::string partOfIt(const Diagnosis& d) {
  std::vector<std::string> ids;
  for (const Candidate& candidate : d.candidates)
    if (hasNoEquation(d.verdict) && candidate.rejected_because.empty()) ids.push_back(candidate.id);
  return ids.empty() ? "" : "; with " + join(ids);
}

std::string verdictText(const Diagnosis& d) {
  std::string text =
      wrapped("verdict      ", toString(d.verdict) + ": " + d.summary + " " + meaningOf(d.verdict));
  if (d.mechanism)
    text += wrapped("mechanism    ",
                    mechanismId(*d.mechanism) + " (" + mechanismSentence(*d.mechanism) + ")" +
                        (d.probability > 0.0 ? format(", probability %.2f", d.probability) : "") +
                        partOfIt(d));
  if (d.mechanisms.size() > 1) text += wrapped("likely       ", likelyMechanismsText(d.mechanisms));
  if (!d.base.provenance.recording.empty())
    text += "recording    " + d.base.provenance.recording + "\n";
  if (d.fit.train.to > d.fit.train.from)
    text +=
        format("%sfitted to %.1f to %.1f s, compared on %.1f to %.1f s, which no fit has used\n",
               kIndent, d.fit.train.from, d.fit.train.to, d.fit.holdout.from, d.fit.holdout.to);
  return text;
}

/// The segments with the largest peaks, in order of time.
std::vector<MismatchSegment> largest(std::vector<MismatchSegment> segments) {
  const auto is_larger = [](const MismatchSegment& a, const MismatchSegment& b) {
    return std::abs(a.peak_error) > std::abs(b.peak_error);
  };
  std::stable_sort(segments.begin(), segments.end(), is_larger);
  if (segments.size() > kSegmentsTold) segments.resize(kSegmentsTold);
  std::sort(segments.begin(), segments.end(),
            [](const MismatchSegment& a, const MismatchSegment& b) { return a.from < b.from; });
  return segments;
}

std::string mismatchText(const Diagnosis& d) {
  if (d.mismatch.empty()) {
    const std::string sentence = noStretchText(d);
    return sentence.empty() ? "" : "\n" + wrapped("", sentence);
  }
  std::string text =
      format("\nwhere measurement and base model deviate (%zu stretch%s%s), measured minus model\n",
             d.mismatch.size(), d.mismatch.size() == 1 ? "" : "es",
             d.mismatch.size() > kSegmentsTold ? ", of which the largest are listed" : "");
  text += format("%s%10s %10s  %-22s %10s %10s %9s\n", kIndent, "from [s]", "to [s]", "regime",
                 "mean [mV]", "peak [mV]", "p");
  for (const MismatchSegment& s : largest(d.mismatch))
    text += format("%s%10.1f %10.1f  %-22s %10s %10s %9.2g\n", kIndent, s.from, s.to,
                   plainName(s.regime).c_str(), millivolts(s.mean_error).c_str(),
                   millivolts(s.peak_error).c_str(), s.p_value);
  return text;
}

std::string regimesText(const Diagnosis& d) {
  std::string text;
  for (const RegimeFinding& f : d.regimes) {
    if (!f.is_significant) continue;
    const std::string unit = f.statistic == "slope" ? "mV/s" : "mV";
    text += wrapped(kIndent, plainName(f.regime) + ": " + f.statistic + " " + millivolts(f.value) +
                                 " " + unit + ", 95 % interval " + millivolts(f.lower) + " to " +
                                 millivolts(f.upper) + " " + unit +
                                 format(" (%zu episodes)", f.episodes));
  }
  return text.empty() ? text : "\nregimes in which the base model deviates\n" + text;
}

std::string parameterBiasText(const Diagnosis& d) {
  std::string text;
  for (const ParameterBias& a : d.parameter_bias)
    if (std::abs(a.z) >= kNotableZ)
      text += format("%s%-12s %16s in %-22s (z %+.1f)\n", kIndent, a.parameter.c_str(),
                     biasText(a).c_str(), plainName(a.regime).c_str(), a.z);
  return text.empty()
             ? text
             : "\nhow the base model's parameters would have to change to fit one regime\n" + text;
}

std::string parameterText(const DiagnosedParameter& p) {
  const std::string error = p.std ? "+- " + threeDigits(*p.std) : "";
  const std::string interval =
      p.lower && p.upper ? "95 % " + threeDigits(*p.lower) + " to " + threeDigits(*p.upper) : "";
  return format("%s%-24s %10s %-10s %-6s %s%s\n", kIndent, p.name.c_str(),
                threeDigits(p.value).c_str(), error.c_str(), p.unit.c_str(), interval.c_str(),
                p.at_bound ? " (at a bound)" : "");
}

std::string effectsText(const Diagnosis& d) {
  std::string text;
  for (const NamedEffect& effect : d.effects) {
    text += "\n" + wrapped("effect       ",
                           effect.id + ": " + titleOf(effect.id) + "; confidence " +
                               confidenceText(effect.confidence) + ", changes the voltage by " +
                               millivolts(effect.voltage_rms) + " mV RMS");
    if (!effect.biased_parameters.empty())
      text += wrapped(kIndent, "parameters biased without it: " + join(effect.biased_parameters));
    if (!effect.indistinguishable_from.empty())
      text += wrapped(kIndent, "this recording cannot distinguish it from " +
                                   join(effect.indistinguishable_from));
    for (const DiagnosedParameter& p : effect.parameters) text += parameterText(p);
  }
  return text;
}

std::string rejectedText(const Diagnosis& d) {
  std::string text;
  std::size_t reported = 0;
  for (const Candidate& c : d.candidates)
    if (!c.rejected_because.empty() && reported++ < kReportedCandidates)
      text += wrapped(format("%s%-30s evidence %7.1f  ", kIndent, c.id.c_str(), c.evidence),
                      c.rejected_because);
  return text.empty() ? text : "\ntested and rejected\n" + text;
}

std::string comparisonText(const Diagnosis& d) {
  if (!(d.fit.train.to > d.fit.train.from)) return "";
  std::string text = format("\n%-30s %10s %10s   %10s %10s\n", "", "training", "", "hold-out", "");
  text += format("%-30s %10s %10s   %10s %10s\n", "before and after", "base", "extended", "base",
                 "extended");
  const auto cell = [](const std::optional<double>& value) {
    return value ? format("%.1f", *value) : "-";
  };
  for (const MetricRow& row : metricRows(d.fit))
    text += format("%-30s %10s %10s   %10s %10s\n", ("  " + row.title).c_str(),
                   cell(row.base_train).c_str(), cell(row.extended_train).c_str(),
                   cell(row.base_holdout).c_str(), cell(row.extended_holdout).c_str());
  if (!crankCounts(d.fit).empty()) text += "  " + crankCounts(d.fit) + "\n";
  if (!baselineSentence(d).empty()) text += wrapped("  ", baselineSentence(d));
  for (const RegimeComparison& r : d.fit.regimes)
    if (changeOf(r) == "worse")
      text += wrapped("  ", "the error grows in " + plainName(r.regime) + ": from " +
                                millivolts(r.base_rmse) + " to " + millivolts(r.extended_rmse) +
                                " mV RMS");
  return text;
}

std::string detectionLimitsText(const Diagnosis& d) {
  const bool promises = d.unexplained.isNoise();
  std::vector<std::string> hidden;
  for (const DetectionLimit& x : d.detection_limits)
    if (!x.visible && promises)
      hidden.push_back(x.id + (x.strength ? " (" + x.parameter + " below " +
                                                threeDigits(*x.strength) + " " + x.unit + ")"
                                          : " (at any strength)"));
  std::string text;
  if (!hidden.empty())
    text += "\n" + wrapped("limits       ",
                           "could be present without being detected: " + join(hidden, "; ") +
                               ". The strengths are estimates");
  if (!d.detection_limits.empty() && !promises)
    text += "\n" + wrapped("limits       ", whyNothingIsPromised(d.unexplained));
  for (const std::string& what : d.outside) text += wrapped("unobservable ", what);
  return text;
}

std::string restText(const Diagnosis& d) {
  std::string text;
  for (const std::string& what : d.instrument) text += wrapped("instrument   ", what);
  if (d.discrepancy) {
    text += wrapped("discrepancy  ", d.discrepancy->description + " " + useOfDiscrepancy(d));
    if (d.discrepancy->is_used)
      for (const std::string& term : d.discrepancy->terms) text += wrapped(kIndent, term);
  }
  if (d.verdict != Verdict::kInsufficientData)
    text += d.unexplained.rmse < d.unexplained.limits.rmse
                ? wrapped("unexplained  ",
                          millivolts(d.unexplained.rmse) +
                              " mV RMS of the error still depends on the currents, which is too "
                              "little to be reported (limit " +
                              millivolts(d.unexplained.limits.rmse) + " mV)")
                : wrapped("unexplained  ",
                          millivolts(d.unexplained.rmse) +
                              " mV RMS of the error still depends on the currents, and no equation "
                              "represents it");
  if (!d.next_experiment.empty()) text += wrapped("next         ", d.next_experiment);
  return text.empty() ? text : "\n" + text;
}

}  // namespace

// ---------------------------------------------------------------------------------------------
// JSON: what messages do not have (descriptions.hpp has the rest). Schema battery_sof/diagnosis/2.

DESCRIBED(RegimeFinding, MEMBERS("", regime, statistic, episodes, value, lower, upper, p_value),
          visit("unit", of.statistic == "slope" ? "V/s" : "V"), visit("alarm", of.is_significant))

DESCRIBED(ParameterBias, MEMBERS("", parameter, regime, z, change))

DESCRIBED(RegimeComparison, MEMBERS("", regime, samples),
          MEMBERS("v", base_rmse, extended_rmse, change, change_lower, change_upper))

DESCRIBED(Comparison, MEMBERS("", train, holdout, regimes),
          visit("base",
                Json{{"train", jsonOf(of.base_train)}, {"holdout", jsonOf(of.base_holdout)}}),
          visit("extended", Json{{"train", jsonOf(of.extended_train)},
                                 {"holdout", jsonOf(of.extended_holdout)}}))

DESCRIBED(DiscrepancyAnswer, MEMBERS("s", time),
          MEMBERS("v", charging, discharging, charging_std, discharging_std))

DESCRIBED(DiscrepancyAtCurrent, MEMBERS("a", current),
          MEMBERS("v", early, late, early_std, late_std))

DESCRIBED(MechanismProbability, visit("id", mechanismId(of.mechanism)),
          visit("probability",
                of.probability > 0.0 ? std::optional<double>(of.probability) : std::nullopt))

DESCRIBED(MechanismWeight, MEMBERS("", gain), MEMBERS("v", rms),
          visit("mechanism", mechanismId(of.mechanism)))

DESCRIBED(DiscrepancyFinding, MEMBERS("", mechanisms, terms, answers, curve, description),
          MEMBERS("v", rms), visit("used", of.is_used), visit("answers_to", of.answer_current, "a"),
          visit("left_out_base_rmse", of.left_out.base, "v"),
          visit("left_out_rmse", of.left_out.discrepancy, "v"))

DESCRIBED(Relevance, MEMBERS("v", crank, rmse), MEMBERS("", charge_share))

DESCRIBED(UnexplainedPart, MEMBERS("v", crank, rmse, noise), MEMBERS("", charge_share, limits))

DESCRIBED(DetectionLimit, MEMBERS("", id, parameter, unit, strength, typical, visible))

DESCRIBED(ScoreGain, MEMBERS("", value, std_error))

DESCRIBED(ControlledTime, MEMBERS("s", from, to))

DESCRIBED(ControlModeOverview, MEMBERS("", seen, summary), visit("reasons", of.totals),
          visit("voltage", of.times))

nlohmann::json resultJson(const Diagnosis& of) {
  JsonFields visit;
  describe(visit, of);
  MEMBERS("", fit, regimes, parameter_bias, mechanisms, discrepancy, detection_limits);
  visit("schema", "battery_sof/diagnosis/2");
  visit("program", "battery_sof " + version());
  visit("recording", printable(of.base.provenance.recording));
  visit("charger_share", of.source.share);
  visit("operating_mode", of.source);
  visit("baseline", of.fit.baseline_ridge);
  visit("baseline_line", of.fit.baseline_line);
  visit("probability", of.mechanism && of.probability > 0.0 ? std::optional<double>(of.probability)
                                                            : std::nullopt);
  visit("relevance", of.unexplained);
  visit("withheld_rmse", of.withheld_rmse, "v");
  visit("evidence", Json{{"base", jsonOf(of.evidence_base)},
                         {"extended", jsonOf(of.evidence_extended)},
                         {"effective_sample_fraction", jsonOf(of.effective_sample_fraction)}});
  for (std::size_t k = 0; k < of.candidates.size(); ++k)
    visit.json["candidates"][k]["score"] = jsonOf(of.candidates[k].score);
  return visit.json;
}

std::string resultText(const Diagnosis& d) {
  return verdictText(d) + mismatchText(d) + regimesText(d) + parameterBiasText(d) + effectsText(d) +
         rejectedText(d) + comparisonText(d) + detectionLimitsText(d) + restText(d);
}

std::string useOfDiscrepancy(const Diagnosis& diagnosis) {
  if (!diagnosis.discrepancy->is_used) return "It is not used.";
  if (diagnosis.extended.fit.discrepancy || diagnosis.source.share == 0.0)
    return "It is part of the extended model.";
  return "It is part of the extended model's voltage. A model file does not contain it: where a "
         "source controls the voltage, it predicts the current, with the correction that was "
         "estimated there.";
}

}  // namespace battery_sof
