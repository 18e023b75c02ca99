#include "prediction/crank_watch.hpp"

#include <algorithm>

#include "prediction/cranking.hpp"

namespace battery_sof {

namespace {

double lowest(const std::vector<double>& values) {
  return *std::min_element(values.begin(), values.end());
}

}  // namespace

std::optional<CrankComparison> CrankWatch::add(const StreamSample& sample,
                                               const StateTracker& before, double max_gap) {
  if (model_ && sample.time - before.state().time > max_gap) reset();
  if (sample.current > 0.5 * limits_.crank_current) {
    const auto comparison = model_ ? finish() : std::nullopt;
    reset();
    return comparison;
  }
  if (!model_) {
    model_ = before.modelNow();
    crank_ = {};
  }
  // Once too long to be a crank nothing more is stored; finish() sees the length.
  if (crank_.empty() || crank_.time.back() - crank_.time.front() <= limits_.crank_max_duration) {
    crank_.time.push_back(sample.time);
    crank_.current.push_back(sample.current);
    crank_.voltage.push_back(sample.voltage);
  }
  return std::nullopt;
}

std::optional<CrankComparison> CrankWatch::finish() const {
  const bool too_long = crank_.time.back() - crank_.time.front() > limits_.crank_max_duration;
  if (too_long || lowest(crank_.current) > limits_.crank_current) return std::nullopt;
  CrankingQuery query;
  query.crank = {crank_.time, crank_.current};
  for (double& time : query.crank.time) time -= model_->state.time;
  query.crank.time.insert(query.crank.time.begin(), 0.0);
  query.crank.current.insert(query.crank.current.begin(), model_->state.current);
  const CrankingAnswer answer = predictCranking(*model_, query);
  if (!answer.u_min) return std::nullopt;
  FittedModel unexperienced = *model_;
  unexperienced.intervals.event_history = {};
  const auto minimum = std::min_element(crank_.voltage.begin(), crank_.voltage.end());
  return CrankComparison{crank_.time[static_cast<std::size_t>(minimum - crank_.voltage.begin())],
                         lowest(crank_.current), *minimum, *answer.u_min,
                         predictCranking(unexperienced, query).u_min->value};
}

}  // namespace battery_sof
