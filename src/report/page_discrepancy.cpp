#include <algorithm>
#include <cmath>
#include <limits>

#include "page.hpp"
#include "util/text.hpp"
#include "wording.hpp"

namespace battery_sof {
namespace {

// of a chart of 640 by 232
constexpr double kLeft = 56.0, kRight = 628.0, kTop = 12.0, kBottom = 196.0;
constexpr double kNormal95 = 1.96;  // standard deviations
constexpr double kTicks = 5.0;      // about as many on an axis
constexpr char kNotDriven[] = "\xe2\x80\x93";

/// A point of a line in the axes' units; half its 95 % band is 0 where that is not known.
struct Point {
  double x, y, half_band;
};

/// A line of a chart.
struct Curve {
  std::string name, css_class;
  /// dots and a solid line, else squares and a dashed one: distinguished without colour
  bool is_round;
  std::vector<Point> points;
};

struct Axis {
  double low, high;
  bool is_log;
  double share(double value) const {
    return is_log ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
  }
};

/// A step of 1, 2 or 5 times a power of ten that parts a range in about kTicks.
double roundStep(double range) {
  const double decade = std::pow(10.0, std::floor(std::log10(range / kTicks)));
  for (const double step : {1.0, 2.0, 5.0})
    if (range <= kTicks * step * decade) return step * decade;
  return 10.0 * decade;
}

std::vector<double> ticksOf(const Axis& axis) {
  std::vector<double> ticks;
  if (axis.is_log) {
    const int first = static_cast<int>(std::ceil(std::log10(axis.low) - 1e-9)),
              last = static_cast<int>(std::floor(std::log10(axis.high) + 1e-9));
    for (int decade = first; decade <= last; ++decade) ticks.push_back(std::pow(10.0, decade));
    return ticks;
  }
  const double step = roundStep(axis.high - axis.low);
  const auto first = static_cast<long>(std::ceil(axis.low / step - 1e-9)),
             last = static_cast<long>(std::floor(axis.high / step + 1e-9));
  for (long k = first; k <= last; ++k) ticks.push_back(static_cast<double>(k) * step);
  return ticks;
}

double xOf(const Axis& axis, double value) { return kLeft + (kRight - kLeft) * axis.share(value); }
double yOf(const Axis& axis, double value) {
  return kBottom - (kBottom - kTop) * axis.share(value);
}

std::string label(double x, double y, const char* anchor, const std::string& text) {
  return element("text", text, format("x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\"", x, y, anchor));
}

std::string tickText(double value) {
  return withMinusSigns(format("%.4g", value == 0.0 ? 0.0 : value));
}

std::string gridHtml(const Axis& x, const Axis& y, const std::string& unit) {
  std::string lines, labels;
  for (const double tick : ticksOf(x)) {
    lines += format("M%.1f %.1fV%.1f", xOf(x, tick), kTop, kBottom);
    labels += label(xOf(x, tick), kBottom + 15.0, "middle", tickText(tick));
  }
  for (const double tick : ticksOf(y)) {
    lines += format("M%.1f %.1fH%.1f", kLeft, yOf(y, tick), kRight);
    labels += label(kLeft - 6.0, yOf(y, tick) + 4.0, "end", tickText(tick));
  }
  const std::string zero = format("M%.1f %.1fH%.1f", kLeft, yOf(y, 0.0), kRight);
  return element("path.grid", "", "d=\"" + lines + "\"") +
         element("path.zero", "", "d=\"" + zero + "\"") + labels +
         label(kRight, kBottom + 32.0, "end", unit);
}

/// 95 % of the posterior about a line: along its upper side and back along the lower one.
std::string bandHtml(const Curve& curve, const Axis& x, const Axis& y) {
  std::string upper, lower;
  bool is_known = false;
  for (const Point& point : curve.points) {
    is_known = is_known || point.half_band > 0.0;
    const double top = std::min(point.y + point.half_band, y.high),
                 bottom = std::max(point.y - point.half_band, y.low);
    upper += format("%s%.1f %.1f", upper.empty() ? "M" : "L", xOf(x, point.x), yOf(y, top));
    lower = format("L%.1f %.1f", xOf(x, point.x), yOf(y, bottom)) + lower;
  }
  return is_known ? element("path.band", "", "d=\"" + upper + lower + "z\"") : "";
}

std::string curveHtml(const Curve& curve, const Axis& x, const Axis& y) {
  std::string path, marks;
  for (const Point& point : curve.points) {
    const double px = xOf(x, point.x), py = yOf(y, point.y);
    path += format("%s%.1f %.1f", path.empty() ? "M" : "L", px, py);
    marks +=
        curve.is_round
            ? element("circle", "", format("cx=\"%.1f\" cy=\"%.1f\" r=\"3\"", px, py))
            : element("rect", "",
                      format("x=\"%.1f\" y=\"%.1f\" width=\"6\" height=\"6\"", px - 3.0, py - 3.0));
  }
  const std::string dashes = curve.is_round ? "" : " stroke-dasharray=\"6 4\"";
  return element("g",
                 element("title", curve.name) + bandHtml(curve, x, y) +
                     element("path", "", "d=\"" + path + "\"" + dashes) + marks,
                 "class=\"" + curve.css_class + "\"");
}

/// Of the lines, and as much of their bands as they are high: where little was driven a band may be
/// volts wide.
Axis valueAxis(const std::vector<Curve>& curves) {
  double largest = 0.0;
  for (const Curve& curve : curves)
    for (const Point& point : curve.points) largest = std::max(largest, std::abs(point.y));
  Axis axis{0.0, 0.0, false};
  for (const Curve& curve : curves)
    for (const Point& point : curve.points) {
      const double half_band = std::min(point.half_band, largest);
      axis.low = std::min(axis.low, point.y - half_band);
      axis.high = std::max(axis.high, point.y + half_band);
    }
  const double room = std::max(0.08 * (axis.high - axis.low), 0.05);
  return {axis.low - room, axis.high + room, false};
}

std::string chartHtml(const std::string& title, const Axis& x, const std::string& unit,
                      const std::vector<Curve>& curves) {
  const Axis y = valueAxis(curves);
  std::string lines = gridHtml(x, y, unit), key;
  for (const Curve& curve : curves) {
    lines += curveHtml(curve, x, y);
    key += keyEntry(curve.name, "border-color:var(--" + curve.css_class +
                                    ");border-top-style:" + (curve.is_round ? "solid" : "dashed"));
  }
  const std::string svg = element("svg", lines,
                                  "viewBox=\"0 0 640 232\" role=\"img\" aria-label=\"" + title +
                                      "; the table below has the numbers\"");
  return figure("figure.chart", element("span.what", title), element("span.legend", key), svg);
}

Point pointOf(double x, double volts, const std::optional<double>& std) {
  return {x, 1e3 * volts, std && std::isfinite(*std) ? 1e3 * kNormal95 * *std : 0.0};
}

/// Two lines over one axis; nothing where neither has two points.
std::string curvesHtml(const std::string& title, bool is_log, const std::string& unit,
                       const Curve& first, const Curve& second) {
  Axis axis{std::numeric_limits<double>::infinity(), 0.0, is_log};
  axis.high = -axis.low;
  std::vector<Curve> curves;
  for (const Curve& curve : {first, second}) {
    if (curve.points.size() < 2) continue;
    curves.push_back(curve);
    axis.low = std::min(axis.low, curve.points.front().x);
    axis.high = std::max(axis.high, curve.points.back().x);
  }
  return axis.high > axis.low ? chartHtml(title, axis, unit, curves) : "";
}

/// What it adds over the time since a rest: the memory of charging and discharging.
std::string memoryChart(const DiscrepancyFinding& discrepancy) {
  Curve charging{"charging", "extended", true, {}}, discharging{"discharging", "base", false, {}};
  for (const DiscrepancyAnswer& one : discrepancy.answers) {
    if (std::isfinite(one.charging))
      charging.points.push_back(pointOf(one.time, one.charging, one.charging_std));
    if (std::isfinite(one.discharging))
      discharging.points.push_back(pointOf(one.time, one.discharging, one.discharging_std));
  }
  return curvesHtml(format("Correction during a constant current of %g A after a rest [mV]",
                           discrepancy.answer_current.value_or(0.0)),
                    true, "time since the rest [s]", charging, discharging);
}

/// What it adds over the current: at once, and when its memory has set in.
std::string currentChart(const DiscrepancyFinding& discrepancy) {
  Curve early{"at once", "extended", true, {}}, late{"after a minute", "base", false, {}};
  for (const DiscrepancyAtCurrent& at : discrepancy.curve) {
    if (std::isfinite(at.early))
      early.points.push_back(pointOf(at.current, at.early, at.early_std));
    if (std::isfinite(at.late)) late.points.push_back(pointOf(at.current, at.late, at.late_std));
  }
  return curvesHtml("Correction as a function of the current [mV]", false,
                    "current [A], positive into the battery", early, late);
}

std::string bandNote(const DiscrepancyFinding& discrepancy) {
  const auto has_band = [](const DiscrepancyAnswer& one) {
    return one.charging_std || one.discharging_std;
  };
  if (std::none_of(discrepancy.answers.begin(), discrepancy.answers.end(), has_band)) return "";
  return element("p.note",
                 "The bands are 95 % intervals from the posterior of the weights. They do not "
                 "cover errors that no regressor represents. A band that leaves the chart is cut "
                 "off; the recording has little data there.");
}

std::string answerTable(const DiscrepancyFinding& discrepancy) {
  double largest = std::numeric_limits<double>::min();
  for (const DiscrepancyAnswer& one : discrepancy.answers)
    for (const double value : {one.charging, one.discharging})
      if (std::isfinite(value)) largest = std::max(largest, std::abs(value));
  const auto cell = [&](double value) -> Cell {
    if (!std::isfinite(value)) return {kNotDriven, "class=\"heat\""};
    return {withMinusSigns(format("%+.1f", 1e3 * value)),
            format("class=\"heat %s\" style=\"--strength:%.2f\"", value > 0.0 ? "more" : "less",
                   std::abs(value) / largest)};
  };
  std::vector<std::vector<Cell>> rows;
  for (const DiscrepancyAnswer& one : discrepancy.answers)
    rows.push_back({{threeDigits(one.time) + " s"}, cell(one.charging), cell(one.discharging)});
  return rows.empty() ? ""
                      : table({"since the rest", "charging [mV]", "discharging [mV]"}, rows,
                              "class=\"map\"");
}

std::string currentTable(const DiscrepancyFinding& discrepancy) {
  const auto at_size = [](double value) {
    return std::isfinite(value) ? format("%+.1f", 1e3 * value) : std::string(kNotDriven);
  };
  std::vector<std::vector<Cell>> rows;
  for (const DiscrepancyAtCurrent& at : discrepancy.curve)
    rows.push_back({{withMinusSigns(format("%g A", at.current))},
                    numberCell(at_size(at.early)),
                    numberCell(at_size(at.late))});
  return rows.empty() ? "" : table({"current", "at once [mV]", "after a minute [mV]"}, rows);
}

/// The catalogue's equation that speaks best for itself, of the mechanism that the discrepancy
/// follows most.
std::string nearestHtml(const Diagnosis& d) {
  if (d.discrepancy->mechanisms.empty()) return "";
  const Mechanism mechanism = d.discrepancy->mechanisms.front().mechanism;
  const Candidate* nearest = nullptr;
  for (const Candidate& c : d.candidates)
    if (c.mechanism == mechanismId(mechanism) &&
        (nearest == nullptr || c.evidence > nearest->evidence))
      nearest = &c;
  std::string text = "It most resembles the mechanism " +
                     element("strong", escaped(plainName(mechanismId(mechanism)))) + ". ";
  if (nearest == nullptr)
    text += "No equation of this mechanism was tested.";
  else
    text += "The closest equation of the catalogue is: " + escaped(titleOf(nearest->id)) + " " +
            element("code", escaped(nearest->id)) +
            withMinusSigns(format(" (evidence %.0f; ", nearest->evidence)) +
            (nearest->rejected_because.empty() ? "accepted, and the discrepancy is what it leaves)."
                                               : escaped(nearest->rejected_because) + ").");
  return element("p", text);
}

}  // namespace

std::string discrepancyHtml(const Diagnosis& d) {
  const DiscrepancyFinding& discrepancy = *d.discrepancy;
  const std::string numbers = answerTable(discrepancy) + currentTable(discrepancy);
  const std::string charts = memoryChart(discrepancy) + currentChart(discrepancy);
  const std::string note = element(
      "p.note", "The curves cover only currents and durations that occur in the training part.");
  return nearestHtml(d) + charts + (charts.empty() ? "" : note) + bandNote(discrepancy) +
         (numbers.empty() ? "" : details("The same in numbers", numbers));
}

}  // namespace battery_sof
