#include "prediction/scores.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace battery_sof {
namespace {

double lowest(const std::vector<double>& values, IndexRange range) {
  return *std::min_element(values.begin() + static_cast<std::ptrdiff_t>(range.first),
                           values.begin() + static_cast<std::ptrdiff_t>(range.last));
}

CrankScore scoreCrank(const Series& part, const PredictedVoltage& predicted, const Event& crank) {
  const auto begin = part.voltage.begin();
  const auto lowest_at = std::min_element(begin + static_cast<std::ptrdiff_t>(crank.range.first),
                                          begin + static_cast<std::ptrdiff_t>(crank.range.last));
  CrankScore score;
  score.time = part.time[static_cast<std::size_t>(lowest_at - begin)];
  score.current = crank.peak_current;
  score.measured_minimum = *lowest_at;
  score.predicted_minimum = {lowest(predicted.voltage, crank.range),
                             lowest(predicted.lower, crank.range),
                             lowest(predicted.upper, crank.range)};
  return score;
}

}  // namespace

PredictionScores scorePrediction(const Series& series, IndexRange range,
                                 const PredictedVoltage& predicted, const EventLimits& limits) {
  const Series part = slice(series, range);
  if (part.empty() || predicted.voltage.size() != part.size())
    throw std::invalid_argument("scorePrediction: " + std::to_string(predicted.voltage.size()) +
                                " predictions for " + std::to_string(part.size()) + " samples");
  PredictionScores scores;
  scores.window = {part.time.front(), part.time.back(), part.size()};
  scores.q_dyn_percent = qDyn(part.voltage, predicted.voltage);
  scores.rmse = rootMeanSquareError(part.voltage, predicted.voltage);
  std::size_t inside = 0;
  for (std::size_t n = 0; n < part.size(); ++n) {
    const double u = part.voltage[n];
    scores.max_abs = std::max(scores.max_abs, std::abs(u - predicted.voltage[n]));
    if (u >= predicted.lower[n] && u <= predicted.upper[n]) ++inside;
  }
  scores.coverage_90 = static_cast<double>(inside) / static_cast<double>(part.size());
  double error = 0.0;
  for (const Event& event : detectEvents(part, limits)) {
    if (event.kind != EventKind::kCrank) continue;
    scores.cranks.push_back(scoreCrank(part, predicted, event));
    error += std::abs(scores.cranks.back().measured_minimum -
                      scores.cranks.back().predicted_minimum.value);
  }
  if (!scores.cranks.empty())
    scores.crank_mean_abs_error = error / static_cast<double>(scores.cranks.size());
  return scores;
}

}  // namespace battery_sof
