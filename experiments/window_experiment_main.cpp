#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "battery_sof/csv.hpp"
#include "window_experiment.hpp"

namespace {

using namespace battery_sof;

void printRow(const std::string& recording, const std::string& setting, int window,
              const experiments::WindowResult& r) {
  const auto& errors = r.crank_errors;
  const double count = std::max<double>(static_cast<double>(errors.size()), 1.0);
  const double mean = std::accumulate(errors.begin(), errors.end(), 0.0) / count;
  double square = 0.0;
  for (double e : errors) square += (e - mean) * (e - mean) / count;
  const auto& p = r.model.fit.parameters;
  std::printf("%s,\"%s\",%d,%.2f,%.3f,%.3f,%.5f,%.5f,%d,%d,%s,%.6f,%.6f,%.3f,%.4f,%.4f\n",
              recording.c_str(), setting.c_str(), window, r.model.fit.window.from,
              r.model.fit.scores.q_dyn_percent, r.hour.q_dyn_percent.value_or(NAN), mean,
              std::sqrt(square), r.model.fit.scores.cranks, r.model.fit.iterations,
              toString(r.model.fit.status).c_str(), p.r_discharge, p.r_charge, p.c2, p.beta,
              p.u_dc);
}

void runRecording(const std::string& path) {
  const Recording recording = readCsv(path);
  const auto starts = experiments::paperWindowStarts(recording.series);
  for (const auto& setting : experiments::settings())
    for (std::size_t k = 0; k < starts.size(); ++k)
      printRow(recording.name, setting.name, static_cast<int>(k) + 1,
               experiments::runWindow(recording.series, starts[k], setting));
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Fits the paper's windows of recordings under every setting and scores each on the whole "
      "recording (CSV).");
  std::vector<std::string> recordings;
  app.add_option("REC", recordings, "CSV recordings")->required();
  CLI11_PARSE(app, argc, argv);
  std::puts(
      "recording,setting,window,from_s,q_window_percent,q_hour_percent,crank_mae_v,crank_sd_v,"
      "pulses,iterations,status,"
      "r_discharge_ohm,r_charge_ohm,c2_f,beta_per_v,u_dc_v");
  try {
    for (const auto& path : recordings) runRecording(path);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "window_experiment: %s\n", error.what());
    return 2;
  }
  return 0;
}
