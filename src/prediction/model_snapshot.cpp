#include "prediction/model_snapshot.hpp"

namespace battery_sof {
namespace {

FittedModel unusable() {
  FittedModel none;
  none.fit.status = FitStatus::kNotExcited;
  return none;
}

/// An answer that the baseline predictor may have given. @param says_nothing of its interval.
template <typename Answer>
Answer judged(Answer answer, const std::string& says_nothing) {
  if (answer.valid && !says_nothing.empty()) judge(answer, says_nothing);
  return answer;
}

}  // namespace

ModelSnapshot::ModelSnapshot(FittedModel model, std::optional<std::string> why_no_model,
                             double capacity, const BaselineSelections& baseline)
    : model_(why_no_model ? unusable() : std::move(model)),
      why_no_model_(std::move(why_no_model)),
      capacity_(capacity),
      baseline_(baseline) {}

template <typename Answer>
Answer ModelSnapshot::explained(Answer answer) const {
  if (why_no_model_ && answer.code == AnswerCode::kNoModel) answer.message = *why_no_model_;
  return answer;
}

CrankingAnswer ModelSnapshot::predictCranking(const CrankingQuery& query) const {
  return betterOf(explained(battery_sof::predictCranking(model_, query, capacity_)), query);
}

CrankingAnswer ModelSnapshot::betterOf(CrankingAnswer answer, const CrankingQuery& query) const {
  CrankingAnswer better = battery_sof::betterOf(std::move(answer), query, model_.fit.baseline,
                                                baseline_.cranks, model_.fit.series_blocks);
  return better.u_min ? judged(better, voltageSaysNothing(model_.fit, *better.u_min)) : better;
}

StopTimeAnswer ModelSnapshot::predictStopTime(const StopTimeQuery& query) const {
  StopTimeAnswer answer = explained(battery_sof::predictStopTime(model_, query, capacity_));
  if (answer.t_stop && baseline_.cranks.score.baseline_selected)
    answer.message += "; by the model, though " + baselineCrankName(model_.fit.baseline) +
                      " is better at cranks at present";
  return answer;
}

ChargeAcceptanceAnswer ModelSnapshot::predictChargeAcceptance(
    const ChargeAcceptanceQuery& query) const {
  return betterOf(explained(battery_sof::predictChargeAcceptance(model_, query, capacity_)), query);
}

ChargeAcceptanceAnswer ModelSnapshot::betterOf(ChargeAcceptanceAnswer answer,
                                               const ChargeAcceptanceQuery& query) const {
  // What was compared over 10 s and over 60 s have no question in common.
  ChargeAcceptanceAnswer better = battery_sof::betterOf(
      battery_sof::betterOf(std::move(answer), query, model_.fit.baseline, baseline_.charges,
                            model_.fit.series_blocks),
      query, model_.fit.baseline, baseline_.long_charges, model_.fit.series_blocks);
  return better.i_boost ? judged(better, currentSaysNothing(model_, query, *better.i_boost))
                        : better;
}

CrankingMap ModelSnapshot::mapCranking(const CrankingQuery& query,
                                       const std::vector<double>& i_load,
                                       const std::vector<double>& t_stop,
                                       const WorkWatch& watch) const {
  CrankingMap map =
      explained(battery_sof::mapCranking(model_, query, i_load, t_stop, capacity_, watch));
  CrankingQuery cell = query;
  cell.load = {};
  for (std::size_t k = 0; k < map.answers.size(); ++k) {
    cell.t_stop = t_stop[k % t_stop.size()];
    map.answers[k] = betterOf(std::move(map.answers[k]), cell);
  }
  return map;
}

ChargeAcceptanceMap ModelSnapshot::mapChargeAcceptance(const ChargeAcceptanceQuery& query,
                                                       const std::vector<double>& u_boost,
                                                       const std::vector<double>& t_sof2,
                                                       const WorkWatch& watch) const {
  ChargeAcceptanceMap map =
      explained(battery_sof::mapChargeAcceptance(model_, query, u_boost, t_sof2, capacity_, watch));
  ChargeAcceptanceQuery cell = query;
  for (std::size_t k = 0; k < map.answers.size(); ++k) {
    cell.u_boost = u_boost[k / t_sof2.size()];
    cell.t_sof2 = t_sof2[k % t_sof2.size()];
    map.answers[k] = betterOf(std::move(map.answers[k]), cell);
  }
  return map;
}

ProfileAnswer ModelSnapshot::simulateProfile(const std::vector<double>& time,
                                             const std::vector<double>& current,
                                             const WorkWatch& watch) const {
  return explained(battery_sof::simulateProfile(model_, time, current, watch));
}

}  // namespace battery_sof
