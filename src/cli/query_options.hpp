#pragma once

#include <string>
#include <vector>

#include "command.hpp"
#include "prediction/pipeline.hpp"

namespace battery_sof {

/// What every question to a saved model is reported.
struct QueryArguments {
  std::string model;
  double capacity_ah = 50.0;
  bool rested = false;
  std::string json;
};

void addQueryOptions(CLI::App& command, QueryArguments& arguments);

/// Reads the model, rested when that was asked. @throws UsageError for a capacity that is not above
/// 0.
FittedModel modelOf(const QueryArguments& arguments);

/**
 * @brief Reads a current profile from a CSV file with the columns time_s and current_a; other
 * columns are passed over.
 * @throws UsageError naming file, line, what stands there and what was expected.
 */
CurrentProfile readProfile(const std::string& path);

/// @return the exit code to an answer, after printing it. @throws UsageError for an invalid query.
template <typename Answer>
int finish(const CommandLine& line, const Answer& answer, const std::string& text,
           const nlohmann::json& json, const std::string& json_target) {
  if (answer.code == AnswerCode::kInvalidQuery) throw UsageError(answer.message);
  emit(line, text, json, json_target);
  if (answer.code != AnswerCode::kOk) complain(line.err, answer.message);
  return answer.code == AnswerCode::kOk ? kExitDone : kExitNegative;
}

}  // namespace battery_sof
