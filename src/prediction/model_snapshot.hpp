#pragma once

#include <optional>
#include <string>
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
  ModelSnapshot(FittedModel model, std::optional<std::string> why_no_model, double capacity);

  CrankingAnswer predictCranking(const CrankingQuery& query) const;
  StopTimeAnswer predictStopTime(const StopTimeQuery& query) const;
  ChargeAcceptanceAnswer predictChargeAcceptance(const ChargeAcceptanceQuery& query) const;
  CrankingMap mapCranking(const CrankingQuery& query, const std::vector<double>& i_load,
                          const std::vector<double>& t_stop,
                          const WorkWatch& watch = nullptr) const;
  ChargeAcceptanceMap mapChargeAcceptance(const ChargeAcceptanceQuery& query,
                                          const std::vector<double>& u_boost,
                                          const std::vector<double>& t_sof2,
                                          const WorkWatch& watch = nullptr) const;
  ProfileAnswer simulateProfile(const std::vector<double>& time, const std::vector<double>& current,
                                const WorkWatch& watch = nullptr) const;

  const FittedModel& model() const { return model_; }

 private:
  /// The reason in place of the free functions' general one; faults of the query come first.
  template <typename Answer>
  Answer explained(Answer answer) const;

  FittedModel model_;
  std::optional<std::string> why_no_model_;
  double capacity_;  // [Ah]
};

}  // namespace battery_sof
