// What a record of a given length costs: one pass with derivatives at full rate, one whole fit, memory. One length a
// process, so that its peak is its own.
#include <sys/resource.h>

#include <cstdlib>
#include <exception>
#include <iostream>
#include <nlohmann/json.hpp>

#include "composed_record.hpp"
#include "stopwatch.hpp"

namespace {

using namespace battery_sof;
using namespace battery_sof_bench;

/// Most memory the process ever held [MB].
double peakMegabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

nlohmann::json measured(double duration) {
  const BatteryModel model = composedModel();
  const Series series = composedRecord(model, composedTruth(model), duration);
  nlohmann::json result = {{"duration", duration}, {"samples", series.size()}};
  result["record_mb"] = peakMegabytes();

  CompositionFit fit;
  std::size_t compressed = 0;
  result["fit_ms"] = processorMilliseconds([&] {
    const Drive drive = compressedDrive(series, all(series));
    compressed = drive.samples.size();
    const CompositionPoint start = typicalStart(model, drive);
    const CompositionProblem problem(model, drive, {}, start);
    fit = fitComposition(problem, {start});
  });
  result["compressed"] = compressed;
  result["fit_passes"] = fit.passes;
  result["fit_mb"] = peakMegabytes();

  const Drive full = fullDrive(series, all(series));
  result["drive_mb"] = peakMegabytes();
  const CompositionProblem problem(model, full, {}, fit.point);
  NormalEquations at;
  result["pass_ms"] = processorMilliseconds([&] { problem.evaluate(fit.x, at); });
  result["pass_mb"] = peakMegabytes();
  result["noise"] = std::sqrt(at.cost / static_cast<double>(series.size()));
  return result;
}

}  // namespace

int main(int argc, char** argv) {
  const double duration = argc == 2 ? std::atof(argv[1]) : 0.0;
  if (!(duration > 0.0)) {
    std::cerr << "usage: composed_length SECONDS\n";
    return 2;
  }
  try {
    std::cout << measured(duration) << "\n";
  } catch (const std::exception& error) {
    std::cerr << "composed_length: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
