#include "battery_sof/predict/live_model.hpp"

namespace battery_sof {
namespace {

FittedModel unusable() {
  FittedModel none;
  none.status = FitStatus::kNotExcited;
  return none;
}

}  // namespace

LiveModel::LiveModel(FittedModel model, std::optional<std::string> why_no_model, double capacity)
    : model_(why_no_model ? unusable() : std::move(model)),
      why_no_model_(std::move(why_no_model)),
      capacity_(capacity) {}

template <typename Answer>
Answer LiveModel::explained(Answer answer) const {
  if (why_no_model_ && answer.code == AnswerCode::kNoModel) answer.message = *why_no_model_;
  return answer;
}

CrankingAnswer LiveModel::predictCranking(const CrankingQuery& query) const {
  return explained(battery_sof::predictCranking(model_, query, capacity_));
}

StopTimeAnswer LiveModel::predictStopTime(const StopTimeQuery& query) const {
  return explained(battery_sof::predictStopTime(model_, query, capacity_));
}

ChargeAcceptanceAnswer LiveModel::predictChargeAcceptance(const ChargeAcceptanceQuery& query) const {
  return explained(battery_sof::predictChargeAcceptance(model_, query, capacity_));
}

CrankingMap LiveModel::mapCranking(const CrankingQuery& query, const std::vector<double>& i_load,
                                   const std::vector<double>& t_stop) const {
  return explained(battery_sof::mapCranking(model_, query, i_load, t_stop, capacity_));
}

ChargeAcceptanceMap LiveModel::mapChargeAcceptance(const ChargeAcceptanceQuery& query,
                                                   const std::vector<double>& u_boost,
                                                   const std::vector<double>& t_sof2) const {
  return explained(battery_sof::mapChargeAcceptance(model_, query, u_boost, t_sof2, capacity_));
}

ProfileAnswer LiveModel::simulateProfile(const std::vector<double>& time,
                                         const std::vector<double>& current) const {
  return explained(battery_sof::simulateProfile(model_, time, current));
}

}  // namespace battery_sof
