#include "stage_prepare.hpp"

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
constexpr double kMinNoise = 1e-5;     // [V]
constexpr double kRoughNoise = 0.001;  // [V]
constexpr int kMoreStarts = 6;

void takeDrives(Prepared& prepared) {
  const Screening& screened = prepared.screened;
  const IndexRange train = prepared.parts.train;
  Compression compression;
  compression.max_length =
      std::max(compression.max_length, kSlowLength * medianInterval(screened.series));
  InputSequence& inputs = prepared.inputs;
  inputs = train.size() > kCompressFrom
               ? compressedInputs(screened.series, train, compression, screened.limits.masked)
               : inputSequence(screened.series, train, screened.limits.masked);
  if (!screened.slow)
    inputs = withoutEdges(inputs, std::numeric_limits<double>::infinity(), 0.0, kAfterEdge);
  prepared.quiet = screened.slow ? inputs : withoutEdges(inputs, kEdge, kBeforeEdge, kAfterEdge);
}

void fitBase(Prepared& prepared) {
  const double lsb = prepared.screened.limits.voltage_lsb_std;
  prepared.search.min_white = std::max(kMinNoise, lsb);
  const BatteryModel model;
  prepared.base = fitWhitened(model, prepared.quiet, {typicalStart(model, prepared.quiet)},
                              std::nullopt, prepared.search);
  std::vector<std::string>& faults = prepared.screened.faults;
  if (lsb > kCoarse * kRoughNoise && lsb > 0.5 * prepared.base.noise.white_std &&
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

/// Exchange test on the halves of the training part: a half that fits better with the other's
/// parameters than with its own reports that a search stopped early, not of physics. The base model
/// is then searched from more starts.
void exchangeHalves(Prepared& prepared) {
  const InputSequence& quiet = prepared.quiet;
  WhitenedFit& base = prepared.base;
  const std::size_t middle = quiet.samples.size() / 2;
  const InputSequence first = partOf(quiet, 0, middle),
                      second = partOf(quiet, middle, quiet.samples.size());
  const BatteryModel model;
  WhitenedSearch once = prepared.search;
  once.rounds = 1;
  const auto fitOf = [&](const InputSequence& part) {
    return fitWhitened(model, part, {base.point, typicalStart(model, part)}, base.noise, once);
  };
  const WhitenedFit one = fitOf(first), other = fitOf(second);
  if (!optimiserFailed(exchangeOf({&first, &second}, {&one, &other}))) return;
  prepared.notes.push_back(
      "the base model's search stopped early in a half of the recording and was begun again from "
      "more starts");
  WhitenedSearch wider = prepared.search;
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

Prepared prepare(const Recording& recording, const Parts& parts, const DiagnoseOptions& options) {
  Prepared prepared;
  prepared.parts = parts;
  tell(options, "checking the instruments");
  prepared.screened = screenInstruments(recording, slice(recording.series, parts.train));
  prepared.notes = prepared.screened.sentences;
  tell(options, "fitting the base model");
  takeDrives(prepared);
  prepared.search.pulse = options.pulse;
  prepared.search.priors = options.priors;
  fitBase(prepared);
  exchangeHalves(prepared);
  return prepared;
}

ModelPoint beginningOf(const CompositionPoint& point, const InputSequence& inputs) {
  return {point.parameters, point.state, inputs.first_time, inputs.first_time};
}

void tell(const DiagnoseOptions& options, const std::string& stage) {
  if (options.progress) options.progress(stage);
  pulse(options);
}

void pulse(const DiagnoseOptions& options) {
  if (options.pulse) options.pulse();
}

}  // namespace battery_sof
