#include "report/drawing.hpp"

#include <algorithm>
#include <numeric>

#include "page.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr double kPlotFoot = 240.0,
                 kPlotHead = 10.0;  // of a view box, between which values are drawn

/// Ranges of samples that share a bucket of time; empty buckets leave none.
std::vector<IndexRange> bucketRanges(const Series& series, std::size_t buckets) {
  const double begin = series.time.front();
  const double width = (series.time.back() - begin) / static_cast<double>(buckets);
  const auto bucket = [&](std::size_t n) {
    return std::min(static_cast<std::size_t>((series.time[n] - begin) / width), buckets - 1);
  };
  return cutWhere({0, series.size()}, [&](std::size_t n) { return bucket(n) == bucket(n - 1); });
}

void pickExtremes(IndexRange range, const Trace& trace, std::vector<std::size_t>& picked) {
  std::size_t low = range.first, high = range.first;
  for (std::size_t n = range.first + 1; n < range.last; ++n) {
    if (trace(n) < trace(low)) low = n;
    if (trace(n) > trace(high)) high = n;
  }
  picked.insert(picked.end(), {low, high});
}

}  // namespace

std::vector<std::size_t> displaySamples(const Series& series, const std::vector<Trace>& traces,
                                        std::size_t buckets, const std::vector<IndexRange>& whole) {
  std::vector<std::size_t> picked;
  if (series.size() <= 2 * buckets) {
    picked.resize(series.size());
    std::iota(picked.begin(), picked.end(), std::size_t{0});
    return picked;
  }
  for (const IndexRange& range : bucketRanges(series, buckets)) {
    picked.push_back(range.first);
    for (const Trace& trace : traces) pickExtremes(range, trace, picked);
  }
  picked.push_back(series.size() - 1);
  for (const IndexRange& range : whole)
    for (std::size_t n = range.first; n < range.last; ++n) picked.push_back(n);
  std::sort(picked.begin(), picked.end());
  picked.erase(std::unique(picked.begin(), picked.end()), picked.end());
  return picked;
}

void Scale::include(double value) {
  low = std::min(low, value);
  high = std::max(high, value);
}

double Scale::share(double value) const {
  return high > low ? std::clamp((value - low) / (high - low), 0.0, 1.0) : 0.5;
}

std::string tracePath(const Series& series, const std::vector<std::size_t>& shown,
                      const Trace& trace, const std::string& name, const Scale& time,
                      const Scale& value) {
  const double gap = gapThreshold(series);
  std::string path;
  for (const std::size_t n : shown) {
    const bool is_start = path.empty() || series.time[n] - series.time[n - 1] > gap;
    path += format("%s%.1f %.1f", is_start ? "M" : "L", kDrawingWidth * time.share(series.time[n]),
                   kPlotFoot - (kPlotFoot - kPlotHead) * value.share(trace(n)));
  }
  return element("path." + name, element("title", name), "d=\"" + path + "\"");
}

std::string drawingFigure(const std::string& title, const std::string& span,
                          const std::string& legend, const std::string& paths) {
  const std::string svg = element(
      "svg", paths,
      format("viewBox=\"0 0 %g %g\" preserveAspectRatio=\"none\" role=\"img\" aria-label=\"%s\"",
             kDrawingWidth, kDrawingHeight, title.c_str()));
  return figure("figure.drawing", element("span", element("span.what", title) + span), legend, svg);
}

}  // namespace battery_sof
