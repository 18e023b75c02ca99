#include "simulator/simulation.hpp"

#include <algorithm>

#include "simulator/fields.hpp"

namespace battery_sof_simulator {
namespace {

constexpr double kStep = FullBattery::kStep;  // [s]
static_assert(kStep == PorousBlock::kStep, "drives count in one step");
constexpr double kPorousTemperature = 25.0;  // [degC]
constexpr double kProgressInterval = 60.0;   // [s], simulated

/// driveThrough() and what is recorded. @param duration recorded [s]; the filter needs more.
template <typename Battery, typename Look>
std::vector<RecordedSample> recordedDrive(const Battery& battery, const Scenario& scenario,
                                          double duration, const Look& look) {
  Acquisition acquisition(scenario.acquisition, 1.0 / kStep, scenario.seed);
  const long all =
      std::lround(duration / kStep) + std::lround(std::ceil(acquisition.lookAhead() / kStep));
  driveThrough(battery, scenario, duration, all, [&](const auto& state, long n) {
    acquisition.push(state.current, battery.voltage(state));
    return look(state, n);
  });
  return acquisition.recording(duration);
}

Simulation simulateCircuit(const Scenario& scenario, const SimulationOptions& options,
                           double duration) {
  const long recorded = std::lround(duration / kStep);
  const FullBattery battery(scenario.battery, scenario.effects, scenario.start, 1,
                            scenario.additions);
  EnergyLedger ledger(battery, battery.rested());
  const double rate = scenario.acquisition.sample_rate_hz;
  std::vector<double> temperature;  // at each sample's time
  double reported = 0.0;
  Simulation result;
  result.samples = recordedDrive(battery, scenario, duration, [&](const auto& state, long n) {
    const double time = static_cast<double>(n) * kStep;
    if (time + 0.5 * kStep >= static_cast<double>(temperature.size()) / rate)
      temperature.push_back(state.temperature);
    if (n > 0 && n <= recorded) ledger.enter(state);
    if (n <= recorded) result.soc_at_end = battery.soc(state);
    if (options.progress && n <= recorded && time - reported >= kProgressInterval)
      options.progress(reported = time);
    return ledger.balance().charge_in / kSecondsPerHour;
  });
  for (const RecordedSample& sample : result.samples)
    result.temperature.push_back(
        temperature[static_cast<std::size_t>(std::lround(sample.time * rate))]);
  result.balance = ledger.balance();
  return result;
}

Simulation simulatePorous(const Scenario& scenario, double duration) {
  const long recorded = std::lround(duration / kStep);
  const PorousBlock block(*scenario.porous, scenario.start.soc);
  Simulation result;
  double charge_ah = 0.0;
  result.samples = recordedDrive(block, scenario, duration, [&](const auto& state, long n) {
    charge_ah += state.current * kStep / kSecondsPerHour;
    if (n == recorded) {
      result.soc_at_end = block.soc(state);
      result.balance.charge_in = charge_ah * kSecondsPerHour;
      result.balance.main_charge = state.main_charge;
      result.balance.gas_charge = state.gas_charge;
    }
    return charge_ah;
  });
  result.temperature.assign(result.samples.size(), kPorousTemperature);
  return result;
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
      faults.push_back(
          faultOf(name + "at_s", inserts[k].at, std::to_string(earliest) + " or more"));
  }
  return faults;
}

void requirePositive(std::vector<std::string>& faults, const char* name, double value) {
  if (!(value > 0.0) || !std::isfinite(value)) faults.push_back(faultOf(name, value, "above 0"));
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
  if (options.cut_after) requirePositive(faults, "cut_after", *options.cut_after);
  requireNone(faults, "scenario");
}

}  // namespace

void insertAt(Scenario& scenario, double at, const std::vector<Phase>& phases) {
  std::vector<Insert>& all = scenario.inserts;
  const auto after = std::upper_bound(all.begin(), all.end(), at,
                                      [](double time, const Insert& one) { return time < one.at; });
  all.insert(after, {at, phases});
}

Simulation simulate(const Scenario& scenario, const SimulationOptions& options) {
  requireValid(scenario, options);
  const double duration = options.cut_after.value_or(scenario.duration);
  Simulation result = scenario.porous ? simulatePorous(scenario, duration)
                                      : simulateCircuit(scenario, options, duration);
  result.duration = duration;
  result.soc_at_start = scenario.start.soc;
  return result;
}

std::vector<std::string> faultsOf(const Scenario& scenario) {
  std::vector<std::string> faults;
  requirePositive(faults, "duration_s", scenario.duration);
  requirePositive(faults, "voltage_limit_v", scenario.voltage_limit);
  requirePositive(faults, "slew_a_per_s", scenario.slew);
  append(faults, "battery.", faultsOf(scenario.battery));
  append(faults, "additions.", fieldFaults(scenario.additions));
  append(faults, "acquisition.", faultsOf(scenario.acquisition));
  append(faults, "profile.", faultsOf(scenario.profile));
  append(faults, "", faultsOf(scenario.inserts));
  if (scenario.later) append(faults, "later.", faultsOf(*scenario.later, scenario.duration));
  append(faults, "", faultsOf(scenario.start));
  return faults;
}

}  // namespace battery_sof_simulator
