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

void addBeyondWindow(Reasons& reasons, const ExcitedRange& seen,
                     const std::vector<double>& current) {
  const auto [low, high] = std::minmax_element(current.begin(), current.end());
  if (*low < kCurrentReach * std::min(seen.min_current, 0.0) ||
      *high > kCurrentReach * std::max(seen.max_current, 0.0))
    reasons.push_back({ReasonKind::kProfile, {*low, *high, seen.min_current, seen.max_current}});
}

}  // namespace

Faults faultsOfProfile(const std::vector<double>& time, const std::vector<double>& current) {
  if (time.empty() && current.empty())
    return {"the profile is empty, expected at least one sample"};
  const auto fault = faultOf(time, current, "profile", kMaxProfileSamples);
  return fault ? Faults{*fault} : Faults{};
}

ProfileAnswer simulateProfile(const FittedModel& model, const std::vector<double>& time,
                              const std::vector<double>& current, const WorkWatch& watch) {
  ProfileAnswer answer;
  if (isRefused(answer, model.fit, faultsOfProfile(time, current))) return answer;
  Simulation simulation = uncertainSimulationOf(model);
  const ResidualFilter errors(model);
  const double own = model.fit.noise ? model.fit.noise->white_std : model.fit.scores.rmse;
  Reasons reasons;
  addBeyondWindow(reasons, model.fit.excited, current);
  std::optional<Reason> says_nothing;  // of the first sample whose interval does not
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
    if (!says_nothing && (says_nothing = voltageSaysNothing(model.fit, u))) {
      says_nothing->kind = ReasonKind::kWideSample;
      says_nothing->numbers.back() = static_cast<double>(n);
    }
    append(answer.predicted, ofSeries(u, model.fit.series_blocks));
    time_before = time[n];
    current_before = current[n];
  }
  if (says_nothing) reasons.push_back(*says_nothing);
  for (const Reason& denial : denialOf(model)) reasons.push_back(denial);
  answer.message = format("%zu voltages", time.size());
  judge(answer, reasons, model.fit.series_blocks);
  return answer;
}

}  // namespace battery_sof
