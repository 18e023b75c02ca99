#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "simulator/dice.hpp"
#include "simulator/filters.hpp"

namespace battery_sof_simulator {

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

/// What lies between the battery's terminals and the recording.
struct AcquisitionOptions {
  double sample_rate_hz = 100.0;  ///< of the recording; the simulation's rate is a whole multiple
  double cutoff_hz = 20.0;        ///< of the anti-aliasing Bessel filter; 0: no filter
  NoiseOptions voltage_noise{0.001, 0.0, 2.0, 0.0};
  NoiseOptions current_noise{0.05, 0.0, 2.0, 0.0};
  double voltage_step_v = 0.001;        ///< quantisation; 0 for none
  double current_step_a = 0.01;         ///< quantisation; 0 for none
  double current_offset_a = 0.0;        ///< added to the current
  double current_gain = 1.0;            ///< the current is multiplied with it
  double current_delay_s = 0.0;         ///< by which the current is reported later than the voltage
  double current_gain_charge = 1.0;     ///< on top of current_gain while charging
  double current_gain_discharge = 1.0;  ///< on top of current_gain while discharging
  double current_lag_s = 0.0;           ///< time constant of a one-pole lag; 0 for none
  double voltage_lag_s = 0.0;           ///< time constant of a one-pole lag; 0 for none
  double voltage_drift_v_per_h = 0.0;   ///< of the recorded voltage
  double current_limit_a = kNoLimit;    ///< |current| is clipped there
  double voltage_floor_v = -kNoLimit;   ///< the voltage is clipped there
  double voltage_ceiling_v = kNoLimit;  ///< the voltage is clipped there
  double lost_share = 0.0;              ///< of the samples, at random
  double frozen_per_min = 0.0;  ///< stretches in which both channels repeat their last value
  Range frozen_s{0.1, 1.0};     ///< their length
  double tone_v = 0.0;          ///< amplitude of a tone behind the anti-aliasing filter
  double tone_hz = 0.0;         ///< its frequency; above half the sample rate it is aliased
};

/// One recorded sample, current positive into the battery.
struct RecordedSample {
  double time, current, voltage;  ///< [s], [A], [V]
};

/// One channel: anti-aliasing filter, then samples on the recording's grid, free of the filter's
/// delay. The sample stamped t is the filter's output at t + lead, between two inputs by a cubic
/// through four of them (error below 1e-5 of a 20 Hz signal at 1 kHz). lead is the filter's delay,
/// less what the channel reports late.
class SampledChannel {
 public:
  SampledChannel(const AcquisitionOptions& options, double input_rate, double reported_late);

  void push(double value);
  const std::vector<double>& samples() const { return samples_; }

 private:
  double outputAt(double position) const;

  std::optional<BesselFilter> filter_;
  double inputs_per_sample_;
  double lead_;                      // in inputs
  std::array<double, 4> outputs_{};  // the newest last
  std::int64_t pushed_ = 0;
  std::vector<double> samples_;
};

/// The recording of a simulated battery (paper, section V; docs/physics.md#acquisition). Gain and
/// offset of the current, lags, the same Bessel filter on both channels at the simulation's rate,
/// decimation with the filter's delay taken out of the stamps, tone and drift of the voltage,
/// noise, clipping, quantisation, frozen stretches, lost samples, in this order.
class Acquisition {
 public:
  /// @throws std::invalid_argument naming every fault of the options.
  Acquisition(const AcquisitionOptions& options, double input_rate, std::uint64_t seed);

  /// Takes the next pair of true values.
  void push(double current, double voltage);

  /// @return how much longer than the recording the simulation has to run [s].
  double lookAhead() const;

  /// @return the samples whose stamps lie in [0, duration).
  std::vector<RecordedSample> recording(double duration) const;

 private:
  std::vector<RecordedSample> withDropouts(const std::vector<RecordedSample>& samples) const;

  AcquisitionOptions options_;
  std::uint64_t seed_;
  Lag current_lag_, voltage_lag_;
  SampledChannel current_, voltage_;
};

/// @return one sentence for every fault of the options; empty when all is well.
std::vector<std::string> faultsOf(const AcquisitionOptions& options);

}  // namespace battery_sof_simulator
