#include "diagnosis/residuals.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "diagnosis/parameter_bias.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr std::size_t kCompressFrom = 4000;  // samples
// sampling intervals that may be averaged where the current is held
constexpr double kSlowLength = 10.0;
constexpr double kEdge = 5.0;  // [A]
// [s], docs/physics.md#noise-of-a-residual; a channel may be late
constexpr double kBeforeEdge = 0.1, kAfterEdge = 0.15;
// rounding to more than this many deviations of the noise
constexpr double kCoarse = 3.0;
constexpr double kDeepShare = 0.25;  // of the largest discharge: a starter turns at 0.4 of its rush
constexpr double kMinNoise = 1e-5;   // [V]
constexpr double kRoughNoise = 0.001;  // [V]
constexpr int kMoreStarts = 6;

void takeDrives(Residuals& residuals) {
  const Screening& screened = residuals.screened;
  const IndexRange train = residuals.parts.train;
  const double longest = std::max(kLongestStretch, kSlowLength * medianInterval(screened.series));
  InputSequence& inputs = residuals.inputs;
  inputs = train.size() > kCompressFrom
               ? compressedInputs(screened.series, train, longest, screened.limits.masked)
               : inputSequence(screened.series, train, screened.limits.masked);
  if (!screened.slow)
    inputs = withoutEdges(inputs, std::numeric_limits<double>::infinity(), 0.0, kAfterEdge);
  residuals.quiet = screened.slow ? inputs : withoutEdges(inputs, kEdge, kBeforeEdge, kAfterEdge);
}

/// [A], the largest measured discharge, as a magnitude.
double deepestOf(const InputSequence& inputs) {
  double deepest = 0.0;
  for (const InputSample& sample : inputs.samples)
    if (sample.count > 0.0) deepest = std::max(deepest, -sample.step.current);
  return deepest;
}

/// Whether too little is left without the surroundings of edges: too few samples, or none of the
/// pulses that determine the resistance. Pulses a second long leave hardly a sample at 10 Hz, and
/// those of a robot follow one another at any rate.
bool needsEdges(const Residuals& residuals) {
  return !residuals.screened.slow &&
         (!hasTwoHalves(residuals.quiet) ||
          deepestOf(residuals.quiet) < kDeepShare * deepestOf(residuals.inputs));
}

void fitBase(Residuals& residuals) {
  const double lsb = residuals.screened.limits.voltage_lsb_std;
  residuals.search.min_white = std::max(kMinNoise, lsb);
  const BatteryModel model;
  residuals.base = fitWhitened(model, residuals.quiet, {typicalStart(model, residuals.quiet)},
                               std::nullopt, residuals.search);
  std::vector<std::string>& faults = residuals.screened.faults;
  if (lsb > kCoarse * kRoughNoise && lsb > 0.5 * residuals.base.noise.white_std &&
      !contains(faults, "quantisation"))
    faults.push_back("quantisation");
}

InputSequence partOf(const InputSequence& inputs, std::size_t begin, std::size_t end) {
  InputSequence part = inputs;
  part.samples.assign(inputs.samples.begin() + static_cast<std::ptrdiff_t>(begin),
                      inputs.samples.begin() + static_cast<std::ptrdiff_t>(end));
  part.samples.front().step.duration = 0.0;
  part.first_time = part.samples.front().step.time;
  return part;
}

/// Exchange test on the halves of the training part: where a half fits better with the other's
/// parameters than with its own, a search stopped early. The base model is then searched from more
/// starts.
void exchangeHalves(Residuals& residuals) {
  const InputSequence& quiet = residuals.quiet;
  if (!hasTwoHalves(quiet)) return;
  WhitenedFit& base = residuals.base;
  const std::size_t middle = quiet.samples.size() / 2;
  const InputSequence first = partOf(quiet, 0, middle),
                      second = partOf(quiet, middle, quiet.samples.size());
  const BatteryModel model;
  WhitenedSearch once = residuals.search;
  once.rounds = 1;
  const auto fitOf = [&](const InputSequence& part) {
    return fitWhitened(model, part, {base.point, typicalStart(model, part)}, base.noise, once);
  };
  const WhitenedFit one = fitOf(first), other = fitOf(second);
  if (!optimiserFailed(first, one, other.point.parameters) &&
      !optimiserFailed(second, other, one.point.parameters))
    return;
  residuals.screened.sentences.push_back(
      "the search for the base model stopped early in one half of the recording and was repeated "
      "from more starting points");
  WhitenedSearch wider = residuals.search;
  wider.more_starts = kMoreStarts;
  const WhitenedFit again =
      fitWhitened(model, quiet, {base.point, one.point, other.point}, base.noise, wider);
  if (again.deviance < base.deviance) base = again;
}

}  // namespace

Parts partsOf(const Series& series, double holdout_share) {
  const auto held =
      static_cast<std::size_t>(std::ceil(holdout_share * static_cast<double>(series.size())));
  const std::size_t trained = series.size() - std::min(series.size(), held);
  return {{0, trained}, {trained, series.size()}};
}

Residuals residualsOf(const Recording& recording, const Parts& parts,
                      const DiagnoseOptions& options) {
  Residuals residuals;
  residuals.parts = parts;
  residuals.crank_current = options.crank_current.value_or(kCrankCurrent);
  tell(options, "checking the instruments");
  residuals.screened = screenInstruments(recording, slice(recording.series, parts.train));
  tell(options, "fitting the base model");
  takeDrives(residuals);
  if (needsEdges(residuals)) {
    residuals.screened = screenInstruments(recording, slice(recording.series, parts.train), true);
    takeDrives(residuals);
  }
  residuals.lack = lackOfMeasurements(residuals.quiet);
  if (residuals.lack) return residuals;
  residuals.search.pulse = options.pulse;
  residuals.search.priors = options.priors;
  fitBase(residuals);
  exchangeHalves(residuals);
  return residuals;
}

void tell(const DiagnoseOptions& options, const std::string& stage) {
  if (options.progress) options.progress(stage);
  pulse(options);
}

void pulse(const DiagnoseOptions& options) {
  if (options.pulse) options.pulse();
}

}  // namespace battery_sof
