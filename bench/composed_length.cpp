// What a record of a given length costs: one pass with derivatives at full rate, one whole fit,
// memory. One length a process, so that its peak is its own.
#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "composed_record.hpp"
#include "program.hpp"
#include "stopwatch.hpp"

namespace {

using namespace battery_sof;
using namespace battery_sof_bench;

constexpr int kPasses = 3;

/// A line of this program's status [MB].
double megabytes(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.rfind(name, 0) == 0) return std::stod(line.substr(name.size())) / 1024.0;
  throw std::runtime_error("/proc/self/status has no " + name);
}

/// Most memory that a call holds beyond what was there before [MB].
template <typename Work>
double extraMegabytes(const Work& work) {
  malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << "5";  // the peak begins again
  const double before = megabytes("VmRSS:");
  work();
  return megabytes("VmHWM:") - before;
}

nlohmann::json measured(double duration) {
  const BatteryModel model = composedModel();
  const Series series = composedRecord(model, composedTruth(model), duration);
  nlohmann::json result = {{"duration", duration}, {"samples", series.size()}};
  malloc_trim(0);
  result["record_mb"] = megabytes("VmRSS:");
  CompositionFit fit;
  result["fit_mb"] = extraMegabytes([&] {
    result["fit_ms"] = processorMilliseconds([&] {
      const InputSequence inputs = compressedInputs(series, all(series));
      result["compressed"] = inputs.samples.size();
      const CompositionPoint start = typicalStart(model, inputs);
      const CompositionProblem problem(model, inputs, {}, start);
      fit = fitComposition(problem, {start});
    });
  });
  result["fit_passes"] = fit.passes;

  NormalEquations at;
  double least = HUGE_VAL;
  result["pass_mb"] = extraMegabytes([&] {
    const InputSequence full = inputSequence(series, all(series));
    const CompositionProblem problem(model, full, {}, fit.point);
    for (int k = 0; k < kPasses; ++k)
      least = std::min(least, processorMilliseconds([&] { problem.evaluate(fit.x, at); }));
  });
  result["pass_ms"] = least;
  result["noise"] = std::sqrt(at.cost / static_cast<double>(series.size()));
  return result;
}

}  // namespace

int main(int argc, char** argv) {
  return runBenchmark<double>(argc, argv, "composed_length SECONDS",
                              [](double duration) { std::cout << measured(duration) << "\n"; });
}
