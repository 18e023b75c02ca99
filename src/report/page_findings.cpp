#include <algorithm>
#include <cmath>
#include <limits>

#include "page.hpp"
#include "report/results.hpp"
#include "util/text.hpp"
#include "wording.hpp"

namespace battery_sof {
namespace {

/// Whether the extended model is another than the base model.
bool hasExtended(const Diagnosis& d) {
  return !d.effects.empty() || (d.discrepancy && d.discrepancy->is_used);
}

constexpr double kFullColorZ = 15.0;  // |z| from which the map's colour no longer deepens
constexpr std::size_t kSegmentsListed = 60;
constexpr std::size_t kCandidatesListed = 8;
constexpr char kNone[] = "\xe2\x80\x93";

std::string code(const std::string& text) { return element("code", escaped(text)); }

/// A unit as one would say it: milliohms and millivolts below one.
struct SpokenUnit {
  double factor;
  std::string name;
};

SpokenUnit spokenUnit(double value, const std::string& unit) {
  const bool is_small = std::abs(value) < 1.0 && value != 0.0;
  if (unit == "ohm") return is_small ? SpokenUnit{1e3, " m\xce\xa9"} : SpokenUnit{1.0, " \xce\xa9"};
  if (unit == "V" && is_small) return {1e3, " mV"};
  return {1.0, unit == "1" ? "" : " " + unit};
}

/// Three significant digits, four from 1000 on; no exponent where it can be helped.
std::string spoken(double value, const std::string& unit) {
  if (!std::isfinite(value)) return kNone;
  const SpokenUnit spoken_unit = spokenUnit(value, unit);
  const double number = spoken_unit.factor * value;
  const bool is_large = std::abs(number) >= 1000.0 && std::abs(number) < 1e6;
  return (is_large ? format("%.0f", number) : threeDigits(number)) + spoken_unit.name;
}

/// "8.50 ± 0.17 mΩ": as many decimals as the standard error's second digit.
std::string withError(double value, const std::optional<double>& std, const std::string& unit) {
  if (!std || !(*std > 0.0) || !std::isfinite(*std) || !std::isfinite(value))
    return spoken(value, unit);
  const SpokenUnit spoken_unit = spokenUnit(value, unit);
  const double error = spoken_unit.factor * *std;
  const int decimals = std::clamp(1 - static_cast<int>(std::floor(std::log10(error))), 0, 6);
  return format("%.*f \xc2\xb1 %.*f", decimals, spoken_unit.factor * value, decimals, error) +
         spoken_unit.name;
}

/// Begins with a capital.
std::string headline(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z')
    text[0] = static_cast<char>(text[0] - 'a' + 'A');
  return text;
}

// ---------------------------------------------------------------------------------------------
// where

/// The regimes or parameters of a list, each once, in order of appearance.
template <typename Item>
std::vector<std::string> namesOf(const std::vector<Item>& items, std::string Item::*name) {
  std::vector<std::string> names;
  for (const Item& item : items)
    if (!contains(names, item.*name)) names.push_back(item.*name);
  return names;
}

Cell findingCell(const std::vector<RegimeFinding>& findings, const std::string& regime,
                 const std::string& statistic) {
  for (const RegimeFinding& f : findings)
    if (f.regime == regime && f.statistic == statistic)
      return {
          element(f.is_significant ? "strong" : "span", withMinusSigns(millivolts(f.value))) +
              element("small", withMinusSigns(millivolts(f.lower) + " to " + millivolts(f.upper))),
          f.is_significant ? "class=\"number significant\"" : kNumber};
  return numberCell(kNone);
}

std::string regimeTable(const Diagnosis& d) {
  std::vector<std::vector<Cell>> rows;
  for (const std::string& regime : namesOf(d.regimes, &RegimeFinding::regime)) {
    std::size_t episodes = 0;
    for (const RegimeFinding& f : d.regimes)
      if (f.regime == regime) episodes = std::max(episodes, f.episodes);
    rows.push_back({{escaped(plainName(regime))},
                    numberCell(std::to_string(episodes)),
                    findingCell(d.regimes, regime, "mean"),
                    findingCell(d.regimes, regime, "slope"),
                    findingCell(d.regimes, regime, "end")});
  }
  if (rows.empty()) return "";
  return element("h3", "By operating regime") +
         element("p.note",
                 "Measured minus base model, with 95 % intervals. A value is marked if it is "
                 "larger than chance explains, given the number of values that were tested. A "
                 "regime with fewer than five episodes is not listed.") +
         table({"regime", "episodes", "mean [mV]", "slope [mV/s]", "at its end [mV]"}, rows);
}

Cell parameterBiasCell(const std::vector<ParameterBias>& map, const std::string& parameter,
                       const std::string& regime) {
  for (const ParameterBias& a : map)
    if (a.parameter == parameter && a.regime == regime) {
      const double strength = std::min(std::abs(a.z) / kFullColorZ, 1.0);
      const std::string wish = biasText(a);
      const std::string kind =
          format("class=\"heat %s%s\" style=\"--strength:%.2f\"", a.z > 0.0 ? "more" : "less",
                 std::abs(a.z) >= kNotableZ ? " notable" : "", strength);
      return {withMinusSigns(format("%+.1f", a.z)) + element("small", withMinusSigns(wish)), kind};
    }
  return {kNone, "class=\"heat\""};
}

std::string parameterBiasTable(const Diagnosis& d) {
  if (d.parameter_bias.empty()) return "";
  const auto regimes = namesOf(d.parameter_bias, &ParameterBias::regime);
  std::vector<std::string> head = {"parameter"};
  for (const std::string& regime : regimes) head.push_back(escaped(plainName(regime)));
  std::vector<std::vector<Cell>> rows;
  for (const std::string& parameter : namesOf(d.parameter_bias, &ParameterBias::parameter)) {
    rows.push_back({{code(parameter)}});
    for (const std::string& regime : regimes)
      rows.back().push_back(parameterBiasCell(d.parameter_bias, parameter, regime));
  }
  return element("h3", "Parameters that would fit better with another value") +
         element("p.note",
                 "Each parameter has one value for all regimes. A cell shows how far the best "
                 "value for one regime is from it, in standard errors (z), and the change that "
                 "this would take: " +
                     element("span.chip more", "more") + " or " +
                     element("span.chip less", "less") +
                     ". With a correct model, all cells are pale.") +
         table(head, rows, "class=\"map\"");
}

std::string segmentTable(const Diagnosis& d, double clock_origin) {
  if (d.mismatch.empty()) {
    const std::string sentence = noStretchText(d);
    return sentence.empty() ? "" : element("p.note", sentence);
  }
  std::vector<std::vector<Cell>> rows;
  for (const MismatchSegment& s : d.mismatch) {
    if (rows.size() == kSegmentsListed) break;
    const double from = s.from - clock_origin, to = s.to - clock_origin;
    rows.push_back(
        {{format("%.1f to %.1f s", from, to) +
          element("button", "show",
                  format("type=\"button\" class=\"show\" data-from=\"%.3f\" data-to=\"%.3f\"", from,
                         to))},
         {escaped(plainName(s.regime))},
         numberCell(millivolts(s.mean_error)),
         numberCell(millivolts(s.peak_error)),
         numberCell(format("%.1g", s.p_value))});
  }
  const std::string more =
      format("Only the first %zu of %zu stretches are listed; the JSON output has all of them.",
             kSegmentsListed, d.mismatch.size());
  return details(format("Stretch by stretch (%zu)", d.mismatch.size()),
                 table({"stretch", "regime", "mean [mV]", "peak [mV]", "p"}, rows) +
                     (d.mismatch.size() > kSegmentsListed ? element("p.note", more) : ""));
}

// ---------------------------------------------------------------------------------------------
// evidence

/// Share of the full width on a logarithmic axis that begins at 1.
double onAxis(double value, double end) {
  return value <= 1.0 ? 0.0 : std::min(std::log(value) / std::log(end), 1.0);
}

std::string candidateHtml(const Candidate& c, double end, double threshold) {
  const bool is_accepted = c.rejected_because.empty();
  std::string numbers =
      escaped(plainName(c.mechanism)) + format(" \xc2\xb7 evidence %.0f", c.evidence);
  if (c.holdout_gain_percent)
    numbers += format(" \xc2\xb7 hold-out %+.0f %%", *c.holdout_gain_percent);
  const std::string
      bar = format("style=\"width:%.1f%%\"", 100.0 * onAxis(c.evidence, end)),
      line = format("style=\"left:%.1f%%\"", 100.0 * onAxis(threshold, end)),
      why = is_accepted ? "accepted, because its evidence is above the line. The probability that "
                          "its mechanism is missing and that this equation describes it is " +
                              escaped(confidenceText(c.confidence))
                        : "rejected: " + escaped(c.rejected_because);
  return element(
      is_accepted ? "li.accepted" : "li",
      element("div.name", element("strong", escaped(headline(titleOf(c.id)))) + " " + code(c.id)) +
          element("div.track",
                  element("span.bar after", "", bar) + element("span.threshold", "", line)) +
          element("div.numbers", withMinusSigns(numbers)) + element("div.why", why));
}

// ---------------------------------------------------------------------------------------------
// effects

/// Where a value lies between the catalogue's bounds, as a mark on a gauge and in numbers.
std::string plausibility(const std::string& id, const DiagnosedParameter& p) {
  if (p.at_bound)
    return element("strong", "at the bound of the catalogue, so the value is not plausible");
  const EffectInfo* effect = catalogued(id);
  if (effect == nullptr) return kNone;
  const auto info = std::find_if(effect->parameters.begin(), effect->parameters.end(),
                                 [&](const ParameterInfo& known) { return known.name == p.name; });
  if (info == effect->parameters.end()) return kNone;
  const bool log = info->logarithmic && info->lower > 0.0 && p.value > 0.0;
  const auto at = [&](double x) { return log ? std::log(x) : x; };
  const double share =
      std::clamp((at(p.value) - at(info->lower)) / (at(info->upper) - at(info->lower)), 0.0, 1.0);
  return element("span.gauge", element("i", "", format("style=\"left:%.0f%%\"", 100.0 * share))) +
         element("small",
                 escaped(spoken(info->lower, p.unit) + " to " + spoken(info->upper, p.unit)));
}

std::string effectHtml(const NamedEffect& effect) {
  std::vector<std::vector<Cell>> rows;
  for (const DiagnosedParameter& p : effect.parameters)
    rows.push_back({{code(p.name)},
                    numberCell(withError(p.value, p.std, p.unit)),
                    numberCell(p.lower && p.upper
                                   ? spoken(*p.lower, p.unit) + " to " + spoken(*p.upper, p.unit)
                                   : kNone),
                    {plausibility(effect.id, p)}});
  std::string facts = "The probability that its mechanism is missing is " +
                      escaped(confidenceText(effect.probability));
  if (!effect.indistinguishable_from.empty())
    facts += "; that this equation describes it, " + escaped(confidenceText(effect.confidence));
  facts += ". The effect changes the voltage by " + millivolts(effect.voltage_rms) + " mV RMS.";
  if (!effect.biased_parameters.empty())
    facts += " Without it, the fit biased " + escaped(join(effect.biased_parameters)) + ".";
  if (!effect.indistinguishable_from.empty())
    facts += " This recording cannot distinguish it from " +
             escaped(join(effect.indistinguishable_from)) + ".";
  std::string html = element("h3", escaped(headline(titleOf(effect.id))) + " " + code(effect.id)) +
                     element("p", facts);
  if (const EffectInfo* info = catalogued(effect.id))
    html += element("pre", escaped(info->equations));
  return html +
         table({"parameter", "value", "95 % interval", "inside the catalogue\xe2\x80\x99s bounds"},
               rows);
}

std::string baseParameterTable(const Diagnosis& d) {
  std::vector<std::vector<Cell>> rows;
  for (const ParameterEstimate& before : d.base.fit.estimates)
    for (const ParameterEstimate& after : d.extended.fit.estimates) {
      if (after.name != before.name || before.value == 0.0) continue;
      rows.push_back({{code(before.name)},
                      numberCell(withError(before.value, before.std, before.unit)),
                      numberCell(withError(after.value, after.std, after.unit)),
                      numberCell(format("%+.1f %%", 100.0 * (after.value / before.value - 1.0)))});
    }
  if (rows.empty()) return "";
  return element("h3", "Parameters of the base model") +
         table({"parameter", "base model", "extended model", "change"}, rows);
}

// ---------------------------------------------------------------------------------------------
// comparison

std::string metricTable(const Diagnosis& d) {
  const bool is_extended = hasExtended(d);
  const auto cell = [](const std::optional<double>& value) {
    return numberCell(value && std::isfinite(*value) ? format("%.1f", *value) : kNone);
  };
  std::vector<std::vector<Cell>> rows;
  for (const MetricRow& row : metricRows(d.fit)) {
    const Cell title{escaped(row.title)};
    // The better one of two is bold, where they differ as they are shown.
    const auto pair = [&](const std::optional<double>& base,
                          const std::optional<double>& extended) {
      std::vector<Cell> cells = {cell(base), cell(extended)};
      if (!base || !extended || cells[0].html == cells[1].html) return cells;
      const bool is_better =
          row.more_is_better ? *extended > *base : std::abs(*extended) < std::abs(*base);
      cells[is_better ? 1 : 0].html = element("strong", cells[is_better ? 1 : 0].html);
      return cells;
    };
    if (is_extended) {
      const auto holdout = pair(row.base_holdout, row.extended_holdout),
                 train = pair(row.base_train, row.extended_train);
      rows.push_back({title, holdout[0], holdout[1], train[0], train[1]});
    } else
      rows.push_back({title, cell(row.base_holdout), cell(row.base_train)});
  }
  const std::string sentence = baselineSentence(d), counts = crankCounts(d.fit);
  const std::string baseline = sentence.empty() ? "" : element("p", escaped(sentence));
  const std::string cranks = counts.empty() ? "" : element("p.note", headline(counts) + ".");
  if (!is_extended) return table({"", "hold-out", "training"}, rows) + cranks + baseline;
  return baseline + cranks +
         table({"", "hold-out, base", "hold-out, extended", "training, base", "training, extended"},
               rows);
}

std::string regimeComparisonTable(const Diagnosis& d) {
  if (d.effects.empty() || d.fit.regimes.empty()) return "";
  std::vector<std::vector<Cell>> rows;
  for (const RegimeComparison& r : d.fit.regimes) {
    const std::string change = changeOf(r), kind = change == "not decided" ? "open" : change,
                      by = (r.change > 0.0 ? "+" : "") + millivolts(r.change) + " mV",
                      range = millivolts(r.change_lower) + " to " + millivolts(r.change_upper);
    rows.push_back({{escaped(plainName(r.regime))},
                    numberCell(std::to_string(r.samples)),
                    numberCell(millivolts(r.base_rmse)),
                    numberCell(millivolts(r.extended_rmse)),
                    {withMinusSigns(by) + element("small", withMinusSigns(range)), kNumber},
                    {element("span.verdict-chip " + kind, change)}});
  }
  return element("h3", "Regime by regime, on the hold-out") +
         table({"regime", "samples", "base, RMS [mV]", "extended, RMS [mV]", "change, 95 %", ""},
               rows);
}

// ---------------------------------------------------------------------------------------------
// hidden

std::string detectionLimitsTable(std::vector<DetectionLimit> list) {
  const auto ratio = [](const DetectionLimit& x) {
    return !x.strength        ? std::numeric_limits<double>::infinity()
           : x.typical != 0.0 ? std::abs(*x.strength / x.typical)
                              : 0.0;
  };
  std::stable_sort(list.begin(), list.end(), [&](const DetectionLimit& a, const DetectionLimit& b) {
    return ratio(a) > ratio(b);
  });
  std::vector<std::vector<Cell>> rows;
  for (const DetectionLimit& x : list)
    rows.push_back(
        {{escaped(headline(titleOf(x.id))) + " " + code(x.id)},
         {code(x.parameter)},
         numberCell(x.strength ? spoken(*x.strength, x.unit) : "at no strength"),
         numberCell(spoken(x.typical, x.unit)),
         numberCell(x.strength && ratio(x) > 0.0 ? threeDigits(ratio(x)) + " \xc3\x97" : kNone)});
  return table({"effect", "parameter", "detected from", "typical", "ratio"}, rows);
}

std::string listHtml(const std::vector<std::string>& sentences) {
  std::string items;
  for (const std::string& text : sentences) items += element("li", escaped(text));
  return element("ul", items);
}

}  // namespace

std::string section(const std::string& id, const std::string& title, const std::string& body) {
  if (body.empty()) return "";
  return element("section", element("h2", title) + "\n" + body, "id=\"" + id + "\"") + "\n";
}

std::string whereSection(const Diagnosis& d, double clock_origin) {
  return section("where", "Where model and measurement deviate",
                 regimeTable(d) + segmentTable(d, clock_origin) + parameterBiasTable(d));
}

std::string evidenceSection(const Diagnosis& d) {
  if (d.candidates.empty()) return "";
  const double threshold = kMinGain;
  double end = 2.0 * threshold;
  for (const Candidate& c : d.candidates) end = std::max(end, c.evidence);
  std::vector<Candidate> candidates = d.candidates;
  std::stable_partition(candidates.begin(), candidates.end(),
                        [](const Candidate& c) { return c.rejected_because.empty(); });
  std::string items, further;
  for (std::size_t k = 0; k < candidates.size(); ++k)
    (k < kCandidatesListed ? items : further) +=
        candidateHtml(candidates[k], end, threshold) + "\n";
  if (!further.empty())
    further = details(format("%zu more", d.candidates.size() - kCandidatesListed),
                      element("ol.evidence", further));
  const std::string likely = "Likely mechanisms: " + escaped(likelyMechanismsText(d.mechanisms));
  return section(
      "evidence", "What was tested",
      element("p.note",
              element("span.swatch after", "") +
                  " Gain in evidence when the effect is added to the model, on a logarithmic "
                  "scale. The line marks the gain from which an effect is accepted.") +
          element("ol.evidence", items) + further +
          (d.mechanisms.empty() ? "" : element("p", likely + ".")));
}

std::string effectsSection(const Diagnosis& d) {
  std::string html;
  for (const NamedEffect& effect : d.effects) html += effectHtml(effect);
  return html.empty() ? ""
                      : section("effects", "What is missing, with its parameters",
                                html + baseParameterTable(d));
}

std::string comparisonSection(const Diagnosis& d) {
  if (!(d.fit.holdout.to > d.fit.holdout.from)) return "";
  const std::string note =
      !hasExtended(d) ? "Nothing was added, so these are the errors of the base model. " : "";
  return section(
      "comparison", "Before and after",
      element("p.note",
              note + "The hold-out is the end of the drive, which neither the fits nor the choice "
                     "of effects has used. The better value is bold: the higher one of Q_dyn and "
                     "explained variation, and the smaller one of everything else.") +
          metricTable(d) + regimeComparisonTable(d));
}

std::string detectionLimitsSection(const Diagnosis& d) {
  std::vector<DetectionLimit> hidden, visible;
  for (const DetectionLimit& x : d.detection_limits)
    if (d.unexplained.isNoise()) (x.visible ? visible : hidden).push_back(x);
  std::string html;
  if (!d.detection_limits.empty() && !d.unexplained.isNoise())
    html += element("p", headline(whyNothingIsPromised(d.unexplained)) + ".");
  if (!hidden.empty())
    html += element(
        "p",
        "These effects may be present at their usual strength without showing in this recording. "
        "The strengths are estimates and only as good as the model that was found.");
  if (!hidden.empty()) html += detectionLimitsTable(hidden);
  if (!visible.empty())
    html += details(format("Effects that would have been detected (%zu)", visible.size()),
                    detectionLimitsTable(visible));
  if (!d.outside.empty())
    html +=
        element("h3", "What no recording of current and voltage can show") + listHtml(d.outside);
  if (!d.instrument.empty()) html += element("h3", "Instruments") + listHtml(d.instrument);
  return section("hidden", "Detection limits", html);
}

std::string unexplainedSection(const Diagnosis& d) {
  if (!d.discrepancy) return "";
  const DiscrepancyFinding& discrepancy = *d.discrepancy;
  std::string html = element("p", escaped(discrepancy.description + " " + useOfDiscrepancy(d)));
  if (!discrepancy.is_used) return section("unexplained", "What no equation represents", html);
  if (d.mechanism)
    html += element("p", "Its mechanism: " + escaped(mechanismSentence(*d.mechanism)) + ".");
  html += element("h3", "Regressors with the largest weights") + listHtml(discrepancy.terms);
  return section("unexplained", "What no equation represents", html + discrepancyHtml(d));
}

std::string nextSection(const Diagnosis& d) {
  if (d.next_experiment.empty()) return "";
  return section("next", "What to record next", element("p.next", escaped(d.next_experiment)));
}

std::string readingSection() {
  const char* const items[][2] = {
      {"Base model",
       "The small circuit of the paper: two resistances, a double layer with charge transfer, and "
       "a constant open-circuit voltage. It is fitted to the training part."},
      {"Extended model",
       "The base model with the effects that were found, all fitted together, and the "
       "discrepancy."},
      {"Evidence",
       "The logarithm of how much better the data are predicted with an effect than without it. "
       "Correlated errors count once. An effect is accepted if the gain is at least 12."},
      {"Probability",
       "How likely it is that this mechanism is missing, compared with the best that any other "
       "mechanism offers in its place."},
      {"Discrepancy",
       "A correction from the data, a function of the current and its history, for what no "
       "equation represents. It is used only if it predicts stretches that it was not fitted to."},
      {"Q_dyn", "1 - RMS error / standard deviation of the voltage [%] (paper, eq. 6)."},
      {"Sign", "Current is positive into the battery; errors are measured minus model."}};
  std::string list;
  for (const auto& item : items) list += element("dt", item[0]) + element("dd", item[1]);
  return section("reading", "How to read this page", element("dl", list));
}

}  // namespace battery_sof
