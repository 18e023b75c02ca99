#pragma once

#include "support/base_circuit.hpp"
#include "support/synthetic_recording.hpp"

/// Drives whose voltage is the base model's own, for tests that need to know the truth exactly.
namespace battery_sof::test {

inline BaseParameters drivenBattery() {
  BaseParameters p;
  p.r_discharge = 0.006;
  p.r_charge = 0.0085;
  p.c2 = 1100.0;
  p.beta = 22.0;
  p.u_dc = 12.7;
  return p;
}

/// Current like the paper's data set 1 (docs/physics.md#drives): charges and discharges of 2 to 9
/// s, rests, and a 1 s pulse every minute or so. The first pulse comes within 40 s. [A]
inline std::vector<double> dataSetOneCurrent(double duration, double interval, std::uint64_t seed) {
  Random random(seed);
  std::vector<double> current;
  double level = 0.0, until = 0.0, charge = 0.0;
  double pulse_at = random.uniform(10.0, 40.0), pulse = 0.0;
  for (long n = 0; n < std::lround(duration / interval); ++n) {
    const double t = static_cast<double>(n) * interval;
    if (t >= until) {
      const bool charging =
          charge < 0.0 ? random.uniform(0.0, 1.0) < 0.7 : random.uniform(0.0, 1.0) < 0.3;
      level = charging ? random.uniform(8.0, 42.0) : random.uniform(-60.0, -8.0);
      if (random.uniform(0.0, 1.0) < 0.15) level = 0.0;
      until = t + random.uniform(2.0, 9.0);
    }
    if (t >= pulse_at + 1.0) pulse_at = t + random.uniform(50.0, 90.0);
    pulse = t >= pulse_at ? (pulse == 0.0 ? random.uniform(-300.0, -160.0) : pulse) : 0.0;
    current.push_back(pulse != 0.0 ? pulse : level);
    charge += current.back() * interval;
  }
  return current;
}

/// The base model's answer to a current linear between samples, with white noise on the voltage.
inline Series answered(const BaseParameters& battery, const std::vector<double>& current,
                       double interval, double noise, std::uint64_t seed, double u_c2_first = 0.0) {
  Random random(seed ^ 0x5EEDULL);
  const BaseStep step(battery);
  Series series;
  double u_c2 = u_c2_first;
  for (std::size_t n = 0; n < current.size(); ++n) {
    if (n > 0) u_c2 = step.advance(u_c2, 0.5 * (current[n - 1] + current[n]), interval);
    series.append({static_cast<double>(n) * interval, current[n],
                   terminalVoltage(battery, current[n], u_c2) + noise * random.normal()});
  }
  return series;
}

/// Four minutes at 100 Hz with 2 mV of noise.
inline Series baseDrive(std::uint64_t seed, double duration = 240.0, double noise = 0.002) {
  return answered(drivenBattery(), dataSetOneCurrent(duration, 0.01, seed), 0.01, noise, seed);
}

}  // namespace battery_sof::test
