#pragma once

#include <optional>
#include <string>

#include "battery_sof/identify/fitted_model.hpp"
#include "battery_sof/predict/answer.hpp"

namespace battery_sof {

/// Will the battery crank the engine after a stop? (paper, Fig. 1)
struct CrankingQuery {
  double i_load = 0.0;                ///< [A], <= 0: consumers while the engine is off, held for t_stop
  double t_stop = 0.0;                ///< [s], 0 to 86400
  double i_cranking = 0.0;            ///< [A], < 0
  double t_cranking = 1.0;            ///< [s], > 0 to 60
  std::optional<double> u_required;   ///< [V], what the starter needs; the paper names 7.2 V
};

/// SOF1. The numbers are present unless code is kInvalidQuery or kNoModel.
struct CrankingAnswer {
  std::optional<Interval> u_min;  ///< [V], lowest voltage during the crank, with its 90 % interval
  std::optional<bool> capable;    ///< lower bound of u_min at or above u_required; none without u_required
  bool valid = false;             ///< the model may be trusted here
  AnswerCode code = AnswerCode::kOk;
  std::string message;            ///< one sentence
};

/**
 * @brief Lowest voltage during a crank after a stop phase (paper, Fig. 1; PHYSICS 5.1).
 *
 *     u_SOF1 = min over (t_stop, t_stop + t_cranking] of u_b(t),   i = i_load, then i_cranking
 *
 * Under a held current u_c2 moves monotonically, so the minimum stands at one end of the crank: two exact steps.
 * The interval is 1.645 standard deviations of the parameters', the state's and the window's own crank error together.
 *
 * valid is false when i_cranking is more than 1.25 times the largest discharge of the window, or the stop would move
 * the charge by more than 1 % of capacity: the base model holds u_dc constant.
 *
 * @param model    event begins at its saved state.
 * @param capacity [Ah], nominal, > 0.
 */
CrankingAnswer predictCranking(const FittedModel& model, const CrankingQuery& query,
                               double capacity = 50.0);

/// @return every fault of a query, as one sentence each; empty when there is none.
std::string faultsOf(const CrankingQuery& query);

}  // namespace battery_sof
