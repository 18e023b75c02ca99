#include "simulator/generator/imperfect_recorder.hpp"

#include <stdexcept>

#include "simulator/fields.hpp"
#include "simulator/generator/series.hpp"

namespace battery_sof_simulator {
namespace {

constexpr double kStep = FullBattery::kStep;  // [s]
constexpr int kBesselPoles = 8;
constexpr double kCornersApart = 2.0;  // at most, of the two channels' filters
constexpr std::uint32_t kVoltageStream = 31, kCurrentStream = 32, kJitterStream = 33;

/// Equal real poles in a row.
struct PoleCascade {
  PoleCascade(int count, double corner_hz)
      : tau(std::sqrt(std::exp2(1.0 / count) - 1.0) / (2.0 * kPi * corner_hz)),
        poles(static_cast<std::size_t>(count), Lag{{tau, kStep}}) {}
  double push(double input) {
    for (Lag& pole : poles) input = pole.push(input);
    return input;
  }
  double delay() const { return tau * static_cast<double>(poles.size()); }

  double tau;
  std::vector<Lag> poles;
};

double converted(const ImperfectChannel& channel, double value) {
  if (channel.step <= 0.0) return value;
  const double turn = 2.0 * kPi * value / (channel.step * channel.bow_period_steps);
  const double bowed =
      value + channel.step * channel.bow_steps * std::sin(turn + channel.bow_phase);
  return quantised(bowed, channel.step);
}

/// One channel's samples behind its filter, unconverted and without noise.
template <typename Filter>
std::vector<double> lookedThrough(Filter filter, const ImperfectChannel& channel,
                                  const std::vector<double>& truth,
                                  const std::vector<double>& instants, std::size_t per_sample) {
  std::vector<double> seen, samples;
  seen.reserve(truth.size());
  for (double value : truth) seen.push_back(filter.push(value));
  const double lead = filter.delay() * (1.0 - channel.late_share) / kStep;
  for (double instant : instants)
    samples.push_back(valueAt(seen, instant * static_cast<double>(per_sample) + lead));
  return samples;
}

std::vector<double> looked(const ImperfectChannel& channel, const std::vector<double>& truth,
                           const std::vector<double>& instants, std::size_t per_sample) {
  if (channel.poles < 1 || channel.poles > kBesselPoles)
    throw std::invalid_argument("poles is " + std::to_string(channel.poles) + ", expected 1 to 8");
  if (!(channel.corner_hz >= 0.1 && channel.corner_hz <= 400.0))
    throw std::invalid_argument(faultOf("corner_hz", channel.corner_hz, "0.1 to 400"));
  if (channel.poles < kBesselPoles)
    return lookedThrough(PoleCascade(channel.poles, channel.corner_hz), channel, truth, instants,
                         per_sample);
  BesselFilter bessel(channel.corner_hz, 1.0 / kStep);
  bessel.settle(truth.front());
  return lookedThrough(bessel, channel, truth, instants, per_sample);
}

/// @param corner_hz lowest and highest corner [Hz].
ImperfectChannel drawChannel(const Range& corner_hz, Dice& dice) {
  ImperfectChannel channel;
  channel.poles = dice.oneOf(std::array{1, 2, 3, 4, kBesselPoles});
  channel.corner_hz = dice.logBetween(corner_hz);
  channel.late_share = dice.between({-0.05, 0.05});
  channel.bow_steps = dice.between({0.2, 0.5});
  channel.bow_period_steps = dice.logBetween({20.0, 500.0});
  channel.bow_phase = dice.between({0.0, 2.0 * kPi});
  return channel;
}

SmoothTerm drawTerm(double duration, Dice& dice) {
  SmoothTerm term;
  term.kind = static_cast<int>(3.0 * dice.share());
  term.memory = dice.logBetween({term.kind == 2 ? 20.0 : 0.3, 0.5 * duration});
  term.scale = dice.logBetween({2.0, 60.0});
  term.phase = dice.between({0.0, 2.0 * kPi});
  term.weight = dice.normal();
  return term;
}

}  // namespace

ImperfectRecorder drawRecorder(double rate, double duration, Dice& dice) {
  ImperfectRecorder r;
  r.voltage = drawChannel({std::max(8.0, 0.2 * rate), std::max(40.0, 0.5 * rate)}, dice);
  const double corner = r.voltage.corner_hz;
  const Range near{corner / kCornersApart, corner * kCornersApart};
  r.current = dice.share() < 0.5 ? drawChannel(near, dice) : r.voltage;
  r.voltage.step = dice.logBetween({0.5e-3, 5e-3});
  r.current.step = dice.logBetween({10e-3, 100e-3});
  r.jitter_apart_share = dice.logBetween({0.005, 0.05});  // a converter takes turns in milliseconds
  r.voltage.ripple = dice.between({0.1e-3, 1e-3});
  r.current.ripple = dice.between({0.01, 0.1});
  r.ripple_hz = dice.logBetween({20.0, 480.0});
  // docs/physics.md#imperfect-recorders: up to 2 mV over 2 s and 0.6 mV a root minute.
  r.voltage.noise = {dice.between({0.3e-3, 1.5e-3}), dice.between({0.5e-3, 2e-3}),
                     dice.logBetween({1.0, 4.0}), dice.between({0.1e-3, 0.6e-3})};
  r.current.noise = {dice.between({0.01, 0.06}), 0.0, 2.0, 0.0};
  const int terms = 3 + static_cast<int>(4.0 * dice.share());
  for (int k = 0; k < terms; ++k) r.smooth.push_back(drawTerm(duration, dice));
  r.smooth_rms_v = dice.logBetween({0.01e-3, 0.5e-3});
  return r;
}

SampleInstants jitteredInstants(const ImperfectRecorder& recorder, std::size_t samples,
                                std::uint64_t seed) {
  Dice dice(seed, kJitterStream);
  const double apart = recorder.jitter_share * std::sqrt(recorder.jitter_apart_share);
  const double shared = recorder.jitter_share * std::sqrt(1.0 - recorder.jitter_apart_share);
  SampleInstants instants;
  for (std::size_t n = 0; n < samples; ++n) {
    const double both = static_cast<double>(n) + shared * dice.normal();
    instants.voltage.push_back(both + apart * dice.normal());
    instants.current.push_back(both + apart * dice.normal());
  }
  return instants;
}

std::vector<double> smoothStructure(const ImperfectRecorder& recorder,
                                    const std::vector<double>& current) {
  std::vector<double> sum(current.size(), 0.0);
  for (const SmoothTerm& term : recorder.smooth) {
    double remembered = current.front();
    for (std::size_t n = 0; n < current.size(); ++n) {
      remembered += kStep / term.memory * (current[n] - remembered);
      const double x = remembered / term.scale;
      const double turn = 2.0 * kPi * static_cast<double>(n) * kStep / term.memory + term.phase;
      sum[n] += term.weight * (term.kind == 0   ? std::sin(x)
                               : term.kind == 1 ? std::tanh(x)
                                                : std::sin(turn));
    }
  }
  double mean = 0.0, square = 0.0;
  for (double value : sum) mean += value / static_cast<double>(sum.size());
  for (double value : sum)
    square += (value - mean) * (value - mean) / static_cast<double>(sum.size());
  const double scale = square > 0.0 ? recorder.smooth_rms_v / std::sqrt(square) : 0.0;
  for (double& value : sum) value = scale * (value - mean);
  return sum;
}

std::vector<RecordedSample> recordedThrough(const ImperfectRecorder& recorder, const Course& truth,
                                            std::size_t per_sample, std::uint64_t seed,
                                            const ActingParts& acting) {
  const std::size_t count = (truth.current.size() - 1) / per_sample + 1;
  const double interval = kStep * static_cast<double>(per_sample);
  const SampleInstants instants = jitteredInstants(recorder, count, seed);
  std::vector<double> shown = truth.voltage;
  const std::vector<double> smooth = smoothStructure(recorder, truth.current);
  for (std::size_t n = 0; n < shown.size(); ++n) shown[n] += smooth[n];
  const auto voltage = looked(recorder.voltage, shown, instants.voltage, per_sample);
  const auto current = looked(recorder.current, truth.current, instants.current, per_sample);
  ChannelNoise voltage_noise(recorder.voltage.noise, interval, Dice(seed, kVoltageStream));
  ChannelNoise current_noise(recorder.current.noise, interval, Dice(seed, kCurrentStream));
  std::vector<RecordedSample> samples;
  for (std::size_t n = 0; n < count; ++n) {
    double u = voltage[n], i = current[n];
    if (acting.noise) {
      const double wave = std::sin(2.0 * kPi * recorder.ripple_hz * instants.voltage[n] * interval);
      u += recorder.voltage.ripple * wave + voltage_noise.next();
      i += recorder.current.ripple * wave + current_noise.next();
    }
    samples.push_back({static_cast<double>(n) * interval, converted(recorder.current, i),
                       acting.steps ? converted(recorder.voltage, u) : u});
  }
  return samples;
}

}  // namespace battery_sof_simulator
