#include "simulator/porous_simulation.hpp"

#include <cmath>
#include <stdexcept>

#include "simulator/drive_follower.hpp"

namespace battery_sof_reference {
namespace {

constexpr double kStep = PorousBlock::kStep;  // [s]
static_assert(kStep == FullBattery::kStep, "drives count in one step");
constexpr double kSecondsPerHour = 3600.0;
constexpr double kTemperature = 25.0;  // [degC]

void requireValid(const Scenario& scenario) {
  std::string text;
  for (const auto& fault : faultsOf(scenario)) text += (text.empty() ? "" : "; ") + fault;
  if (!text.empty()) throw std::invalid_argument("scenario: " + text);
}

}  // namespace

Simulation simulatePorous(const Scenario& scenario, const PorousParameters& parameters) {
  requireValid(scenario);
  const PorousBlock block(parameters, scenario.start.soc);
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
  result.temperature.assign(result.samples.size(), kTemperature);
  result.duration = scenario.duration;
  result.soc_at_start = scenario.start.soc;
  return result;
}

}  // namespace battery_sof_reference
