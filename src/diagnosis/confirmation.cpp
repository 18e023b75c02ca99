#include "confirmation.hpp"

#include <algorithm>

#include "diagnosis/hypotheses.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr int kConfirmations = 6;

bool isNamedWith(const Confirmation& confirmation, const BatteryModel& larger,
                 const CompositionPoint& point, const std::string& id,
                 const DiagnoseOptions& asked) {
  const Prepared& prepared = confirmation.prepared;
  const IndexRange train = prepared.parts.train;
  const InputSequence every =
      inputSequence(prepared.screened.series, train, prepared.screened.limits.masked);
  const Eigen::VectorXd added =
      simulatedVoltage(larger, point, every) -
      simulatedVoltage(confirmation.fit.model, confirmation.fit.point, every);
  if (!added.allFinite()) return false;
  Recording changed = confirmation.recording;
  for (Eigen::Index n = 0; n < added.size(); ++n)
    changed.series.voltage[train.first + static_cast<std::size_t>(n)] += added[n];
  DiagnoseOptions options = asked;
  options.lists_detection_limits = false;
  options.confirm.clear();
  options.progress = nullptr;
  const Diagnosis found = diagnose(changed, options);
  return std::any_of(found.effects.begin(), found.effects.end(), [&](const NamedEffect& effect) {
    return effect.id == id || contains(effect.indistinguishable_from, id);
  });
}

}  // namespace

std::optional<double> confirmedStrength(const Confirmation& confirmation, const DetectionLimit& one,
                                        const DiagnoseOptions& options) {
  tell(options, "diagnosing with " + one.id + " put in");
  const WhitenedFit& fit = confirmation.fit;
  const BatteryModel larger = enlarged(fit.model, one.id);
  const ParameterInfo& info =
      larger.parameters()[static_cast<std::size_t>(*larger.parameterRow(one.parameter))];
  std::optional<double> strength = one.strength.value_or(one.typical);
  for (int round = 0; round < kConfirmations && strength; ++round) {
    CompositionPoint point = embedded(fit.model, fit.point, larger);
    for (const ParameterInfo& other : larger.parameters())
      if (!fit.model.parameterRow(other.name))
        point.parameters[*larger.parameterRow(other.name)] = other.magnitude;
    point.parameters[*larger.parameterRow(one.parameter)] = *strength;
    if (isNamedWith(confirmation, larger, point, one.id, options)) return strength;
    const double gone = info.vanishes_at.value_or(0.0);
    const double next = gone + 2.0 * (*strength - gone);
    strength =
        next >= info.lower && next <= info.upper ? std::optional<double>(next) : std::nullopt;
  }
  return std::nullopt;
}

}  // namespace battery_sof
