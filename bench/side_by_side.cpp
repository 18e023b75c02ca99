// Times our identification and Ceres on the same window, in turns, and writes times as JSON.
#include <cstdlib>
#include <ctime>
#include <exception>
#include <fstream>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>

#include "ceres_fit.hpp"
#include "estimation/identification.hpp"
#include "our_fit.hpp"

namespace {

using namespace battery_sof_bench;

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
std::vector<Contender> agreeingContenders(const DriveWindow& window, const Fit& ours) {
  requireSameAsIdentify(window, ours);
  std::vector<Contender> contenders;
  contenders.push_back({"ours, identify()",
                        [&window] { battery_sof::identify(window.series, window.range()); },
                        ours.evaluations});
  contenders.push_back({"ours, search alone", [&window] { searchOnly(window); }, ours.evaluations});
  for (const CeresSettings& settings : allCeresSettings()) {
    const Fit theirs = fitWithCeres(window.samples, settings);
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
  const Fit ours = searchOnly(window);
  const auto contenders = agreeingContenders(window, ours);
  const nlohmann::json result = {{"times", timesAsJson(contenders, rounds)}};
  std::ofstream file(out);
  file << result;
  file.close();
  if (!file) throw std::runtime_error(out + ": cannot be written");
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc == 3 ? std::atoi(argv[1]) : 0;
  if (rounds < 1) {
    std::cerr << "usage: side_by_side ROUNDS OUT.json\n";
    return 2;
  }
  try {
    compare(rounds, argv[2]);
  } catch (const std::exception& error) {
    std::cerr << "side_by_side: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
