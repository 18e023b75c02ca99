// What one pass over the window costs, per sample: ours and that of Ceres' Jets.
#include <benchmark/benchmark.h>
#include <ceres/cost_function.h>

#include <memory>

#include "battery_sof/model/base_model.hpp"
#include "ceres_fit.hpp"
#include "drive_window.hpp"

namespace {

using namespace battery_sof;
using namespace battery_sof_bench;

const DriveWindow& window() {
  static const DriveWindow shared = simulatedWindow();
  return shared;
}

void countSamples(benchmark::State& state) {
  state.SetItemsProcessed(static_cast<int64_t>(state.iterations() * window().samples.size()));
}

void sweepAndNormalEquations(benchmark::State& state) {
  const BaseNormalEquations equations(window().samples, BaseParameters{}.i0);
  for (auto _ : state) benchmark::DoNotOptimize(equations.sums({}));
  countSamples(state);
}
BENCHMARK(sweepAndNormalEquations)->Name("ours: sweep and normal equations");

void sweep(benchmark::State& state) {
  std::vector<HeldCurrent> held;
  for (const auto& sample : window().samples) held.push_back(sample.held);
  const OverpotentialSweep states(held, BaseParameters{}.i0);
  for (auto _ : state)
    states.run({}, [](Eigen::Index, const OverpotentialSweep::States& block) {
      benchmark::DoNotOptimize(block.u_c2.data());
      benchmark::ClobberMemory();
    });
  countSamples(state);
}
BENCHMARK(sweep)->Name("ours: of that the sweep, with derivatives");

void stepWithDerivatives(benchmark::State& state) {
  const OverpotentialStep step{BaseParameters{}};
  const Samples& samples = window().samples;
  for (auto _ : state) {
    Overpotential u;
    for (const auto& sample : samples)
      u = step.advance(u, sample.held.current, sample.held.duration);
    benchmark::DoNotOptimize(u);
  }
  countSamples(state);
}
BENCHMARK(stepWithDerivatives)->Name("ours: OverpotentialStep::advance");

/// Ceres' evaluation as its solver calls it; the product J'J is not in it.
void jets(benchmark::State& state, CeresForm form) {
  const std::unique_ptr<ceres::CostFunction> cost(makeCostFunction(window().samples, form));
  const double x[] = {1.0, 1.0, 1.0, 1.0, 1.0, 0.0};
  const double* blocks[] = {x};
  std::vector<double> residuals(window().samples.size());
  std::vector<double> jacobian(6 * residuals.size());
  double* jacobians[] = {jacobian.data()};
  for (auto _ : state) {
    cost->Evaluate(blocks, residuals.data(), jacobians);
    benchmark::ClobberMemory();
  }
  countSamples(state);
}
BENCHMARK_CAPTURE(jets, tuned, CeresForm::kTuned)->Name("Ceres tuned: residuals, Jacobian by Jets");
BENCHMARK_CAPTURE(jets, plain, CeresForm::kPlain)->Name("Ceres plain: residuals, Jacobian by Jets");

}  // namespace

BENCHMARK_MAIN();
