#include "reference/acquisition.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "reference/fields.hpp"

namespace battery_sof_reference {
namespace {

constexpr std::uint32_t kVoltageStream = 2, kCurrentStream = 3;
constexpr double kInterpolationReach =
    1.0;  // inputs after a point, which then lies in the cubic's middle
constexpr double kSecondsPerMinute = 60.0;
constexpr double kHighestRate = 1000.0;  // [Hz], of the simulation

/// The noise of one channel, sample by sample.
class Noise {
 public:
  Noise(const NoiseOptions& options, double interval, Dice dice)
      : options_(options),
        memory_(std::exp(-interval / options.correlation_time)),
        walk_step_(options.walk_per_sqrt_min * std::sqrt(interval / kSecondsPerMinute)),
        dice_(dice),
        correlated_(options.correlated * dice_.normal()) {}

  double next() {
    const double now = options_.white * dice_.normal() + correlated_ + walk_;
    correlated_ = memory_ * correlated_ +
                  options_.correlated * std::sqrt(1.0 - memory_ * memory_) * dice_.normal();
    walk_ += walk_step_ * dice_.normal();
    return now;
  }

 private:
  NoiseOptions options_;
  double memory_, walk_step_;
  Dice dice_;
  double correlated_;
  double walk_ = 0.0;
};

double quantised(double value, double step) {
  return step > 0.0 ? step * std::round(value / step) : value;
}

const AcquisitionOptions& valid(const AcquisitionOptions& options) {
  std::string text;
  for (const auto& fault : faultsOf(options)) text += (text.empty() ? "" : "; ") + fault;
  if (!text.empty()) throw std::invalid_argument("acquisition: " + text);
  return options;
}

}  // namespace

std::vector<std::string> faultsOf(const AcquisitionOptions& options) {
  auto faults = fieldFaults(options);
  const double ratio = kHighestRate / options.sample_rate_hz;
  if (std::abs(ratio - std::round(ratio)) > 1e-9)
    faults.push_back("sample_rate_hz is " + std::to_string(options.sample_rate_hz) +
                     ", expected 1000 divided by a whole number");
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
  const double output = filtered(value);
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

double SampledChannel::filtered(double value) {
  if (!filter_) return value;
  if (pushed_ == 0) filter_->settle(value);
  return filter_->push(value);
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
      current_(options, input_rate, options.current_delay_s),
      voltage_(options, input_rate, 0.0) {}

void Acquisition::push(double current, double voltage) {
  current_.push(options_.current_gain * current + options_.current_offset_a);
  voltage_.push(voltage);
}

double Acquisition::lookAhead() const {
  const double filter =
      options_.cutoff_hz > 0.0 ? BesselFilter(options_.cutoff_hz, kHighestRate).delay() : 0.0;
  return filter + std::max(0.0, -options_.current_delay_s) + 4.0 / kHighestRate;
}

std::vector<RecordedSample> Acquisition::recording(double duration) const {
  const double interval = 1.0 / options_.sample_rate_hz;
  Noise current_noise(options_.current_noise, interval, Dice(seed_, kCurrentStream));
  Noise voltage_noise(options_.voltage_noise, interval, Dice(seed_, kVoltageStream));
  const auto wanted = static_cast<std::size_t>(std::ceil(duration / interval - 1e-9));
  const std::size_t count =
      std::min({wanted, current_.samples().size(), voltage_.samples().size()});
  std::vector<RecordedSample> samples;
  samples.reserve(count);
  for (std::size_t n = 0; n < count; ++n)
    samples.push_back(
        {static_cast<double>(n) / options_.sample_rate_hz,
         quantised(current_.samples()[n] + current_noise.next(), options_.current_step_a),
         quantised(voltage_.samples()[n] + voltage_noise.next(), options_.voltage_step_v)});
  return samples;
}

}  // namespace battery_sof_reference
