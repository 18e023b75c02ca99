#include "prediction/model_snapshot.hpp"

namespace battery_sof {
namespace {

FittedModel unusable() {
  FittedModel none;
  none.fit.status = FitStatus::kNotExcited;
  return none;
}

}  // namespace

ModelSnapshot::ModelSnapshot(FittedModel model, std::optional<std::string> why_no_model,
                             double capacity)
    : model_(why_no_model ? unusable() : std::move(model)),
      why_no_model_(std::move(why_no_model)),
      capacity_(capacity) {}

template <typename Answer>
Answer ModelSnapshot::explained(Answer answer) const {
  if (why_no_model_ && answer.code == AnswerCode::kNoModel) answer.message = *why_no_model_;
  return answer;
}

CrankingAnswer ModelSnapshot::predictCranking(const CrankingQuery& query) const {
  return explained(battery_sof::predictCranking(model_, query, capacity_));
}

StopTimeAnswer ModelSnapshot::predictStopTime(const StopTimeQuery& query) const {
  return explained(battery_sof::predictStopTime(model_, query, capacity_));
}

ChargeAcceptanceAnswer ModelSnapshot::predictChargeAcceptance(
    const ChargeAcceptanceQuery& query) const {
  return explained(battery_sof::predictChargeAcceptance(model_, query, capacity_));
}

CrankingMap ModelSnapshot::mapCranking(const CrankingQuery& query,
                                       const std::vector<double>& i_load,
                                       const std::vector<double>& t_stop,
                                       const WorkWatch& watch) const {
  return explained(battery_sof::mapCranking(model_, query, i_load, t_stop, capacity_, watch));
}

ChargeAcceptanceMap ModelSnapshot::mapChargeAcceptance(const ChargeAcceptanceQuery& query,
                                                       const std::vector<double>& u_boost,
                                                       const std::vector<double>& t_sof2,
                                                       const WorkWatch& watch) const {
  return explained(
      battery_sof::mapChargeAcceptance(model_, query, u_boost, t_sof2, capacity_, watch));
}

ProfileAnswer ModelSnapshot::simulateProfile(const std::vector<double>& time,
                                             const std::vector<double>& current,
                                             const WorkWatch& watch) const {
  return explained(battery_sof::simulateProfile(model_, time, current, watch));
}

}  // namespace battery_sof
