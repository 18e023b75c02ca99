#pragma once

#include <optional>
#include <string>
#include <vector>

#include "prediction/charge_acceptance.hpp"
#include "prediction/cranking.hpp"

namespace battery_sof {

/// Most points of a map along one side.
inline constexpr std::size_t kMaxMapSide = 200;

/// Answers to every combination of two lists, row by row: answers[row * columns + column].
struct CrankingMap {
  std::vector<CrankingAnswer> answers;  ///< rows: i_load, columns: t_stop; empty unless code is kOk
  /// kInvalidQuery for a list that is empty or too long and for too much work, kNoModel
  AnswerCode code = AnswerCode::kOk;
  std::string message;
};
struct ChargeAcceptanceMap {
  std::vector<ChargeAcceptanceAnswer> answers;  ///< rows: u_boost, columns: t_sof2
  AnswerCode code = AnswerCode::kOk;
  std::string message;
};

/// SOF1 over (i_load, t_stop). @param query the crank; its i_load and t_stop are taken from the
/// lists.
/// @param watch asked before every answer; a map that is broken off has no answers, is
/// kInvalidQuery and says how far it came.
CrankingMap mapCranking(const FittedModel& model, const CrankingQuery& query,
                        const std::vector<double>& i_load, const std::vector<double>& t_stop,
                        double capacity = 50.0, const WorkWatch& watch = nullptr);

/// SOF2 over (u_boost, t_sof2). @param query the limit; its u_boost and t_sof2 are taken from the
/// lists.
ChargeAcceptanceMap mapChargeAcceptance(const FittedModel& model,
                                        const ChargeAcceptanceQuery& query,
                                        const std::vector<double>& u_boost,
                                        const std::vector<double>& t_sof2, double capacity = 50.0,
                                        const WorkWatch& watch = nullptr);

/// What maps come to as a whole.
struct MapVerdict {
  /// the gravest: invalid_query, then no_model, then extrapolation
  AnswerCode code = AnswerCode::kOk;
  /// one sentence: of the first answer with that code, or how many answers there are
  std::string message;
};

/// @param cranking, charge the maps that were asked; kInvalidQuery when neither was.
MapVerdict verdictOf(const std::optional<CrankingMap>& cranking,
                     const std::optional<ChargeAcceptanceMap>& charge);

}  // namespace battery_sof
