#include "diagnosis/response_features.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "recording/channel_statistics.hpp"
#include "recording/control_mode.hpp"
#include "recording/fit_mask.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr int kJackknifeBlocks = 8;
constexpr int kTapsBefore = 3;
constexpr double kCountedStep = 8.0;           // [A], a change of current that counts
constexpr double kDischarge = -4.0;            // [A], below: the battery discharges
constexpr double kBlockedWindow = 11.0;        // [A]
constexpr double kBlockedWidth = 0.3;          // [A], of the kernel
constexpr double kMoves = 0.04, kJumps = 1.0;  // [V], in 3 s
constexpr double kLeastWidth = 3e-4;           // [Ohm], of the scatter of resistances
constexpr double kLeastStep = 4e-3;            // [V], of a change of voltage: noise of a channel
constexpr std::size_t kFewestEdges = 12, kFewestBlocked = 50, kFewestPulses = 60;

/// A statistic of a recording, and of it without each block.
struct Jackknife {
  std::optional<double> whole;
  std::array<std::optional<double>, kJackknifeBlocks> without;
  double min_variance = 0.0;
};

int blockOf(std::size_t row, std::size_t rows) {
  return static_cast<int>(row * kJackknifeBlocks / std::max<std::size_t>(rows, 1));
}

bool isJoined(const ResponseRows& rows, std::size_t from, std::size_t to) {
  const double expected = rows.interval * static_cast<double>(to - from);
  return std::abs(rows.time[to] - rows.time[from] - expected) < 0.4 * rows.interval;
}

struct Ratio {
  double value = 0.0, weight = 0.0;
  int block = 0;
};

/// Location of dv/di over changes of current di (Ratio::weight) by a Cauchy likelihood, whose scale
/// is that of the ratios' scatter and of a step of the voltage's channel over |di|.
class EdgeLocation {
 public:
  /// @param step [V].
  EdgeLocation(std::vector<Ratio> ratios, double step) : ratios_(std::move(ratios)), step_(step) {
    const auto square = [](const Ratio& one) { return one.weight * one.weight; };
    value_ = weightedMedian(ratios_, square);
    std::vector<Ratio> apart = ratios_;
    for (Ratio& one : apart) one.value = std::abs(one.value - value_);
    width_ = 1.5 * weightedMedian(std::move(apart), square) + kLeastWidth;
    value_ = *without(-1);
  }

  double value() const { return value_; }

  /// The same without a block, from where the whole stands; none where too few are left.
  std::optional<double> without(int block) const {
    const auto counts = [&](const Ratio& one) { return one.block != block; };
    const auto left = std::count_if(ratios_.begin(), ratios_.end(), counts);
    if (static_cast<std::size_t>(left) < kFewestEdges / 2) return std::nullopt;
    double value = value_;
    for (int round = 0; round < 12; ++round) {
      double sum = 0.0, weighted = 0.0;
      for (const Ratio& one : ratios_) {
        if (!counts(one)) continue;
        const double square = scaleSquareOf(one);
        const double weight = 1.0 / (square + std::pow(one.value - value, 2));
        sum += weight;
        weighted += weight * one.value;
      }
      value = weighted / sum;
    }
    return value;
  }

  /// Of an M-estimate: sum psi^2 / (sum psi')^2 (Huber 1964).
  double variance() const {
    double squares = 0.0, slope = 0.0, sum = 0.0;
    for (const Ratio& one : ratios_) {
      const double square = scaleSquareOf(one), apart = std::pow(one.value - value_, 2);
      const double weight = 1.0 / (square + apart);
      squares += weight * weight * apart;
      slope += weight * weight * (square - apart);
      sum += weight;
    }
    return squares / std::pow(std::max(slope, 0.2 * sum), 2);
  }

 private:
  template <typename Weight>
  static double weightedMedian(std::vector<Ratio> values, Weight&& weight) {
    std::sort(values.begin(), values.end(),
              [](const Ratio& a, const Ratio& b) { return a.value < b.value; });
    double total = 0.0, below = 0.0;
    for (const Ratio& one : values) total += weight(one);
    for (const Ratio& one : values)
      if ((below += weight(one)) >= 0.5 * total) return one.value;
    return values.back().value;
  }

  double scaleSquareOf(const Ratio& one) const {
    return width_ * width_ + std::pow(step_ / one.weight, 2);
  }

  std::vector<Ratio> ratios_;
  double step_, width_ = 0.0, value_ = 0.0;
};

Jackknife edgeResistance(const ResponseRows& rows, double scale, std::size_t stride) {
  std::vector<Ratio> ratios;
  for (std::size_t k = stride; k < rows.size(); ++k) {
    const double before = rows.current[k - stride], behind = rows.current[k];
    const double change = behind - before;
    if (std::abs(change) <= kCountedStep * scale) continue;
    if (before >= kDischarge * scale || behind >= kDischarge * scale) continue;
    if (rows.excluded[k] || rows.excluded[k - stride] || !isJoined(rows, k - stride, k)) continue;
    ratios.push_back({(rows.voltage[k] - rows.voltage[k - stride]) / change, std::abs(change),
                      blockOf(k, rows.size())});
  }
  Jackknife of;
  if (ratios.size() < kFewestEdges) return of;
  const EdgeLocation location(std::move(ratios), rows.voltage_step);
  of.whole = location.value();
  of.min_variance = location.variance();
  for (int block = 0; block < kJackknifeBlocks; ++block)
    of.without[block] = location.without(block);
  return of;
}

/// Mode of the values under a Gaussian kernel.
std::optional<double> modeOf(const std::vector<Ratio>& values, double scale, int without) {
  const double step = 0.05 * scale, end = (kBlockedWindow + 1.0) * scale;
  std::vector<double> counts(static_cast<std::size_t>(2.0 * end / step) + 1, 0.0);
  std::size_t count = 0;
  for (const Ratio& one : values) {
    if (one.block == without) continue;
    ++count;
    const double cell = (one.value + end) / step;
    if (cell >= 0.0 && cell < static_cast<double>(counts.size())) counts[cell] += 1.0;
  }
  if (count < kFewestBlocked) return std::nullopt;
  const double width = kBlockedWidth * scale;
  double best = -1.0, at = 0.0;
  const int reach = static_cast<int>(3.3 * width / step);
  for (int cell = 0; cell < static_cast<int>(counts.size()); ++cell) {
    double density = 0.0;
    for (int k = std::max(0, cell - reach);
         k <= std::min(static_cast<int>(counts.size()) - 1, cell + reach); ++k)
      if (counts[k] > 0.0)
        density += counts[k] * std::exp(-0.5 * std::pow((k - cell) * step / width, 2));
    if (density > best) best = density, at = (cell + 0.5) * step - end;
  }
  for (int round = 0; round < 5; ++round) {  // mean shift
    double sum = 0.0, weighted = 0.0;
    for (const Ratio& one : values) {
      if (one.block == without || std::abs(one.value - at) > 3.3 * width) continue;
      const double weight = std::exp(-0.5 * std::pow((one.value - at) / width, 2));
      sum += weight;
      weighted += weight * one.value;
    }
    if (sum > 0.0) at = weighted / sum;
  }
  return at;
}

Jackknife blockedCurrent(const ResponseRows& rows, double scale) {
  if (!rows.has_source) return {};
  const auto stride =
      static_cast<std::size_t>(std::max(1.0, std::round(3.0 / std::max(rows.interval, 1e-3))));
  std::vector<Ratio> values;
  for (std::size_t k = stride; k < rows.size(); ++k) {
    const std::size_t middle = k - stride + (stride > 1 ? 1 : 0);
    const double current = rows.current[middle];
    if (std::abs(current) >= kBlockedWindow * scale || !isJoined(rows, k - stride, k)) continue;
    const double moved = std::abs(rows.voltage[k] - rows.voltage[k - stride]);
    if (moved <= kMoves || moved >= kJumps) continue;
    values.push_back({current, 1.0, blockOf(k, rows.size())});
  }
  Jackknife of;
  of.whole = modeOf(values, scale, -1);
  for (int block = 0; block < kJackknifeBlocks && of.whole; ++block)
    of.without[block] = modeOf(values, scale, block);
  of.min_variance = std::pow(0.05 * scale, 2);
  return of;
}

using Taps = Eigen::Matrix<double, kTaps, 1>;
using TapMatrix = Eigen::Matrix<double, kTaps, kTaps>;

std::array<Jackknife, kTaps> pulseResponse(const ResponseRows& rows, double scale) {
  std::array<Jackknife, kTaps> of;
  std::array<TapMatrix, kJackknifeBlocks> normal;
  std::array<Taps, kJackknifeBlocks> right;
  for (int block = 0; block < kJackknifeBlocks; ++block)
    normal[block].setZero(), right[block].setZero();
  std::size_t count = 0;
  const std::size_t behind = kTaps - 1 - kTapsBefore;
  for (std::size_t n = behind + 1; n + kTapsBefore < rows.size(); ++n) {
    Taps changes;
    double largest = 0.0;
    for (int tap = 0; tap < kTaps; ++tap) {
      const std::size_t k = n + kTapsBefore - tap;
      changes[tap] = rows.current[k] - rows.current[k - 1];
      largest = std::max(largest, std::abs(changes[tap]));
    }
    if (largest <= kCountedStep * scale) continue;
    bool is_sound = true;
    for (std::size_t k = n - behind - 1; k <= n + kTapsBefore && is_sound; ++k)
      is_sound = !rows.excluded[k] && (k == n - behind - 1 || isJoined(rows, k - 1, k));
    if (!is_sound) continue;
    ++count;
    const double weight = 1.0 / std::max(10.0 * scale, largest);
    changes *= weight;
    const double answer = weight * (rows.voltage[n] - rows.voltage[n - 1]);
    const int block = blockOf(n, rows.size());
    normal[block].noalias() += changes * changes.transpose();
    right[block] += answer * changes;
  }
  if (count < kFewestPulses) return of;
  TapMatrix all = TapMatrix::Zero();
  Taps answers = Taps::Zero();
  for (int block = 0; block < kJackknifeBlocks; ++block)
    all += normal[block], answers += right[block];
  const TapMatrix ridge = TapMatrix::Identity() * (1e-3 * all.trace() / kTaps);
  const auto shape = [&](const TapMatrix& matrix, const Taps& vector) -> Taps {
    const Taps taps = (matrix + ridge).ldlt().solve(vector);
    return taps / std::max(taps.cwiseAbs().sum(), 1e-9);
  };
  const Taps whole = shape(all, answers);
  for (int block = 0; block < kJackknifeBlocks; ++block) {
    const Taps part = shape(all - normal[block], answers - right[block]);
    for (int tap = 0; tap < kTaps; ++tap) of[tap].without[block] = part[tap];
  }
  for (int tap = 0; tap < kTaps; ++tap) {
    of[tap].whole = whole[tap];
    of[tap].min_variance = 1e-4;
  }
  return of;
}

}  // namespace

std::string featureId(std::size_t feature) {
  if (feature == kEdgeResistance) return "edge_resistance";
  if (feature == kSlowEdgeResistance) return "slow_edge_resistance";
  if (feature == kBlockedCurrent) return "blocked_current";
  return format("response_%+d", static_cast<int>(feature) - kFirstTap - kTapsBefore);
}

const char* featureUnit(std::size_t feature) {
  if (feature == kBlockedCurrent) return "A";
  return feature < kBlockedCurrent ? "ohm" : "1";
}

std::size_t ResponseFeatures::count() const {
  return static_cast<std::size_t>(std::count(known.begin(), known.end(), true));
}

ResponseRows responseRows(const Series& series) {
  ResponseRows rows{series.time, series.current, series.voltage, {}, medianInterval(series), false};
  rows.has_source = detectControlMode(series).seen;
  const InstrumentLimits limits = instrumentLimits(series);
  rows.excluded = limits.masked;
  rows.voltage_step = std::max(kLeastStep, std::sqrt(12.0) * limits.voltage_lsb_std);
  rows.excluded.resize(rows.size(), 0);
  return rows;
}

ResponseRows withCurrentMoved(ResponseRows rows, int later) {
  const auto move = [later](auto& values) {
    auto moved = values;
    const int last = static_cast<int>(values.size()) - 1;
    for (int n = 0; n <= last; ++n) moved[n] = values[std::clamp(n - later, 0, last)];
    values = std::move(moved);
  };
  if (later == 0 || rows.size() == 0) return rows;
  move(rows.current);
  move(rows.excluded);
  return rows;
}

ResponseScale responseScale(const ResponseRows& reference) {
  ResponseScale scale;
  const double range = quantile(reference.current, 0.999) - quantile(reference.current, 0.001);
  scale.current = std::clamp(range / 200.0, 0.02, 1.0);
  const auto taps = pulseResponse(reference, scale.current);
  if (!taps[0].whole) return scale;
  int largest = 0;
  for (int tap = 1; tap < kTaps; ++tap)
    if (*taps[tap].whole > *taps[largest].whole) largest = tap;
  scale.moved = std::clamp(largest - kTapsBefore, -2, 3);
  return scale;
}

ResponseFeatures responseFeatures(const ResponseRows& given, const ResponseScale& scale) {
  const ResponseRows moved =
      scale.moved == 0 ? ResponseRows() : withCurrentMoved(given, scale.moved);
  const ResponseRows& rows = scale.moved == 0 ? given : moved;
  ResponseFeatures features;
  if (rows.size() < std::size_t{2} * kJackknifeBlocks) return features;
  std::array<Jackknife, kResponseFeatures> all;
  const auto stride =
      static_cast<std::size_t>(std::max(1.0, std::round(0.1 / std::max(rows.interval, 1e-3))));
  all[kEdgeResistance] = edgeResistance(rows, scale.current, stride);
  all[kSlowEdgeResistance] = edgeResistance(rows, scale.current, 2 * stride);
  all[kBlockedCurrent] = blockedCurrent(rows, scale.current);
  const auto taps = pulseResponse(rows, scale.current);
  std::copy(taps.begin(), taps.end(), all.begin() + kFirstTap);

  Eigen::MatrixXd deviation = Eigen::MatrixXd::Zero(kResponseFeatures, kJackknifeBlocks);
  for (int k = 0; k < kResponseFeatures; ++k) {
    features.known[k] = all[k].whole.has_value();
    if (!features.known[k]) continue;
    features.value[k] = *all[k].whole;
    double sum = 0.0, parts = 0.0;
    for (const auto& part : all[k].without)
      if (part) sum += *part, parts += 1.0;
    for (int block = 0; block < kJackknifeBlocks; ++block)
      if (const auto& part = all[k].without[block]) deviation(k, block) = *part - sum / parts;
  }
  features.covariance =
      (kJackknifeBlocks - 1.0) / kJackknifeBlocks * deviation * deviation.transpose();
  for (int k = 0; k < kResponseFeatures; ++k)
    features.covariance(k, k) += std::max(0.0, all[k].min_variance - features.covariance(k, k));
  return features;
}

ResponseFeatures meanOf(const std::vector<ResponseFeatures>& all) {
  ResponseFeatures mean;
  Eigen::VectorXd counts = Eigen::VectorXd::Zero(kResponseFeatures);
  for (const ResponseFeatures& one : all)
    for (int k = 0; k < kResponseFeatures; ++k)
      if (one.known[k]) counts[k] += 1.0, mean.value[k] += one.value[k], mean.known[k] = true;
  for (int k = 0; k < kResponseFeatures; ++k)
    if (mean.known[k]) mean.value[k] /= counts[k];
  for (const ResponseFeatures& one : all)
    for (int k = 0; k < kResponseFeatures; ++k)
      for (int m = 0; m < kResponseFeatures; ++m)
        if (one.known[k] && one.known[m])
          mean.covariance(k, m) += one.covariance(k, m) / (counts[k] * counts[m]);
  return mean;
}

}  // namespace battery_sof
