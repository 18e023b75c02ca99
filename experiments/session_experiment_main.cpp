#include <CLI/CLI.hpp>
#include <cstdio>

#include "battery_sof/predict/online_session.hpp"
#include "battery_sof/recording/csv.hpp"

namespace {

using namespace battery_sof;

void print(const std::string& recording, const SessionEvents& events, const OnlineSession& session) {
  for (const CrankComparison& c : events.cranks)
    std::printf("%s,crank,%.2f,%.2f,%.4f,%.4f,%.4f,%.4f,%.4f\n", recording.c_str(), c.time, c.current,
                c.measured_minimum, c.expected_minimum.value, c.expected_minimum.lower,
                c.expected_minimum.upper, session.crankScale().factor);
  for (const ChargeComparison& c : events.charges)
    std::printf("%s,charge,%.2f,%.3f,%.4f,%.4f,%.4f,%.4f,%.4f\n", recording.c_str(), c.time, c.mean_voltage,
                c.measured_current, c.expected_current.value, c.expected_current.lower,
                c.expected_current.upper, session.chargeScale().factor);
}

/// Plays a recording through a session; identifications end before the next sample.
void play(const std::string& path, const CsvColumns& columns, const SessionOptions& options,
          const std::vector<std::string>& extension) {
  const Recording recording = readCsv(path, columns);
  OnlineSession session(options);
  if (!extension.empty()) session.extendWith(extension);
  for (std::size_t n = 0; n < recording.series.size(); ++n) {
    const SessionEvents events = session.push(
        {recording.series.time[n], recording.series.current[n], recording.series.voltage[n],
         std::nullopt});
    print(recording.name, events, session);
    if (auto job = session.takeDueJob()) {
      session.finish(runIdentification(*job));
      if (!extension.empty()) std::fprintf(stderr, "%.0f s: %s\n", *session.newestTime(), session.status().extension.c_str());
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Plays recordings (CSV) through a session and prints every crank and charge with what was expected.");
  std::vector<std::string> recordings;
  std::vector<std::string> extension;
  SessionOptions options;
  CsvColumns columns;
  app.add_option("REC", recordings, "CSV recordings")->required();
  app.add_option("--effects", options.identify.effects, "ids of further physics")->delimiter(',');
  app.add_option("--extend", extension, "ids on trial beside the base model; standard error says who answers")->delimiter(',');
  app.add_option("--identify-period", options.identify_period, "[s]");
  app.add_option("--time-column", columns.time);
  app.add_option("--current-column", columns.current);
  app.add_option("--voltage-column", columns.voltage);
  app.add_flag("--discharge-positive", columns.discharge_positive);
  CLI11_PARSE(app, argc, argv);
  std::puts("recording,kind,time_s,current_a_or_voltage_v,measured,expected,lower,upper,scale");
  try {
    for (const auto& path : recordings) play(path, columns, options, extension);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "session_experiment: %s\n", error.what());
    return 2;
  }
  return 0;
}
