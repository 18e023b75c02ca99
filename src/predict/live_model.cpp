#include "battery_sof/predict/live_model.hpp"

namespace battery_sof {
namespace {

FittedModel unusable() {
  FittedModel none;
  none.fit.status = FitStatus::kNotExcited;
  return none;
}

}  // namespace

LiveModel::LiveModel(FittedModel model, std::optional<std::string> why_no_model, double capacity, const NaiveStandings& naive)
    : model_(why_no_model ? unusable() : std::move(model)), why_no_model_(std::move(why_no_model)), capacity_(capacity), naive_(naive) {}

template <typename Answer>
Answer LiveModel::explained(Answer answer) const {
  if (why_no_model_ && answer.code == AnswerCode::kNoModel) answer.message = *why_no_model_;
  return answer;
}

CrankingAnswer LiveModel::predictCranking(const CrankingQuery& query) const {
  return battery_sof::betterOf(explained(battery_sof::predictCranking(model_, query, capacity_)), query, model_.fit.naive, naive_.cranks,
                               model_.fit.blocks);
}

StopTimeAnswer LiveModel::predictStopTime(const StopTimeQuery& query) const {
  StopTimeAnswer answer = explained(battery_sof::predictStopTime(model_, query, capacity_));
  if (answer.t_stop && naive_.cranks.score.naive_answers)
    answer.message += "; by the model, though " + naiveCrankName(model_.fit.naive) + " is better at cranks at present";
  return answer;
}

ChargeAcceptanceAnswer LiveModel::predictChargeAcceptance(const ChargeAcceptanceQuery& query) const {
  return betterOf(explained(battery_sof::predictChargeAcceptance(model_, query, capacity_)), query);
}

ChargeAcceptanceAnswer LiveModel::betterOf(ChargeAcceptanceAnswer answer, const ChargeAcceptanceQuery& query) const {
  // What was compared over 10 s and over 60 s have no question in common.
  return battery_sof::betterOf(battery_sof::betterOf(std::move(answer), query, model_.fit.naive, naive_.charges, model_.fit.blocks), query,
                               model_.fit.naive, naive_.long_charges, model_.fit.blocks);
}

CrankingMap LiveModel::mapCranking(const CrankingQuery& query, const std::vector<double>& i_load, const std::vector<double>& t_stop) const {
  CrankingMap map = explained(battery_sof::mapCranking(model_, query, i_load, t_stop, capacity_));
  CrankingQuery cell = query;
  cell.load = {};
  for (std::size_t k = 0; k < map.answers.size(); ++k) {
    cell.t_stop = t_stop[k % t_stop.size()];
    map.answers[k] = battery_sof::betterOf(std::move(map.answers[k]), cell, model_.fit.naive, naive_.cranks, model_.fit.blocks);
  }
  return map;
}

ChargeAcceptanceMap LiveModel::mapChargeAcceptance(const ChargeAcceptanceQuery& query, const std::vector<double>& u_boost,
                                                   const std::vector<double>& t_sof2) const {
  ChargeAcceptanceMap map = explained(battery_sof::mapChargeAcceptance(model_, query, u_boost, t_sof2, capacity_));
  ChargeAcceptanceQuery cell = query;
  for (std::size_t k = 0; k < map.answers.size(); ++k) {
    cell.u_boost = u_boost[k / t_sof2.size()];
    cell.t_sof2 = t_sof2[k % t_sof2.size()];
    map.answers[k] = betterOf(std::move(map.answers[k]), cell);
  }
  return map;
}

ProfileAnswer LiveModel::simulateProfile(const std::vector<double>& time, const std::vector<double>& current) const {
  return explained(battery_sof::simulateProfile(model_, time, current));
}

}  // namespace battery_sof
