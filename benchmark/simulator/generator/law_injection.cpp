#include "simulator/generator/law_injection.hpp"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <stdexcept>

#include "simulator/fields.hpp"
#include "simulator/generator/law_scenario.hpp"
#include "simulator/generator/series.hpp"

namespace battery_sof_simulator {
namespace {

constexpr double kStep = LawBattery::kStep;
constexpr double kGap = 3.0;  // times the median interval
constexpr char kHeader[] = "time_s,current_a,voltage_v";

/// A recording on steps of kStep: where each sample stands, and what is known between them.
struct Grid {
  const std::vector<RecordedSample>& samples;
  std::vector<long> steps;  ///< since the first sample
  double interval = 0.0;    ///< median [s]

  explicit Grid(const std::vector<RecordedSample>& measured) : samples(measured), steps{0} {
    std::vector<double> passed;
    for (std::size_t n = 1; n < samples.size(); ++n) {
      passed.push_back(std::max(0.0, samples[n].time - samples[n - 1].time));
      steps.push_back(steps.back() + std::lround(passed.back() / kStep));
    }
    interval = quantile(passed, 0.5);
  }
  double duration() const { return static_cast<double>(steps.back()) * kStep; }
  bool isGap(std::size_t to) const {
    return static_cast<double>(steps[to] - steps[to - 1]) * kStep > kGap * interval;
  }
  /// Value of a quantity at a step between sample `to` and the one before it.
  double between(std::size_t to, long step, double RecordedSample::*of) const {
    const double share = static_cast<double>(step - steps[to - 1]) /
                         static_cast<double>(std::max(1L, steps[to] - steps[to - 1]));
    return samples[to - 1].*of + share * (samples[to].*of - samples[to - 1].*of);
  }
  double current(std::size_t to, long step) const {
    if (isGap(to) && step < steps[to]) return 0.0;
    return between(to, step, &RecordedSample::current);
  }
};

Scenario scenarioOf(const InjectionOrder& order, double duration) {
  Scenario s;
  s.duration = duration;
  s.effects = plainCircuit();
  setResistances(s.battery, order.r_discharge, order.r_charge);
  s.start.soc = kReferenceSoc;
  return s;
}

/// The state of a battery at every sample of a recording's current.
template <typename Look>
void follow(const Grid& grid, const LawBattery& battery, const Look& look) {
  LawState state = battery.rested();
  if (grid.samples[0].current != 0.0) state = battery.advance(state, grid.samples[0].current);
  look(0, state);
  for (std::size_t to = 1; to < grid.samples.size(); ++to) {
    for (long step = grid.steps[to - 1] + 1; step <= grid.steps[to]; ++step)
      state = battery.advance(state, grid.current(to, step));
    look(to, state);
  }
}

/// The base circuit's voltage at every sample, and what a law is reported the drive.
Circumstances circumstancesOf(const Grid& grid, const LawBattery& base,
                              std::vector<double>& voltage) {
  const double rest = base.voltage(base.rested());
  std::vector<double> charging;
  Circumstances c;
  c.duration = grid.duration();
  c.sample_rate_hz = 1.0 / grid.interval;
  c.lowest_as = c.highest_as = c.throughput_as = 0.0;
  follow(grid, base, [&](std::size_t n, const LawState& state) {
    voltage.push_back(base.voltage(state));
    c.lowest_as = std::min(c.lowest_as, state.charge);
    c.highest_as = std::max(c.highest_as, state.charge);
    if (n > 0 && !grid.isGap(n))
      c.throughput_as += std::abs(grid.samples[n].current) * kStep *
                         static_cast<double>(grid.steps[n] - grid.steps[n - 1]);
    if (grid.samples[n].current > 1.0) charging.push_back(rest + state.base.cpe2.voltage);
  });
  c.onset_low_v = quantile(charging, 0.4);
  c.onset_high_v = quantile(charging, 0.75);
  return c;
}

Course courseOf(const Grid& grid) {
  if (grid.duration() > kLongestForInstrument)
    throw std::invalid_argument("recording is " + std::to_string(grid.duration()) +
                                " s long, an instrument's law takes at most " +
                                std::to_string(kLongestForInstrument) + " s");
  Course course{{grid.samples[0].current}, {grid.samples[0].voltage}};
  for (std::size_t to = 1; to < grid.samples.size(); ++to)
    for (long step = grid.steps[to - 1] + 1; step <= grid.steps[to]; ++step) {
      course.current.push_back(grid.current(to, step));
      course.voltage.push_back(grid.between(to, step, &RecordedSample::voltage));
    }
  return course;
}

std::vector<RecordedSample> shownBy(const Law& instrument, const Grid& grid, double strength) {
  const Course truth = courseOf(grid), shown = instrument.shown(truth, strength);
  std::vector<RecordedSample> samples = grid.samples;
  for (std::size_t n = 0; n < samples.size(); ++n) {
    const auto at = static_cast<std::size_t>(grid.steps[n]);
    samples[n].current += shown.current[at] - truth.current[at];
    samples[n].voltage += shown.voltage[at] - truth.voltage[at];
  }
  return samples;
}

std::vector<RecordedSample> withPhysics(const Law& law, const Grid& grid, const Scenario& scenario,
                                        double strength, const std::vector<double>& base) {
  const LawBattery battery(scenario, &law, strength);
  std::vector<RecordedSample> samples = grid.samples;
  follow(grid, battery, [&](std::size_t n, const LawState& state) {
    samples[n].voltage += battery.voltage(state) - base[n];
  });
  return samples;
}

}  // namespace

std::vector<RecordedSample> injected(const std::vector<RecordedSample>& measured,
                                     const InjectionOrder& order) {
  if (measured.size() < 3)
    throw std::invalid_argument("recording has " + std::to_string(measured.size()) +
                                " samples, expected 3 or more");
  if (!std::isfinite(order.strength))
    throw std::invalid_argument(faultOf("strength", order.strength, "finite"));
  const Grid grid(measured);
  const Scenario scenario = scenarioOf(order, grid.duration());
  std::vector<double> base;
  const Circumstances drive = circumstancesOf(grid, LawBattery(scenario, nullptr, 0.0), base);
  Dice dice(order.seed, kLawStream);
  const Law law = lawNamed(order.mechanism, order.id).draw(dice, drive);
  return law.shown ? shownBy(law, grid, order.strength)
                   : withPhysics(law, grid, scenario, order.strength, base);
}

std::vector<RecordedSample> readRecording(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string line;
  if (!std::getline(file, line) || line.rfind(kHeader, 0) != 0)
    throw std::invalid_argument(path.string() + ": expected a header that begins with " + kHeader);
  std::vector<RecordedSample> samples;
  for (std::size_t number = 2; std::getline(file, line); ++number) {
    RecordedSample one{};
    if (std::sscanf(line.c_str(), "%lf,%lf,%lf", &one.time, &one.current, &one.voltage) != 3 ||
        !std::isfinite(one.time + one.current + one.voltage))
      throw std::invalid_argument(path.string() + ":" + std::to_string(number) + ": \"" + line +
                                  "\", expected three numbers");
    samples.push_back(one);
  }
  return samples;
}

}  // namespace battery_sof_simulator
