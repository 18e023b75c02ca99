#include <algorithm>
#include <cmath>

#include "html.hpp"
#include "page_sections.hpp"
#include "recording/events.hpp"
#include "report/display_samples.hpp"
#include "util/text.hpp"
#include "wording.hpp"

namespace battery_sof {
namespace {

constexpr std::size_t kBuckets = 1000;       // a plot is about 1000 pixels wide
constexpr std::size_t kWholeSamples = 4000;  // of cranks that are shown at full rate
// [s], before and after a crank that is shown at full rate
constexpr double kCrankMargin = 0.5;
constexpr std::size_t kStretchesShown = 4000;
constexpr double kHatching = 5.0;  // of a drawing's width of 1000

/// What a plot draws: the recording, the models' voltages, and which samples of them.
struct Drawing {
  const Recording& recording;
  const Diagnosis& diagnosis;
  std::vector<Event> cranks;
  std::vector<std::size_t> shown;
  double t0 = 0.0;  ///< [s], what the time axis counts from
  bool hasModel() const { return !diagnosis.base_voltage.empty(); }
  bool hasExtended() const {
    return hasModel() && diagnosis.extended_voltage != diagnosis.base_voltage;
  }
};

std::vector<Event> cranksIn(const Series& series) {
  std::vector<Event> events = detectEvents(series);
  events.erase(std::remove_if(events.begin(), events.end(),
                              [](const Event& event) { return event.kind != EventKind::kCrank; }),
               events.end());
  return events;
}

std::vector<Trace> tracesOf(const Recording& recording, const Diagnosis& d) {
  const Series& series = recording.series;
  std::vector<Trace> traces = {[&](std::size_t n) { return series.voltage[n]; },
                               [&](std::size_t n) { return series.current[n]; }};
  for (const std::vector<double>* model : {&d.base_voltage, &d.extended_voltage}) {
    if (model->empty()) continue;
    traces.push_back([model](std::size_t n) { return (*model)[n]; });
    traces.push_back([model, &series](std::size_t n) { return series.voltage[n] - (*model)[n]; });
  }
  return traces;
}

/// Cranks with their edges at full rate, as many of the first ones as there is room for.
std::vector<IndexRange> wholeRanges(const Series& series, const std::vector<Event>& cranks) {
  std::vector<IndexRange> ranges;
  std::size_t samples = 0;
  for (const Event& crank : cranks) {
    const IndexRange range = indexRange(series, crank.from - kCrankMargin, crank.to + kCrankMargin);
    samples += range.size();
    if (samples > kWholeSamples) break;
    ranges.push_back(range);
  }
  return ranges;
}

Drawing drawingOf(const Recording& recording, const Diagnosis& diagnosis) {
  const Series& series = recording.series;
  Drawing drawing{recording, diagnosis, cranksIn(series), {}, 0.0};
  drawing.shown = displaySamples(series, tracesOf(recording, diagnosis), kBuckets,
                                 wholeRanges(series, drawing.cranks));
  drawing.t0 = clockOrigin(series);
  return drawing;
}

/// A number of fixed decimals, short; JSON null when it is not finite.
std::string shortNumber(double value, int decimals) {
  if (!std::isfinite(value)) return "null";
  std::string text = format("%.*f", decimals, value);
  if (text.find('.') == std::string::npos) return text;
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

/// The shown samples of a trace; JSON null where the recording has a gap, so that lines break
/// there.
std::string columnText(const Drawing& drawing, const Trace& trace, int decimals,
                       bool is_time = false) {
  const Series& series = drawing.recording.series;
  const double gap = gapThreshold(series);
  std::string text = "[";
  for (std::size_t k = 0; k < drawing.shown.size(); ++k) {
    const std::size_t n = drawing.shown[k];
    if (n > 0 && series.time[n] - series.time[n - 1] > gap)
      text += (is_time ? shortNumber(0.5 * (trace(n) + trace(n - 1)), decimals) : "null") + ",";
    text += shortNumber(trace(n), decimals) + (k + 1 < drawing.shown.size() ? "," : "");
  }
  return text + "]";
}

/// Stretches of time as [[from, to], ...], kStretchesShown at most.
template <typename Stretch>
std::string stretchesText(const Drawing& drawing, const std::vector<Stretch>& stretches) {
  std::string text = "[";
  for (std::size_t k = 0; k < std::min(stretches.size(), kStretchesShown); ++k)
    text += (k > 0 ? ",[" : "[") + shortNumber(stretches[k].from - drawing.t0, 3) + "," +
            shortNumber(stretches[k].to - drawing.t0, 3) + "]";
  return text + "]";
}

/// The drive as JSON. Numbers and nothing else: no text of a file can end the script element.
std::string driveText(const Drawing& drawing) {
  const Series& series = drawing.recording.series;
  const Diagnosis& d = drawing.diagnosis;
  std::string text =
      "{\"time\":" +
      columnText(
          drawing, [&](std::size_t n) { return series.time[n] - drawing.t0; }, 3, true);
  text += ",\n\"current\":" + columnText(
                                  drawing, [&](std::size_t n) { return series.current[n]; }, 2);
  text += ",\n\"measured\":" + columnText(
                                   drawing, [&](std::size_t n) { return series.voltage[n]; }, 4);
  if (drawing.hasModel())
    text += ",\n\"base\":" + columnText(
                                 drawing, [&](std::size_t n) { return d.base_voltage[n]; }, 4);
  if (drawing.hasExtended())
    text +=
        ",\n\"extended\":" + columnText(
                                 drawing, [&](std::size_t n) { return d.extended_voltage[n]; }, 4);
  text += ",\n\"mismatch\":" + stretchesText(drawing, d.mismatch) +
          ",\n\"cranks\":" + stretchesText(drawing, drawing.cranks);
  text += ",\n\"controlled\":" + stretchesText(drawing, d.source.voltage_controlled);
  if (d.fit.holdout.to > d.fit.holdout.from)
    text += ",\n\"holdout\":[" + shortNumber(d.fit.holdout.from - drawing.t0, 3) + "," +
            shortNumber(d.fit.holdout.to - drawing.t0, 3) + "]";
  return text + "}";
}

std::string operatingModeKey(const Drawing& drawing) {
  const std::size_t stretches = drawing.diagnosis.source.voltage_controlled.size();
  std::string text = element("span", "", "class=\"swatch controlled\"") +
                     format(" hatched: a source controls the voltage (%zu stretches", stretches);
  if (stretches > kStretchesShown) text += format(", the first %zu drawn", kStretchesShown);
  return text + "); elsewhere the current is controlled. ";
}

// ---------------------------------------------------------------------------------------------
// drawings without the library

struct Line {
  std::string name, css_class;
  Trace trace;
};

struct Scale {
  double low = 0.0, high = 1.0;
  double share(double value) const { return (value - low) / (high - low); }
};

Scale scaleOf(const Drawing& drawing, const std::vector<Line>& lines) {
  Scale scale{lines[0].trace(drawing.shown[0]), lines[0].trace(drawing.shown[0])};
  for (const Line& line : lines)
    for (const std::size_t n : drawing.shown) {
      scale.low = std::min(scale.low, line.trace(n));
      scale.high = std::max(scale.high, line.trace(n));
    }
  if (!(scale.high > scale.low)) scale.high = scale.low + 1.0;
  return scale;
}

/// Upright hatching where a source controls the voltage, with a solid foot, so that short stretches
/// are seen.
std::string operatingModeBands(const Drawing& drawing) {
  const Series& series = drawing.recording.series;
  const std::vector<ControlledTime>& stretches = drawing.diagnosis.source.voltage_controlled;
  const Scale time{series.time.front(), series.time.back()};
  std::string lines, feet;
  for (std::size_t k = 0; k < std::min(stretches.size(), kStretchesShown); ++k) {
    const double left = 1000.0 * time.share(stretches[k].from),
                 right = 1000.0 * time.share(stretches[k].to);
    for (int n = static_cast<int>(std::ceil(left / kHatching)); kHatching * n < right; ++n)
      lines += format("M%.1f 0V240", kHatching * n);
    feet += format("M%.1f 240H%.1fV245H%.1fz", left, right, left);
  }
  if (feet.empty()) return "";
  return element("path", element("title", "a source controls the voltage"),
                 "class=\"controlled\" d=\"" + lines + "\"") +
         element("path", "", "class=\"foot\" d=\"" + feet + "\"");
}

std::string polyline(const Drawing& drawing, const Line& line, const Scale& value) {
  const Series& series = drawing.recording.series;
  const Scale time{series.time.front(), series.time.back()};
  const double gap = gapThreshold(series);
  std::string path;
  for (const std::size_t n : drawing.shown) {
    const bool is_start = path.empty() || series.time[n] - series.time[n - 1] > gap;
    path += format("%s%.1f %.1f", is_start ? "M" : "L", 1000.0 * time.share(series.time[n]),
                   240.0 - 230.0 * value.share(line.trace(n)));
  }
  return element("path", element("title", escaped(line.name)),
                 "class=\"" + line.css_class + "\" d=\"" + path + "\"");
}

std::string drawingHtml(const Drawing& drawing, const std::string& title,
                        const std::vector<Line>& lines, const std::string& bands = "") {
  const Series& series = drawing.recording.series;
  const Scale value = scaleOf(drawing, lines);
  std::string paths = bands, key;
  for (const Line& line : lines) {
    paths += polyline(drawing, line, value);
    key +=
        element("span", element("i", "", "style=\"border-color:var(--" + line.css_class + ")\"") +
                            line.name);
  }
  const std::string svg =
      element("svg", paths,
              "viewBox=\"0 0 1000 245\" preserveAspectRatio=\"none\" role=\"img\" aria-label=\"" +
                  title + "\"");
  const std::string range =
      withMinusSigns(format(", %.4g to %.4g, over %.1f to %.1f s", value.low, value.high,
                            series.time.front() - drawing.t0, series.time.back() - drawing.t0));
  return element(
      "figure",
      element("figcaption", element("span", element("span", title, "class=\"what\"") + range) +
                                element("span", key, "class=\"legend\"")) +
          svg,
      "class=\"drawing\"");
}

std::string drawingsHtml(const Drawing& drawing) {
  const Series& series = drawing.recording.series;
  const Diagnosis& d = drawing.diagnosis;
  const auto voltage = [&](std::size_t n) { return series.voltage[n]; };
  std::vector<Line> voltages = {{"measured", "measured", voltage}}, errors;
  const auto add = [&](const std::string& name, const std::vector<double>& model) {
    voltages.push_back({name, name, [&model](std::size_t n) { return model[n]; }});
    errors.push_back({name, name, [&model, &series](std::size_t n) {
                        return 1e3 * (series.voltage[n] - model[n]);
                      }});
  };
  if (drawing.hasModel()) add("base", d.base_voltage);
  if (drawing.hasExtended()) add("extended", d.extended_voltage);
  std::string html =
      element("p",
              "These plots cannot be zoomed: the program was built without the plot library "
              "(package libjs-dygraphs).",
              "class=\"note\"");
  html += drawingHtml(drawing, "Terminal voltage [V]", voltages, operatingModeBands(drawing));
  if (!d.source.voltage_controlled.empty())
    html += element("p", operatingModeKey(drawing), "class=\"note\"");
  if (!errors.empty()) html += drawingHtml(drawing, "Measured minus model [mV]", errors);
  return html +
         drawingHtml(drawing, "Current [A]",
                     {{"current", "current", [&](std::size_t n) { return series.current[n]; }}});
}

// ---------------------------------------------------------------------------------------------

std::string button(const std::string& id, const std::string& text) {
  return element("button", text, "type=\"button\" id=\"" + id + "\"");
}

std::string plotHtml(const std::string& id, const std::string& title) {
  return element(
      "figure",
      element("figcaption", element("span", title, "class=\"what\"") +
                                element("span", "", "class=\"legend\" id=\"" + id + "-legend\"")) +
          element("div", "", "class=\"plot\" id=\"" + id + "\""));
}

std::string plotsHtml(const Drawing& drawing) {
  std::string buttons = button("zoom-all", "Whole drive");
  if (drawing.diagnosis.fit.holdout.to > drawing.diagnosis.fit.holdout.from)
    buttons += button("zoom-holdout", "Hold-out");
  if (!drawing.diagnosis.mismatch.empty()) buttons += button("zoom-mismatch", "Next mismatch");
  if (!drawing.cranks.empty()) buttons += button("zoom-crank", "Next crank");
  std::string html = element("div", buttons, "class=\"buttons\"");
  html += plotHtml("plot-voltage", "Terminal voltage [V]");
  if (drawing.hasModel()) html += plotHtml("plot-error", "Measured minus model [mV]");
  return html + plotHtml("plot-current", "Current [A], positive into the battery");
}

std::string keyHtml(const Drawing& drawing) {
  std::string text = "Drag to zoom, double-click to see all again, shift and drag to move. ";
  if (!drawing.diagnosis.source.voltage_controlled.empty()) text += operatingModeKey(drawing);
  if (!drawing.diagnosis.mismatch.empty())
    text += element("span", "", "class=\"swatch mismatch\"") +
            " where the base model deviates beyond chance. ";
  if (drawing.diagnosis.fit.holdout.to > drawing.diagnosis.fit.holdout.from)
    text += element("span", "", "class=\"swatch holdout\"") + " hold-out: no fit has seen it. ";
  text += drawing.t0 > 0.0 ? "Time [s] counts from the recording\xe2\x80\x99s first sample."
                           : "Time [s] is the recording\xe2\x80\x99s own clock.";
  if (drawing.shown.size() < drawing.recording.series.size())
    text += format(" %zu of %zu samples are drawn; every peak is among them.", drawing.shown.size(),
                   drawing.recording.series.size());
  return element("p", text, "class=\"note\"");
}

}  // namespace

std::string plotsSection(const Recording& recording, const Diagnosis& diagnosis, bool zoomable) {
  if (recording.series.size() < 2) return "";
  const Drawing drawing = drawingOf(recording, diagnosis);
  if (!zoomable)
    return section("drive", "The drive", drawingsHtml(drawing) + sourceHtml(diagnosis));
  return section(
      "drive", "The drive",
      plotsHtml(drawing) + keyHtml(drawing) + sourceHtml(diagnosis) +
          element("script", driveText(drawing), "type=\"application/json\" id=\"drive-data\""));
}

}  // namespace battery_sof
