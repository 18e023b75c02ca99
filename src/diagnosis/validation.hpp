#pragma once

#include "diagnosis/model_selection.hpp"

namespace battery_sof {

/// Opens the part that was held out: base and extended model on it, and what is handed on after it.
/// @param found takes them; what is withheld: Diagnosis::withheld_rmse.
void validate(const Recording& recording, const Residuals& residuals,
              const ModelSelection& selected, const DiagnoseOptions& options, Diagnosis& found);

}  // namespace battery_sof
