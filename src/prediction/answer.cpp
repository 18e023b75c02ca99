#include "prediction/answer.hpp"

namespace battery_sof {

std::string toString(AnswerCode code) {
  switch (code) {
    case AnswerCode::kOk: return "ok";
    case AnswerCode::kInvalidQuery: return "invalid_query";
    case AnswerCode::kNoModel: return "no_model";
    case AnswerCode::kExtrapolation: return "extrapolation";
  }
  return "unknown";
}

}  // namespace battery_sof
