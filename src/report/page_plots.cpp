#include <algorithm>
#include <cmath>

#include "page.hpp"
#include "recording/channel_statistics.hpp"
#include "recording/events.hpp"
#include "report/diagnosis_page.hpp"
#include "report/drawing.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr std::size_t kBuckets = 1000;       // a plot is about 1000 pixels wide
constexpr std::size_t kWholeSamples = 4000;  // of cranks that are shown at full rate
constexpr double kCrankMargin = 0.5;  // [s], before and after a crank that is shown at full rate
constexpr std::size_t kStretchesShown = 4000;
constexpr double kHatching = 5.0;  // of a drawing's width

/// A line of a plot; its name is its colour's and that of its data too.
struct Line {
  std::string name;
  int decimals;
  Trace trace;
};

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

/// What a plot draws: the recording, the models' voltages, and which samples of them.
struct Drawing {
  Drawing(const Recording& recording, const Diagnosis& d)
      : series(recording.series),
        diagnosis(d),
        cranks(detectCranks(series, {0, series.size()}, EventLimits{d.base.fit.crank_current})),
        time{series.time.front(), series.time.back()},
        t0(clockOrigin(series)),
        current{"current", 2, [this](std::size_t n) { return series.current[n]; }},
        voltages{{"measured", 4, [this](std::size_t n) { return series.voltage[n]; }}} {
    std::vector<Trace> traces = {current.trace, voltages[0].trace};
    const auto add = [&, this](const char* name, const std::vector<double>& model) {
      const Trace error = [this, &model](std::size_t n) { return series.voltage[n] - model[n]; };
      voltages.push_back({name, 4, [&model](std::size_t n) { return model[n]; }});
      errors.push_back({name, 1, [error](std::size_t n) { return 1e3 * error(n); }});
      traces.insert(traces.end(), {voltages.back().trace, error});
    };
    if (!d.base_voltage.empty()) add("base", d.base_voltage);
    if (d.extended_voltage != d.base_voltage) add("extended", d.extended_voltage);
    shown = displaySamples(series, traces, kBuckets, wholeRanges(series, cranks));
  }
  Drawing(const Drawing&) = delete;
  Drawing& operator=(const Drawing&) = delete;

  bool hasHoldout() const { return diagnosis.fit.holdout.to > diagnosis.fit.holdout.from; }

  const Series& series;
  const Diagnosis& diagnosis;
  std::vector<Event> cranks;
  Scale time;                          ///< [s], of the drawings
  double t0;                           ///< [s], what the time axis counts from
  Line current;                        ///< [A]
  std::vector<Line> voltages, errors;  ///< [V]; [mV], measured minus model
  std::vector<std::size_t> shown;
};

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
  const Series& series = drawing.series;
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
  const Diagnosis& d = drawing.diagnosis;
  const Trace time = [&](std::size_t n) { return drawing.series.time[n] - drawing.t0; };
  std::string text = "{\"time\":" + columnText(drawing, time, 3, true);
  const auto add = [&](const Line& line) {
    text += ",\n\"" + line.name + "\":" + columnText(drawing, line.trace, line.decimals);
  };
  add(drawing.current);
  for (const Line& line : drawing.voltages) add(line);
  text += ",\n\"mismatch\":" + stretchesText(drawing, d.mismatch) +
          ",\n\"cranks\":" + stretchesText(drawing, drawing.cranks) +
          ",\n\"controlled\":" + stretchesText(drawing, d.source.times);
  if (drawing.hasHoldout())
    text += ",\n\"holdout\":[" + shortNumber(d.fit.holdout.from - drawing.t0, 3) + "," +
            shortNumber(d.fit.holdout.to - drawing.t0, 3) + "]";
  return text + "}";
}

std::string operatingModeKey(const Drawing& drawing) {
  const std::size_t stretches = drawing.diagnosis.source.times.size();
  std::string text = element("span.swatch controlled", "") +
                     format(" hatched: a source controls the voltage (%zu stretches", stretches);
  if (stretches > kStretchesShown)
    text += format(", of which the first %zu are drawn", kStretchesShown);
  return text + "); elsewhere the current is controlled. ";
}

// ---------------------------------------------------------------------------------------------
// drawings without the library

Scale scaleOf(const Drawing& drawing, const std::vector<Line>& lines) {
  Scale scale;
  for (const Line& line : lines)
    for (const std::size_t n : drawing.shown) scale.include(line.trace(n));
  return scale;
}

/// Upright hatching where a source controls the voltage, with a solid foot, so that short stretches
/// are seen.
std::string operatingModeBands(const Drawing& drawing) {
  const std::vector<ControlledTime>& stretches = drawing.diagnosis.source.times;
  std::string lines, feet;
  for (std::size_t k = 0; k < std::min(stretches.size(), kStretchesShown); ++k) {
    const double left = kDrawingWidth * drawing.time.share(stretches[k].from),
                 right = kDrawingWidth * drawing.time.share(stretches[k].to);
    for (int n = static_cast<int>(std::ceil(left / kHatching)); kHatching * n < right; ++n)
      lines += format("M%.1f 0V240", kHatching * n);
    feet += format("M%.1f 240H%.1fV245H%.1fz", left, right, left);
  }
  if (feet.empty()) return "";
  return element("path.controlled", element("title", "a source controls the voltage"),
                 "d=\"" + lines + "\"") +
         element("path.foot", "", "d=\"" + feet + "\"");
}

std::string drawingHtml(const Drawing& drawing, const std::string& title,
                        const std::vector<Line>& lines, const std::string& bands = "") {
  const Scale value = scaleOf(drawing, lines);
  std::string paths = bands, key;
  for (const Line& line : lines) {
    paths += tracePath(drawing.series, drawing.shown, line.trace, line.name, drawing.time, value);
    key += keyEntry(line.name, "border-color:var(--" + line.name + ")");
  }
  const std::string range =
      withMinusSigns(format(", %.4g to %.4g, over %.1f to %.1f s", value.low, value.high,
                            drawing.time.low - drawing.t0, drawing.time.high - drawing.t0));
  return drawingFigure(title, range, element("span.legend", key), paths);
}

std::string drawingsHtml(const Drawing& drawing) {
  std::string html = element("p.note",
                             "These plots cannot be zoomed: the program was built without the plot "
                             "library (package libjs-dygraphs).");
  html +=
      drawingHtml(drawing, "Terminal voltage [V]", drawing.voltages, operatingModeBands(drawing));
  if (!drawing.diagnosis.source.times.empty()) html += element("p.note", operatingModeKey(drawing));
  if (!drawing.errors.empty())
    html += drawingHtml(drawing, "Measured minus model [mV]", drawing.errors);
  return html + drawingHtml(drawing, "Current [A]", {drawing.current});
}

// ---------------------------------------------------------------------------------------------

std::string button(const std::string& id, const std::string& text) {
  return element("button", text, "type=\"button\" id=\"" + id + "\"");
}

std::string plotHtml(const std::string& id, const std::string& title) {
  return figure("figure", element("span.what", title),
                element("span.legend", "", "id=\"" + id + "-legend\""),
                element("div.plot", "", "id=\"" + id + "\""));
}

std::string plotsHtml(const Drawing& drawing) {
  std::string buttons = button("zoom-all", "Whole drive");
  if (drawing.hasHoldout()) buttons += button("zoom-holdout", "Hold-out");
  if (!drawing.diagnosis.mismatch.empty()) buttons += button("zoom-mismatch", "Next mismatch");
  if (!drawing.cranks.empty()) buttons += button("zoom-crank", "Next crank");
  std::string html = element("div.buttons", buttons);
  html += plotHtml("plot-voltage", "Terminal voltage [V]");
  if (!drawing.errors.empty()) html += plotHtml("plot-error", "Measured minus model [mV]");
  return html + plotHtml("plot-current", "Current [A], positive into the battery");
}

std::string keyHtml(const Drawing& drawing) {
  std::string text = "Drag to zoom, double-click to zoom out, hold Shift and drag to pan. ";
  if (!drawing.diagnosis.source.times.empty()) text += operatingModeKey(drawing);
  if (!drawing.diagnosis.mismatch.empty())
    text += element("span.swatch mismatch", "") +
            " the base model deviates far more than in most minutes. ";
  if (drawing.hasHoldout())
    text += element("span.swatch holdout", "") + " hold-out, which no fit has used. ";
  text += drawing.t0 > 0.0 ? "Time [s] counts from the recording\xe2\x80\x99s first sample."
                           : "Time [s] is the recording\xe2\x80\x99s own clock.";
  if (drawing.shown.size() < drawing.series.size())
    text += format(" %zu of %zu samples are drawn; every peak is among them.", drawing.shown.size(),
                   drawing.series.size());
  return element("p.note", text);
}

// ---------------------------------------------------------------------------------------------
// operating mode

std::size_t samplesOf(const ControlModeOverview& source) {
  std::size_t samples = 0;
  for (const ControlModeTotals& totals : source.totals) samples += totals.samples;
  return samples;
}

/// Shares as one bar: hatched where the voltage is controlled, plain where the current is. The
/// labels say it in words.
std::string stripHtml(double voltage_share) {
  const double voltage = 100.0 * voltage_share, current = 100.0 - voltage;
  const auto part = [](const char* kind, double percent) {
    return element("span", "", format("class=\"%s\" style=\"width:%.2f%%\"", kind, percent));
  };
  const std::string label = format(
      "voltage controlled %.1f %%, current controlled %.1f %% of the samples", voltage, current);
  const std::string bar = element("div", part("controlled", voltage) + part("free", current),
                                  "class=\"strip\" role=\"img\" aria-label=\"" + label + "\"");
  return bar + element("p.note", element("span.swatch controlled", "") +
                                     format(" voltage controlled %.1f %%", voltage) +
                                     element("span.swatch free", "") +
                                     format(" current controlled %.1f %%", current));
}

std::string reasonTable(const ControlModeOverview& source) {
  const auto samples = static_cast<double>(samplesOf(source));
  std::vector<std::vector<Cell>> rows;
  for (const ControlModeTotals& totals : source.totals)
    rows.push_back(
        {{escaped(toString(totals.mode))},
         {escaped(totals.reason)},
         numberCell(std::to_string(totals.stretches)),
         numberCell(format("%.1f", 100.0 * static_cast<double>(totals.samples) / samples))});
  return details(format("Why (%zu reasons)", rows.size()),
                 table({"controlled", "because", "stretches", "samples [%]"}, rows));
}

/// Who controls the voltage and who the current: one bar with the shares, and the reasons.
std::string sourceHtml(const Diagnosis& d) {
  const ControlModeOverview& source = d.source;
  if (samplesOf(source) == 0) return "";
  std::string html =
      element("h3", "Operating mode") + element("p", withMinusSigns(escaped(source.summary)));
  if (source.seen) html += stripHtml(source.share);
  return element("div", html + reasonTable(source), "id=\"controlled\"");
}

}  // namespace

std::string plotsSection(const Recording& recording, const Diagnosis& diagnosis, bool zoomable) {
  if (recording.series.size() < 2) return "";
  const Drawing drawing(recording, diagnosis);
  if (!zoomable)
    return section("drive", "The drive", drawingsHtml(drawing) + sourceHtml(diagnosis));
  return section(
      "drive", "The drive",
      plotsHtml(drawing) + keyHtml(drawing) + sourceHtml(diagnosis) +
          element("script", driveText(drawing), "type=\"application/json\" id=\"drive-data\""));
}

}  // namespace battery_sof
