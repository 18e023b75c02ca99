#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "battery_sof/series.hpp"
#include "recording/resample.hpp"

/// Recordings with known properties, for tests of recording/ and report/. Seeded: the same on every
/// machine.
namespace battery_sof::test {

/// Numbers that are the same with every standard library (SplitMix64; Box-Muller).
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  double uniform(double low, double high) {
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15ULL);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return low + (high - low) * static_cast<double>((z ^ (z >> 31)) >> 11) / 9007199254740992.0;
  }

  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(uniform(1e-300, 1.0)));
    return radius * std::cos(6.283185307179586 * uniform(0.0, 1.0));
  }

 private:
  std::uint64_t state_;
};

/// A 60 Ah block: rest voltage rising with charge, 5 mOhm, a fast and a slow polarisation; charging
/// voltage limited.
class SyntheticBattery {
 public:
  /// Voltage after interval [s] of the wished current [A], which is lowered when it would exceed
  /// the limit.
  double step(double& current, double interval) {
    constexpr double kResistance = 0.005, kFast = 0.002, kFastTime = 0.2, kSlow = 0.004,
                     kSlowTime = 40.0, kVoltPerCoulomb = 1.3 / (60.0 * 3600.0);
    const double rest = 12.6 + kVoltPerCoulomb * charge_;
    current = std::min(current, (kVoltageLimit - rest - fast_ - slow_) / kResistance);
    fast_ += (kFast * current - fast_) * (1.0 - std::exp(-interval / kFastTime));
    slow_ += (kSlow * current - slow_) * (1.0 - std::exp(-interval / kSlowTime));
    charge_ += current * interval;
    return rest + kResistance * current + fast_ + slow_;
  }

 private:
  static constexpr double kVoltageLimit = 14.4;
  double fast_ = 0.0, slow_ = 0.0, charge_ = 0.0;
};

/// Wished current [A] at 1 kHz: a rest of two minutes, then stop, crank, drive and recuperate over
/// and over.
inline std::vector<double> driveProfile(double duration, std::uint64_t seed) {
  Random random(seed);
  std::vector<double> current(120000, 0.0);
  const auto hold = [&](double level, double seconds) {
    current.insert(current.end(), static_cast<std::size_t>(1000.0 * seconds), level);
  };
  // Drawn one after the other: a compiler evaluates arguments in an order of its own.
  const auto hold_any = [&](double lowest, double highest, double shortest, double longest) {
    const double seconds = random.uniform(shortest, longest);
    hold(random.uniform(lowest, highest), seconds);
  };
  while (current.size() < 1000.0 * duration) {
    hold_any(-35.0, -15.0, 8.0, 30.0);
    const double inrush = random.uniform(-600.0, -450.0), turning = random.uniform(-220.0, -160.0);
    for (int k = 0; k < 600; ++k) {
      const double ripple = 25.0 * std::sin(0.04 * k);
      current.push_back(turning + (inrush - turning) * std::exp(-k / 60.0) + ripple);
    }
    for (int part = 0; part < 3; ++part) {
      hold_any(-30.0, 0.0, 3.0, 12.0);
      hold_any(3.0, 20.0, 4.0, 25.0);
      hold_any(45.0, 80.0, 4.0, 15.0);
    }
  }
  return current;
}

/// The answer of the battery to a profile at 1 kHz.
inline Series driveSeries(const std::vector<double>& profile) {
  SyntheticBattery battery;
  Series series;
  for (std::size_t k = 0; k < profile.size(); ++k) {
    double current = profile[k];
    const double voltage = battery.step(current, 1e-3);
    series.append({1e-3 * static_cast<double>(k), current, voltage});
  }
  return series;
}

/// Every n-th sample, without a filter.
inline Series everyNth(const Series& series, std::size_t n) {
  Series result;
  for (std::size_t k = 0; k < series.size(); k += n) {
    result.append(series[k]);
  }
  return result;
}

/// White noise on both channels.
inline void addNoise(Series& series, double current_noise, double voltage_noise,
                     std::uint64_t seed) {
  Random random(seed);
  for (std::size_t k = 0; k < series.size(); ++k) {
    series.current[k] += current_noise * random.normal();
    series.voltage[k] += voltage_noise * random.normal();
  }
}

/// Rounds to multiples of step.
inline void quantise(std::vector<double>& values, double step) {
  for (double& value : values) value = step * std::round(value / step);
}

inline Recording toRecording(Series series) {
  Recording recording;
  recording.name = "synthetic";
  recording.offered = series.size();
  recording.series = std::move(series);
  return recording;
}

/// A drive of ten minutes as the paper's set-up records it: filtered and sampled at 100 Hz, noise
/// of 0.1 A and 1 mV.
inline Series cleanDrive(std::uint64_t seed = 1) {
  Series series = atDesignRate(driveSeries(driveProfile(600.0, seed)));
  addNoise(series, 0.1, 0.001, seed + 100);
  return series;
}

}  // namespace battery_sof::test
