#include "diagnosis/slow_tone.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <complex>
#include <unsupported/Eigen/FFT>
#include <utility>
#include <vector>

#include "recording/channel_statistics.hpp"

namespace battery_sof {
namespace {

constexpr double kBin = 1.0;            // [s]
constexpr double kChance = 1e-3;        // of a recording without a tone
constexpr double kShortestSpan = 10.0;  // periods of a tone that a recording must hold
constexpr std::size_t kAround = 20;     // frequencies to either side that tell the level there
constexpr std::size_t kFewest = 4 * kAround;
// of the RMS error: a tone below it takes less than 2 % of the error
constexpr double kMinShare = 0.25;
constexpr double kMaxBinsPerSample = 4.0;  // a recording of which most is gaps shows no tone
constexpr double kTwoPi = 6.283185307179586;

/// @return the least number of at least so many without a prime factor above 5: others take a
/// Fourier transform many times as long.
std::size_t transformedFast(std::size_t least) {
  for (std::size_t count = least;; ++count) {
    std::size_t rest = count;
    for (const std::size_t prime : {2, 3, 5})
      while (rest > 1 && rest % prime == 0) rest /= prime;
    if (rest <= 1) return count;
  }
}

/// Mean innovation of each bin, of variance one where there are samples and zero where there are
/// none.
std::vector<double> binned(const WhitenedFit& fit, const InputSequence& inputs, double bin) {
  const double span = inputs.samples.back().step.time - inputs.first_time;
  std::vector<double> sums(transformedFast(static_cast<std::size_t>(span / bin) + 1)),
      counts(sums.size());
  for (std::size_t n = 0; n < inputs.samples.size(); ++n) {
    if (!(inputs.samples[n].count > 0.0)) continue;
    const auto at = static_cast<std::size_t>(
        std::max(0.0, inputs.samples[n].step.time - inputs.first_time) / bin);
    sums[at] += fit.innovation[n];
    counts[at] += 1.0;
  }
  for (std::size_t k = 0; k < sums.size(); ++k)
    if (counts[k] > 0.0) sums[k] /= std::sqrt(counts[k]);
  return sums;
}

/// Chance that one line without a tone stands so far above the median of its neighbours. That
/// median is uncertain itself: a sum of m + 1 of the 2 m + 1 exponential spacings, of which this is
/// the Laplace transform.
double chanceOf(double power) {
  double chance = 1.0;
  for (std::size_t j = 0; j <= kAround; ++j) {
    const auto left = static_cast<double>(2 * kAround + 1 - j);
    chance *= left / (left + power / std::log(2.0));
  }
  return chance;
}

/// RMS error over the measurements, each as often as it counts [V]; 0 without any.
double rmsError(const WhitenedFit& fit, const InputSequence& inputs) {
  double square = 0.0, counts = 0.0;
  for (std::size_t n = 0; n < inputs.samples.size(); ++n) {
    const double count = inputs.samples[n].count, error = fit.residual[n];
    square += count * error * error;
    counts += count;
  }
  return counts > 0.0 ? std::sqrt(square / counts) : 0.0;
}

double amplitudeOf(const WhitenedFit& fit, const InputSequence& inputs, double period) {
  Eigen::MatrixXd columns(fit.innovation.size(), 2);
  for (Eigen::Index n = 0; n < columns.rows(); ++n) {
    const double angle = kTwoPi * (inputs.samples[n].step.time - inputs.first_time) / period;
    columns.row(n) << std::sin(angle), std::cos(angle);
  }
  return whitened(fit, inputs, columns).colPivHouseholderQr().solve(fit.innovation).norm();
}

}  // namespace

std::optional<SlowTone> slowTone(const WhitenedFit& fit, const InputSequence& inputs) {
  const double bin = std::max(kBin, medianDuration(inputs));
  const double span = inputs.samples.back().step.time - inputs.first_time;
  if (span / bin > kMaxBinsPerSample * static_cast<double>(inputs.samples.size()))
    return std::nullopt;
  std::vector<double> values = binned(fit, inputs, bin);
  std::vector<std::complex<double>> transform;
  Eigen::FFT<double> fft;
  fft.fwd(transform, values);
  const auto lowest = static_cast<std::size_t>(kShortestSpan);
  if (values.size() / 2 < lowest + kFewest) return std::nullopt;
  std::vector<double> power;
  for (std::size_t k = lowest; k < values.size() / 2; ++k) power.push_back(std::norm(transform[k]));
  SlowTone best;
  for (std::size_t k = 0; k < power.size(); ++k) {
    const std::size_t from = std::min(k - std::min(k, kAround), power.size() - 2 * kAround - 1);
    const auto first = power.begin() + static_cast<std::ptrdiff_t>(from);
    const double level = quantile({first, first + 2 * kAround + 1}, 0.5) / std::log(2.0);
    if (!(level > 0.0) || power[k] <= best.power * level) continue;
    best.power = power[k] / level;
    best.period = bin * static_cast<double>(values.size()) / static_cast<double>(lowest + k);
  }
  if (static_cast<double>(power.size()) * chanceOf(best.power) > kChance) return std::nullopt;
  best.amplitude = amplitudeOf(fit, inputs, best.period);
  if (best.amplitude < kMinShare * rmsError(fit, inputs)) return std::nullopt;
  return best;
}

}  // namespace battery_sof
