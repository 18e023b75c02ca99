#include "report/display_samples.hpp"

#include <algorithm>
#include <numeric>

namespace battery_sof {
namespace {

/// Ranges of samples that share a bucket of time; empty buckets leave none.
std::vector<IndexRange> bucketRanges(const Series& series, std::size_t buckets) {
  const double begin = series.time.front();
  const double width = (series.time.back() - begin) / static_cast<double>(buckets);
  std::vector<IndexRange> ranges;
  std::size_t last_bucket = buckets;
  for (std::size_t n = 0; n < series.size(); ++n) {
    const auto bucket =
        std::min(static_cast<std::size_t>((series.time[n] - begin) / width), buckets - 1);
    if (bucket != last_bucket) ranges.push_back({n, n});
    ranges.back().last = n + 1;
    last_bucket = bucket;
  }
  return ranges;
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

}  // namespace battery_sof
