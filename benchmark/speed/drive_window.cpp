#include "drive_window.hpp"

#include <algorithm>
#include <stdexcept>

#include "estimation/identification.hpp"
#include "estimation/window.hpp"
#include "recording/events.hpp"
#include "simulator/city_drive.hpp"

namespace battery_sof_bench {
namespace {

using namespace battery_sof;

constexpr std::size_t kFourMinutes = 24000;  // samples at 100 Hz

Series simulatedDrive() {
  battery_sof_simulator::CityDriveOptions options;
  options.seed = 1;
  options.duration = 900.0;
  Series series;
  for (const auto& sample : battery_sof_simulator::simulateCityDrive(options)) {
    series.append({sample.time, sample.current, sample.voltage});
  }
  return series;
}

bool holdsCrank(const Series& series) {
  const auto events = detectEvents(series);
  return std::any_of(events.begin(), events.end(),
                     [](const Event& event) { return event.kind == EventKind::kCrank; });
}

}  // namespace

DriveWindow simulatedWindow() {
  const Series drive = simulatedDrive();
  const WindowChoice choice = chooseWindow(drive, {0, drive.size()});
  if (!choice.range) throw std::runtime_error("benchmark window: " + choice.message);
  DriveWindow window;
  window.series = slice(drive, *choice.range);
  window.max_gap = gapThreshold(window.series);
  if (window.series.size() < kFourMinutes || !holdsCrank(window.series))
    throw std::runtime_error("benchmark window: " + choice.message + ", but no crank or too short");
  const std::vector<char> none;
  window.samples = WindowSamples{window.series, window.range(), {}, window.max_gap, none}.copied();
  return window;
}

}  // namespace battery_sof_bench
