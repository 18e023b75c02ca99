#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>

#include "simulator/city_drive.hpp"
#include "simulator/program_frame.hpp"
#include "simulator/recording_output.hpp"

using namespace battery_sof_simulator;

int main(int argc, char** argv) {
  CLI::App app("Writes a simulated city drive of a start-stop car as CSV at 100 Hz.");
  CityDriveOptions options;
  std::string out;
  app.add_option("OUT", out, "CSV file to write")->required();
  app.add_option("--seed", options.seed, "the same seed gives the same drive")
      ->capture_default_str();
  app.add_option("--duration", options.duration, "[s]")->capture_default_str();
  const auto work = [&] {
    std::string text = "time_s,current_a,voltage_v\n";
    char row[80];
    for (const RecordedSample& sample : simulateCityDrive(options)) {
      std::snprintf(row, sizeof row, "%.3f,%.6g,%.8g\n", sample.time, sample.current,
                    sample.voltage);
      text += row;
    }
    writeText(out, text);
  };
  return runProgram(app, {argv + 1, argv + argc}, "simulate_city_drive", work, std::cout,
                    std::cerr);
}
