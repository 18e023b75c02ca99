#include "composed_record.hpp"

#include <cmath>
#include <random>

#include "simulator/city_drive.hpp"

namespace battery_sof_bench {

using namespace battery_sof;

namespace {

constexpr double kInterval = 0.01;       // [s]
constexpr double kOneDrive = 1800.0;     // [s]
constexpr double kVoltageNoise = 0.002;  // [V]

std::vector<double> drivenCurrent(double duration) {
  battery_sof_simulator::CityDriveOptions options;
  options.seed = 1;
  options.duration = std::min(duration, kOneDrive);
  std::vector<double> current;
  for (const auto& sample : battery_sof_simulator::simulateCityDrive(options))
    current.push_back(sample.current);
  return current;
}

void setParameter(const BatteryModel& model, CompositionPoint& point, const char* name,
                  double value) {
  if (const auto row = model.parameterRow(name)) point.parameters[*row] = value;
}

}  // namespace

BatteryModel composedModel() {
  return BatteryModel({"charge_acceptance", "acid_transport", "current_dependent_resistance"});
}

CompositionPoint composedTruth(const BatteryModel& model) {
  CompositionPoint truth{model.typicalParameters(), model.restState()};
  setParameter(model, truth, "r_discharge", 0.0065);
  setParameter(model, truth, "r_charge", 0.0085);
  setParameter(model, truth, "c2", 700.0);
  setParameter(model, truth, "beta", 26.0);
  setParameter(model, truth, "u_dc", 12.45);
  setParameter(model, truth, "inverse_limiting_current", 1.0 / 45.0);
  setParameter(model, truth, "refill_time", 18.0);
  setParameter(model, truth, "acid_resistance_1", 0.0015);
  setParameter(model, truth, "acid_time_1", 40.0);
  setParameter(model, truth, "acid_resistance_2", 0.004);
  setParameter(model, truth, "acid_time_2", 700.0);
  setParameter(model, truth, "low_current_resistance", 0.004);
  setParameter(model, truth, "resistance_current", 22.0);
  return truth;
}

Series composedRecord(const BatteryModel& model, const CompositionPoint& truth, double duration) {
  const std::vector<double> driven = drivenCurrent(duration);
  const auto count = static_cast<std::size_t>(std::lround(duration / kInterval));
  Series series;
  for (std::size_t n = 0; n < count; ++n) {
    series.append({kInterval * static_cast<double>(n), driven[n % driven.size()], 0.0});
  }
  Simulation simulation(model, {truth.parameters, truth.state, 0.0, 0.0});
  std::mt19937_64 engine(1);
  std::normal_distribution<double> noise(0.0, kVoltageNoise);
  for (std::size_t n = 0; n < count; ++n) {
    const std::size_t before = n > 0 ? n - 1 : 0;
    simulation.advance(inputStep(series.time[before], series.current[before], series.time[n],
                                 series.current[n], 10.0 * kInterval));
    series.voltage[n] = simulation.voltage() + noise(engine);
  }
  return series;
}

IndexRange all(const Series& series) { return {0, series.size()}; }

}  // namespace battery_sof_bench
