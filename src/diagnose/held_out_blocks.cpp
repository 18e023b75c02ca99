#include "battery_sof/diagnose/held_out_blocks.hpp"

#include <cmath>

#include "battery_sof/identify/noise_filter.hpp"
#include "battery_sof/identify/parallel.hpp"

namespace battery_sof {
namespace {

constexpr int kIterations = 6;  // from the optimum over all blocks, the one left out moves it by a fraction of itself

/// ln of the innovations' variances, one a sample.
std::vector<double> logVariances(const NoiseModel& noise, const Drive& drive) {
  NoiseFilter<double> filter(noise.white_std * noise.white_std, noise.ar_std * noise.ar_std, noise.ar_time,
                             noise.walk_std * noise.walk_std);
  std::vector<double> logs;
  bool first = true;
  for (const DriveSample& sample : drive.samples) {
    if (sample.count > 0.0) {
      logs.push_back(std::log(filter.step(sample.step.duration, sample.count, first).variance));
    } else {
      if (!first) filter.wait(sample.step.duration);
      logs.push_back(0.0);
    }
    first = false;
  }
  return logs;
}

}  // namespace

std::vector<BlockError> heldOutErrors(const WhitenedFit& fit, const Drive& drive, int blocks, int threads) {
  std::vector<BlockError> errors(static_cast<std::size_t>(blocks));
  const Whitening whitening(fit.noise, drive.samples);
  const std::vector<double> logs = logVariances(fit.noise, drive);
  const std::size_t length = drive.samples.size() / errors.size() + 1;
  parallelFor(errors.size(), threads, [&](std::size_t b) {
    const std::size_t first = b * length, last = std::min(drive.samples.size(), first + length);
    Drive others = drive;
    for (std::size_t n = first; n < last; ++n) others.samples[n].count = 0.0;
    FitCost cost;
    cost.noise = fit.noise;
    const CompositionProblem problem(fit.model, others, cost, fit.point);
    CompositionSearch search;
    search.max_iterations = kIterations;
    const CompositionFit found = fitComposition(problem, {fit.point}, search);
    const Eigen::VectorXd error = problem.residual(found.x);
    const Eigen::VectorXd innovation = whitening.whitened(error);
    for (std::size_t n = first; n < last; ++n) {
      if (!(drive.samples[n].count > 0.0)) continue;
      const auto k = static_cast<Eigen::Index>(n);
      errors[b].deviance += logs[n] + innovation[k] * innovation[k];
      errors[b].square += error[k] * error[k] * drive.samples[n].count;
      errors[b].samples += drive.samples[n].count;
    }
  });
  return errors;
}

}  // namespace battery_sof
