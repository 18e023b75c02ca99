#include "report/diagnosis_page.hpp"

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "battery_sof/version.hpp"
#include "page.hpp"
#include "report/results.hpp"
#include "util/text.hpp"
#include "wording.hpp"

namespace battery_sof {
namespace {

constexpr double kEpochClock = 1e8;  // [s]; a clock above it counts from 1970

/// Nothing may be fetched: a page that is passed on must not call home.
constexpr char kHead[] =
    "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
    "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
    "<meta name=\"color-scheme\" content=\"light dark\">\n"
    "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src "
    "'unsafe-inline'; script-src 'unsafe-inline'; img-src data:\">\n";

void requireMatching(const Recording& recording, const Diagnosis& diagnosis) {
  for (const auto* model : {&diagnosis.base_voltage, &diagnosis.extended_voltage})
    if (!model->empty() && model->size() != recording.series.size())
      throw std::invalid_argument(format("diagnosisPage: %zu modelled voltages for %zu samples",
                                         model->size(), recording.series.size()));
  if (diagnosis.base_voltage.empty() != diagnosis.extended_voltage.empty())
    throw std::invalid_argument("diagnosisPage: one model's voltages without the other's");
}

/// The verdict as two or three words above the sentence.
std::string verdictWords(Verdict verdict) {
  switch (verdict) {
    case Verdict::kNoMismatch: return "No mismatch";
    case Verdict::kEffect: return "One effect is missing from the model";
    case Verdict::kSeveral: return "Several effects are missing from the model";
    case Verdict::kAmbiguous: return "One of a few effects is missing from the model";
    case Verdict::kMechanism: return "A mechanism is missing from the model";
    case Verdict::kUnexplained: return "Something is missing from the model";
    case Verdict::kSensorFault: return "The measurement is at fault";
    case Verdict::kInsufficientData: break;
  }
  return "Not enough to judge";
}

std::string figureHtml(const std::string& what, const std::string& before, const std::string& after,
                       const std::string& unit) {
  const std::string value = before == after
                                ? element("b", escaped(after))
                                : escaped(before) + " \xe2\x86\x92 " + element("b", escaped(after));
  return element("div", element("dt", escaped(what)) + element("dd", value + " " + escaped(unit)));
}

/// Three numbers that say what was gained, on the hold-out.
std::string figuresHtml(const Diagnosis& d) {
  if (!(d.fit.holdout.to > d.fit.holdout.from)) return "";
  const ErrorMetrics &base = d.fit.base_holdout, &extended = d.fit.extended_holdout;
  std::string html =
      figureHtml("RMS error, hold-out", millivolts(base.rmse), millivolts(extended.rmse), "mV");
  if (base.crank_mae && extended.crank_mae)
    html += figureHtml(
        base.cranks == 1 ? "minimum of one crank" : format("minima of %zu cranks", base.cranks),
        millivolts(base.crank_mae), millivolts(extended.crank_mae), "mV");
  if (base.charge_bias && extended.charge_bias)
    html += figureHtml("bias in charges", millivolts(base.charge_bias),
                       millivolts(extended.charge_bias), "mV");
  return element("dl.figures", html);
}

std::string headerHtml(const Recording& recording, const Diagnosis& d) {
  const std::string badge =
      element("p.badge " + toString(d.verdict), escaped(verdictWords(d.verdict)));
  std::string origin = "Diagnosis of " + element("strong", escaped(recording.name));
  if (!recording.series.empty())
    origin += format(", %.0f s, %zu samples",
                     recording.series.time.back() - recording.series.time.front(),
                     recording.series.size());
  const std::string headline = escaped(d.summary) + " " + escaped(meaningOf(d.verdict));
  return element("header",
                 element("p.origin", origin) + badge + element("h1", headline) + figuresHtml(d)) +
         "\n";
}

std::string scripts(bool zoomable) {
  if (!zoomable) return "";
  return "<!--\n" + escaped(kDygraphsNotice) + "-->\n" + element("script", kDygraphsJs) + "\n" +
         element("script", kPageJs) + "\n";
}

/// Titles stand as the cells below them do.
std::string titleCell(const std::string& title, const std::vector<std::vector<Cell>>& rows,
                      std::size_t column) {
  const bool is_number = !rows.empty() && column < rows[0].size() &&
                         rows[0][column].attributes.find("\"number") != std::string::npos;
  return element("th", title, std::string("scope=\"col\" ") + (is_number ? kNumber : ""));
}

}  // namespace

bool hasPlotLibrary() { return kDygraphsJs[0] != '\0'; }

double clockOrigin(const Series& series) {
  return !series.empty() && series.time.front() > kEpochClock ? series.time.front() : 0.0;
}

std::string diagnosisPage(const Recording& recording, const Diagnosis& diagnosis, bool zoomable) {
  requireMatching(recording, diagnosis);
  zoomable = zoomable && hasPlotLibrary();
  const std::string body =
      headerHtml(recording, diagnosis) + plotsSection(recording, diagnosis, zoomable) +
      whereSection(diagnosis, clockOrigin(recording.series)) + evidenceSection(diagnosis) +
      effectsSection(diagnosis) + comparisonSection(diagnosis) + unexplainedSection(diagnosis) +
      detectionLimitsSection(diagnosis) + nextSection(diagnosis) + readingSection() +
      element("footer", "battery_sof " + escaped(version()) + ", sof diagnose");
  return pageOf("Diagnosis of " + recording.name, body,
                dataHtml(resultJson(diagnosis)) + scripts(zoomable),
                std::string(kDygraphsCss) + "\n");
}

std::string pageOf(const std::string& title, const std::string& body, const std::string& scripts,
                   const std::string& style) {
  return std::string(kHead) + element("title", escaped(title)) + "\n" +
         element("style", style + kPageCss) + "\n</head>\n" +
         element("body", "\n" + element("main", "\n" + body) + "\n" + scripts) + "\n</html>\n";
}

std::string dataHtml(const nlohmann::json& result) {
  std::string safe;  // no text in it ends the element
  for (const char c : jsonText(result, 1)) safe += c == '<' ? "\\u003c" : std::string(1, c);
  return element("script", safe, "type=\"application/json\" id=\"result\"") + "\n";
}

std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    switch (c) {
      case '&': safe += "&amp;"; break;
      case '<': safe += "&lt;"; break;
      case '>': safe += "&gt;"; break;
      case '"': safe += "&quot;"; break;
      case '\'': safe += "&#39;"; break;
      default: safe += c;
    }
  }
  return safe;
}

std::string element(const std::string& name, const std::string& content,
                    const std::string& attributes) {
  const std::size_t dot = name.find('.');
  const std::string tag = name.substr(0, dot);
  std::string opening = "<" + tag;
  if (dot != std::string::npos) opening += " class=\"" + name.substr(dot + 1) + "\"";
  if (!attributes.empty()) opening += " " + attributes;
  return opening + ">" + content + "</" + tag + ">";
}

std::string figure(const std::string& name, const std::string& what, const std::string& legend,
                   const std::string& drawing) {
  return element(name, element("figcaption", what + legend) + drawing);
}

std::string keyEntry(const std::string& name, const std::string& style) {
  return element("span", element("i", "", "style=\"" + style + "\"") + name);
}

std::string details(const std::string& summary, const std::string& content) {
  return element("details", element("summary", summary) + content);
}

std::string withMinusSigns(std::string text) {
  for (std::size_t at = text.find('-'); at != std::string::npos; at = text.find('-', at + 1)) {
    const bool leads = at == 0 || text[at - 1] == ' ';
    const bool is_sign =
        leads && at + 1 < text.size() && text[at + 1] >= '0' && text[at + 1] <= '9';
    if (is_sign) text.replace(at, 1, "\xe2\x88\x92");
  }
  return text;
}

Cell numberCell(const std::string& text) { return {escaped(withMinusSigns(text)), kNumber}; }

std::string table(const std::vector<std::string>& head, const std::vector<std::vector<Cell>>& rows,
                  const std::string& attributes) {
  std::string titles, body;
  for (std::size_t k = 0; k < head.size(); ++k) titles += titleCell(head[k], rows, k);
  for (const auto& row : rows) {
    std::string cells;
    for (std::size_t k = 0; k < row.size(); ++k)
      cells += k == 0 ? element("th", row[k].html, "scope=\"row\" " + row[k].attributes)
                      : element("td", row[k].html, row[k].attributes);
    body += element("tr", cells) + "\n";
  }
  return element("div.scroll",
                 element("table",
                         element("thead", element("tr", titles)) + "\n" + element("tbody", body),
                         attributes),
                 "tabindex=\"0\"") +
         "\n";
}

}  // namespace battery_sof
