#include "prediction/questions.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

void requireSide(Faults& faults, const std::vector<double>& side, const char* name) {
  if (side.empty() || side.size() > kMaxMapSide)
    faults.push_back(
        format("%s has %zu values, expected 1 to %zu", name, side.size(), kMaxMapSide));
}

/// Fills a map, or says why not.
template <typename Map, typename Ask>
Map filled(const Fit& fit, const std::vector<double>& rows, const char* row_name,
           const std::vector<double>& columns, const char* column_name, const WorkWatch& watch,
           Ask&& ask) {
  Map map;
  if (isRefused(map, fit, faultsOfMap(rows, row_name, columns, column_name))) return map;
  const std::size_t cells = rows.size() * columns.size();
  for (const double row : rows)
    for (const double column : columns) {
      if (isBrokenOff(map, watch, map.answers.size(), cells, "answers")) return map;
      map.answers.push_back(ask(row, column));
    }
  map.message = format("%zu answers", cells);
  return map;
}

/// Of the codes the least is the gravest, but for kOk.
void take(MapVerdict& verdict, AnswerCode code, const std::string& message) {
  if (code == AnswerCode::kOk) return;
  if (verdict.code == AnswerCode::kOk || code < verdict.code) verdict = {code, message};
}

/// @return how many answers a map has.
template <typename Map>
std::size_t takeMap(MapVerdict& verdict, const std::optional<Map>& map) {
  if (!map) return 0;
  take(verdict, map->code, map->message);
  for (const auto& answer : map->answers) take(verdict, answer.code, answer.message);
  return map->answers.size();
}

}  // namespace

Faults faultsOfMap(const std::vector<double>& rows, const char* row_name,
                   const std::vector<double>& columns, const char* column_name) {
  Faults faults;
  requireSide(faults, rows, row_name);
  requireSide(faults, columns, column_name);
  return faults;
}

std::optional<Assurance> assuranceOf(const MapVerdict& verdict) {
  if (verdict.code == AnswerCode::kExtrapolation) return Assurance::kNotValid;
  if (verdict.code != AnswerCode::kOk || !verdict.has_limit) return std::nullopt;
  return verdict.not_assured > 0 ? Assurance::kNotAssured : Assurance::kHolds;
}

MapVerdict verdictOf(const std::optional<CrankingMap>& cranking,
                     const std::optional<ChargeAcceptanceMap>& charge) {
  MapVerdict verdict;
  const std::size_t answers = takeMap(verdict, cranking) + takeMap(verdict, charge);
  if (!cranking && !charge)
    verdict = {AnswerCode::kInvalidQuery,
               "no question is given, expected i_load and t_stop, or u_boost and t_sof2"};
  for (const CrankingAnswer& answer : cranking ? cranking->answers : std::vector<CrankingAnswer>())
    if (answer.capable) {
      verdict.has_limit = true;
      verdict.not_assured += !*answer.capable;
    }
  if (verdict.code != AnswerCode::kOk) return verdict;
  const std::optional<Assurance> assurance = assuranceOf(verdict);
  verdict.message = format("%zu answer%s", answers, answers == 1 ? "" : "s");
  if (assurance == Assurance::kNotAssured)
    verdict.message = format("%zu of %zu cranks may miss the limit", verdict.not_assured,
                             cranking->answers.size());
  if (assurance) verdict.message = toString(*assurance) + ": " + verdict.message;
  return verdict;
}

CrankingMap mapCranking(const FittedModel& model, const CrankingQuery& query,
                        const std::vector<double>& i_load, const std::vector<double>& t_stop,
                        double capacity, const WorkWatch& watch) {
  return filled<CrankingMap>(model.fit, i_load, "i_load", t_stop, "t_stop", watch,
                             [&](double load, double stop) {
                               CrankingQuery one = query;
                               one.load = {};
                               one.i_load = load;
                               one.t_stop = stop;
                               return predictCranking(model, one, capacity);
                             });
}

ChargeAcceptanceMap mapChargeAcceptance(const FittedModel& model,
                                        const ChargeAcceptanceQuery& query,
                                        const std::vector<double>& u_boost,
                                        const std::vector<double>& t_sof2, double capacity,
                                        const WorkWatch& watch) {
  return filled<ChargeAcceptanceMap>(model.fit, u_boost, "u_boost", t_sof2, "t_sof2", watch,
                                     [&](double voltage, double duration) {
                                       ChargeAcceptanceQuery one = query;
                                       one.u_boost = voltage;
                                       one.t_sof2 = duration;
                                       return predictChargeAcceptance(model, one, capacity);
                                     });
}

}  // namespace battery_sof
