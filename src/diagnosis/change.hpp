#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "battery_sof/series.hpp"
#include "diagnosis/response_table.hpp"
#include "state/fitted_model.hpp"

namespace battery_sof {

/// What a comparison with a reference comes to.
enum class ChangeVerdict {
  kNoChange,          ///< nothing but what two sound trips of one battery differ by
  kChanged,           ///< one change explains what differs
  kAnotherBattery,    ///< the models of the two do not predict each other
  kInsufficientData,  ///< one of them cannot answer
};

/// @return "no_change", "changed", "another_battery", "insufficient_data".
std::string toString(ChangeVerdict verdict);

/// One change since the reference.
struct Change {
  std::string id;         ///< of an effect or of a parameter
  bool is_effect = true;  ///< else a parameter of the fitted model that moved
  std::string mechanism;  ///< mechanismId()
  double then = 0.0, now = 0.0;
  std::string unit;
  double lower = 0.0, upper = 0.0;  ///< 90 % interval of `now`
  double probability = 0.0;         ///< [0, 1], that it is this one or one that looks the same
  std::vector<std::string> indistinguishable;
};

/// A quantity that was compared.
struct ComparedFeature {
  std::string id, unit;
  double then = 0.0, now = 0.0;
  std::optional<double> with_change;  ///< the reference's with the changes that are stated put in
  double std_error = 0.0;             ///< of the difference, from both recordings
  double spread = 0.0;                ///< standard deviation of the difference of two sound trips
};

/// Strength from which an effect is named in nine cases of ten.
struct ChangeLimit {
  std::string id, unit;
  double strength = 0.0;
};

/// Explained variation on the last quarter of NOW in the directions that are controlled [%].
struct ModelShare {
  std::optional<double> share_percent, current_share_percent, voltage_share_percent;
};

struct ChangeDiagnosis {
  ChangeVerdict verdict = ChangeVerdict::kInsufficientData;
  /// one sentence, and one each for a second change and for references that do not agree
  std::string summary;
  std::vector<Change> changes;  ///< at most two, likeliest first; empty but for kChanged
  std::vector<ComparedFeature> compared;
  std::vector<ChangeLimit> detection_limits;
  /// of the reference's model, of the model of the reference with the change in it, and of a model
  /// that is fitted to the first three quarters of NOW; each of the last quarter of NOW
  ModelShare reference_model, changed_model, own_model;
  /// [1], distance of what was compared from the reference, and by how much the best change lowers it
  double distance = 0.0, gain = 0.0;
  /// [1], median of ln(error of the other's model / error of the own one) over blocks of both
  /// recordings, the smaller one of the reference and of it with the changes, and the largest that
  /// two sound recordings have that are as long as the shorter one
  std::optional<double> model_distance, largest_model_distance;
  /// fitted to the longest recording of now, which is number `modelled` of them; none where no model
  /// could be, or was to be, fitted
  std::optional<FittedModel> model;
  std::size_t modelled = 0;
};

struct ChangeOptions {
  bool anyway = false;  ///< recordings with a problem (findProblems()) are compared all the same
  /// false: the responses alone are compared, in a second; another battery is not noticed then
  bool runs_models = true;
  /// called with what is done next
  std::function<void(const std::string&)> progress = nullptr;
};

/// What NOW is compared with: recordings of the battery when it was sound, and models of such
/// recordings with what their files keep of them (FittedModel::responses).
struct ChangeReference {
  std::vector<Series> recordings;
  std::vector<FittedModel> models;
};

/**
 * @brief What has changed in a battery or its instruments since a reference.
 *
 * What is compared are responseFeatures() f. A change c of strength s is put into the reference
 * exactly (v + R i with i as late as the voltage is, (1 + g) i, i + i_o, a shift by rows, a
 * first-order lag of one channel), so its signature needs no model and no linearisation:
 *
 *     D(c, s) = (f_now - f_then(c, s))' V^-1 (f_now - f_then(c, s)) + ln det V,
 *     V = V_now + V_then(c, s) + V_between
 *
 * V_between is the spread between sound trips of one battery (docs/changes.md); D counts from ln det
 * V with nothing changed.
 * The change of least D is stated where it lowers D(nothing) by more than kLeastGain; changes
 * within kAlike of it are indistinguishable. Recordings of the reference are then compared again
 * with that change put in, and one of another kind is stated beside it in the same way. A contact's
 * resistance looks like the battery's own ohmic one, an offset like a load that the sensor does not
 * see, always.
 *
 * Models are fitted, of THEN, of THEN with the changes in it and of NOW, and run on each other's
 * recording. Where neither one of THEN is as near to that of NOW as those of one battery are, it is
 * another battery, or another vehicle. A reference that is a model alone has no recording to run the
 * other one on, and no change is put into it: it runs on NOW, and on NOW with the change taken out.
 * That says how much it explains, and not whether it is another battery.
 *
 * @param now recordings at the rate models are fitted at (atDesignRate()), of one battery.
 * @param then of the same battery, at least one; recordings at that rate, too.
 * @return kInsufficientData with the reason in the summary where nothing can be compared; never
 * throws for poor data.
 * @throws std::invalid_argument for no recording of now or no reference, and for references that
 * cannot be averaged.
 */
ChangeDiagnosis diagnoseChange(const std::vector<Series>& now, const ChangeReference& then,
                               const ChangeOptions& options = {});

/// The same of drives whose samples are gone, by their responses alone. @param reference with
/// ResponseTable::since; without it, or none: kInsufficientData.
ChangeDiagnosis diagnoseChange(const std::shared_ptr<const ResponseTable>& reference);

}  // namespace battery_sof
