#pragma once

#include <vector>

#include "simulator/generator/law.hpp"
#include "simulator/simulation.hpp"

namespace battery_sof_simulator {

/// One channel of an instrument that is as good as real ones are.
struct ImperfectChannel {
  int poles = 2;                 ///< of the anti-alias filter: equal real ones, 1 to 7; 8: Bessel's
  double corner_hz = 20.0;       ///< its -3 dB frequency [Hz], 0.1 to 400
  double late_share = 0.0;       ///< of the filter's delay that the stamps leave in [1]
  double step = 1e-3;            ///< of the converter [V or A], 0: none
  double bow_steps = 0.0;        ///< largest nonlinearity [steps]
  double bow_period_steps = 64;  ///< of the converter's values over which it repeats, > 0
  double bow_phase = 0.0;        ///< [rad]
  double ripple = 0.0;           ///< amplitude [V or A]
  NoiseOptions noise;
};

/// A term of smooth structure: a sine or tanh of a remembered current, or a sine of time.
struct SmoothTerm {
  int kind = 0;          ///< 0: sin(m / scale), 1: tanh(m / scale), 2: sin(2 pi t / memory + phase)
  double memory = 10.0;  ///< time constant of m, a mean of the past current, or period [s], > 0
  double scale = 20.0;   ///< [A], > 0
  double phase = 0.0;    ///< [rad]
  double weight = 1.0;
};

struct ImperfectRecorder {
  ImperfectChannel voltage, current;
  double jitter_share = 0.01;        ///< standard deviation of a sample's instant, of the interval
  double jitter_apart_share = 0.05;  ///< of its variance that each channel has of its own
  double ripple_hz = 120.0;          ///< of both channels
  std::vector<SmoothTerm> smooth;
  double smooth_rms_v = 0.0;  ///< of all terms together [V]
};

/// What of a recorder acts; for saying how much each is.
struct ActingParts {
  bool noise = true;  ///< random noise and ripple
  bool steps = true;  ///< the voltage's rounding and converter nonlinearity
};

/// Draws a recorder. @param rate of the recording [Hz].  @param duration [s].
ImperfectRecorder drawRecorder(double rate, double duration, Dice& dice);

/// A course seen through a recorder. Filter of each channel at the simulation's rate, its delay
/// taken out of the stamps but for late_share; samples on a grid that jitters, stamped as if it did
/// not; smooth structure (voltage alone), ripple and noise; converter nonlinearity, rounding.
/// @param per_sample simulation steps a sample, >= 1.
std::vector<RecordedSample> recordedThrough(const ImperfectRecorder& recorder, const Course& truth,
                                            std::size_t per_sample, std::uint64_t seed,
                                            const ActingParts& acting = {});

/// The instants, in samples, at which the two channels look; n without jitter.
struct SampleInstants {
  std::vector<double> voltage, current;
};
SampleInstants jitteredInstants(const ImperfectRecorder& recorder, std::size_t samples,
                                std::uint64_t seed);

/// Smooth structure along a current, scaled to smooth_rms_v about its mean [V].
std::vector<double> smoothStructure(const ImperfectRecorder& recorder,
                                    const std::vector<double>& current);

}  // namespace battery_sof_simulator
