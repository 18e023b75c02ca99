#include "simulator/acquisition.hpp"

#include <algorithm>

#include "simulator/fields.hpp"

namespace battery_sof_simulator {
namespace {

constexpr std::uint32_t kVoltageStream = 2, kCurrentStream = 3, kDropoutStream = 5;
// inputs after a point, which then lies in the cubic's middle
constexpr double kInterpolationReach = 1.0;
constexpr double kHighestRate = 1000.0;  // [Hz], of the simulation

const AcquisitionOptions& valid(const AcquisitionOptions& options) {
  requireNone(faultsOf(options), "acquisition");
  return options;
}

}  // namespace

std::vector<std::string> faultsOf(const AcquisitionOptions& options) {
  auto faults = fieldFaults(options);
  const double ratio = kHighestRate / options.sample_rate_hz;
  if (std::abs(ratio - std::round(ratio)) > 1e-9)
    faults.push_back(
        faultOf("sample_rate_hz", options.sample_rate_hz, "1000 divided by a whole number"));
  if (options.voltage_floor_v >= options.voltage_ceiling_v)
    faults.push_back("voltage_floor_v is not below voltage_ceiling_v");
  if (options.current_gain == 0.0) faults.push_back("current_gain is 0, expected another number");
  return faults;
}

SampledChannel::SampledChannel(const AcquisitionOptions& options, double input_rate,
                               double reported_late)
    : inputs_per_sample_(input_rate / options.sample_rate_hz), lead_(-reported_late * input_rate) {
  if (options.cutoff_hz <= 0.0) return;
  filter_.emplace(options.cutoff_hz, input_rate);
  lead_ += filter_->delay() * input_rate;
}

void SampledChannel::push(double value) {
  if (filter_ && pushed_ == 0) filter_->settle(value);
  const double output = filter_ ? filter_->push(value) : value;
  if (pushed_ == 0) outputs_.fill(output);
  std::rotate(outputs_.begin(), outputs_.begin() + 1, outputs_.end());
  outputs_.back() = output;
  ++pushed_;
  const double newest = static_cast<double>(pushed_ - 1);
  for (;;) {
    const double position =
        std::max(0.0, static_cast<double>(samples_.size()) * inputs_per_sample_ + lead_);
    if (position + kInterpolationReach > newest) return;
    samples_.push_back(outputAt(position));
  }
}

/// Lagrange's cubic through the four newest outputs. @param position in inputs since the first.
double SampledChannel::outputAt(double position) const {
  const double x = position - static_cast<double>(pushed_ - 4);  // 0 to 3 across the four
  const auto& y = outputs_;
  return -y[0] * (x - 1) * (x - 2) * (x - 3) / 6 + y[1] * x * (x - 2) * (x - 3) / 2 -
         y[2] * x * (x - 1) * (x - 3) / 2 + y[3] * x * (x - 1) * (x - 2) / 6;
}

Acquisition::Acquisition(const AcquisitionOptions& options, double input_rate, std::uint64_t seed)
    : options_(valid(options)),
      seed_(seed),
      current_lag_{{options.current_lag_s, 1.0 / input_rate}},
      voltage_lag_{{options.voltage_lag_s, 1.0 / input_rate}},
      current_(options, input_rate, options.current_delay_s),
      voltage_(options, input_rate, 0.0) {}

void Acquisition::push(double current, double voltage) {
  const double gain =
      current < 0.0 ? options_.current_gain_discharge : options_.current_gain_charge;
  const double sensed = options_.current_gain * gain * current + options_.current_offset_a;
  current_.push(current_lag_.push(sensed));
  voltage_.push(voltage_lag_.push(voltage));
}

double Acquisition::lookAhead() const {
  const double filter =
      options_.cutoff_hz > 0.0 ? BesselFilter(options_.cutoff_hz, kHighestRate).delay() : 0.0;
  return filter + std::max(0.0, -options_.current_delay_s) + 4.0 / kHighestRate;
}

std::vector<RecordedSample> Acquisition::recording(double duration) const {
  const double interval = 1.0 / options_.sample_rate_hz;
  ChannelNoise current_noise(options_.current_noise, interval, Dice(seed_, kCurrentStream));
  ChannelNoise voltage_noise(options_.voltage_noise, interval, Dice(seed_, kVoltageStream));
  const auto wanted = static_cast<std::size_t>(std::ceil(duration / interval - 1e-9));
  const std::size_t count =
      std::min({wanted, current_.samples().size(), voltage_.samples().size()});
  std::vector<RecordedSample> samples;
  samples.reserve(count);
  for (std::size_t n = 0; n < count; ++n) {
    const double time = static_cast<double>(n) / options_.sample_rate_hz;
    const double current = current_.samples()[n] + current_noise.next();
    const double fault = options_.voltage_drift_v_per_h * time / kSecondsPerHour +
                         options_.tone_v * std::sin(kTwoPi * options_.tone_hz * time);
    const double voltage = voltage_.samples()[n] + fault + voltage_noise.next();
    samples.push_back(
        {time,
         quantised(std::clamp(current, -options_.current_limit_a, options_.current_limit_a),
                   options_.current_step_a),
         quantised(std::clamp(voltage, options_.voltage_floor_v, options_.voltage_ceiling_v),
                   options_.voltage_step_v)});
  }
  return withDropouts(samples);
}

std::vector<RecordedSample> Acquisition::withDropouts(
    const std::vector<RecordedSample>& samples) const {
  if (options_.lost_share == 0.0 && options_.frozen_per_min == 0.0) return samples;
  Dice dice(seed_, kDropoutStream);
  const double starts = options_.frozen_per_min / (kSecondsPerMinute * options_.sample_rate_hz);
  std::vector<RecordedSample> kept;
  RecordedSample last = samples.empty() ? RecordedSample{} : samples.front();
  double frozen_until = -1.0;
  for (const RecordedSample& sample : samples) {
    const bool lost = dice.share() < options_.lost_share;
    if (dice.share() < starts && sample.time >= frozen_until)
      frozen_until = sample.time + dice.between(options_.frozen_s);
    if (sample.time >= frozen_until) last = sample;
    if (!lost) kept.push_back({sample.time, last.current, last.voltage});
  }
  return kept;
}

}  // namespace battery_sof_simulator
