// What a source's voltage costs: identify() of a quarter of an hour at 1 Hz and one pass with
// derivatives, driven where a source controls the voltage by that and, for comparison, by the
// current alone. Prints a table.
#include <algorithm>
#include <cstdio>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "estimation/composition_fit.hpp"
#include "estimation/identification.hpp"
#include "program.hpp"
#include "stopwatch.hpp"
#include "support/start_stop.hpp"

namespace {

using namespace battery_sof;
using namespace battery_sof_bench;

constexpr double kMinTurn = 50.0;  // [ms], of runs of one contender in a row

/// A record of 15 minutes whose answers are a composition's own, under a vehicle's sensors.
test::StartStopDrive recordOf(const BatteryModel& model) {
  test::StartStopOptions options;
  options.current_noise = 0.2;
  options.voltage_noise = 0.006;
  const bool is_fresh = !model.effects().empty() && model.effects().front() == "fresh_sulphate";
  if (!is_fresh) {
    options.lowest = 12.9;
    options.highest = 13.3;
  }
  return test::startStopDrive(
      model, is_fresh ? test::freshBattery(model) : test::typicalPoint(model), options);
}

/// Shortest of some turns [ms] of a call.
template <typename Work>
double shortest(int rounds, const Work& work) {
  double least = std::numeric_limits<double>::infinity();
  for (int round = 0; round < rounds; ++round) {
    double spent = 0.0, runs = 0.0;
    for (; spent < kMinTurn; runs += 1.0) spent += processorMilliseconds(work);
    least = std::min(least, spent / runs);
  }
  return least;
}

double fitMilliseconds(const test::StartStopDrive& record, const std::vector<std::string>& effects,
                       bool mixed, int rounds) {
  IdentifyOptions options;
  options.effects = effects;
  if (mixed) options.source = test::knownSource(record);
  return shortest(rounds, [&] {
    if (!isUsable(identify(record.series, {0, record.series.size()}, options).fit))
      throw std::runtime_error("a fit found nothing");
  });
}

/// [us] a sample.
double passMicroseconds(const test::StartStopDrive& record, const BatteryModel& model, bool mixed,
                        bool derivatives, int rounds) {
  const IndexRange all{0, record.series.size()};
  const InputSequence inputs = mixed ? inputSequence(record.series, all, {}, record.controlled)
                                     : inputSequence(record.series, all);
  const CompositionPoint point = typicalStart(model, inputs);
  const CompositionProblem problem(model, inputs, {}, point);
  const Eigen::MatrixXd seeds = problem.seedsAt(problem.coordinatesOf(point));
  const ModelPoint start{point.parameters, point.state, inputs.first_time, inputs.first_time};
  const double milliseconds = shortest(rounds, [&] {
    Simulation simulation =
        derivatives ? Simulation(model, start, seeds) : Simulation(model, start);
    for (const InputSample& sample : inputs.samples) simulation.follow(sample);
  });
  return 1e3 * milliseconds / static_cast<double>(inputs.samples.size());
}

void printRow(const std::vector<std::string>& effects, int rounds) {
  const BatteryModel model(effects);
  const test::StartStopDrive record = recordOf(model);
  double fit[2], pass[2], values[2];
  for (const bool mixed : {false, true}) {
    fit[mixed] = fitMilliseconds(record, effects, mixed, rounds);
    pass[mixed] = passMicroseconds(record, model, mixed, true, rounds);
    values[mixed] = passMicroseconds(record, model, mixed, false, rounds);
  }
  std::string name = "base";
  for (const std::string& id : effects) name += " + " + id;
  std::printf("%-28s %9.3f %9.3f %7.2f   %8.2f %8.2f %6.1f   %8.2f %8.2f %6.1f\n", name.c_str(),
              fit[0], fit[1], fit[1] / fit[0], pass[0], pass[1], pass[1] / pass[0], values[0],
              values[1], values[1] / values[0]);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  return runBenchmark<int>(argc, argv, "mixed_fit ROUNDS", [](int rounds) {
    std::printf("%-28s %27s   %24s   %24s\n", "15 min at 1 Hz, by current", "identify() [ms]",
                "derivatives [us/sample]", "values [us/sample]");
    std::printf("%-28s %9s %9s %7s   %8s %8s %6s   %8s %8s %6s\n", "and where a source drives",
                "current", "mixed", "ratio", "current", "mixed", "ratio", "current", "mixed",
                "ratio");
    const std::vector<std::vector<std::string>> compositions = {
        {},          {"acid_transport"},    {"charge_transfer"},
        {"gassing"}, {"charge_acceptance"}, {"fresh_sulphate"}};
    for (const auto& effects : compositions) printRow(effects, rounds);
  });
}
