// What one pass over the window costs, per sample: ours and that of Ceres' Jets.
#include <benchmark/benchmark.h>
#include <ceres/cost_function.h>

#include <cmath>
#include <memory>

#include "ceres_fit.hpp"
#include "drive_window.hpp"
#include "model/base_model.hpp"
#include "model/closed_form_step.hpp"

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

/// The yardstick: an exponential a sample, of the values that the pass takes it of.
void bareExponentials(benchmark::State& state) {
  const BaseParameters p;
  std::vector<double> x;
  for (const auto& sample : window().samples)
    x.push_back(-0.5 * p.beta / p.c2 * sharesOf(sample.held.current, p.i0).R *
                sample.held.duration);
  for (auto _ : state) {
    double sum = 0.0;
    for (std::size_t n = 0; n < x.size(); ++n) sum += std::exp(x[n]);
    benchmark::DoNotOptimize(sum);
    benchmark::ClobberMemory();
  }
  countSamples(state);
}
BENCHMARK(bareExponentials)->Name("bare loop of std::exp");

void sweepAndNormalEquations(benchmark::State& state, InstructionSet set) {
  if (set > widestInstructionSet()) return state.SkipWithError("not on this processor");
  const BaseNormalEquations equations(window().samples, BaseParameters{}.i0);
  for (auto _ : state) benchmark::DoNotOptimize(equations.sums({}, set));
  countSamples(state);
}
BENCHMARK_CAPTURE(sweepAndNormalEquations, avx512, InstructionSet::kAvx512)
    ->Name("ours: one pass, AVX-512");
BENCHMARK_CAPTURE(sweepAndNormalEquations, avx2, InstructionSet::kAvx2)
    ->Name("ours: one pass, AVX2");
BENCHMARK_CAPTURE(sweepAndNormalEquations, plain, InstructionSet::kPlain)
    ->Name("ours: one pass, neither of them");

void stepWithDerivatives(benchmark::State& state) {
  const BaseParameters p;
  const Samples& samples = window().samples;
  for (auto _ : state) {
    ClosedFormSlopes at{};
    for (const auto& sample : samples) {
      at = closedFormSlopes(at.w, sample.held.current, p.i0,
                            0.5 * p.beta * sample.held.duration / p.c2);
      benchmark::DoNotOptimize(at);
    }
  }
  countSamples(state);
}
BENCHMARK(stepWithDerivatives)->Name("ours: closedFormSlopes(), sample by sample");

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
