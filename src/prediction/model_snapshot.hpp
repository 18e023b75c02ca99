#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "prediction/charge_acceptance.hpp"
#include "prediction/cranking.hpp"
#include "prediction/maps.hpp"
#include "prediction/profile.hpp"
#include "prediction/stop_time.hpp"

namespace battery_sof {

/**
 * @brief What a session would answer at one moment, to be asked without the session: a copy that
 * shares nothing with it.
 *
 * Every question is that of the free function of its name; kNoModel with the session's reason when
 * there is no model.
 */
class ModelSnapshot {
 public:
  /// @param why_no_model the reason when `model` is not to be asked.
  ModelSnapshot(FittedModel model, std::optional<std::string> why_no_model, double capacity)
      : model_(std::move(model)), why_no_model_(std::move(why_no_model)), capacity_(capacity) {
    if (!why_no_model_) return;
    model_ = {};
    model_.fit.status = FitStatus::kNotExcited;
  }

  CrankingAnswer predictCranking(const CrankingQuery& query) const {
    return explained(battery_sof::predictCranking(model_, query, capacity_));
  }
  StopTimeAnswer predictStopTime(const StopTimeQuery& query) const {
    return explained(battery_sof::predictStopTime(model_, query, capacity_));
  }
  ChargeAcceptanceAnswer predictChargeAcceptance(const ChargeAcceptanceQuery& query) const {
    return explained(battery_sof::predictChargeAcceptance(model_, query, capacity_));
  }
  CrankingMap mapCranking(const CrankingQuery& query, const std::vector<double>& i_load,
                          const std::vector<double>& t_stop,
                          const WorkWatch& watch = nullptr) const {
    return explained(battery_sof::mapCranking(model_, query, i_load, t_stop, capacity_, watch));
  }
  ChargeAcceptanceMap mapChargeAcceptance(const ChargeAcceptanceQuery& query,
                                          const std::vector<double>& u_boost,
                                          const std::vector<double>& t_sof2,
                                          const WorkWatch& watch = nullptr) const {
    return explained(
        battery_sof::mapChargeAcceptance(model_, query, u_boost, t_sof2, capacity_, watch));
  }
  ProfileAnswer simulateProfile(const std::vector<double>& time, const std::vector<double>& current,
                                const WorkWatch& watch = nullptr) const {
    return explained(battery_sof::simulateProfile(model_, time, current, watch));
  }

  const FittedModel& model() const { return model_; }

 private:
  /// The reason in place of the free functions' general one; faults of the query come first.
  template <typename Answer>
  Answer explained(Answer answer) const {
    if (why_no_model_ && answer.code == AnswerCode::kNoModel) answer.message = *why_no_model_;
    return answer;
  }

  FittedModel model_;
  std::optional<std::string> why_no_model_;
  double capacity_;  // [Ah]
};

}  // namespace battery_sof
