#include "simulator/out_of_model_case.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "simulator/increasing_root.hpp"
#include "simulator/out_of_model_drive.hpp"

namespace battery_sof_reference {
namespace {

constexpr std::uint32_t kOrderStream = 20, kBaseStream = 21, kDriveStream = 22, kForceStream = 23,
                        kRecorderStream = 24, kVoltageStream = 25, kCurrentStream = 26;
constexpr std::uint64_t kNextAttempt = 0x9E3779B97F4A7C15u;  // golden ratio: seeds far apart
constexpr int kMaxAttempts = 20, kMaxSteps = 6, kMaxRecorders = 12;
constexpr double kStep = OutOfModelBattery::kStep;
constexpr double kNear = 0.2;  // relative, of the visible RMS wanted
// beyond, a form's constants would be absurd
constexpr Range kStrength{0.03, 4.0};
constexpr double kMaxVisible = 80e-3;                   // [V]
constexpr double kHoldoutShare = 0.4;                   // of the training part's visible RMS
constexpr double kShortest = 120.0, kLongest = 7200.0;  // [s]
constexpr double kReferenceSoc = 0.8;                   // of BatteryParameters::u0_v
constexpr double kCrankCurrent = -100.0;                // [A]
constexpr char kInstrument[] = "instrument";

template <typename Choices>
auto chosen(const Choices& choices, Dice& dice) {
  return choices[static_cast<std::size_t>(dice.share() * static_cast<double>(choices.size()))];
}

std::vector<std::string> mechanismsOf(const std::vector<OutOfModelKind>& kinds) {
  std::vector<std::string> mechanisms;
  for (const OutOfModelKind& one : kinds)
    if (one.kind == "other_form" && (mechanisms.empty() || mechanisms.back() != one.mechanism))
      mechanisms.push_back(one.mechanism);
  return mechanisms;
}

std::vector<OutOfModelKind> fitting(const OutOfModelOrder& order) {
  std::vector<OutOfModelKind> fits;
  for (const OutOfModelKind& one : outOfModelKinds()) {
    const bool mechanism = order.mechanism.empty() || order.mechanism == one.mechanism;
    const bool form = order.form.empty() || order.form == one.form;
    if (one.kind == order.kind && mechanism && form) fits.push_back(one);
  }
  return fits;
}

void requireSound(const OutOfModelOrder& order) {
  if (fitting(order).empty())
    throw std::invalid_argument("nothing is \"" + order.kind + " " + order.mechanism + " " +
                                order.form + "\"; --list names what there is");
  if (!std::isfinite(order.scale) || order.scale < 0.0)
    throw std::invalid_argument("scale is " + std::to_string(order.scale) + ", expected 0 or more");
  if (order.duration && !(*order.duration >= kShortest && *order.duration <= kLongest))
    throw std::invalid_argument("duration is " + std::to_string(*order.duration) +
                                " s, expected 120 to 7200");
  if (!order.rate) return;
  const double ratio = 1.0 / (kStep * *order.rate);
  if (!(ratio >= 1.0 && ratio <= 1000.0) || std::abs(ratio - std::round(ratio)) > 1e-9)
    throw std::invalid_argument("rate is " + std::to_string(*order.rate) +
                                " Hz, expected 1000 over a whole number, 1 to 1000");
}

/// What the order leaves open, chosen mechanism first so that each mechanism is as likely.
OutOfModelOrder filledIn(OutOfModelOrder order, Dice& dice) {
  const double mechanism = dice.share(), rate = dice.share();
  const double duration = std::round(logBetween(dice, {600.0, 3600.0}));
  const std::string drive = chosen(outOfModelDrives(), dice);
  if (order.mechanism.empty() && order.form.empty() && order.kind == "other_form") {
    const auto mechanisms = mechanismsOf(outOfModelKinds());
    order.mechanism =
        mechanisms[static_cast<std::size_t>(mechanism * static_cast<double>(mechanisms.size()))];
  }
  const OutOfModelKind kind = chosen(fitting(order), dice);
  order.mechanism = kind.mechanism;
  order.form = kind.form;
  if (order.drive.empty()) order.drive = drive;
  if (!order.rate) order.rate = rate < 0.3 ? 1.0 : rate < 0.65 ? 10.0 : 100.0;
  if (!order.duration) order.duration = duration;
  return order;
}

/// Base parameters of blocks of 30 to 100 Ah, new to old; side reactions need a full one.
Scenario drawScenario(const OutOfModelOrder& order, std::uint64_t seed, Dice& dice) {
  Scenario s;
  s.name = order.kind;
  s.seed = seed;
  s.duration = *order.duration;
  s.effects = plainCircuit();
  const bool full = order.mechanism == "side_reactions";
  const double r_discharge = logBetween(dice, {2.5e-3, 12e-3});
  const double r_charge = r_discharge * dice.between({0.9, 1.8});
  s.battery.r_ohmic_ohm = 0.4 * std::min(r_discharge, r_charge);
  s.battery.r1_discharge_ohm = r_discharge - s.battery.r_ohmic_ohm;
  s.battery.r1_charge_ohm = r_charge - s.battery.r_ohmic_ohm;
  s.battery.cpe2_capacitance_f = logBetween(dice, {300.0, 3000.0});
  s.battery.beta_per_v = full ? logBetween(dice, {8.0, 18.0}) : logBetween(dice, {12.0, 40.0});
  s.battery.u0_v = full ? dice.between({12.8, 13.1}) : dice.between({12.3, 12.95});
  s.start.soc = kReferenceSoc;
  return s;
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

Circumstances circumstancesOf(const Scenario& scenario, double rate,
                              const std::vector<double>& current) {
  const auto per_sample = static_cast<std::size_t>(std::lround(0.1 / kStep));
  const BaseAnswer base = baseAnswer(scenario, current, per_sample);
  std::vector<double> charging;
  Circumstances c;
  c.duration = scenario.duration;
  c.sample_rate_hz = rate;
  c.lowest_as = c.highest_as = c.throughput_as = 0.0;
  double charge = 0.0;
  for (std::size_t n = 0; n < current.size(); ++n) {
    charge += kStep * current[n];
    c.throughput_as += kStep * std::abs(current[n]);
    c.lowest_as = std::min(c.lowest_as, charge);
    c.highest_as = std::max(c.highest_as, charge);
    if (n % per_sample == 0 && current[n] > 1.0)
      charging.push_back(scenario.battery.u0_v + base.u2[n / per_sample]);
  }
  c.onset_low_v = quantile(charging, 0.4);
  c.onset_high_v = quantile(charging, 0.75);
  return c;
}

/// A form with what it needs, at any strength.
struct OutOfModel {
  std::unique_ptr<OutOfModelVoltage> force;
  std::unique_ptr<OutOfModelInstrument> instrument;
  double max_strength = kStrength.high;
};

OutOfModel drawOutOfModel(const OutOfModelOrder& order, const Circumstances& drive, Dice& dice) {
  OutOfModel out_of_model;
  if (order.mechanism == kInstrument) {
    for (const auto& form : outOfModelInstrumentForms())
      if (form.id == order.form) {
        out_of_model.instrument = form.draw(dice, drive);
        out_of_model.max_strength = form.max_strength;
      }
    return out_of_model;
  }
  for (const auto& form : outOfModelForms())
    if (form.mechanism == order.mechanism && form.id == order.form)
      out_of_model.force = form.draw(dice, drive);
  return out_of_model;
}

/// Clean samples of a course, every per_sample entries.
std::vector<RecordedSample> sampled(const Course& course, std::size_t per_sample) {
  std::vector<RecordedSample> samples;
  for (std::size_t n = 0; n < course.current.size(); n += per_sample)
    samples.push_back({static_cast<double>(n) * kStep, course.current[n], course.voltage[n]});
  return samples;
}

/// How far samples lie from the base circuit under the current they show.
ErrorSize sizeOf(const Scenario& scenario, const std::vector<RecordedSample>& samples,
                 std::size_t per_sample) {
  std::vector<double> current((samples.size() - 1) * per_sample + 1), error;
  for (std::size_t n = 0; n < current.size(); ++n) {
    const std::size_t k = n / per_sample, next = std::min(k + 1, samples.size() - 1);
    const double share = static_cast<double>(n % per_sample) / static_cast<double>(per_sample);
    current[n] = samples[k].current + share * (samples[next].current - samples[k].current);
  }
  const BaseAnswer base = baseAnswer(scenario, current, per_sample);
  for (std::size_t k = 0; k < samples.size(); ++k)
    error.push_back(samples[k].voltage - base.voltage[k]);
  return errorSize(error, base);
}

void setSize(OutOfModelCase& one, const ErrorSize& size) {
  one.effect = size.plain;
  one.visible = size.visible;
  one.crank_v = size.crank_v;
}

std::size_t perSample(const OutOfModelOrder& order) {
  return static_cast<std::size_t>(std::lround(1.0 / (kStep * *order.rate)));
}

/// Clean samples at a strength: source, limit and force together, then linear between samples.
std::vector<RecordedSample> cleanSamples(const OutOfModelCase& one, const OutOfModel& out_of_model,
                                         double strength) {
  const std::size_t per_sample = perSample(one.order);
  const OutOfModelVoltage* force = out_of_model.force.get();
  const Course driven = drivenCourse(one.scenario, force, strength);
  Course course = controlledCourse(one.scenario, force, strength,
                                   linearBetweenSamples(driven.current, per_sample));
  if (out_of_model.instrument) course = out_of_model.instrument->shown(course, strength);
  std::vector<RecordedSample> samples = sampled(course, per_sample);
  while (samples.back().time > one.scenario.duration - 0.5 * kStep) samples.pop_back();
  return samples;
}

/// Searches the strength whose visible RMS is wanted; whether what it came to will do.
bool findStrength(OutOfModelCase& one, const OutOfModel& out_of_model, double wanted,
                  double least) {
  double strength = 1.0;
  for (int step = 0; step < kMaxSteps; ++step) {
    one.samples = cleanSamples(one, out_of_model, strength);
    const ErrorSize size = sizeOf(one.scenario, one.samples, perSample(one.order));
    one.strength = strength;
    setSize(one, size);
    const double ratio = wanted / std::max(size.visible.training, 1e-9);
    const double next = std::clamp(strength * std::clamp(ratio, 0.1, 10.0), kStrength.low,
                                   out_of_model.max_strength);
    if (std::abs(ratio - 1.0) < kNear || next == strength) break;
    strength = next;
  }
  return one.visible.training >= least && one.visible.training <= kMaxVisible &&
         one.visible.holdout >= kHoldoutShare * one.visible.training;
}

double rounded(double value, double step) {
  return step > 0.0 ? step * std::round(value / step) : value;
}

void addNoise(OutOfModelCase& one) {
  const double interval = 1.0 / *one.order.rate;
  ChannelNoise voltage(one.voltage_noise, interval, Dice(one.order.seed, kVoltageStream));
  ChannelNoise current(one.current_noise, interval, Dice(one.order.seed, kCurrentStream));
  for (RecordedSample& sample : one.samples) {
    sample.voltage = rounded(sample.voltage + voltage.next(), one.voltage_step_v);
    sample.current = rounded(sample.current + current.next(), one.current_step_a);
  }
}

void makeNull(OutOfModelCase& one, Dice& dice) {
  one.voltage_noise.white = dice.between({2e-3, 5e-3});
  one.samples = cleanSamples(one, {}, 0.0);
  addNoise(one);
}

/// Shows a course through one more recorder; whether it is as good as real ones are.
bool seenThrough(OutOfModelCase& one, const ImperfectRecorder& recorder, const Course& truth) {
  const std::size_t per_sample = perSample(one.order);
  const auto seen = [&](bool noise, bool steps) {
    auto samples = recordedThrough(recorder, truth, per_sample, one.order.seed, {noise, steps});
    samples.pop_back();  // stamped at the end of the drive
    return samples;
  };
  const ErrorSize left = sizeOf(one.scenario, seen(false, false), per_sample);
  if (left.visible.training > kMaxImperfection || left.crank_v > kMaxCrankImperfection)
    return false;
  const double all = sizeOf(one.scenario, seen(false, true), per_sample).visible.training;
  setSize(one, left);
  one.steps_rms_v =
      std::sqrt(std::max(0.0, all * all - left.visible.training * left.visible.training));
  one.samples = seen(true, true);
  one.voltage_noise = recorder.voltage.noise;
  one.current_noise = recorder.current.noise;
  one.voltage_step_v = recorder.voltage.step;
  one.current_step_a = recorder.current.step;
  one.recorder = recorder;
  return true;
}

bool makeImperfectNull(OutOfModelCase& one, Dice& dice) {
  const Course driven = drivenCourse(one.scenario, nullptr, 0.0);
  const Course truth = controlledCourse(one.scenario, nullptr, 0.0,
                                        linearBetweenSamples(driven.current, perSample(one.order)));
  for (int draw = 0; draw < kMaxRecorders; ++draw)
    if (seenThrough(one, drawRecorder(*one.order.rate, one.scenario.duration, dice), truth))
      return true;
  return false;
}

bool makeOtherForm(OutOfModelCase& one, Dice& force, Dice& dice) {
  one.voltage_noise.white = dice.between({0.5e-3, 2e-3});
  one.current_noise.white = dice.between({0.01, 0.05});
  one.voltage_step_v = 1e-3;
  one.current_step_a = 0.01;
  const double least = std::max(kVisible.low, kMinOverNoise * one.voltage_noise.white);
  const double wanted = logBetween(dice, {1.2 * least, kVisible.high});
  const Course driven = drivenCourse(one.scenario, nullptr, 0.0);
  const OutOfModel out_of_model = drawOutOfModel(
      one.order, circumstancesOf(one.scenario, *one.order.rate, driven.current), force);
  if (!findStrength(one, out_of_model, wanted, least)) return false;
  if (one.order.scale != 1.0) {
    one.strength *= one.order.scale;
    one.samples = cleanSamples(one, out_of_model, one.strength);
    const ErrorSize size = sizeOf(one.scenario, one.samples, perSample(one.order));
    setSize(one, size);
  }
  addNoise(one);
  return true;
}

bool make(OutOfModelCase& one, std::uint64_t seed) {
  Dice base(seed, kBaseStream), drive(seed, kDriveStream), force(seed, kForceStream),
      recorder(seed, kRecorderStream);
  one.scenario = drawScenario(one.order, seed, base);
  drawOutOfModelDrive(one.scenario, one.order.drive, one.order.mechanism, drive);
  if (one.order.kind == "other_form") return makeOtherForm(one, force, recorder);
  if (one.order.kind == "imperfect_null") return makeImperfectNull(one, recorder);
  makeNull(one, recorder);
  return true;
}

double rms(const Eigen::VectorXd& values) {
  return values.size() > 0 ? std::sqrt(values.squaredNorm() / static_cast<double>(values.size()))
                           : 0.0;
}

SplitRms split(const Eigen::VectorXd& values, Eigen::Index training) {
  return {rms(values.head(training)), rms(values.tail(values.size() - training))};
}

/// The largest difference of minima over a stretch of crank current, over all stretches [V].
double crankShift(const std::vector<double>& error, const BaseAnswer& base) {
  double largest = 0.0, lowest = kNoLimit, lowest_base = kNoLimit;
  for (std::size_t n = 0; n <= error.size(); ++n) {
    const bool cranking = n < error.size() && base.columns[n][2] <= kCrankCurrent;
    if (cranking) {
      lowest = std::min(lowest, base.voltage[n] + error[n]);
      lowest_base = std::min(lowest_base, base.voltage[n]);
    } else if (lowest_base < kNoLimit) {
      largest = std::max(largest, std::abs(lowest - lowest_base));
      lowest = lowest_base = kNoLimit;
    }
  }
  return largest;
}

}  // namespace

ErrorSize errorSize(const std::vector<double>& error, const BaseAnswer& base) {
  const auto count = static_cast<Eigen::Index>(error.size());
  if (count < 1 || error.size() > base.columns.size())
    throw std::invalid_argument("errorSize: no errors, or more than the base circuit has rows");
  const auto training = static_cast<Eigen::Index>(kTrainingShare * static_cast<double>(count));
  const Eigen::VectorXd e = Eigen::Map<const Eigen::VectorXd>(error.data(), count);
  Eigen::MatrixXd columns(count, 6);
  for (Eigen::Index n = 0; n < count; ++n)
    for (Eigen::Index k = 0; k < 6; ++k)
      columns(n, k) = base.columns[static_cast<std::size_t>(n)][static_cast<std::size_t>(k)];
  const Eigen::VectorXd moved =
      columns.topRows(training).colPivHouseholderQr().solve(e.head(training));
  const double mean = e.head(training).mean();
  return {split(e.array() - mean, training), split(e - columns * moved, training),
          crankShift(error, base)};
}

std::vector<OutOfModelKind> outOfModelKinds() {
  std::vector<OutOfModelKind> kinds{{"null", "-", "-"}, {"imperfect_null", "-", "-"}};
  for (const auto& form : outOfModelForms())
    kinds.push_back({"other_form", form.mechanism, form.id});
  for (const auto& form : outOfModelInstrumentForms())
    kinds.push_back({"other_form", kInstrument, form.id});
  return kinds;
}

OutOfModelCase drawOutOfModelCase(const OutOfModelOrder& order) {
  requireSound(order);
  Dice dice(order.seed, kOrderStream);
  OutOfModelCase one;
  one.order = filledIn(order, dice);
  for (; one.attempt < kMaxAttempts; ++one.attempt) {
    const auto times = static_cast<std::uint64_t>(one.attempt);
    if (make(one, order.seed + times * kNextAttempt)) return one;
  }
  throw NoSolution("no draw of " + one.order.kind + " " + one.order.mechanism + " " +
                   one.order.form + " could be used");
}

}  // namespace battery_sof_reference
