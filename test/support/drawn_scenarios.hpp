#pragma once

#include <string>
#include <vector>

#include "simulator/generator/draw_scenario_command.hpp"
#include "simulator/generator/scenario_kind.hpp"
#include "support/commands.hpp"

/// What tests of drawn scenarios share.
namespace battery_sof_simulator {

inline Order orderOf(const ScenarioKind& what, std::uint64_t seed, double duration,
                     const std::vector<double>& scale = {1.0}) {
  Order order;
  order.what = what;
  order.seed = seed;
  order.duration = duration;
  order.scale = scale;
  return order;
}

/// Draws into a folder: case.csv and case.json.
class DrawInFolder : public battery_sof::test::InFolder {
 protected:
  DrawInFolder() : InFolder("draw_scenario") {}

  static std::string contentOf(const std::string& file) {
    std::ifstream stream(file);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  int run(const std::vector<std::string>& arguments) {
    const auto outcome = battery_sof::test::outcomeOf(
        [](auto&... all) { return runDrawScenario(all...); }, arguments);
    out_ = outcome.out;
    err_ = outcome.err;
    return outcome.code;
  }
  /// run() with both files to be written.
  int draw(std::vector<std::string> arguments) {
    for (const std::string& one :
         {std::string("--out"), recording(), std::string("--label"), label()})
      arguments.push_back(one);
    return run(arguments);
  }
  std::string recording() const { return path("case.csv"); }
  std::string label() const { return path("case.json"); }

  std::string out_, err_;
};

}  // namespace battery_sof_simulator
