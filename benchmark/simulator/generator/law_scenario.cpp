#include "simulator/generator/law_scenario.hpp"

#include <Eigen/Dense>
#include <stdexcept>

#include "simulator/generator/series.hpp"

namespace battery_sof_simulator {
namespace {

constexpr std::uint32_t kOrderStream = 20, kBaseStream = 21, kDriveStream = 22,
                        kRecorderStream = 24, kVoltageStream = 25, kCurrentStream = 26,
                        kIndependentStream = 27;
constexpr std::uint64_t kNextAttempt = 0x9E3779B97F4A7C15u;  // golden ratio: seeds far apart
constexpr int kMaxAttempts = 20, kMaxSteps = 6, kMaxRecorders = 12;
constexpr double kStep = LawBattery::kStep;
constexpr double kNear = 0.2;                          // relative, of the visible RMS wanted
constexpr double kMinStrength = 0.03;                  // below, a law's constants would be absurd
constexpr double kMaxVisible = 80e-3;                  // [V]
constexpr double kHoldoutShare = 0.4;                  // of the training part's visible RMS
constexpr double kShortest = 60.0, kLongest = 7200.0;  // [s]
constexpr double kCrankCurrent = -100.0;               // [A]

/// Mechanisms of laws, each once.
std::vector<std::string> mechanisms() {
  std::vector<std::string> all;
  for (const LawForm& law : lawForms())
    if (all.empty() || all.back() != law.mechanism) all.push_back(law.mechanism);
  return all;
}

void requireLawOrder(const Order& order) {
  requireSound(order, kShortest, kLongest);
  if (order.scale.size() != 1 || order.quiet)
    throw std::invalid_argument("--quiet and more than one --scale are for catalogue kinds");
  if (order.drive_seed && order.what.kind != kOutOfCatalogue)
    throw std::invalid_argument("--drive-seed is for out_of_catalogue");
  if (!order.rate) return;
  const double ratio = 1.0 / (kStep * *order.rate);
  if (!(ratio >= 1.0 && ratio <= 1000.0) || std::abs(ratio - std::round(ratio)) > 1e-9)
    throw std::invalid_argument("rate is " + std::to_string(*order.rate) +
                                " Hz, expected 1000 over a whole number, 1 to 1000");
}

/// What a battery and a drive are made for: a law's mechanism, or one of chance.
std::string exercisedBy(const Order& order, std::uint64_t seed) {
  if (!order.independent_drive) return order.what.mechanism;
  std::vector<std::string> all = mechanisms();
  all.push_back("-");
  return Dice(seed, kIndependentStream).oneOf(all);
}

/// What the order leaves open, chosen mechanism first so that each is as likely.
Order filledIn(Order order, Dice& dice) {
  const double mechanism = dice.share(), rate = dice.share();
  const double shortest = order.independent_drive ? kShortest : 600.0;
  const double duration = std::round(dice.logBetween({shortest, 3600.0}));
  const std::string drive = dice.oneOf(kLawDrives);
  if (order.what.mechanism.empty() && order.what.id.empty() && order.what.kind == kOutOfCatalogue) {
    const auto all = mechanisms();
    order.what.mechanism =
        all[static_cast<std::size_t>(mechanism * static_cast<double>(all.size()))];
  }
  order.what = dice.oneOf(meantBy(order.what));
  if (order.drive.empty()) order.drive = drive;
  if (!order.rate) order.rate = rate < 0.3 ? 1.0 : rate < 0.65 ? 10.0 : 100.0;
  if (!order.duration) order.duration = duration;
  return order;
}

/// Base parameters of blocks of 30 to 100 Ah, new to old; side reactions need a full one.
Scenario drawBase(const Order& order, bool full, std::uint64_t seed, Dice& dice) {
  Scenario s;
  s.name = order.what.kind;
  s.seed = seed;
  s.duration = *order.duration;
  s.effects = plainCircuit();
  const double r_discharge = dice.logBetween({2.5e-3, 12e-3});
  const double r_charge = r_discharge * dice.between({0.9, 1.8});
  setResistances(s.battery, r_discharge, r_charge);
  s.battery.cpe2_capacitance_f = dice.logBetween({300.0, 3000.0});
  s.battery.beta_per_v = full ? dice.logBetween({8.0, 18.0}) : dice.logBetween({12.0, 40.0});
  s.battery.u0_v = full ? dice.between({12.8, 13.1}) : dice.between({12.3, 12.95});
  s.start.soc = kReferenceSoc;
  return s;
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

/// How far samples lie from the base circuit under the current they show.
ErrorSize sizeOf(const Scenario& scenario, const std::vector<RecordedSample>& samples,
                 std::size_t per_sample) {
  std::vector<double> knots, error;
  for (const RecordedSample& sample : samples) knots.push_back(sample.current);
  const BaseAnswer base = baseAnswer(scenario, joined(knots, per_sample), per_sample);
  for (std::size_t k = 0; k < samples.size(); ++k)
    error.push_back(samples[k].voltage - base.voltage[k]);
  return errorSize(error, base);
}

std::size_t perSample(const Order& order) {
  return static_cast<std::size_t>(std::lround(1.0 / (kStep * *order.rate)));
}

/// Clean samples at a strength: source, limit and law together, then linear between samples.
std::vector<RecordedSample> cleanSamples(const LawScenario& one, const Law* law, double strength) {
  const std::size_t per_sample = perSample(one.order);
  const bool is_instrument = law != nullptr && law->shown;
  const Law* physics = is_instrument ? nullptr : law;
  const Course driven = drivenCourse(one.scenario, physics, strength);
  Course course = controlledCourse(one.scenario, physics, strength,
                                   linearBetweenSamples(driven.current, per_sample));
  if (is_instrument) course = law->shown(course, strength);
  std::vector<RecordedSample> samples;
  for (std::size_t n = 0; n < course.current.size(); n += per_sample)
    samples.push_back({static_cast<double>(n) * kStep, course.current[n], course.voltage[n]});
  while (samples.back().time > one.scenario.duration - 0.5 * kStep) samples.pop_back();
  return samples;
}

void useStrength(LawScenario& one, const Law& law, double strength) {
  one.strength = strength;
  one.samples = cleanSamples(one, &law, strength);
  one.size = sizeOf(one.scenario, one.samples, perSample(one.order));
}

/// Searches the strength whose visible RMS is wanted; whether what it came to will do.
bool findStrength(LawScenario& one, const Law& law, double wanted, double least) {
  double strength = 1.0;
  for (int step = 0; step < kMaxSteps; ++step) {
    useStrength(one, law, strength);
    const double ratio = wanted / std::max(one.size.visible.training, 1e-9);
    const double next =
        std::clamp(strength * std::clamp(ratio, 0.1, 10.0), kMinStrength, law.max_strength);
    if (std::abs(ratio - 1.0) < kNear || next == strength) break;
    strength = next;
  }
  return one.size.visible.training >= least && one.size.visible.training <= kMaxVisible &&
         one.size.visible.holdout >= kHoldoutShare * one.size.visible.training;
}

void addNoise(LawScenario& one) {
  const double interval = 1.0 / *one.order.rate;
  const std::uint64_t seed = one.order.drive_seed.value_or(one.order.seed);
  ChannelNoise voltage(one.voltage_noise, interval, Dice(seed, kVoltageStream));
  ChannelNoise current(one.current_noise, interval, Dice(seed, kCurrentStream));
  for (RecordedSample& sample : one.samples) {
    sample.voltage = quantised(sample.voltage + voltage.next(), one.voltage_step_v);
    sample.current = quantised(sample.current + current.next(), one.current_step_a);
  }
}

/// Shows a course through one more recorder; whether it is as good as real ones are.
bool seenThrough(LawScenario& one, const ImperfectRecorder& recorder, const Course& truth) {
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
  one.size = left;
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

bool makeRecorderControl(LawScenario& one, Dice& dice) {
  const Course driven = drivenCourse(one.scenario, nullptr, 0.0);
  const Course truth = controlledCourse(one.scenario, nullptr, 0.0,
                                        linearBetweenSamples(driven.current, perSample(one.order)));
  for (int draw = 0; draw < kMaxRecorders; ++draw)
    if (seenThrough(one, drawRecorder(*one.order.rate, one.scenario.duration, dice), truth))
      return true;
  return false;
}

/// The same battery in a drive of the drive seed, of a kind of chance.
void takeOtherDrive(LawScenario& one, std::uint64_t seed) {
  Dice base(seed, kBaseStream), drive(*one.order.drive_seed, kDriveStream);
  const std::string exercised = exercisedBy(one.order, seed);
  one.scenario = drawBase(one.order, exercised == "side_reactions", seed, base);
  one.order.drive = drive.oneOf(kLawDrives);
  drawLawDrive(one.scenario, one.order.drive, exercisedBy(one.order, *one.order.drive_seed), drive);
}

bool makeLaw(LawScenario& one, std::uint64_t seed, Dice& law_dice, Dice& dice) {
  one.voltage_noise.white = dice.between({0.5e-3, 2e-3});
  one.current_noise.white = dice.between({0.01, 0.05});
  one.voltage_step_v = 1e-3;
  one.current_step_a = 0.01;
  const double least = std::max(kVisible.low, kMinOverNoise * one.voltage_noise.white);
  const double wanted = dice.logBetween({1.2 * least, kVisible.high});
  const Course driven = drivenCourse(one.scenario, nullptr, 0.0);
  const Law law =
      lawNamed(one.order.what.mechanism, one.order.what.id)
          .draw(law_dice, circumstancesOf(one.scenario, *one.order.rate, driven.current));
  if (!findStrength(one, law, wanted, least)) return false;
  if (one.order.drive_seed) takeOtherDrive(one, seed);
  const double scale = one.order.scale.front();
  if (scale != 1.0 || one.order.drive_seed) useStrength(one, law, one.strength * scale);
  addNoise(one);
  return true;
}

bool make(LawScenario& one, std::uint64_t seed) {
  Dice base(seed, kBaseStream), drive(seed, kDriveStream), law(seed, kLawStream),
      recorder(seed, kRecorderStream);
  const std::string exercised = exercisedBy(one.order, seed);
  one.scenario = drawBase(one.order, exercised == "side_reactions", seed, base);
  drawLawDrive(one.scenario, one.order.drive, exercised, drive);
  if (one.order.what.kind == kOutOfCatalogue) return makeLaw(one, seed, law, recorder);
  if (one.order.what.kind == kRecorderControl) return makeRecorderControl(one, recorder);
  one.voltage_noise.white = recorder.between({2e-3, 5e-3});
  one.samples = cleanSamples(one, nullptr, 0.0);
  addNoise(one);
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
  const Eigen::MatrixXd columns =
      Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>>(
          base.columns.front().data(), count, 6);
  const Eigen::VectorXd moved =
      columns.topRows(training).colPivHouseholderQr().solve(e.head(training));
  const double mean = e.head(training).mean();
  return {split(e.array() - mean, training), split(e - columns * moved, training),
          crankShift(error, base)};
}

LawScenario drawLawScenario(const Order& order) {
  requireLawOrder(order);
  Dice dice(order.seed, kOrderStream);
  LawScenario one;
  one.order = filledIn(order, dice);
  for (; one.attempt < kMaxAttempts; ++one.attempt) {
    const auto times = static_cast<std::uint64_t>(one.attempt);
    if (make(one, order.seed + times * kNextAttempt)) return one;
  }
  const ScenarioKind& what = one.order.what;
  throw NoSolution("no draw of " + what.kind + " " + what.mechanism + " " + what.id +
                   " could be used");
}

}  // namespace battery_sof_simulator
