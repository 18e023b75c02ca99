#include "html.hpp"
#include "page_sections.hpp"
#include "util/text.hpp"
#include "wording.hpp"

namespace battery_sof {
namespace {

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
  return bar + element("p",
                       element("span", "", "class=\"swatch controlled\"") +
                           format(" voltage controlled %.1f %%", voltage) +
                           element("span", "", "class=\"swatch free\"") +
                           format(" current controlled %.1f %%", current),
                       "class=\"note\"");
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
  return element("details", element("summary", format("Why (%zu reasons)", rows.size())) +
                                table({"controlled", "because", "stretches", "samples [%]"}, rows));
}

}  // namespace

std::string sourceHtml(const Diagnosis& d) {
  const ControlModeOverview& source = d.source;
  if (samplesOf(source) == 0) return "";
  std::string html =
      element("h3", "Operating mode") + element("p", withMinusSigns(escaped(source.summary)));
  if (source.seen) html += stripHtml(source.share);
  return element("div", html + reasonTable(source), "id=\"controlled\"");
}

}  // namespace battery_sof
