#pragma once

#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>

#include "battery_sof/queries.hpp"
#include "report/descriptions.hpp"
#include "report/results.hpp"
#include "util/text.hpp"

namespace battery_sof::python {

/// @throws std::invalid_argument for a capacity [Ah] that is none.
inline std::optional<double> checkedCapacity(std::optional<double> capacity_ah) {
  if (!capacity_ah || (*capacity_ah > 0.0 && std::isfinite(*capacity_ah))) return capacity_ah;
  throw std::invalid_argument(
      format("capacity_ah is %g, expected above 0 and finite", *capacity_ah));
}

/// An answer as JSON. @throws std::invalid_argument for a query that is none.
template <typename Answer>
std::string answerText(const Answer& answer) {
  if (answer.code == AnswerCode::kInvalidQuery) throw std::invalid_argument(answer.message);
  return jsonText(jsonOf(answer));
}

}  // namespace battery_sof::python
