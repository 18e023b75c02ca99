#include "simulator/recording_output.hpp"

#include <cerrno>
#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <system_error>

#include "simulator/bag_output.hpp"
#include "simulator/whole_file.hpp"

namespace battery_sof_simulator {
namespace {

namespace fs = std::filesystem;

void writeRows(const fs::path& path, const std::string& text) {
  errno = 0;
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (!file) throw std::system_error(errno != 0 ? errno : EIO, std::generic_category());
}

std::string csvOf(const Simulation& simulation, bool with_temperature, Digits digits) {
  std::string text = "time_s,current_a,voltage_v";
  text += with_temperature ? ",temperature_c\n" : "\n";
  char cells[120];
  for (std::size_t n = 0; n < simulation.samples.size(); ++n) {
    const RecordedSample& sample = simulation.samples[n];
    const int more = digits == Digits::kMany ? 3 : 0;
    std::snprintf(cells, sizeof cells, "%.10g,%.*g,%.*g", sample.time, 7 + more, sample.current,
                  8 + more, sample.voltage);
    text += cells;
    if (with_temperature) {
      std::snprintf(cells, sizeof cells, ",%.6g", simulation.temperature[n]);
      text += cells;
    }
    text += "\n";
  }
  return text;
}

}  // namespace

bool isRecordingName(const fs::path& path) {
  return path.extension() == ".csv" || path.extension() == ".bag";
}

void writeRecording(const fs::path& path, const Simulation& simulation, bool with_temperature,
                    Digits digits) {
  if (!isRecordingName(path))
    throw std::invalid_argument(path.string() + ": expected a name ending in .csv or .bag");
  if (path.extension() == ".csv")
    return writeText(path, csvOf(simulation, with_temperature, digits));
  writeWhole(path, [&](const fs::path& name) { writeBag(name, simulation, with_temperature); });
}

void writeImpedance(const fs::path& path, const std::vector<ImpedancePoint>& spectrum) {
  std::string text = "frequency_hz,real_ohm,imag_ohm,analytic_real_ohm,analytic_imag_ohm\n";
  char row[160];
  for (const ImpedancePoint& point : spectrum) {
    std::snprintf(row, sizeof row, "%.8g,%.8g,%.8g,%.8g,%.8g\n", point.frequency,
                  point.simulated.real(), point.simulated.imag(), point.analytic.real(),
                  point.analytic.imag());
    text += row;
  }
  writeText(path, text);
}

void writeText(const fs::path& path, const std::string& text) {
  writeWhole(path, [&](const fs::path& name) { writeRows(name, text); });
}

}  // namespace battery_sof_simulator
