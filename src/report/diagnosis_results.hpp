#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "diagnosis/diagnosis.hpp"

namespace battery_sof {

/**
 * @brief JSON of `sof diagnose`, schema battery_sof/diagnosis/2. Absent and not finite numbers are
 * JSON null.
 *
 * In addition to the contract's fields: program, recording; effects: title, evidence,
 * voltage_rms_v, indistinguishable_from, and parameters' lower, upper (of the 95 % interval),
 * at_bound; candidates: title, mechanism; fit.regimes; regimes; parameter_bias; instrument;
 * withheld_rmse_v: of an extended model that predicts the hold-out worse than the base model and is
 * not given; discrepancy; detection_limits; unobservable; operating_mode by reason, and the
 * stretches whose voltage a source controls.
 */
nlohmann::json diagnosisJson(const Diagnosis& diagnosis);

/// The same to read or to paste into a mail: plain text of at most 100 columns, verdict first.
std::string diagnosisText(const Diagnosis& diagnosis);

/// @return whether and where what was estimated is used, as a sentence. @param diagnosis one with
/// Diagnosis::discrepancy.
std::string useOfDiscrepancy(const Diagnosis& diagnosis);

}  // namespace battery_sof
