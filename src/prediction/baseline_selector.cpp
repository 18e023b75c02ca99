#include "prediction/baseline_selector.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "prediction/interval_calibration.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr double kCurrentReach = 1.25;  // as extrapolationOf()
constexpr double kVoltageReach = 0.5;   // [V], as correctChargePrediction()
constexpr double kLongerOrShorter = 2.0;
constexpr const char* kWarning = "; outside the identified range: ";

Interval scaled(const Interval& baseline, const IntervalCalibration& scale) {
  return {baseline.value, baseline.value + scale.factor * (baseline.lower - baseline.value),
          baseline.value + scale.factor * (baseline.upper - baseline.value)};
}

double lowestCurrent(const CrankingQuery& query) {
  if (query.crank.empty()) return query.i_cranking;
  return *std::min_element(query.crank.current.begin(), query.crank.current.end());
}

bool isAlike(const CrankingQuery& query, const BaselineSelection& selection) {
  const double t_stop = query.load.empty() ? query.t_stop : query.load.duration();
  return lowestCurrent(query) >= kCurrentReach * selection.least &&
         t_stop <= BaselineSelector::kSpan;
}

bool isAlike(const ChargeAcceptanceQuery& query, const BaselineSelection& selection) {
  return query.u_boost >= selection.least - kVoltageReach &&
         query.u_boost <= selection.most + kVoltageReach &&
         query.t_sof2 * kLongerOrShorter >= selection.shortest &&
         query.t_sof2 <= kLongerOrShorter * selection.longest;
}

/// What a model's message says of the model's validity.
std::string warningOf(const std::string& message) {
  const auto at = message.find(kWarning);
  return at == std::string::npos ? std::string() : message.substr(at);
}

}  // namespace

Interval BaselineSelector::add(const EventComparison& event) {
  const Interval baseline = scaled(*event.baseline, calibration_);
  update(calibration_, event.measured, baseline);
  events_.push_back(event);
  while (events_.size() > kEvents && events_.front().time < event.time - kSpan) events_.pop_front();
  const BaselineScore now = score();
  if (now.events < kMinEvents) return baseline;
  baseline_selected_ =
      now.model_error > (baseline_selected_ ? 1.0 : kTolerated) * now.baseline_error;
  return baseline;
}

void BaselineSelector::moveBy(double moved) {
  for (EventComparison& event : events_) event.time += moved;
}

BaselineScore BaselineSelector::score() const {
  BaselineScore score;
  score.events = static_cast<int>(events_.size());
  score.baseline_selected = baseline_selected_;
  for (const EventComparison& event : events_) {
    score.model_error += std::abs(event.measured - event.expected.value) / score.events;
    score.baseline_error += std::abs(event.measured - event.baseline->value) / score.events;
  }
  return score;
}

BaselineSelection BaselineSelector::selection() const {
  BaselineSelection selection{score(), calibration_, 0.0, 0.0, 0.0, 0.0};
  if (events_.empty()) return selection;
  const auto by = [&](auto&& number) {
    const auto [least, most] =
        std::minmax_element(events_.begin(), events_.end(),
                            [&](const auto& a, const auto& b) { return number(a) < number(b); });
    return std::pair(number(*least), number(*most));
  };
  std::tie(selection.least, selection.most) = by([](const PastEvent& e) { return e.stimulus(); });
  std::tie(selection.shortest, selection.longest) =
      by([](const PastEvent& e) { return e.duration; });
  return selection;
}

CrankingAnswer betterOf(CrankingAnswer answer, const CrankingQuery& query,
                        const BaselinePredictor& baseline, const BaselineSelection& selection,
                        double series_blocks) {
  if (!selection.score.baseline_selected || !answer.u_min || !isAlike(query, selection))
    return answer;
  const auto minimum = baselineCrankMinimum(baseline, lowestCurrent(query));
  if (!minimum) return answer;
  answer.u_min = ofSeries(scaled(*minimum, selection.scale), series_blocks);
  if (query.u_required) answer.capable = answer.u_min->lower >= *query.u_required;
  std::string message = sentenceOf(answer, query.u_required);
  message +=
      format("; %s answers: it missed %.3f V where the model missed %.3f V",
             baselineCrankName(baseline).c_str(), series_blocks * selection.score.baseline_error,
             series_blocks * selection.score.model_error);
  answer.message = message + warningOf(answer.message);
  return answer;
}

ChargeAcceptanceAnswer betterOf(ChargeAcceptanceAnswer answer, const ChargeAcceptanceQuery& query,
                                const BaselinePredictor& baseline,
                                const BaselineSelection& selection, double series_blocks) {
  ChargeAcceptanceQuery of_one = query;
  of_one.u_boost /= series_blocks;
  if (!selection.score.baseline_selected || !answer.i_boost || !isAlike(of_one, selection))
    return answer;
  const auto current = baselineChargeCurrent(baseline, of_one.u_boost, query.t_sof2);
  if (!current) return answer;
  Interval i_boost = scaled(*current, selection.scale);
  for (double* bound : {&i_boost.value, &i_boost.lower, &i_boost.upper})
    *bound = std::min(*bound, query.i_limit);
  answer.i_boost = i_boost;
  const std::string message =
      format("mean current %.1f A over %.1f s at %.2f V, 90 %% between %.1f and %.1f A",
             i_boost.value, query.t_sof2, query.u_boost, i_boost.lower, i_boost.upper) +
      format("; %s answers: it missed %.1f A where the model missed %.1f A",
             baselineChargeName(baseline).c_str(), selection.score.baseline_error,
             selection.score.model_error);
  answer.message = message + warningOf(answer.message);
  return answer;
}

std::string baselineCrankName(const BaselinePredictor& baseline) {
  return baseline.cranks ? "the baseline (line through past cranks)"
                         : "the baseline (line of voltage over current)";
}

std::string baselineChargeName(const BaselinePredictor& baseline) {
  return baseline.phase ? "the baseline (median of past charges)"
                        : "the baseline (line of current over voltage)";
}

}  // namespace battery_sof
