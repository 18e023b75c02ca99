#pragma once

#include <optional>
#include <string>
#include <vector>

#include "diagnosis/model_selection.hpp"
#include "recording/control_mode.hpp"

namespace battery_sof {

/// Base and extended model on the part that was held out, and what is handed on after it.
struct Validation {
  Comparison fit;
  ControlModeOverview source;  ///< of the whole recording
  /// Named::extended; the base model where it is withheld
  FittedModel extended;
  std::vector<double> base_voltage, extended_voltage;  ///< [V], one a sample of the recording
  /// by which the extended model's error falls; none where the base model makes none
  std::optional<double> holdout_gain_percent;
  std::optional<double> withheld_rmse;  ///< [V], see Diagnosis::withheld_rmse
  /// on the part that was held out, a sentence each
  std::vector<std::string> notes;
};

/// Opens the part that was held out.
Validation validate(const Recording& recording, const Residuals& residuals,
                    const ModelSelection& selected, const DiagnoseOptions& options);

}  // namespace battery_sof
