#include "simulator/simulate_command.hpp"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>

#include "simulator/impedance.hpp"
#include "simulator/program_frame.hpp"
#include "simulator/recording_output.hpp"
#include "simulator/scenario_file.hpp"

namespace battery_sof_simulator {
namespace {

constexpr double kProgressAfter = 2.0;     // [s]
constexpr double kLowestFrequency = 1e-3;  // [Hz] (paper, III-B)
constexpr double kHighestFrequency = 1e3;  // [Hz]; the ladders are good to 1 % there
constexpr int kPointsPerDecade = 20;

// config/scenarios/city_drive.yaml, for a program that is far from its package.
constexpr char kDemo[] =
    "{name: city_drive, seed: 1, duration_s: 900.0, voltage_limit_v: 14.2, soc: 0.8, "
    "temperature_degc: 20.0, effects: {gassing: threshold}, acquisition: {voltage_white_v: 0.002, "
    "current_white_a: 0.05}, profile: {kind: city_drive, net_charge_ah: 0.5}}";

struct Arguments {
  std::string scenario, out, json, impedance;
  std::optional<std::uint64_t> seed;
  std::optional<double> duration;
};

/// Says on err how far work of more than two seconds is, when that is a terminal.
std::function<void(double)> progressOn(std::ostream& err, double duration) {
  using Clock = std::chrono::steady_clock;
  return [&err, duration, began = Clock::now()](double time) {
    const std::chrono::duration<double> passed = Clock::now() - began;
    if (isatty(STDERR_FILENO) == 0 || passed.count() < kProgressAfter) return;
    char text[80];
    std::snprintf(text, sizeof text, "\rsimulated %.0f of %.0f min", time / kSecondsPerMinute,
                  duration / kSecondsPerMinute);
    const bool at_end = time + kSecondsPerMinute > duration;  // it comes once a minute
    err << text << (at_end ? "\n" : "") << std::flush;
  };
}

void addOptions(CLI::App& app, Arguments& arguments) {
  app.add_option("SCENARIO", arguments.scenario, "scenario: .yaml")->required();
  app.add_option("OUT", arguments.out, "recording to write: .csv or .bag");
  app.add_option("--seed", arguments.seed,
                 "seed in place of the scenario's; the same seed gives the same drive")
      ->check(isSeed);
  app.add_option("--duration", arguments.duration, "duration [s] in place of the scenario's")
      ->check(CLI::Range(0.01, 1e6));
  app.add_option("--json", arguments.json, "write the result as JSON; - for standard output");
  app.add_option("--impedance", arguments.impedance,
                 "write the small-signal impedance, 1 mHz to 1 kHz, as CSV");
}

nlohmann::json jsonOf(const Scenario& scenario, const Simulation& simulation,
                      const std::string& out) {
  const Balance& b = simulation.balance;
  return {{"schema", "battery_sof/simulation/1"},
          {"scenario", shown(scenario.name)},
          {"out", shown(out)},
          {"seed", scenario.seed},
          {"duration_s", simulation.duration},
          {"samples", simulation.samples.size()},
          {"soc_at_start", simulation.soc_at_start},
          {"soc_at_end", simulation.soc_at_end},
          {"charge_in_ah", b.charge_in / kSecondsPerHour},
          {"gassing_ah", b.gas_charge / kSecondsPerHour},
          {"charge_error_as", b.chargeError()},
          {"energy_in_j", b.energy_in},
          {"energy_stored_j", b.stored},
          {"energy_lost_j", b.lost.total()},
          {"energy_error_j", b.energyError()}};
}

std::string textOf(const Simulation& simulation, const std::string& out) {
  char samples[80], charge[80];
  std::snprintf(samples, sizeof samples, "%zu samples in %.2f s written to ",
                simulation.samples.size(), simulation.duration);
  std::snprintf(charge, sizeof charge, "; SOC %.4f to %.4f, %.3f Ah charged\n",
                simulation.soc_at_start, simulation.soc_at_end,
                simulation.balance.charge_in / kSecondsPerHour);
  return samples + shown(out) + charge;
}

void printSpectrum(const Scenario& scenario, const std::string& path, std::ostream& out) {
  const auto frequencies =
      logarithmicFrequencies(kLowestFrequency, kHighestFrequency, kPointsPerDecade);
  std::string text = "frequency_hz,real_ohm,imag_ohm,analytic_real_ohm,analytic_imag_ohm\n";
  char row[160];
  for (const auto& one : impedance(scenario.battery, scenario.effects, scenario.start,
                                   scenario.impedance_current, frequencies)) {
    std::snprintf(row, sizeof row, "%.8g,%.8g,%.8g,%.8g,%.8g\n", one.frequency,
                  one.simulated.real(), one.simulated.imag(), one.analytic.real(),
                  one.analytic.imag());
    text += row;
  }
  writeText(path, text);
  out << "impedance at " << scenario.impedance_current << " A, SOC " << scenario.start.soc
      << " written to " << shown(path) << "\n";
}

/// simulate(); what it says when there is no solution begins with the scenario's file.
Simulation solved(const Scenario& scenario, const SimulationOptions& options,
                  const std::string& file) {
  try {
    return simulate(scenario, options);
  } catch (const NoSolution& error) {
    throw NoSolution(file + ": " + error.what());
  }
}

void record(const Scenario& scenario, const Arguments& arguments, std::ostream& out,
            std::ostream& err) {
  SimulationOptions options;
  options.cut_after = arguments.duration;
  options.progress = progressOn(err, arguments.duration.value_or(scenario.duration));
  const Simulation simulation = solved(scenario, options, arguments.scenario);
  writeRecording(arguments.out, simulation.samples, Digits::kSensor,
                 scenario.effects.self_heating ? simulation.temperature : std::vector<double>{});
  const std::string json = jsonOf(scenario, simulation, arguments.out).dump(2) + "\n";
  if (!arguments.json.empty() && arguments.json != "-") writeText(arguments.json, json);
  out << (arguments.json == "-" ? json : textOf(simulation, arguments.out));
}

void run(const Arguments& arguments, std::ostream& out, std::ostream& err) {
  if (arguments.out.empty() && arguments.impedance.empty())
    throw std::invalid_argument("OUT is missing, and no --impedance asked for");
  if (!arguments.out.empty()) requireRecordingName(arguments.out);
  Scenario scenario = arguments.scenario.empty() ? parseScenario(kDemo, "sof demo")
                                                 : loadScenario(arguments.scenario);
  if (!arguments.impedance.empty() && anyOn(scenario.additions))
    throw std::invalid_argument(
        "--impedance: the spectrum is that of Fig. 4 without additions, but " + arguments.scenario +
        " has some");
  scenario.seed = arguments.seed.value_or(scenario.seed);
  if (arguments.out.empty() && !arguments.json.empty())
    throw std::invalid_argument("--json is of a recording, expected OUT");
  // With --json - standard output holds nothing but the document.
  std::ostream silent(nullptr);
  std::ostream& said = arguments.json == "-" ? silent : out;
  if (!arguments.impedance.empty()) printSpectrum(scenario, arguments.impedance, said);
  if (!arguments.out.empty()) record(scenario, arguments, out, err);
}

}  // namespace

int runSimulate(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err,
                const FileCheck& check) {
  CLI::App app(
      "Writes a simulated recording of a lead-acid battery (the paper's Fig. 4) at 100 Hz.\n"
      "Current is positive into the battery.",
      "sof simulate");
  Arguments parsed;
  addOptions(app, parsed);
  return runProgram(
      app, arguments, "sof",
      [&] {
        if (check) check({parsed.scenario}, {parsed.out, parsed.json, parsed.impedance});
        run(parsed, out, err);
      },
      out, err);
}

int runDemo(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err,
            const FileCheck& check) {
  CLI::App app(
      "Writes an example to try the other commands on: a start-stop car in town, simulated, "
      "current positive into the battery.",
      "sof demo");
  Arguments parsed;
  parsed.out = "drive.bag";
  app.add_option("OUT", parsed.out, "recording to write: .csv or .bag")->capture_default_str();
  app.add_option("--duration", parsed.duration, "duration [s], at most 900; 900 if not given")
      ->check(CLI::Range(1.0, 900.0));
  app.add_option("--json", parsed.json, "write the result as JSON; - for standard output");
  const auto work = [&] {
    if (check) check({}, {parsed.out, parsed.json});
    run(parsed, out, err);
    if (parsed.json == "-") return;
    out << "next: sof check " << shown(parsed.out) << "; sof identify " << shown(parsed.out)
        << " --out model.yaml; sof crank model.yaml --i-load -20 --t-stop 30 --i-cranking -200\n";
  };
  return runProgram(app, arguments, "sof", work, out, err);
}

}  // namespace battery_sof_simulator
