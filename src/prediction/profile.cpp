#include <algorithm>
#include <limits>

#include "model/input_sequence.hpp"
#include "prediction/questions.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr std::size_t kMaxProfileSamples = 3600000;  // an hour at 1 kHz

void append(PredictedVoltage& predicted, const Interval& u) {
  predicted.voltage.push_back(u.value);
  predicted.lower.push_back(u.lower);
  predicted.upper.push_back(u.upper);
}

std::string extrapolation(const Fit& fit, const std::vector<double>& current) {
  const auto [low, high] = std::minmax_element(current.begin(), current.end());
  if (*low >= kCurrentReach * std::min(fit.excited.min_current, 0.0) &&
      *high <= kCurrentReach * std::max(fit.excited.max_current, 0.0))
    return "";
  return format("the profile spans %.1f to %.1f A but the window only %.1f to %.1f A", *low, *high,
                fit.excited.min_current, fit.excited.max_current);
}

/// Of the first sample whose interval says nothing.
std::string emptiness(const Fit& fit, const PredictedVoltage& predicted) {
  for (std::size_t n = 0; n < predicted.voltage.size(); ++n) {
    const std::string reason =
        voltageSaysNothing(fit, {predicted.voltage[n], predicted.lower[n], predicted.upper[n]});
    if (!reason.empty()) return format("sample %zu: ", n) + reason;
  }
  return "";
}

}  // namespace

std::string faultsOfProfile(const std::vector<double>& time, const std::vector<double>& current) {
  if (time.empty() && current.empty()) return "the profile is empty, expected at least one sample";
  return faultOf(time, current, "profile", kMaxProfileSamples);
}

ProfileAnswer simulateProfile(const FittedModel& model, const std::vector<double>& time,
                              const std::vector<double>& current, const WorkWatch& watch) {
  ProfileAnswer answer;
  if (isRefused(answer, model.fit, faultsOfProfile(time, current))) return answer;
  Simulation simulation = uncertainSimulationOf(model);
  const ResidualFilter errors(model);
  const double own = model.fit.noise ? model.fit.noise->white_std : model.fit.scores.rmse;
  double time_before = 0.0;
  double current_before = model.state.current;
  for (std::size_t n = 0; n < time.size(); ++n) {
    if (isBrokenOff(answer, watch, n, time.size(), "samples")) return answer;
    InputStep step = inputStep(time_before, current_before, time[n], current[n],
                               std::numeric_limits<double>::infinity());
    step.time += model.state.time;
    simulation.advance(step);
    const Interval u =
        beginAtPresent(model, voltageAnswer(simulation, errors.forecast(time[n]), own, {}),
                       simulation.voltage(), current[n], time[n]);
    if (!areNumbers(u)) return withoutNumbers<ProfileAnswer>();
    append(answer.predicted, ofSeries(u, model.fit.series_blocks));
    time_before = time[n];
    current_before = current[n];
  }
  std::string reasons = extrapolation(model.fit, current);
  addReason(reasons, emptiness(model.fit, answer.predicted));
  addReason(reasons, denialOf(model));
  answer.message = format("%zu voltages", time.size());
  judge(answer, reasons);
  return answer;
}

}  // namespace battery_sof
