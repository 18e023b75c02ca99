#include "simulator/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "simulator/drive_follower.hpp"
#include "simulator/faults.hpp"
#include "simulator/units.hpp"

namespace battery_sof_simulator {
namespace {

constexpr double kStep = FullBattery::kStep;  // [s]
static_assert(kStep == PorousBlock::kStep, "drives count in one step");
constexpr double kPorousTemperature = 25.0;  // [degC]
constexpr double kProgressInterval = 60.0;   // [s], simulated

/// Battery, books and acquisition, moved on together.
class Bench {
 public:
  Bench(const Scenario& scenario, const SimulationOptions& options)
      : options_(options),
        battery_(scenario.battery, scenario.effects, scenario.start, options.substeps,
                 scenario.additions),
        state_(battery_.rested()),
        ledger_(battery_, state_),
        acquisition_(scenario.acquisition, 1.0 / kStep, scenario.seed),
        temperature_interval_(1.0 / scenario.acquisition.sample_rate_hz) {
    result_.soc_at_start = battery_.soc(state_);
    update();
    remember();
  }

  const FullBattery& battery() const { return battery_; }
  const BatteryState& state() const { return state_; }
  double chargeAh() const { return ledger_.balance().charge_in / kSecondsPerHour; }
  double lookAhead() const { return acquisition_.lookAhead(); }

  /// A step within the recorded time.
  void record(const BatteryState& next) {
    pass(next);
    ledger_.enter(next);
    remember();
    result_.soc_at_end = battery_.soc(next);
    report();
  }
  /// A step after it, which only the filter still needs.
  void pass(const BatteryState& next) {
    state_ = next;
    ++steps_;
    update();
  }

  Simulation result(double duration) {
    result_.samples = acquisition_.recording(duration);
    result_.temperature = temperatureOf(result_.samples);
    result_.duration = duration;
    result_.balance = ledger_.balance();
    return std::move(result_);
  }

 private:
  double time() const { return static_cast<double>(steps_) * kStep; }

  /// The temperature at each sample's time; what lies after the end takes the last one.
  std::vector<double> temperatureOf(const std::vector<RecordedSample>& samples) const {
    std::vector<double> temperature;
    temperature.reserve(samples.size());
    for (const RecordedSample& sample : samples) {
      const auto n = static_cast<std::size_t>(std::lround(sample.time / temperature_interval_));
      temperature.push_back(n < result_.temperature.size() ? result_.temperature[n]
                                                           : state_.temperature);
    }
    return temperature;
  }
  void update() {
    acquisition_.push(state_.current, battery_.voltage(state_));
    const double due = static_cast<double>(result_.temperature.size()) * temperature_interval_;
    if (time() + 0.5 * kStep >= due) result_.temperature.push_back(state_.temperature);
  }
  void remember() {
    if (!options_.keep_truth) return;
    Truth& truth = result_.truth;
    truth.current.push_back(state_.current);
    truth.voltage.push_back(battery_.voltage(state_));
    truth.soc.push_back(battery_.soc(state_));
  }
  void report() {
    if (!options_.progress || time() - reported_ < kProgressInterval) return;
    reported_ = time();
    options_.progress(reported_);
  }

  SimulationOptions options_;
  FullBattery battery_;
  BatteryState state_;
  EnergyLedger ledger_;
  Acquisition acquisition_;
  double temperature_interval_;
  long steps_ = 0;
  double reported_ = 0.0;
  Simulation result_;
};

template <typename NextState>
Simulation run(Bench& bench, double duration, const NextState& next) {
  const long recorded = std::lround(duration / kStep);
  const long all = recorded + std::lround(std::ceil(bench.lookAhead() / kStep));
  for (long n = 1; n <= recorded; ++n) bench.record(next(n));
  for (long n = recorded + 1; n <= all; ++n) bench.pass(next(n));
  return bench.result(duration);
}

void append(std::vector<std::string>& faults, const std::string& where,
            const std::vector<std::string>& more) {
  for (const auto& fault : more) faults.push_back(where + fault);
}

std::vector<std::string> faultsOf(const std::vector<Insert>& inserts) {
  std::vector<std::string> faults;
  for (std::size_t k = 0; k < inserts.size(); ++k) {
    const std::string name = "inserts[" + std::to_string(k) + "].";
    append(faults, name, faultsOf(ProfileOptions{ListedPhases{inserts[k].phases}}));
    const double earliest = k == 0 ? 0.0 : inserts[k - 1].at;
    if (!(inserts[k].at >= earliest))
      faults.push_back(name + "at_s is " + std::to_string(inserts[k].at) + ", expected " +
                       std::to_string(earliest) + " or more");
  }
  return faults;
}

void requirePositive(std::vector<std::string>& faults, const char* name, double value) {
  if (!(value > 0.0) || !std::isfinite(value))
    faults.push_back(std::string(name) + " is " + std::to_string(value) + ", expected above 0");
}

std::vector<std::string> faultsOf(const LaterPart& later, double duration) {
  std::vector<std::string> faults = faultsOf(later.profile);
  requirePositive(faults, "from_s", later.from);
  requirePositive(faults, "voltage_limit_v", later.voltage_limit);
  if (later.from >= duration) faults.push_back("from_s is not below duration_s");
  return faults;
}

void requireValid(const Scenario& scenario, const SimulationOptions& options) {
  std::vector<std::string> faults = faultsOf(scenario);
  if (options.substeps < 1)
    faults.push_back("substeps is " + std::to_string(options.substeps) + ", expected 1 or more");
  if (options.cut_after) requirePositive(faults, "cut_after", *options.cut_after);
  requireNone(faults, "scenario");
}

Simulation simulatePorous(const Scenario& scenario) {
  const PorousBlock block(*scenario.porous, scenario.start.soc);
  PorousState state = block.rested();
  Acquisition acquisition(scenario.acquisition, 1.0 / kStep, scenario.seed);
  DriveFollower driver(scenario, scenario.duration);
  const PowerSource source(scenario.slew);
  const long recorded = std::lround(scenario.duration / kStep);
  const long all = recorded + std::lround(std::ceil(acquisition.lookAhead() / kStep));
  Simulation result;
  double charge_ah = 0.0;
  acquisition.push(state.current, block.voltage(state));
  for (long n = 1; n <= all; ++n) {
    state = source.step(block, state, driver.next(charge_ah));
    charge_ah += state.current * kStep / kSecondsPerHour;
    acquisition.push(state.current, block.voltage(state));
    if (n != recorded) continue;
    result.soc_at_end = block.soc(state);
    result.balance.charge_in = charge_ah * kSecondsPerHour;
    result.balance.main_charge = state.main_charge;
    result.balance.gas_charge = state.gas_charge;
  }
  result.samples = acquisition.recording(scenario.duration);
  result.temperature.assign(result.samples.size(), kPorousTemperature);
  result.duration = scenario.duration;
  result.soc_at_start = scenario.start.soc;
  return result;
}

}  // namespace

Simulation simulate(const Scenario& scenario, const SimulationOptions& options) {
  requireValid(scenario, options);
  if (scenario.porous) return simulatePorous(scenario);
  const double duration = options.cut_after.value_or(scenario.duration);
  Bench bench(scenario, options);
  DriveFollower driver(scenario, duration);
  const PowerSource source(scenario.slew);
  return run(bench, duration, [&](long) {
    return source.step(bench.battery(), bench.state(), driver.next(bench.chargeAh()));
  });
}

Simulation replay(const Scenario& scenario, const std::vector<double>& currents,
                  const SimulationOptions& options) {
  requireValid(scenario, options);
  if (currents.size() < 2) throw std::invalid_argument("replay: fewer than two currents");
  const double length = static_cast<double>(currents.size() - 1) * kStep;
  Bench bench(scenario, options);
  return run(bench, std::min(length, options.cut_after.value_or(length)), [&](long n) {
    const std::size_t index = std::min(static_cast<std::size_t>(n), currents.size() - 1);
    return bench.battery().advance(bench.state(), currents[index]);
  });
}

std::vector<std::string> faultsOf(const Scenario& scenario) {
  std::vector<std::string> faults;
  requirePositive(faults, "duration_s", scenario.duration);
  requirePositive(faults, "voltage_limit_v", scenario.voltage_limit);
  requirePositive(faults, "slew_a_per_s", scenario.slew);
  append(faults, "battery.", faultsOf(scenario.battery));
  append(faults, "additions.", faultsOf(scenario.additions));
  append(faults, "acquisition.", faultsOf(scenario.acquisition));
  append(faults, "profile.", faultsOf(scenario.profile));
  append(faults, "", faultsOf(scenario.inserts));
  if (scenario.later) append(faults, "later.", faultsOf(*scenario.later, scenario.duration));
  append(faults, "", faultsOf(scenario.start));
  return faults;
}

}  // namespace battery_sof_simulator
