#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "battery_sof/series.hpp"

namespace battery_sof {

/// One second-order section, y = b0 x + b1 x1 + b2 x2 - a1 y1 - a2 y2.
struct Biquad {
  double b0, b1, b2, a1, a2;
};

/**
 * @brief Digital 8th-order Bessel low-pass, normalised to -3 dB at the cut-off, by the bilinear
 * transform with the cut-off prewarped. It preserves the wave shape: no overshoot worth the name,
 * constant group delay in the pass band.
 *
 * @param cutoff [Hz], above 0 and below rate / 2.   @param rate sampling rate [Hz].
 * @return four sections of unit gain at 0 Hz.
 * @throws std::invalid_argument for a cut-off outside (0, rate / 2).
 * @see paper, section V (8th-order Bessel-type anti-aliasing filter from 1 kHz to 100 Hz).
 */
std::array<Biquad, 4> designBessel8(double cutoff, double rate);

/// @return group delay of the filter at 0 Hz [s].
double groupDelayAtZero(const std::array<Biquad, 4>& sections, double rate);

/// [Hz], of the result and of its filter: the paper's 100 Hz; 20 Hz is "well below half the Nyquist
/// frequency" (25 Hz).
inline constexpr double kDesignRate = 100.0, kDesignCutoff = 20.0;

/**
 * @brief Streaming anti-alias filter and decimator for one battery's current and voltage.
 *
 * Both channels pass the same filter; the stamps of the result are moved back by its group delay,
 * so edges stay where they were. Input samples are put on a regular grid of the input rate by
 * linear interpolation, which bridges up to ten missing samples. A longer gap is not bridged: the
 * filter starts again in the steady state of the first sample behind it, and the last group delay
 * (25 ms) before it is lost.
 */
class Decimator {
 public:
  /// @param input_rate [Hz], at least twice kDesignRate. @throws std::invalid_argument otherwise.
  explicit Decimator(double input_rate);

  /// Takes one sample (time strictly increasing, all finite) and returns the outputs that became
  /// due, in order.
  /// @throws std::invalid_argument for a sample that is not finite or not after the one before.
  std::vector<Sample> push(const Sample& sample);

 private:
  using Channel = std::array<std::array<double, 4>, 4>;  // x1, x2, y1, y2 of each section
  double filter(Channel& channel, double value) const;
  void startAt(const Sample& sample);
  void advance(const Sample& input, std::vector<Sample>& due);
  bool isReached(double time, double now) const;
  double inputTime() const;
  double outputStamp() const;

  double input_rate_;
  std::array<Biquad, 4> sections_{};
  double delay_ = 0.0;
  Channel current_channel_{}, voltage_channel_{};
  std::optional<Sample> previous_;  // the last sample pushed
  Sample filtered_{};        // the last point of the filtered signal, before its delay is taken off
  double start_ = 0.0;       // time of the first sample since the last gap
  std::size_t inputs_ = 0;   // grid points filtered since start_
  std::size_t outputs_ = 0;  // results given since start_
};

/// @return the series at 100 Hz when it is sampled above 200 Hz (paper, section V), unchanged
/// otherwise: what models are fitted to. Temperatures are carried over.
Series atDesignRate(const Series& series);

}  // namespace battery_sof
