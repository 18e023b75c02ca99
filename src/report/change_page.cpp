#include "report/change_page.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "battery_sof/version.hpp"
#include "page.hpp"
#include "report/change_results.hpp"
#include "report/drawing.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr std::size_t kSideBuckets = 400;                // of a drawing
constexpr double kChartWidth = 720.0, kChartRow = 24.0;  // [px], of a change's picture
constexpr double kLabelEnd = 190.0;                      // [px], where its axis begins

std::string verdictWords(ChangeVerdict verdict) {
  switch (verdict) {
    case ChangeVerdict::kNoChange: return "Nothing has changed";
    case ChangeVerdict::kChanged: return "Something has changed";
    case ChangeVerdict::kAnotherBattery: return "Another battery";
    case ChangeVerdict::kInsufficientData: break;
  }
  return "Not enough to judge";
}

// ---------------------------------------------------------------------------------------------
// then and now

/// A channel of a recording.
struct Channel {
  const char *name, *title;
  std::vector<double> Series::*values;
};
constexpr Channel kVoltageChannel{"extended", "Terminal voltage [V]", &Series::voltage};
constexpr Channel kCurrentChannel{"current", "Current [A]", &Series::current};

std::string drawingOf(const Series& series, const Channel& channel, const Scale& value) {
  const Trace trace = [&](std::size_t n) { return (series.*channel.values)[n]; };
  const Scale time{series.time.front(), series.time.back()};
  return drawingFigure(channel.title,
                       withMinusSigns(format(", axis %.4g to %.4g, %.0f s", value.low, value.high,
                                             time.high - time.low)),
                       "",
                       tracePath(series, displaySamples(series, {trace}, kSideBuckets), trace,
                                 channel.name, time, value));
}

Scale scaleOf(const ComparedSide& then, const ComparedSide& now, const Channel& channel) {
  Scale scale;
  for (const ComparedSide* side : {&then, &now})
    for (const Series& series : side->series)
      for (const double value : series.*channel.values) scale.include(value);
  return scale;
}

std::string sideHtml(const char* title, const ComparedSide& side, const Scale& voltage,
                     const Scale& current) {
  std::string html = element("h3", title) + element("p.origin", escaped(join(side.names)));
  for (const Series& series : side.series) {
    if (series.size() < 2) continue;
    html +=
        drawingOf(series, kVoltageChannel, voltage) + drawingOf(series, kCurrentChannel, current);
  }
  if (side.series.empty())
    html += element(
        "p.note",
        "A model file keeps what a comparison needs of its recording, but not the samples.");
  return element("div", html);
}

std::string sidesSection(const ComparedSide& then, const ComparedSide& now) {
  const Scale voltage = scaleOf(then, now, kVoltageChannel);
  const Scale current = scaleOf(then, now, kCurrentChannel);
  return section("sides", "Then and now",
                 element("div.sides", sideHtml("Then", then, voltage, current) +
                                          sideHtml("Now", now, voltage, current)));
}

// ---------------------------------------------------------------------------------------------
// changes

double scatterOf(const ComparedFeature& one) {
  return std::max(std::hypot(one.std_error, one.spread), 1e-12);
}

/// Distances from the reference, in standard deviations.
struct Distances {
  double now = 0.0;
  std::optional<double> changed;
};
Distances distancesOf(const ComparedFeature& one) {
  Distances of{(one.now - one.then) / scatterOf(one), std::nullopt};
  if (one.with_change) of.changed = (*one.with_change - one.then) / scatterOf(one);
  return of;
}

std::string svgText(double x, double y, const std::string& text, const char* attributes = "") {
  return element("text", escaped(text), format("x=\"%.1f\" y=\"%.1f\" %s", x, y, attributes));
}

std::string svgLine(const char* kind, double x1, double y1, double x2, double y2) {
  return element(std::string("path.") + kind, "",
                 format("d=\"M%.1f %.1fL%.1f %.1f\"", x1, y1, x2, y2));
}

std::string featureRow(const ComparedFeature& one, double y, double reach) {
  const auto x = [&](double distance) {
    return kLabelEnd + (kChartWidth - kLabelEnd - 10.0) * (0.5 + 0.5 * distance / reach);
  };
  const Distances of = distancesOf(one);
  const double bar = std::min(one.std_error / scatterOf(one), reach);
  std::string html = svgText(kLabelEnd - 12.0, y + 4.0, one.id, "text-anchor=\"end\"");
  html += element(
      "g.extended",
      svgLine("bar", x(std::max(of.now - bar, -reach)), y, x(std::min(of.now + bar, reach)), y) +
          element("circle", element("title", "now"),
                  format("cx=\"%.1f\" cy=\"%.1f\" r=\"4.5\"", x(of.now), y)));
  if (of.changed)
    html += element("g.base", element("circle", element("title", "the reference with the change"),
                                      format("cx=\"%.1f\" cy=\"%.1f\" r=\"7\" fill-opacity=\"0\" "
                                             "stroke-width=\"2\"",
                                             x(*of.changed), y)));
  return html;
}

/// Every quantity as its distance from the reference.
std::string featureChart(const std::vector<ComparedFeature>& compared, const std::string& what) {
  double reach = 3.0;
  for (const ComparedFeature& one : compared) {
    const Distances of = distancesOf(one);
    reach = std::max({reach, 1.1 * std::abs(of.now), 1.1 * std::abs(of.changed.value_or(0.0))});
  }
  const double height = kChartRow * (static_cast<double>(compared.size()) + 1.2);
  const double middle = kLabelEnd + 0.5 * (kChartWidth - kLabelEnd - 10.0);
  std::string svg = svgLine("zero", middle, 4.0, middle, height - kChartRow);
  for (std::size_t k = 0; k < compared.size(); ++k)
    svg += featureRow(compared[k], kChartRow * (static_cast<double>(k) + 0.7), reach);
  const double foot = height - 6.0;
  svg += svgText(kLabelEnd, foot, withMinusSigns(format("-%.1f", reach)));
  svg += svgText(middle, foot, "0", "text-anchor=\"middle\"");
  svg += svgText(kChartWidth - 10.0, foot, format("%.1f", reach), "text-anchor=\"end\"");
  const std::string key = keyEntry("now", "border-color:var(--extended)") +
                          keyEntry("the reference with the change", "border-color:var(--base)");
  return figure("figure.chart",
                element("span", element("span.what", what) +
                                    ", distance from the reference in standard deviations"),
                element("span.legend", key),
                element("svg", svg,
                        format("viewBox=\"0 0 %g %.1f\" role=\"img\" aria-label=\"%s\"",
                               kChartWidth, height, escaped(what).c_str())));
}

std::vector<Cell> changeRow(const Change& change) {
  return {{element("code", escaped(change.id))},
          {escaped(change.mechanism)},
          numberCell(changeStrengthText(change.then, change.unit)),
          numberCell(changeStrengthText(change.now, change.unit)),
          numberCell(changeStrengthText(change.lower, change.unit) + " to " +
                     changeStrengthText(change.upper, change.unit)),
          numberCell(format("%.2f", change.probability)),
          {escaped(join(change.indistinguishable))}};
}

/// The picture shows all changes in the reference at once, as they were compared.
std::string changesSection(const ChangeDiagnosis& diagnosis) {
  if (diagnosis.changes.empty()) return "";
  std::vector<std::vector<Cell>> rows;
  std::vector<std::string> ids;
  for (const Change& change : diagnosis.changes) {
    rows.push_back(changeRow(change));
    ids.push_back(change.id);
  }
  const char* verb = ids.size() == 1 ? " explains" : " explain together";
  return section("changes", "What has changed",
                 table({"change", "mechanism", "then", "now", "90 % interval", "probability",
                        "indistinguishable from"},
                       rows) +
                     featureChart(diagnosis.compared, "What " + join(ids) + verb));
}

// ---------------------------------------------------------------------------------------------
// numbers

std::string comparedSection(const ChangeDiagnosis& diagnosis) {
  if (diagnosis.compared.empty()) return "";
  std::vector<std::vector<Cell>> rows;
  for (const ComparedFeature& one : diagnosis.compared)
    rows.push_back({{element("code", escaped(one.id))},
                    numberCell(changeValueText(one.then, one.unit)),
                    numberCell(changeValueText(one.now, one.unit)),
                    numberCell(changeValueText(one.std_error, one.unit)),
                    numberCell(changeValueText(one.spread, one.unit))});
  const std::string chart =
      diagnosis.changes.empty() ? featureChart(diagnosis.compared, "What was compared") : "";
  return section(
      "compared", "What was compared",
      chart + table({"quantity", "then", "now", "standard error", "between sound trips"}, rows));
}

std::string modelsSection(const ChangeDiagnosis& diagnosis) {
  const auto percent = [](const std::optional<double>& share) {
    return share ? numberCell(format("%.0f %%", *share)) : Cell{""};
  };
  std::vector<std::vector<Cell>> rows;
  for (const auto& [name, share] : {std::pair("of the reference", &diagnosis.reference_model),
                                    {"of the reference with the change", &diagnosis.changed_model},
                                    {"fitted to its first three quarters", &diagnosis.own_model}})
    if (share->share_percent)
      rows.push_back({{name},
                      percent(share->share_percent),
                      percent(share->current_share_percent),
                      percent(share->voltage_share_percent)});
  if (rows.empty()) return "";
  return section("models", "How well models explain the recording's last quarter",
                 table({"model", "together", "current", "voltage"}, rows));
}

std::string limitsSection(const ChangeDiagnosis& diagnosis) {
  std::vector<std::vector<Cell>> rows;
  for (const ChangeLimit& limit : diagnosis.detection_limits)
    rows.push_back({{element("code", escaped(limit.id))},
                    numberCell(changeStrengthText(limit.strength, limit.unit))});
  if (rows.empty()) return "";
  return section("limits", "Detection limits",
                 element("p", "A change of this strength is detected in nine cases of ten.") +
                     table({"change", "strength"}, rows));
}

}  // namespace

std::string changePage(const ChangeDiagnosis& diagnosis, const ComparedSide& then,
                       const ComparedSide& now) {
  const std::string title = "Changes of " + join(now.names) + " since " + join(then.names);
  const std::string header = element(
      "header",
      element("p.origin", element("strong", escaped(join(now.names))) + " against " +
                              element("strong", escaped(join(then.names)))) +
          element("p.badge " + toString(diagnosis.verdict), verdictWords(diagnosis.verdict)) +
          element("h1", withMinusSigns(escaped(diagnosis.summary))));
  return pageOf(
      title,
      header + "\n" + changesSection(diagnosis) + sidesSection(then, now) +
          comparedSection(diagnosis) + modelsSection(diagnosis) + limitsSection(diagnosis) +
          element("footer", "battery_sof " + escaped(version()) + ", sof diagnose --reference"),
      dataHtml(resultJson(diagnosis, now.names, then.names)));
}

}  // namespace battery_sof
