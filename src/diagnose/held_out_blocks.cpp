#include "battery_sof/diagnose/held_out_blocks.hpp"

#include <algorithm>
#include <cmath>

#include "battery_sof/identify/parallel.hpp"

namespace battery_sof {
namespace {

constexpr double kBeginning = 60.0;  // [s], always fitted: about a time constant of the double layer at rest
constexpr double kBlockNoise = 4.0;  // of -2 ln density: two standard deviations of one parameter's worth
constexpr double kRegion = 0.7;      // share of the samples on which an addition acts least
constexpr int kIterations = 6;  // from the optimum over all blocks, the one left out moves it by a fraction of itself

}  // namespace

HeldOut heldOutErrors(const WhitenedFit& fit, const Drive& drive, int blocks, int threads) {
  HeldOut held_out{Eigen::VectorXd::Zero(fit.residual.size()), std::vector<double>(static_cast<std::size_t>(blocks))};
  const Whitening whitening(fit.noise, drive.samples);
  // Without its beginning the state there would be anyone's guess.
  std::size_t begin = 0;
  while (begin < drive.samples.size() / 10 && drive.samples[begin].step.time < drive.first_time + kBeginning) ++begin;
  const std::size_t length = (drive.samples.size() - begin) / held_out.deviance.size() + 1;
  parallelFor(held_out.deviance.size(), threads, [&](std::size_t b) {
    const std::size_t first = begin + b * length, last = std::min(drive.samples.size(), first + length);
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
      held_out.deviance[b] += whitening.logVariance(n) + innovation[k] * innovation[k];
      held_out.error[k] = error[k];
    }
  });
  return held_out;
}

double leastActing(const Eigen::VectorXd& acts) {
  std::vector<double> sizes(acts.data(), acts.data() + acts.size());
  for (double& size : sizes) size = std::abs(size);
  const auto at = sizes.begin() + static_cast<std::ptrdiff_t>(kRegion * static_cast<double>(sizes.size() - 1));
  std::nth_element(sizes.begin(), at, sizes.end());
  return *at;
}

double addedRatio(const Eigen::VectorXd& adds, const Eigen::VectorXd& error, const Drive& drive) {
  double ratio = 0.0;
  for (const double least : {0.0, leastActing(adds)}) {
    double own = 0.0, all = 0.0;
    for (Eigen::Index n = 0; n < adds.size(); ++n) {
      const double count = drive.samples[static_cast<std::size_t>(n)].count;
      if (!(count > 0.0) || std::abs(adds[n]) < least) continue;
      own += count * adds[n] * adds[n];
      all += count * error[n] * error[n];
    }
    if (all > 0.0) ratio = std::max(ratio, std::sqrt(own / all));
  }
  return ratio;
}

double leastAddedRatio(double share) { return std::sqrt(1.0 / ((1.0 - share) * (1.0 - share)) - 1.0); }

HeldOutGain gainOf(const HeldOut& before, const HeldOut& after, const Drive& drive, const Eigen::VectorXd& acts) {
  HeldOutGain gain;
  for (std::size_t b = 0; b < before.deviance.size(); ++b) {
    const double by = before.deviance[b] - after.deviance[b];
    gain.deviance += by;
    gain.worse_blocks += by < -kBlockNoise;
  }
  for (const double least : {0.0, leastActing(acts)}) {
    double square_before = 0.0, square_after = 0.0;
    for (Eigen::Index n = 0; n < acts.size(); ++n) {
      const double count = drive.samples[static_cast<std::size_t>(n)].count;
      if (!(count > 0.0) || std::abs(acts[n]) < least) continue;
      square_before += count * before.error[n] * before.error[n];
      square_after += count * after.error[n] * after.error[n];
    }
    if (!(square_before > 0.0)) continue;
    const double share = 1.0 - std::sqrt(square_after / square_before);
    if (least == 0.0 || share > gain.rms_share) gain.rms_share = share;
  }
  return gain;
}

}  // namespace battery_sof
