#include "battery_sof/predict/naive_contest.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "battery_sof/predict/interval_scale.hpp"
#include "battery_sof/recording/words.hpp"

namespace battery_sof {
namespace {

constexpr double kCurrentReach = 1.25;  // as extrapolationOf()
constexpr double kVoltageReach = 0.5;   // [V], as experiencedCharge()
constexpr double kLongerOrShorter = 2.0;
constexpr const char* kWarning = "; not to be relied on: ";

Interval scaled(const Interval& naive, const IntervalScale& scale) {
  return {naive.value, naive.value + scale.factor * (naive.lower - naive.value), naive.value + scale.factor * (naive.upper - naive.value)};
}

Interval scaled(const NaiveInterval& naive, const IntervalScale& scale) {
  return scaled(Interval{naive.value, naive.lower, naive.upper}, scale);
}

double lowestCurrent(const CrankingQuery& query) {
  if (query.crank.empty()) return query.i_cranking;
  return *std::min_element(query.crank.current.begin(), query.crank.current.end());
}

bool isAlike(const CrankingQuery& query, const NaiveStanding& standing) {
  const double t_stop = query.load.empty() ? query.t_stop : query.load.duration();
  return lowestCurrent(query) >= kCurrentReach * standing.least && t_stop <= NaiveContest::kSpan;
}

bool isAlike(const ChargeAcceptanceQuery& query, const NaiveStanding& standing) {
  return query.u_boost >= standing.least - kVoltageReach && query.u_boost <= standing.most + kVoltageReach &&
         query.t_sof2 * kLongerOrShorter >= standing.shortest && query.t_sof2 <= kLongerOrShorter * standing.longest;
}

/// What a model's message says of the model's validity.
std::string warningOf(const std::string& message) {
  const auto at = message.find(kWarning);
  return at == std::string::npos ? std::string() : message.substr(at);
}

}  // namespace

Interval NaiveContest::add(const NaiveContestEvent& event) {
  const Interval naive = scaled(event.naive, scale_);
  observe(scale_, event.measured, naive);
  events_.push_back(event);
  while (events_.size() > kEvents && events_.front().time < event.time - kSpan) events_.pop_front();
  const NaiveScore now = score();
  if (now.events < kLeastEvents) return naive;
  naive_answers_ = now.model_error > (naive_answers_ ? 1.0 : kTolerated) * now.naive_error;
  return naive;
}

void NaiveContest::moveBy(double moved) {
  for (NaiveContestEvent& event : events_) event.time += moved;
}

NaiveScore NaiveContest::score() const {
  NaiveScore score;
  score.events = static_cast<int>(events_.size());
  score.naive_answers = naive_answers_;
  for (const NaiveContestEvent& event : events_) {
    score.model_error += std::abs(event.measured - event.modelled) / score.events;
    score.naive_error += std::abs(event.measured - event.naive.value) / score.events;
  }
  return score;
}

NaiveStanding NaiveContest::standing() const {
  NaiveStanding standing{score(), scale_, 0.0, 0.0, 0.0, 0.0};
  if (events_.empty()) return standing;
  const auto by = [&](double NaiveContestEvent::*number) {
    const auto [least, most] = std::minmax_element(
        events_.begin(), events_.end(), [number](const NaiveContestEvent& a, const NaiveContestEvent& b) { return a.*number < b.*number; });
    return std::pair((*least).*number, (*most).*number);
  };
  std::tie(standing.least, standing.most) = by(&NaiveContestEvent::at);
  std::tie(standing.shortest, standing.longest) = by(&NaiveContestEvent::duration);
  return standing;
}

CrankingAnswer betterOf(CrankingAnswer answer, const CrankingQuery& query, const NaivePredictor& naive, const NaiveStanding& standing,
                        double blocks) {
  if (!standing.score.naive_answers || !answer.u_min || !isAlike(query, standing)) return answer;
  const auto minimum = naiveCrankMinimum(naive, lowestCurrent(query));
  if (!minimum) return answer;
  answer.u_min = inRow(scaled(*minimum, standing.scale), blocks);
  if (query.u_required) answer.capable = answer.u_min->lower >= *query.u_required;
  std::string message = sentenceOf(answer, query.u_required);
  message += sentence("; %s answers: it missed %.3f V where the model missed %.3f V", naiveCrankName(naive).c_str(),
                      blocks * standing.score.naive_error, blocks * standing.score.model_error);
  answer.message = message + warningOf(answer.message);
  return answer;
}

ChargeAcceptanceAnswer betterOf(ChargeAcceptanceAnswer answer, const ChargeAcceptanceQuery& query, const NaivePredictor& naive,
                                const NaiveStanding& standing, double blocks) {
  ChargeAcceptanceQuery of_one = query;
  of_one.u_boost /= blocks;
  if (!standing.score.naive_answers || !answer.i_boost || !isAlike(of_one, standing)) return answer;
  const auto current = naiveChargeCurrent(naive, of_one.u_boost, query.t_sof2);
  if (!current) return answer;
  Interval i_boost = scaled(*current, standing.scale);
  for (double* bound : {&i_boost.value, &i_boost.lower, &i_boost.upper}) *bound = std::min(*bound, query.i_limit);
  answer.i_boost = i_boost;
  const std::string message = sentence("mean current %.1f A over %.1f s at %.2f V, 90 %% between %.1f and %.1f A", i_boost.value,
                                       query.t_sof2, query.u_boost, i_boost.lower, i_boost.upper) +
                              sentence("; %s answers: it missed %.1f A where the model missed %.1f A", naiveChargeName(naive).c_str(),
                                       standing.score.naive_error, standing.score.model_error);
  answer.message = message + warningOf(answer.message);
  return answer;
}

std::string naiveCrankName(const NaivePredictor& naive) {
  return naive.cranks ? "the straight line through past cranks" : "the straight line of voltage over current";
}

std::string naiveChargeName(const NaivePredictor& naive) {
  return naive.phase ? "the median of past charges" : "the straight line of current over voltage";
}

}  // namespace battery_sof
