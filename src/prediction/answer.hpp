#pragma once

#include <string>

namespace battery_sof {

/// What kind of answer a query got.
enum class AnswerCode : int {
  kOk = 0,
  kInvalidQuery = 1,   ///< an input is not finite or out of its range; no numbers
  kNoModel = 2,        ///< nothing identified yet, the model is too old, or it makes no finite numbers of the query; no numbers
  kExtrapolation = 3,  ///< numbers are given, but the window did not excite what they need: valid is false
};

/// @return "ok", "invalid_query", "no_model", "extrapolation".
std::string toString(AnswerCode code);

/// A number with its 90 % interval; NaN-free: absent numbers are optional in the structs that hold this.
struct Interval {
  double value = 0.0;
  double lower = 0.0;  ///< 5 % quantile
  double upper = 0.0;  ///< 95 % quantile
};

/// @return a voltage of one block, of a row of them [V].
inline Interval ofSeries(const Interval& of_one, double series_blocks) {
  return {series_blocks * of_one.value, series_blocks * of_one.lower, series_blocks * of_one.upper};
}

}  // namespace battery_sof
