#include "recording/edges.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace battery_sof {
namespace {

constexpr double kSpan = 0.1;           // [s], longer than any sensor holds a value
constexpr double kFineSpan = 0.02;      // [s], shorter than the battery's fast polarisation
constexpr double kLongestLag = 0.5;     // [s]
constexpr double kFastInterval = 0.05;  // [s], 20 Hz
// [s]: a thousandth of what separates two channels reports nothing more
constexpr double kMinInterval = 2e-4;
constexpr double kEdgeShare = 0.1;  // of the range of current
constexpr double kFineCorrelation = 0.5;
constexpr std::size_t kMaxEdges = 400;

using Lag = std::ptrdiff_t;

/// Changes of a channel over span samples; zero where they would reach across a missing sample.
std::vector<double> changesOver(const Series& series, const std::vector<double>& values,
                                std::size_t span, double interval) {
  std::vector<double> changes(series.size() - span);
  for (std::size_t k = 0; k < changes.size(); ++k) {
    const double duration = series.time[k + span] - series.time[k];
    const bool joined = duration <= 1.5 * static_cast<double>(span) * interval;
    changes[k] = joined ? values[k + span] - values[k] : 0.0;
  }
  return changes;
}

/// Changes of one sign that follow each other, kMaxEdges at most and evenly spread.
std::vector<IndexRange> findEdges(const std::vector<double>& changes, double threshold) {
  std::vector<IndexRange> edges;
  for (std::size_t k = 0; k < changes.size(); ++k) {
    if (std::abs(changes[k]) < threshold) continue;
    const bool continues =
        !edges.empty() && edges.back().last == k && changes[k] * changes[edges.back().first] > 0.0;
    if (!continues) edges.push_back({k, k});
    edges.back().last = k + 1;
  }
  if (edges.size() <= kMaxEdges) return edges;
  std::vector<IndexRange> kept(kMaxEdges);
  for (std::size_t k = 0; k < kMaxEdges; ++k) kept[k] = edges[k * edges.size() / kMaxEdges];
  return kept;
}

/// Sums of products of current and voltage changes over a set of edges, for the lags around a
/// centre.
class CrossProducts {
 public:
  CrossProducts(Lag centre, Lag reach) : lowest_(centre - reach), product_(2 * reach + 1) {
    voltage_squares_.resize(product_.size());
  }

  void add(IndexRange edge, const std::vector<double>& current,
           const std::vector<double>& voltage) {
    for (std::size_t k = edge.first; k < edge.last; ++k) {
      current_squares_ += current[k] * current[k];
      for (std::size_t j = 0; j < product_.size(); ++j) {
        const Lag at = static_cast<Lag>(k + j) + lowest_;
        if (at < 0 || at >= static_cast<Lag>(voltage.size())) continue;
        product_[j] += current[k] * voltage[at];
        voltage_squares_[j] += voltage[at] * voltage[at];
      }
    }
  }

  Lag best() const { return lowest_ + static_cast<Lag>(indexOfBest()); }

  /// The best lag in samples, refined by a parabola through its neighbours.
  double refined() const {
    const std::size_t k = indexOfBest();
    if (k == 0 || k + 1 == product_.size()) return static_cast<double>(best());
    const double before = product_[k - 1], after = product_[k + 1];
    const double curvature = before - 2.0 * product_[k] + after;
    const double shift = curvature == 0.0 ? 0.0 : 0.5 * (before - after) / curvature;
    return static_cast<double>(best()) + shift;
  }

  double correlation(Lag lag) const {
    const double voltage = *std::max_element(voltage_squares_.begin(), voltage_squares_.end());
    const double scale = std::sqrt(current_squares_ * voltage);
    return scale > 0.0 ? product_[lag - lowest_] / scale : 0.0;
  }

  double resistance() const {
    return current_squares_ > 0.0 ? product_[indexOfBest()] / current_squares_ : 0.0;
  }

 private:
  std::size_t indexOfBest() const {
    const auto lower = [](double a, double b) { return std::abs(a) < std::abs(b); };
    return std::max_element(product_.begin(), product_.end(), lower) - product_.begin();
  }

  Lag lowest_;
  std::vector<double> product_, voltage_squares_;
  double current_squares_ = 0.0;
};

/// The edges of a series at one span, and their cross products for all of them and for either half.
struct Comparison {
  Comparison(const Series& series, double interval, std::size_t span, Lag centre, Lag reach)
      : all(centre, reach), first(centre, reach), second(centre, reach) {
    if (series.size() <= span + 1) return;
    const auto [low, high] = std::minmax_element(series.current.begin(), series.current.end());
    const auto current = changesOver(series, series.current, span, interval);
    const auto voltage = changesOver(series, series.voltage, span, interval);
    const auto found =
        *low == *high ? std::vector<IndexRange>{} : findEdges(current, kEdgeShare * (*high - *low));
    edges = found.size();
    for (std::size_t k = 0; k < edges; ++k) {
      all.add(found[k], current, voltage);
      (2 * k < edges ? first : second).add(found[k], current, voltage);
    }
  }

  std::size_t edges = 0;
  CrossProducts all, first, second;
};

std::size_t samplesIn(double duration, double interval) {
  return static_cast<std::size_t>(std::max(1L, std::lround(duration / interval)));
}

void takeLags(const Comparison& comparison, double interval, bool refined, EdgeResponse& response) {
  const auto lag = [&](const CrossProducts& sums) {
    return interval * (refined ? sums.refined() : static_cast<double>(sums.best()));
  };
  response.lag = lag(comparison.all);
  response.lag_first = lag(comparison.first);
  response.lag_second = lag(comparison.second);
}

/// Every n-th sample.
Series everyNth(const Series& series, std::size_t stride) {
  Series some;
  for (std::size_t k = 0; k < series.size(); k += stride) some.append(series[k]);
  return some;
}

}  // namespace

std::optional<EdgeResponse> edgeResponse(const Series& series) {
  const double interval = medianInterval(series);
  if (interval <= 0.0) return std::nullopt;
  const auto stride = static_cast<std::size_t>(
      std::min(std::ceil(kMinInterval / interval), static_cast<double>(series.size())));
  if (stride > 1)
    return series.size() > 2 * stride ? edgeResponse(everyNth(series, stride)) : std::nullopt;
  const bool is_fast = interval <= kFastInterval;
  const std::size_t span = is_fast ? samplesIn(kSpan, interval) : 1;
  const Lag longest = is_fast ? static_cast<Lag>(samplesIn(kLongestLag, interval)) : 1;
  const Comparison coarse(series, interval, span, 0, longest);
  if (coarse.edges == 0) return std::nullopt;
  EdgeResponse response;
  response.edges = coarse.edges;
  response.correlation = coarse.all.correlation(coarse.all.best());
  response.correlation_unshifted = coarse.all.correlation(0);
  response.resistance = coarse.all.resistance();
  takeLags(coarse, interval, is_fast, response);
  if (!is_fast) return response;
  const Comparison fine(series, interval, samplesIn(kFineSpan, interval), coarse.all.best(),
                        static_cast<Lag>(span));
  const bool is_clear = std::abs(fine.all.correlation(fine.all.best())) >= kFineCorrelation;
  if (is_clear) takeLags(fine, interval, true, response);
  return response;
}

}  // namespace battery_sof
