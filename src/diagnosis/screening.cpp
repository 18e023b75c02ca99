#include "diagnosis/screening.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "recording/checks.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

// of the training part, as a noise model requires: nearly three for every unknown of base model and
// noise (docs/diagnosis.md)
constexpr std::size_t kMinSamples = 30;
// [s] of the training part: half of what the slow state takes at rest (docs/physics.md, Base circuit)
constexpr double kMinDuration = 22.0;
constexpr double kMinCharge = 20.0;   // [As] of discharge; twice of it in all
constexpr double kSlow = 0.15;        // [s]; sampled more slowly, edges cannot be set aside
constexpr double kLostShare = 0.005;  // of the samples; a second in three minutes
constexpr std::size_t kFewestFreezes = 3;
constexpr double kCoarseVoltage =
    // [V], 10 mV but for printed digits; most effects leave less than 20 mV
    // (docs/physics.md#visibility)
    0.0099;
// [A], 0.5 A: the offset of docs/physics.md#current_offset
constexpr double kCoarseCurrent = 0.495;
// of the samples repeat the one before: noise of less than a step
constexpr double kStillShare = 0.25;

/// Whether a step is large in itself and the channel's noise is less, so that rounding is most of
/// the error.
bool isCoarse(const Finding& quantisation, const Series& series) {
  const bool is_voltage = quantisation.unit == "V";
  if (*quantisation.value < (is_voltage ? kCoarseVoltage : kCoarseCurrent)) return false;
  const std::vector<double>& values = is_voltage ? series.voltage : series.current;
  std::size_t repeats = 0;
  for (std::size_t k = 1; k < values.size(); ++k)
    if (values[k] == values[k - 1]) ++repeats;
  return medianInterval(series) <= kSlow &&
         static_cast<double>(repeats) > kStillShare * static_cast<double>(values.size());
}

/// The catalogue's id of a finding of the checks; none for what is not a fault of an instrument
/// that spoils a diagnosis. One sleep of the car is not a bus that drops messages, and a gap is no
/// fault.
std::optional<std::string> faultOf(const Finding& finding, const Series& series) {
  if (finding.id == "quantisation" && isCoarse(finding, series)) return finding.id;
  if (finding.severity == Severity::kNote || finding.id == "quantisation") return std::nullopt;
  if (finding.id == "clipping" || finding.id == "aliasing") return finding.id;
  const bool is_lost = finding.id == "stuck" || finding.id == "missing";
  const bool is_single = finding.id == "stuck" && finding.at.size() < kFewestFreezes;
  if (!is_lost || is_single ||
      static_cast<double>(finding.samples) < kLostShare * static_cast<double>(series.size()))
    return std::nullopt;
  return "dropouts";
}

/// Measurements of the first and of the second half.
std::pair<std::size_t, std::size_t> measuredInHalves(const InputSequence& inputs) {
  const auto begin = inputs.samples.begin(),
             middle = begin + static_cast<std::ptrdiff_t>(inputs.samples.size() / 2);
  const auto measured = [](const InputSample& sample) { return sample.count > 0.0; };
  return {static_cast<std::size_t>(std::count_if(begin, middle, measured)),
          static_cast<std::size_t>(std::count_if(middle, inputs.samples.end(), measured))};
}

/// @return values shifted to `by` samples later; what enters at an end is its neighbour.
std::vector<double> moved(const std::vector<double>& values, std::ptrdiff_t by) {
  const auto last = static_cast<std::ptrdiff_t>(values.size()) - 1;
  std::vector<double> shifted(values.size());
  for (std::ptrdiff_t n = 0; n <= last; ++n)
    shifted[n] = values[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(n - by, 0, last))];
  return shifted;
}

/// A channel that is whole samples late cannot be told from physics by a fit: the current is
/// moved to where the voltage answers to it. @param lag [s], > 0 when the voltage comes later.
void alignWholeSamples(Screening& screening, double lag) {
  const auto by = std::lround(lag / medianInterval(screening.series));
  if (!screening.slow || by == 0) return;
  screening.late_samples = by;
  screening.series.current = moved(screening.series.current, by);
  screening.faults.push_back("time_skew");
  screening.sentences.push_back("the current was shifted by " + std::to_string(by) +
                                " samples to align it with the voltage");
}

}  // namespace

std::optional<std::string> lackOf(const Series& train, double holdout_share, bool anyway) {
  // A sample lasts until the next.
  const double duration =
      train.size() < 2 ? 0.0 : train.time.back() - train.time.front() + medianInterval(train);
  const double whole = 1.0 - holdout_share;
  if (train.size() < kMinSamples || std::round(duration) < kMinDuration)
    return format(
        "the training part has %zu samples in %.0f s; a recording of at least %.0f samples and "
        "%.0f s is needed",
        train.size(), duration, std::ceil(kMinSamples / whole), std::ceil(kMinDuration / whole));
  const auto problems = anyway ? std::vector<Finding>() : findProblems(train);
  if (!problems.empty()) return format(problems);
  double charge = 0.0, discharge = 0.0;
  const double gap = gapThreshold(train);
  for (std::size_t k = 1; k < train.size(); ++k) {
    const double dt = train.time[k] - train.time[k - 1];
    if (dt > gap) continue;
    charge += std::max(0.0, train.current[k]) * dt;
    discharge += std::max(0.0, -train.current[k]) * dt;
  }
  if (discharge < kMinCharge) return "the training part hardly discharges the battery";
  if (charge + discharge < 2.0 * kMinCharge) return "the training part hardly moves any charge";
  return std::nullopt;
}

std::optional<std::string> lackOfMeasurements(const InputSequence& inputs) {
  const auto [in_first, in_second] = measuredInHalves(inputs);
  if (in_first + in_second >= kMinSamples) return std::nullopt;
  return format(
      "in the training part only %zu samples of the first half and %zu of the second are "
      "measurements (the others are cut off, stuck, repeated or next to a step of the current), "
      "but at least %zu are needed in all",
      in_first, in_second, kMinSamples);
}

bool hasTwoHalves(const InputSequence& inputs) {
  const auto [in_first, in_second] = measuredInHalves(inputs);
  return std::min(in_first, in_second) >= kMinSamples;
}

Screening screenInstruments(const Recording& recording, const Series& train, bool keeps_edges) {
  Recording part = recording;
  part.series = train;
  Screening found;
  found.limits = instrumentLimits(part.series);
  maskBehindUnknownCharge(part.series, found.limits);
  found.series = withEstimatedCurrent(part.series, found.limits);
  const CurrentFlicker flicker = currentFlicker(found.series);
  found.flicker_share = flicker.share;
  found.series = withoutSensorNoise(found.series, flicker);
  found.slow = keeps_edges || medianInterval(found.series) > kSlow;
  for (const Finding& finding : checkRecording(part).findings) {
    const std::optional<std::string> fault = faultOf(finding, part.series);
    if (finding.severity == Severity::kNote && !fault) continue;
    if (finding.id == "deep_discharge") continue;  // no instrument's, and of the whole recording
    found.sentences.push_back(finding.what + ": " + finding.meaning);
    if (fault) found.faults.push_back(*fault);
    if (finding.id != "skew" || !finding.value) continue;
    found.skew = finding.value;
    alignWholeSamples(found, *found.skew);
  }
  std::sort(found.faults.begin(), found.faults.end());
  found.faults.erase(std::unique(found.faults.begin(), found.faults.end()), found.faults.end());
  return found;
}

Series treatedAsScreened(const Series& whole, const Screening& screening) {
  CurrentFlicker flicker = currentFlicker(whole);
  flicker.share = screening.flicker_share;
  Series treated = withoutSensorNoise(whole, flicker);
  treated.current = moved(treated.current, screening.late_samples);
  std::copy(screening.series.current.begin(), screening.series.current.end(),
            treated.current.begin());
  return treated;
}

}  // namespace battery_sof
