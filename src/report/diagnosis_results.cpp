#include "report/diagnosis_results.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "battery_sof/version.hpp"
#include "util/printable.hpp"
#include "util/text.hpp"
#include "wording.hpp"

namespace battery_sof {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kSegmentsTold = 8;        // of the text's list; JSON has all
constexpr std::size_t kReportedCandidates = 6;  // of the text's list
constexpr double kNotableZ = 4.0;               // of an absorption: 1 in 16,000 by chance alone

// ---------------------------------------------------------------------------------------------
// JSON

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json number(const std::optional<double>& value) { return value ? number(*value) : Json(nullptr); }

/// One array entry for each item.
template <typename Item, typename Entry>
Json listOf(const std::vector<Item>& items, Entry&& entry) {
  Json list = Json::array();
  for (const Item& item : items) list.push_back(entry(item));
  return list;
}

Json parameterJson(const DiagnosedParameter& parameter) {
  return {{"name", parameter.name},           {"value", number(parameter.value)},
          {"std", number(parameter.std)},     {"unit", parameter.unit},
          {"lower", number(parameter.lower)}, {"upper", number(parameter.upper)},
          {"at_bound", parameter.at_bound}};
}

Json effectJson(const NamedEffect& effect) {
  return {{"id", effect.id},
          {"title", titleOf(effect.id)},
          {"mechanism", effect.mechanism},
          {"probability", number(effect.probability)},
          {"confidence", number(effect.confidence)},
          {"absorbed_into", effect.biased_parameters},
          {"parameters", listOf(effect.parameters, parameterJson)},
          {"evidence", number(effect.evidence)},
          {"voltage_rms_v", number(effect.voltage_rms)},
          {"indistinguishable_from", effect.indistinguishable_from}};
}

Json candidateJson(const Candidate& candidate) {
  return {{"id", candidate.id},
          {"title", titleOf(candidate.id)},
          {"mechanism", candidate.mechanism},
          {"probability", number(candidate.confidence)},
          {"holdout_gain_percent", number(candidate.holdout_gain_percent)},
          {"evidence", number(candidate.evidence)},
          {"confidence", number(candidate.confidence)},
          {"rejected_because", candidate.rejected_because}};
}

Json segmentJson(const MismatchSegment& segment) {
  return {{"from_s", number(segment.from)},
          {"to_s", number(segment.to)},
          {"regime", segment.regime},
          {"mean_error_v", number(segment.mean_error)},
          {"peak_error_v", number(segment.peak_error)},
          {"p_value", number(segment.p_value)}};
}

Json regimeJson(const RegimeFinding& finding) {
  return {{"regime", finding.regime},
          {"statistic", finding.statistic},
          {"unit", finding.statistic == "slope" ? "V/s" : "V"},
          {"episodes", finding.episodes},
          {"value", number(finding.value)},
          {"lower", number(finding.lower)},
          {"upper", number(finding.upper)},
          {"p_value", number(finding.p_value)},
          {"alarm", finding.is_significant}};
}

Json parameterBiasJson(const ParameterBias& parameter_bias) {
  return {{"parameter", parameter_bias.parameter},
          {"regime", parameter_bias.regime},
          {"z", number(parameter_bias.z)},
          {"change", number(parameter_bias.change)}};
}

Json comparedJson(const RegimeComparison& regime) {
  return {{"regime", regime.regime},
          {"samples", regime.samples},
          {"base_rmse_v", number(regime.base_rmse)},
          {"extended_rmse_v", number(regime.extended_rmse)},
          {"change_v", number(regime.change)},
          {"change_lower_v", number(regime.change_lower)},
          {"change_upper_v", number(regime.change_upper)}};
}

Json metricsJson(const ErrorMetrics& metrics) {
  return {{"q_dyn_percent", number(metrics.q_dyn_percent)},
          {"rmse_v", number(metrics.rmse)},
          {"max_abs_v", number(metrics.max_abs)},
          {"crank_mae_v", number(metrics.crank_mae)},
          {"cranks", metrics.cranks},
          {"charge_bias_v", number(metrics.charge_bias)},
          {"charge_current_error_a", number(metrics.charge_current_error)},
          {"share_percent", number(metrics.share_percent)},
          {"current_share_percent", number(metrics.current_share_percent)},
          {"voltage_share_percent", number(metrics.voltage_share_percent)}};
}

Json windowJson(const FitWindow& window) {
  return {{"from_s", number(window.from)}, {"to_s", number(window.to)}};
}

Json fitJson(const Comparison& fit) {
  return {{"train", windowJson(fit.train)},
          {"holdout", windowJson(fit.holdout)},
          {"base",
           {{"train", metricsJson(fit.base_train)}, {"holdout", metricsJson(fit.base_holdout)}}},
          {"extended",
           {{"train", metricsJson(fit.extended_train)},
            {"holdout", metricsJson(fit.extended_holdout)}}},
          {"regimes", listOf(fit.regimes, comparedJson)}};
}

Json answerJson(const DiscrepancyAnswer& answer) {
  return {{"time_s", number(answer.time)},
          {"charging_v", number(answer.charging)},
          {"discharging_v", number(answer.discharging)},
          {"charging_std_v", number(answer.charging_std)},
          {"discharging_std_v", number(answer.discharging_std)}};
}

Json atCurrentJson(const DiscrepancyAtCurrent& at) {
  return {{"current_a", number(at.current)},
          {"early_v", number(at.early)},
          {"late_v", number(at.late)},
          {"early_std_v", number(at.early_std)},
          {"late_std_v", number(at.late_std)}};
}

Json weightJson(const MechanismWeight& weight) {
  return {{"mechanism", mechanismId(weight.mechanism)},
          {"gain", number(weight.gain)},
          {"rms_v", number(weight.rms)}};
}

Json discrepancyJson(const std::optional<DiscrepancyFinding>& discrepancy) {
  if (!discrepancy) return nullptr;
  return {{"used", discrepancy->is_used},
          {"rms_v", number(discrepancy->rms)},
          {"left_out_base_rmse_v", number(discrepancy->left_out.base)},
          {"left_out_rmse_v", number(discrepancy->left_out.discrepancy)},
          {"mechanisms", listOf(discrepancy->mechanisms, weightJson)},
          {"terms", discrepancy->terms},
          {"answers_to_a", number(discrepancy->answer_current)},
          {"answers", listOf(discrepancy->answers, answerJson)},
          {"curve", listOf(discrepancy->curve, atCurrentJson)},
          {"description", discrepancy->description}};
}

Json mechanismJson(const MechanismProbability& one) {
  return {{"id", mechanismId(one.mechanism)}, {"probability", number(one.probability)}};
}

Json relevanceJson(const UnexplainedPart& left) {
  return {{"crank_v", number(left.crank)},
          {"charge_share", number(left.charge_share)},
          {"rmse_v", number(left.rmse)},
          {"noise_v", number(left.noise)},
          {"limits",
           {{"crank_v", number(left.limits.crank)},
            {"charge_share", number(left.limits.charge_share)},
            {"rmse_v", number(left.limits.rmse)}}}};
}

Json detectionLimitJson(const DetectionLimit& detection_limits) {
  return {{"id", detection_limits.id},
          {"parameter", detection_limits.parameter},
          {"unit", detection_limits.unit},
          {"strength", number(detection_limits.strength)},
          {"typical", number(detection_limits.typical)},
          {"visible", detection_limits.visible}};
}

// ---------------------------------------------------------------------------------------------
// text

constexpr char kIndent[] = "             ";

std::string timesText(const FitWindow& window) {
  return format("%.1f to %.1f s", window.from, window.to);
}

std::string verdictText(const Diagnosis& d) {
  std::string text = wrapped("verdict      ", toString(d.verdict) + ": " + d.summary);
  for (const MechanismProbability& one : d.mechanisms)
    text += wrapped(&one == &d.mechanisms.front() ? "mechanism    " : kIndent,
                    mechanismId(one.mechanism) + " (" + mechanismSentence(one.mechanism) +
                        format("), probability %.2f", one.probability));
  if (!d.base.provenance.recording.empty())
    text += "recording    " + d.base.provenance.recording + "\n";
  if (d.fit.train.to > d.fit.train.from)
    text += "             trained on " + timesText(d.fit.train) + ", compared on " +
            timesText(d.fit.holdout) + " that no fit has seen\n";
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
  if (d.mismatch.empty()) return "";
  std::string text =
      format("\nwhere measurement and base model deviate (%zu stretches%s), measured minus model\n",
             d.mismatch.size(), d.mismatch.size() > kSegmentsTold ? "; the largest" : "");
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
                                 " " + unit + ", 95 % between " + millivolts(f.lower) + " and " +
                                 millivolts(f.upper) + " " + unit +
                                 format(" (%zu episodes)", f.episodes));
  }
  return text.empty() ? text : "\nregimes in which the base model deviates\n" + text;
}

std::string neededChange(const ParameterBias& a) {
  return a.parameter == "u_dc" ? millivolts(a.change) + " mV"
                               : format("%+.0f %%", 100.0 * a.change);
}

std::string parameterBiasText(const Diagnosis& d) {
  std::string text;
  for (const ParameterBias& a : d.parameter_bias)
    if (std::abs(a.z) >= kNotableZ)
      text += format("%s%-12s needs %8s in %-22s (z %+.1f)\n", kIndent, a.parameter.c_str(),
                     neededChange(a).c_str(), plainName(a.regime).c_str(), a.z);
  return text.empty() ? text : "\nwhat the base model's parameters have taken up\n" + text;
}

std::string intervalText(const DiagnosedParameter& p) {
  if (p.lower && p.upper) return "95 % " + threeDigits(*p.lower) + " to " + threeDigits(*p.upper);
  if (p.lower) return "at least " + threeDigits(*p.lower);
  return p.upper ? "at most " + threeDigits(*p.upper) : "";
}

std::string parameterText(const DiagnosedParameter& p) {
  const std::string error = p.std ? "+- " + threeDigits(*p.std) : "";
  return format("%s%-24s %10s %-10s %-6s %s%s\n", kIndent, p.name.c_str(),
                threeDigits(p.value).c_str(), error.c_str(), p.unit.c_str(),
                intervalText(p).c_str(), p.at_bound ? " (at a bound)" : "");
}

std::string effectsText(const Diagnosis& d) {
  std::string text;
  for (const NamedEffect& effect : d.effects) {
    text +=
        "\n" + wrapped("effect       ", effect.id + ": " + titleOf(effect.id) + "; confidence " +
                                            confidenceText(effect.confidence) + ", adds " +
                                            millivolts(effect.voltage_rms) + " mV RMS");
    if (!effect.biased_parameters.empty())
      text += wrapped(kIndent, "hidden before in " + join(effect.biased_parameters));
    if (!effect.indistinguishable_from.empty())
      text +=
          wrapped(kIndent, "not distinguishable here from " + join(effect.indistinguishable_from));
    for (const DiagnosedParameter& p : effect.parameters) text += parameterText(p);
  }
  return text;
}

std::string rejectedText(const Diagnosis& d) {
  std::string text;
  std::size_t reported = 0;
  for (const Candidate& c : d.candidates)
    if (!c.rejected_because.empty() && reported++ < kReportedCandidates)
      text += wrapped(format("%s%-26s evidence %7.1f  ", kIndent, c.id.c_str(), c.evidence),
                      c.rejected_because);
  return text.empty() ? text : "\nweighed and rejected\n" + text;
}

std::string cell(const std::optional<double>& value, double scale) {
  return value ? format("%.1f", scale * *value) : "-";
}

std::string comparisonText(const Diagnosis& d) {
  if (!(d.fit.train.to > d.fit.train.from)) return "";
  std::string text = format("\n%-26s %10s %10s   %10s %10s\n", "", "training", "", "hold-out", "");
  text += format("%-26s %10s %10s   %10s %10s\n", "before and after", "base", "extended", "base",
                 "extended");
  for (const MetricRow& row : metricRows(d.fit))
    text += format(
        "%-26s %10s %10s   %10s %10s\n", ("  " + row.title + " [" + row.unit + "]").c_str(),
        cell(row.base_train, row.scale).c_str(), cell(row.extended_train, row.scale).c_str(),
        cell(row.base_holdout, row.scale).c_str(), cell(row.extended_holdout, row.scale).c_str());
  if (!crankCounts(d.fit).empty()) text += "  " + crankCounts(d.fit) + "\n";
  if (!baselineSentence(d).empty()) text += wrapped("  ", baselineSentence(d));
  for (const RegimeComparison& r : d.fit.regimes)
    if (changeOf(r) == Change::kWorse)
      text +=
          wrapped("  ", "became worse in " + plainName(r.regime) + ": " + millivolts(r.base_rmse) +
                            " to " + millivolts(r.extended_rmse) + " mV");
  return text;
}

std::string detectionLimitsText(const Diagnosis& d) {
  const bool promises = d.unexplained.isNoise();
  std::vector<std::string> hidden;
  for (const DetectionLimit& x : d.detection_limits)
    if (!x.visible && (promises || x.strength))
      hidden.push_back(x.id + (x.strength ? " (" + x.parameter + " below " +
                                                threeDigits(*x.strength) + " " + x.unit + ")"
                                          : " (at any strength)"));
  const std::string tries = "--verify-detection-limits ID tries one";
  std::string text;
  if (!hidden.empty())
    text += "\n" + wrapped("limits       ",
                           "could be here unseen: " + join(hidden, "; ") +
                               (promises ? ". Strengths are estimates: " + tries : std::string()));
  if (!d.detection_limits.empty() && !promises)
    text += "\n" + wrapped("limits       ", whyNothingIsPromised(d.unexplained) + ": " + tries);
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
                ? wrapped("too small    ",
                          millivolts(d.unexplained.rmse) + " mV RMS of structure is left; below " +
                              millivolts(d.unexplained.limits.rmse) + " mV nothing is reported")
                : wrapped("unexplained  ", "regressors of the currents would explain " +
                                               millivolts(d.unexplained.rmse) +
                                               " mV RMS in addition to the equations");
  if (!d.next_experiment.empty()) text += wrapped("next         ", d.next_experiment);
  return text.empty() ? text : "\n" + text;
}

Json operatingModeJson(const ControlModeOverview& source) {
  return {{"seen", source.seen},
          {"summary", source.summary},
          {"reasons", listOf(source.totals,
                             [](const ControlModeTotals& totals) -> Json {
                               return {{"mode", toString(totals.mode)},
                                       {"reason", totals.reason},
                                       {"stretches", totals.stretches},
                                       {"samples", totals.samples}};
                             })},
          {"voltage", listOf(source.voltage_controlled, [](const ControlledTime& time) -> Json {
             return {{"from_s", number(time.from)}, {"to_s", number(time.to)}};
           })}};
}

}  // namespace

nlohmann::json diagnosisJson(const Diagnosis& d) {
  return {
      {"schema", "battery_sof/diagnosis/2"},
      {"program", "battery_sof " + version()},
      {"recording", printable(d.base.provenance.recording)},
      {"verdict", toString(d.verdict)},
      {"summary", d.summary},
      {"effects", listOf(d.effects, effectJson)},
      {"candidates", listOf(d.candidates, candidateJson)},
      {"mismatch", listOf(d.mismatch, segmentJson)},
      {"fit", fitJson(d.fit)},
      {"charger_share", number(d.charger_share)},
      {"operating_mode", operatingModeJson(d.source)},
      {"baseline", d.fit.baseline_ridge ? metricsJson(*d.fit.baseline_ridge) : Json(nullptr)},
      {"baseline_line", d.fit.baseline_line ? metricsJson(*d.fit.baseline_line) : Json(nullptr)},
      {"next_experiment", d.next_experiment},
      {"regimes", listOf(d.regimes, regimeJson)},
      {"parameter_bias", listOf(d.parameter_bias, parameterBiasJson)},
      {"mechanism", d.mechanism() ? Json(mechanismId(*d.mechanism())) : Json(nullptr)},
      {"mechanisms", listOf(d.mechanisms, mechanismJson)},
      {"probability", d.mechanism() ? number(d.probability()) : Json(nullptr)},
      {"relevance", relevanceJson(d.unexplained)},
      {"withheld_rmse_v", number(d.withheld_rmse)},
      {"discrepancy", discrepancyJson(d.discrepancy)},
      {"evidence",
       {{"base", number(d.evidence_base)},
        {"extended", number(d.evidence_extended)},
        {"effective_sample_fraction", number(d.effective_sample_fraction)}}},
      {"instrument", d.instrument},
      {"detection_limits", listOf(d.detection_limits, detectionLimitJson)},
      {"unobservable", d.outside}};
}

std::string diagnosisText(const Diagnosis& d) {
  return verdictText(d) + mismatchText(d) + regimesText(d) + parameterBiasText(d) + effectsText(d) +
         rejectedText(d) + comparisonText(d) + detectionLimitsText(d) + restText(d);
}

std::string useOfDiscrepancy(const Diagnosis& diagnosis) {
  if (!diagnosis.discrepancy->is_used) return "It is not used.";
  if (diagnosis.extended.fit.discrepancy || diagnosis.charger_share == 0.0)
    return "It is in the extended model.";
  return "It is in the extended model's voltage; a model file answers in the direction that the "
         "source controls and has what was estimated "
         "there.";
}

}  // namespace battery_sof
