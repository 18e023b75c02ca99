#include "recording/resample.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <iterator>
#include <stdexcept>
#include <string>
#include <utility>

#include "util/constants.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

using Complex = std::complex<double>;
// more missing input samples than this are not bridged (gapThreshold)
constexpr double kGapIntervals = 10.0;

/// Poles above the real axis of the analogue 8th-order Bessel low-pass, -3 dB at 1 rad/s, the
/// fastest decaying first: roots of the reverse Bessel polynomial of order 8 by their half-power
/// frequency.
constexpr Complex kUpperPoles[] = {{-1.7574084004021158, 0.27286757509828596},
                                   {-1.6369394181261625, 0.82279562514164595},
                                   {-1.3738412176376416, 1.3883565758771372},
                                   {-0.8928697188471123, 1.9983258436413216}};

/// Bilinear transform of an analogue pole pair with two zeros at infinity, unit gain at 0 Hz.
Biquad sectionOf(const Complex& pole, double rate) {
  const Complex z = (2.0 * rate + pole) / (2.0 * rate - pole);
  const double a1 = -2.0 * z.real(), a2 = std::norm(z);
  const double gain = 0.25 * (1.0 + a1 + a2);
  return {gain, 2.0 * gain, gain, a1, a2};
}

/// On the line through two samples, not beyond the later one.
Sample between(const Sample& before, const Sample& after, double time) {
  const double span = after.time - before.time;
  const double weight = span > 0.0 ? std::min((time - before.time) / span, 1.0) : 1.0;
  return {time, before.current + weight * (after.current - before.current),
          before.voltage + weight * (after.voltage - before.voltage)};
}

}  // namespace

std::array<Biquad, 4> designBessel8(double cutoff, double rate) {
  if (!(rate > 0.0) || !(cutoff > 0.0) || !(cutoff < 0.5 * rate))
    throw std::invalid_argument("designBessel8: cutoff is " + std::to_string(cutoff) +
                                " Hz, expected within (0, rate / 2) for rate " +
                                std::to_string(rate) + " Hz");
  const double warped = 2.0 * rate * std::tan(kPi * cutoff / rate);
  std::array<Biquad, 4> sections{};
  std::transform(std::begin(kUpperPoles), std::end(kUpperPoles), sections.begin(),
                 [&](const Complex& pole) { return sectionOf(warped * pole, rate); });
  return sections;
}

double groupDelayAtZero(const std::array<Biquad, 4>& sections, double rate) {
  double samples = 0.0;
  for (const Biquad& s : sections)
    samples +=
        (s.b1 + 2.0 * s.b2) / (s.b0 + s.b1 + s.b2) - (s.a1 + 2.0 * s.a2) / (1.0 + s.a1 + s.a2);
  return samples / rate;
}

Decimator::Decimator(double input_rate) : input_rate_(input_rate) {
  requireThat(input_rate >= 2.0 * kDesignRate, "Decimator: input rate [Hz]", input_rate,
              "at least twice the design rate of 100 Hz");
  sections_ = designBessel8(kDesignCutoff, input_rate);
  delay_ = groupDelayAtZero(sections_, input_rate);
}

double Decimator::filter(Channel& channel, double value) const {
  for (std::size_t k = 0; k < sections_.size(); ++k) {
    const Biquad& s = sections_[k];
    auto& [x1, x2, y1, y2] = channel[k];
    const double y = s.b0 * value + s.b1 * x1 + s.b2 * x2 - s.a1 * y1 - s.a2 * y2;
    x2 = std::exchange(x1, value);
    y2 = std::exchange(y1, y);
    value = y;
  }
  return value;
}

void Decimator::startAt(const Sample& sample) {
  for (auto& section : current_channel_) section.fill(sample.current);
  for (auto& section : voltage_channel_) section.fill(sample.voltage);
  start_ = sample.time;
  inputs_ = 0;
  outputs_ = 0;
  filtered_ = sample;
}

void Decimator::advance(const Sample& input, std::vector<Sample>& due) {
  const Sample filtered{input.time, filter(current_channel_, input.current),
                        filter(voltage_channel_, input.voltage)};
  for (double stamp = outputStamp(); isReached(stamp + delay_, filtered.time);
       stamp = outputStamp()) {
    due.push_back(between(filtered_, filtered, stamp + delay_));
    due.back().time = stamp;
    ++outputs_;
  }
  filtered_ = filtered;
}

bool Decimator::isReached(double time, double now) const {
  // A thousandth of an interval: stamps of 1e9 s are only known to 0.2 us.
  return time <= now + 1e-3 / input_rate_;
}

double Decimator::inputTime() const { return start_ + static_cast<double>(inputs_) / input_rate_; }

double Decimator::outputStamp() const {
  return start_ + static_cast<double>(outputs_) / kDesignRate;
}

std::vector<Sample> Decimator::push(const Sample& sample) {
  const auto [time, current, voltage] = sample;
  if (!std::isfinite(time) || !std::isfinite(current) || !std::isfinite(voltage) ||
      (previous_ && time <= previous_->time))
    throw std::invalid_argument("Decimator: sample (" + std::to_string(time) + " s, " +
                                std::to_string(current) + " A, " + std::to_string(voltage) +
                                " V) is not finite or not after the one before");
  const bool gap = !previous_ || time - previous_->time > kGapIntervals / input_rate_;
  if (gap) startAt(sample);
  const Sample before = gap ? sample : *previous_;
  std::vector<Sample> due;
  for (; isReached(inputTime(), time); ++inputs_)
    advance(between(before, sample, inputTime()), due);
  previous_ = sample;
  return due;
}

Series atDesignRate(const Series& series) {
  const double interval = medianInterval(series);
  if (!(interval > 0.0 && interval < 0.5 / kDesignRate)) return series;
  Decimator decimator(1.0 / interval);
  Series result;
  for (std::size_t k = 0; k < series.size(); ++k)
    for (const Sample& output : decimator.push(series[k])) result.append(output);
  result.temperature_time = series.temperature_time;
  result.temperature = series.temperature;
  return result;
}

}  // namespace battery_sof
