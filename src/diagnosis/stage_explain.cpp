#include "stage_explain.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "diagnosis/hypotheses.hpp"
#include "explanation_fits.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

// [s] of a slow recording beyond which short steps would take minutes
constexpr double kShortSteps = 6000.0;
constexpr double kLowestVoltage = 10.5, kHighestVoltage = 15.5;  // [V] a block of lead-acid cells
constexpr double kNominalVoltage = 12.8;                         // [V]

/// Whether a voltage is that of blocks of six lead-acid cells, one or more in a row.
bool isLeadAcid(const Series& series) {
  std::vector<double> voltage = series.voltage;
  const auto middle = voltage.begin() + static_cast<std::ptrdiff_t>(voltage.size() / 2);
  std::nth_element(voltage.begin(), middle, voltage.end());
  const double blocks = std::round(*middle / kNominalVoltage);
  return blocks >= 1.0 && *middle >= blocks * kLowestVoltage && *middle <= blocks * kHighestVoltage;
}

/// Ids to weigh. @param notes grows by the ids left out.
std::vector<std::string> idsToWeigh(const Screening& screened,
                                    const std::vector<std::string>& wanted, bool is_driven,
                                    bool is_lead_acid, std::vector<std::string>& notes) {
  if (wanted.empty() && !is_lead_acid) {
    notes.push_back(
        "the voltage is not that of lead-acid blocks: what is missing is estimated and gets no "
        "lead-acid name");
    return {};
  }
  std::vector<std::string> ids = hypothesesOf(wanted, is_driven);
  const double span = screened.series.time.back() - screened.series.time.front();
  if (!wanted.empty() || !screened.slow || span <= kShortSteps) return ids;
  const auto left = std::stable_partition(ids.begin(), ids.end(), [](const std::string& id) {
    const EffectInfo& info = effectInfo(id);
    return !info.takes_short_steps || info.on_request;  // the physics of what a source does
  });
  const std::vector<std::string> left_out(left, ids.end());
  ids.erase(left, ids.end());
  notes.push_back("long and slowly sampled: " + join(left_out) +
                  " are not weighed; give a part of the recording, or name them as hypotheses");
  return ids;
}

/// Fits to the rows of the training part, with the input of each.
std::unique_ptr<ExplanationFits> fitsTo(const Prepared& prepared,
                                        const std::optional<ChargerControl>& driving,
                                        const ExplanationRules& rules) {
  std::vector<char> masked = prepared.screened.limits.masked;
  Series sound = prepared.screened.series;
  if (driving) {
    sound = repaired(sound, driving->repair);
    for (std::size_t n = 0; n < masked.size(); ++n)
      masked[n] = masked[n] || driving->repair.dropped[n];
  }
  const InputSequence inputs =
      inputSequence(sound, prepared.parts.train, masked,
                    driving ? driving->voltage_controlled : std::vector<char>());
  const CompositionPoint& base = prepared.base.point;
  const BatteryModel circuit;
  DesignMatrix table = designMatrix(
      inputs, linearizationOf(circuit, beginningOf(base, inputs), inputs, inputs.samples.size()),
      base.parameters[kRowBeta]);
  return std::make_unique<ExplanationFits>(inputs, std::move(table), base, rules);
}

ExplanationRules rulesOf(const DiagnoseOptions& options) {
  ExplanationRules rules;
  rules.relevance = options.relevance;
  rules.priors = options.priors;
  rules.pulse = options.pulse;
  return rules;
}

}  // namespace

MechanismEvidence weighMechanisms(const Prepared& prepared, const DiagnoseOptions& options) {
  const ExplanationRules rules = rulesOf(options);
  return mechanismEvidence(*fitsTo(prepared, std::nullopt, rules),
                           hypothesesOf(options.hypotheses, false), rules);
}

/// A source is taken to control the voltage where the rows are missed by a tenth less so, once all
/// that can be estimated is taken out: a rest or a step that one channel shows late can look like a
/// source, and a voltage that is controlled although it is not brings its noise into the battery's
/// state.
Explained explainErrors(const Prepared& prepared, const DiagnoseOptions& options) {
  Explained explained;
  explained.driving = chargerControl(prepared.screened.series);
  explained.is_lead_acid = isLeadAcid(prepared.screened.series);
  ExplanationRules rules = rulesOf(options);
  std::unique_ptr<ExplanationFits> fits = fitsTo(prepared, std::nullopt, rules);
  if (explained.driving) {
    std::unique_ptr<ExplanationFits> controlled = fitsTo(prepared, explained.driving, rules);
    if (controlled->minError() < (1.0 - kCatalogueTolerance) * fits->minError()) {
      fits = std::move(controlled);
    } else {
      explained.driving.reset();
      explained.notes.push_back(
          "a source is seen, but to take it as holding the voltage leaves no less of the error: "
          "the current is the input");
    }
  }
  const std::vector<std::string> ids =
      idsToWeigh(prepared.screened, options.hypotheses, explained.driving.has_value(),
                 explained.is_lead_acid, explained.notes);
  explained.explanation = explain(*fits, ids, options.given, rules, options.progress);
  return explained;
}

}  // namespace battery_sof
