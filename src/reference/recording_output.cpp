#include "reference/recording_output.hpp"

#include <rosbag/bag.h>
#include <sensor_msgs/BatteryState.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <limits>
#include <stdexcept>

namespace battery_sof_reference {
namespace {

namespace fs = std::filesystem;
constexpr char kTopic[] = "/battery_state";
constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

/// Has a file written beside its place and moved there when it is complete.
void writeWhole(const fs::path& path, const std::function<void(const fs::path&)>& write) {
  fs::path beside = path;
  beside += "." + std::to_string(::getpid()) + ".part";
  try {
    if (fs::exists(path) && !fs::is_regular_file(path)) throw std::runtime_error("not a file");
    write(beside);
    fs::rename(beside, path);
  } catch (const std::exception& error) {
    std::error_code ignored;
    fs::remove(beside, ignored);
    throw std::runtime_error(path.string() + ": cannot be written (" + error.what() + ")");
  }
}

void writeRows(const fs::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (!file) throw std::runtime_error("no such folder, no permission, or no space");
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

sensor_msgs::BatteryState messageOf(const RecordedSample& sample, float temperature) {
  sensor_msgs::BatteryState message;
  message.header.stamp.fromNSec(static_cast<std::uint64_t>(std::llround(sample.time * 1e9)));
  message.current = static_cast<float>(sample.current);
  message.voltage = static_cast<float>(sample.voltage);
  message.temperature = temperature;
  message.charge = message.capacity = message.design_capacity = message.percentage = kUnknown;
  message.present = 1;
  return message;
}

void writeBag(const fs::path& path, const Simulation& simulation, bool with_temperature) {
  rosbag::Bag bag(path.string(), rosbag::bagmode::Write);
  for (std::size_t n = 0; n < simulation.samples.size(); ++n) {
    const float temperature =
        with_temperature ? static_cast<float>(simulation.temperature[n]) : kUnknown;
    const auto message = messageOf(simulation.samples[n], temperature);
    bag.write(kTopic, std::max(message.header.stamp, ros::TIME_MIN), message);
  }
  bag.close();
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
  writeWhole(path, [&](const fs::path& beside) { writeBag(beside, simulation, with_temperature); });
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
  writeWhole(path, [&](const fs::path& beside) { writeRows(beside, text); });
}

}  // namespace battery_sof_reference
