#include "battery_sof/identify/fitted_model.hpp"

namespace battery_sof {

std::string describe(FitStatus status) {
  switch (status) {
    case FitStatus::kConverged: return "converged";
    case FitStatus::kIterationLimit: return "iteration_limit";
    case FitStatus::kStalled: return "stalled";
    case FitStatus::kWindowTooShort: return "window_too_short";
    case FitStatus::kNotExcited: return "not_excited";
  }
  return "unknown";
}

bool isUsable(const FittedModel& model) {
  return model.status == FitStatus::kConverged || model.status == FitStatus::kIterationLimit;
}

}  // namespace battery_sof
