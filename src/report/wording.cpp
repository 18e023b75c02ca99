#include "wording.hpp"

#include "util/text.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace battery_sof {
std::string wrapped(const std::string& lead, const std::string& text) {
  const std::string indent(lead.size(), ' ');
  std::string result, line = lead;
  std::istringstream words(text);
  bool is_first = true;
  for (std::string word; words >> word; is_first = false) {
    // An option stays beside its value, so that both are copied at once.
    if (std::string value; word.rfind("--", 0) == 0 && words >> value) word += " " + value;
    if (!is_first && line.size() + 1 + word.size() > kTextWidth) {
      result += line + "\n";
      line = indent + word;
    } else {
      line += (is_first ? "" : " ") + word;
    }
  }
  return result + line + "\n";
}

std::string meaningOf(Verdict verdict) {
  switch (verdict) {
    case Verdict::kNoMismatch:
      return "This verdict is about the model and says nothing about the battery's health.";
    case Verdict::kSensorFault:
      return "The fault lies in the measurement or the wiring, not in the battery.";
    case Verdict::kInsufficientData: return "This says nothing about the battery.";
    default: break;
  }
  return "This is a shortcoming of the model and does not mean that the battery is faulty.";
}

std::string threeDigits(double value) { return format("%.3g", value); }

std::string millivolts(const std::optional<double>& volts) {
  if (!volts || !std::isfinite(*volts)) return "-";
  const double mv = 1e3 * *volts;
  return format(std::abs(mv) < 99.95 ? "%.1f" : "%.0f", mv);
}

std::string whyNothingIsPromised(const UnexplainedPart& left) {
  const std::string reason =
      left.noise > kPlausible
          ? millivolts(left.noise) + " mV RMS remain unexplained, more than instruments account for"
          : millivolts(left.rmse) + " mV RMS of the error still depends on the currents";
  return reason + "; an effect would not stand out from it, so no detection limit is stated";
}

std::string biasText(const ParameterBias& bias) {
  constexpr double kNoChange = 0.005;  // of a value: rounds to 0 %
  if (bias.parameter == "u_dc") return millivolts(bias.change) + " mV";
  if (std::abs(bias.change) < kNoChange && std::abs(bias.z) >= kNotableZ) return "beyond its bound";
  return format("%+.0f %%", 100.0 * bias.change);
}

std::string confidenceText(double confidence) {
  return confidence > 0.99 ? "above 99 %" : format("%.0f %%", 100.0 * confidence);
}

std::string likelyMechanismsText(const std::vector<MechanismProbability>& mechanisms) {
  std::vector<std::string> parts;
  for (const MechanismProbability& one : mechanisms)
    parts.push_back(mechanismId(one.mechanism) + format(" %.2f", one.probability));
  return join(parts);
}

std::string noStretchText(const Diagnosis& diagnosis) {
  const Verdict verdict = diagnosis.verdict;
  const bool is_missing = verdict != Verdict::kNoMismatch && verdict != Verdict::kInsufficientData;
  if (!is_missing || !diagnosis.mismatch.empty()) return "";
  return "No stretch of time stands out: the base model deviates about as much in most of the "
         "recording.";
}

std::string plainName(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

std::vector<MetricRow> metricRows(const Comparison& fit) {
  std::vector<MetricRow> rows;
  const auto add = [&](const char* title, double scale, auto ErrorMetrics::*value,
                       bool more_is_better = false) {
    const auto shown = [&](const ErrorMetrics& metrics) {
      const std::optional<double> number = metrics.*value;
      return number ? std::optional(scale * *number) : number;
    };
    const MetricRow row{title,
                        more_is_better,
                        shown(fit.base_train),
                        shown(fit.extended_train),
                        shown(fit.base_holdout),
                        shown(fit.extended_holdout)};
    if (row.base_train || row.extended_train || row.base_holdout || row.extended_holdout)
      rows.push_back(row);
  };
  add("Q_dyn [%]", 1.0, &ErrorMetrics::q_dyn_percent, true);
  add("RMS error [mV]", 1e3, &ErrorMetrics::rmse);
  add("largest error [mV]", 1e3, &ErrorMetrics::max_abs);
  add("crank minima [mV]", 1e3, &ErrorMetrics::crank_mae);
  add("bias in charges [mV]", 1e3, &ErrorMetrics::charge_bias);
  add("charge current [A]", 1.0, &ErrorMetrics::charge_current_error);
  add("explained variation [%]", 1.0, &ErrorMetrics::share_percent, true);
  add("explained, current only [%]", 1.0, &ErrorMetrics::current_share_percent, true);
  return rows;
}

std::string crankCounts(const Comparison& fit) {
  if (fit.base_train.cranks + fit.base_holdout.cranks == 0) return "";
  return format("cranks: %zu in the hold-out, %zu in the training part", fit.base_holdout.cranks,
                fit.base_train.cranks);
}

std::string baselineSentence(const Diagnosis& diagnosis) {
  const Comparison& fit = diagnosis.fit;
  std::string text;
  const auto add = [&text](const char* baseline, const std::optional<ErrorMetrics>& metrics) {
    if (!metrics) return;
    text += text.empty() ? "On the hold-out, without any physics, " : "; ";
    text += baseline + format(" reaches Q_dyn %.1f %% and an RMS error of %.1f mV",
                              metrics->q_dyn_percent, 1e3 * metrics->rmse);
    if (metrics->share_percent)
      text += format(" (explained variation %.1f %%)", *metrics->share_percent);
  };
  add("a ridge regression on the current and its history", fit.baseline_ridge);
  add("a linear baseline", fit.baseline_line);
  if (!text.empty()) text += ".";
  if (diagnosis.source.share > 0.0)
    text += format("%sA source holds the voltage in %.0f %% of the samples.",
                   text.empty() ? "" : " ", 100.0 * diagnosis.source.share);
  return text;
}

std::string changeOf(const RegimeComparison& regime) {
  if (regime.change_upper < 0.0) return "better";
  return regime.change_lower > 0.0 ? "worse" : "not decided";
}

}  // namespace battery_sof
