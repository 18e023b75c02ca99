// Times our identification and Ceres on the same window, in turns, and writes times as JSON.
#include <cmath>
#include <ctime>
#include <functional>
#include <sstream>
#include <stdexcept>

#include "ceres_fit.hpp"
#include "drive_window.hpp"
#include "estimation/base_search.hpp"
#include "estimation/identification.hpp"
#include "program.hpp"

namespace {

using namespace battery_sof;
using namespace battery_sof_bench;

/// The demand: the four tunables agree to this share.
constexpr double kSameOptimum = 1e-4;
/// At the optimum the cost is flat: a share of 1e-4 of a parameter moves it by less than this
/// share.
constexpr double kSameCost = 1e-6;

void requireClose(const std::string& contender, const std::string& name, double ours, double theirs,
                  double tolerance) {
  if (std::abs(theirs - ours) <= tolerance * std::abs(ours)) return;
  std::ostringstream message;
  message.precision(10);
  message << contender << " ended elsewhere: " << name << " is " << theirs << ", ours is " << ours
          << ", allowed share " << tolerance << "; times of different answers are not compared";
  throw std::runtime_error(message.str());
}

/// Refuses a comparison of different answers.
void requireSameOptimum(const Optimum& ours, const Optimum& theirs, const std::string& contender) {
  const auto& a = ours.parameters;
  const auto& b = theirs.parameters;
  requireClose(contender, "r_discharge", a.r_discharge, b.r_discharge, kSameOptimum);
  requireClose(contender, "r_charge", a.r_charge, b.r_charge, kSameOptimum);
  requireClose(contender, "c2", a.c2, b.c2, kSameOptimum);
  requireClose(contender, "beta", a.beta, b.beta, kSameOptimum);
  requireClose(contender, "the cost", ours.cost, theirs.cost, kSameCost);
}

/// The part of identify() that finds the optimum: equations, coarse search, search on all samples.
/// It calls what identify() calls, in the same order; requireSameAsIdentify() holds both together.
Optimum searchOnly(const DriveWindow& window) {
  const IdentifyOptions options;
  const WindowSamples samples{window.series,
                              window.range(),
                              {options.crank_weight, options.crank_current},
                              window.max_gap,
                              options.masked};
  const BaseNormalEquations equations(samples, BaseParameters{}.i0);
  const CompositionFit fit = searchWindow(samples, equations, options);
  return {baseParameters(fit.point.parameters), fit.point.state[0], fit.at.cost, fit.iterations};
}

/// The same optimum by the engine that fits every other composition: compressed inputs, then all
/// samples. What the circuit's own passes (base_kernel) gain over it is why they are there.
Optimum searchWithEngine(const DriveWindow& window) {
  const IdentifyOptions options;
  FitCost cost;
  cost.priors = false;
  const BatteryModel circuit;
  const auto& [r_discharge, r_charge, c2, beta] = options.initial;
  CompositionPoint start{Eigen::VectorXd(kBaseRows), circuit.restState()};
  start.parameters << r_discharge, r_charge, c2, beta, window.series.voltage.front();
  const InputSequence coarse = compressedInputs(window.series, window.range());
  const CompositionFit approach =
      fitComposition(CompositionProblem(circuit, coarse, cost, start), {start});
  const InputSequence inputs = inputSequence(window.series, window.range());
  const CompositionFit fit =
      fitComposition(CompositionProblem(circuit, inputs, cost, approach.point), {approach.point});
  return {baseParameters(fit.point.parameters), fit.point.state[0], fit.at.cost, fit.passes};
}

/// Refuses when identify() did not converge or ended in other parameters than searchOnly().
void requireSameAsIdentify(const DriveWindow& window, const Optimum& searched) {
  const FittedModel model = identify(window.series, window.range());
  if (model.fit.status != FitStatus::kConverged)
    throw std::runtime_error("identify() did not converge: " + model.fit.message);
  const auto& a = model.fit.parameters;
  const auto& b = searched.parameters;
  if (a.r_discharge != b.r_discharge || a.r_charge != b.r_charge || a.c2 != b.c2 ||
      a.beta != b.beta || a.u_dc != b.u_dc)
    throw std::runtime_error(
        "searchOnly() is no longer the search of identify(): benchmark/speed/side_by_side.cpp");
}

/// One line of the table.
struct Contender {
  std::string name;
  std::function<void()> run;
  int evaluations = 0;  ///< passes over all samples
};

constexpr double kTurn = 10.0;  ///< [ms], a contender's turn takes at least so long

/// Processor time of one run: every contender runs on one thread, and other programs' turns do not
/// count. A first run is not counted: it takes back the memory that the contender before has
/// returned to the system.
double millisecondsOf(const std::function<void()>& run) {
  run();
  const std::clock_t begin = std::clock();
  for (int runs = 1;; ++runs) {
    run();
    const double passed = 1e3 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    if (passed >= kTurn) return passed / runs;
  }
}

/// All contenders, each of which has shown to end in the same optimum.
std::vector<Contender> agreeingContenders(const DriveWindow& window, const Optimum& ours) {
  requireSameAsIdentify(window, ours);
  std::vector<Contender> contenders;
  contenders.push_back({"ours, identify()", [&window] { identify(window.series, window.range()); },
                        ours.evaluations});
  contenders.push_back({"ours, search alone", [&window] { searchOnly(window); }, ours.evaluations});
  const Optimum by_engine = searchWithEngine(window);
  requireSameOptimum(ours, by_engine, "the engine of compositions");
  contenders.push_back({"ours, engine of compositions", [&window] { searchWithEngine(window); },
                        by_engine.evaluations});
  for (const CeresSettings& settings : allCeresSettings()) {
    const Optimum theirs = fitWithCeres(window.samples, settings);
    requireSameOptimum(ours, theirs, toString(settings));
    contenders.push_back({toString(settings),
                          [&window, settings] { fitWithCeres(window.samples, settings); },
                          theirs.evaluations});
  }
  return contenders;
}

nlohmann::json timesAsJson(const std::vector<Contender>& contenders, int rounds) {
  std::vector<std::vector<double>> times(contenders.size());
  for (int round = 0; round < rounds; ++round)
    for (std::size_t k = 0; k < contenders.size(); ++k)
      times[k].push_back(millisecondsOf(contenders[k].run));
  nlohmann::json all = nlohmann::json::array();
  for (std::size_t k = 0; k < contenders.size(); ++k)
    all.push_back({{"name", contenders[k].name},
                   {"evaluations", contenders[k].evaluations},
                   {"milliseconds", times[k]}});
  return all;
}

void compare(int rounds, const std::string& out) {
  const DriveWindow window = simulatedWindow();
  const Optimum ours = searchOnly(window);
  const auto contenders = agreeingContenders(window, ours);
  writeJson(out, {{"times", timesAsJson(contenders, rounds)}});
}

}  // namespace

int main(int argc, char** argv) {
  return runBenchmark<int>(argc, argv, "side_by_side ROUNDS OUT.json",
                           [&](int rounds) { compare(rounds, argv[2]); });
}
