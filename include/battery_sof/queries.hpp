#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace battery_sof {

/// The kind of answer to a query.
enum class AnswerCode : int {
  kOk = 0,
  kInvalidQuery = 1,  ///< an input is not finite or out of range; there are no numbers
  /// no sample yet, or no model with a finite answer to the query; there are no numbers
  kNoModel = 2,
  /// there are numbers, but the window does not cover the query: valid is false
  kExtrapolation = 3,
};

/// @return "ok", "invalid_query", "no_model", "extrapolation".
std::string toString(AnswerCode code);

/// What an answer with numbers says about the limit that was asked for. Its message begins with
/// these words.
enum class Assurance {
  kHolds,       ///< the unfavourable end of the 90 % interval keeps the limit
  kNotAssured,  ///< it does not: the limit may be missed
  kNotValid,    ///< the question lies outside the identified range (kExtrapolation)
};

/// @return "holds", "not assured", "not valid".
std::string toString(Assurance assurance);

/// A number with its 90 % prediction interval. It never contains NaN: structs that may lack a
/// number hold it as optional.
struct Interval {
  double value = 0.0;
  double lower = 0.0;  ///< 5 % quantile
  double upper = 0.0;  ///< 95 % quantile
};

/// A current over time, linear between its points. Time counts from the beginning of the phase.
struct CurrentProfile {
  std::vector<double> time;     ///< [s], >= 0, each at least kShortestStep after the one before
  std::vector<double> current;  ///< [A], same length
  bool empty() const { return time.empty(); }
  double duration() const { return time.empty() ? 0.0 : time.back(); }
};

/// Progress callback. Receives the completed fraction [0, 1] and returns a reason to abort, or an
/// empty string to continue.
using WorkWatch = std::function<std::string(double share)>;

/// Will the battery crank the engine after a stop? (paper, Fig. 1)
struct CrankingQuery {
  /// [A], <= 0: consumers while the engine is off, held for t_stop
  double i_load = 0.0;
  double t_stop = 0.0;      ///< [s], 0 to 86400
  double i_cranking = 0.0;  ///< [A], < 0
  double t_cranking = 1.0;  ///< [s], > 0 to 60
  /// [V], above 0 to 100: what the starter needs; the paper names 7.2 V
  std::optional<double> u_required = std::nullopt;
  /// replaces i_load and t_stop unless empty
  CurrentProfile load = {};
  /// replaces i_cranking and t_cranking unless empty
  CurrentProfile crank = {};
  std::optional<double> temperature = std::nullopt;  ///< [K], of the battery, if known
};

/// SOF1. The numbers are present unless code is kInvalidQuery or kNoModel.
struct CrankingAnswer {
  std::optional<Interval> u_min;  ///< [V], lowest voltage during the crank, with its 90 % interval
  /// whether the lower bound of u_min is at or above u_required; none without u_required
  std::optional<bool> capable;
  bool valid = false;  ///< the recorded driving covers the query
  AnswerCode code = AnswerCode::kOk;
  std::string message;  ///< one sentence
};

/// @return none if the answer has no numbers, or if it is valid but no u_required was given.
std::optional<Assurance> assuranceOf(const CrankingAnswer& answer);

/// How long may the engine stay off?
struct StopTimeQuery {
  double i_load = 0.0;      ///< [A], <= 0
  double i_cranking = 0.0;  ///< [A], < 0
  double t_cranking = 1.0;  ///< [s], > 0 to 60
  /// [V], above 0 to 100: what the starter needs
  double u_required = 0.0;
  /// replaces i_cranking and t_cranking unless empty
  CurrentProfile crank = {};
  std::optional<double> temperature = std::nullopt;  ///< [K], of the battery, if known
};

/// The kind of stop time that was found.
enum class StopTimeOutcome {
  kFinite,  ///< the crank fails after t_stop
  /// the crank holds after every stop up to t_stop, the longest that the model supports
  kAtLeast,
  kAlways,  ///< nothing is drawn (i_load = 0), and the crank holds after a stop of up to a day
  kNever,   ///< the crank fails even without a stop
};

/// @return "finite", "at_least", "always" or "never".
std::string toString(StopTimeOutcome outcome);

/// The longest stop. t_stop is present unless code is kInvalidQuery or kNoModel.
struct StopTimeAnswer {
  StopTimeOutcome outcome = StopTimeOutcome::kNever;
  /// [s]; 0 for never, infinite for always. After `lower`, the lower bound of the crank no longer
  /// holds u_required; after `upper`, its upper bound does not. If a current is drawn, no value is
  /// infinite and no stop draws more than the capacity.
  std::optional<Interval> t_stop;
  bool monotone = true;  ///< the crank's voltage falls with the length of the stop everywhere
  bool valid = false;
  AnswerCode code = AnswerCode::kOk;
  std::string message;
};

/// @return none if the answer has no numbers; kNotAssured if the lower end of t_stop is 0 s,
/// because an immediate crank may then miss u_required.
std::optional<Assurance> assuranceOf(const StopTimeAnswer& answer);

/// How much charge will the battery accept? (paper, Fig. 2)
struct ChargeAcceptanceQuery {
  double u_boost = 0.0;  ///< [V], terminal voltage that is held, above 0 to 100
  double t_sof2 = 10.0;  ///< [s], above 0 to 3600
  /// [A], what the source can give, above 0 to 5000
  double i_limit = 5000.0;
  std::optional<double> temperature = std::nullopt;  ///< [K], of the battery, if known
};

/// SOF2. The numbers are present unless code is kInvalidQuery or kNoModel.
struct ChargeAcceptanceAnswer {
  /// [A], mean current over t_sof2; negative if u_boost discharges the battery
  std::optional<Interval> i_boost;
  bool valid = false;
  AnswerCode code = AnswerCode::kOk;
  std::string message;
};

/// @return none if the answer has no numbers; kNotAssured if the lower end of i_boost is 0 A or
/// below, because the voltage may then discharge the battery.
std::optional<Assurance> assuranceOf(const ChargeAcceptanceAnswer& answer);

/// Predicted voltages with 90 % intervals [V], one for each sample of the profile.
struct PredictedVoltage {
  std::vector<double> voltage, lower, upper;
};

/// The answer to a what-if profile. Vectors are empty unless code is kOk or kExtrapolation.
struct ProfileAnswer {
  PredictedVoltage predicted;
  bool valid = false;
  AnswerCode code = AnswerCode::kOk;
  std::string message;
};

/// @return kNotValid or none, because a profile has no limit.
std::optional<Assurance> assuranceOf(const ProfileAnswer& answer);

}  // namespace battery_sof
