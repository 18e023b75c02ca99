#include "diagnosis/explanation_fits.hpp"

#include <algorithm>

#include "model/base_model.hpp"

namespace battery_sof {
namespace {

// standard deviation of a shape's logarithm where the catalogue has none
constexpr double kWideShape = 0.7;

/// @param span of the recording [s].
FitCoordinate effectCoordinate(const ParameterInfo& info, Eigen::Index row, double span) {
  FitCoordinate c;
  c.row = row;
  c.logarithmic = info.logarithmic;
  c.strength = info.vanishes_at.has_value();
  c.instant = info.instant;
  c.lower = info.lower;
  c.upper = info.upper;
  const double gone = info.vanishes_at.value_or(0.0);
  if (info.instant) {
    c.unit = 0.1 * span;
    c.upper = std::min(info.upper, span);
    c.std = 3.0;
    c.centre = 5.0;
    return c;
  }
  // A process that lasts longer than a third of the recording is charge counted or drift: other
  // effects are for that.
  if (info.unit == "s") c.upper = std::max(std::min(info.upper, span / 3.0), 2.0 * info.lower);
  if (info.logarithmic) {
    c.std = c.strength ? kWideStrength : info.prior_std.value_or(kWideShape);
    c.centre = c.strength ? std::log(gone) : std::log(info.magnitude);
    return c;
  }
  c.zero = c.strength ? gone : 0.0;
  c.unit = std::max(std::abs(info.magnitude - c.zero), 1e-12);
  if (c.strength && c.unit < 1e-9 * (std::abs(info.upper) + std::abs(gone)))
    c.unit = 0.25 * (info.upper - gone);
  const double reach =
      0.25 * std::max(std::abs(info.upper - c.zero), std::abs(info.lower - c.zero)) / c.unit;
  c.std = c.strength ? std::max(kWideStrength, reach)
                     : info.prior_std.value_or(kWideShape * c.unit) / c.unit;
  c.centre = c.strength ? 0.0 : info.magnitude / c.unit;
  return c;
}

/// @param start value that the base circuit's fit has there [V].
FitCoordinate baseCoordinate(const ParameterInfo& info, Eigen::Index row, double start) {
  FitCoordinate c;
  c.row = row;
  c.lower = info.lower;
  c.upper = info.upper;
  c.std = baseDirectionStd(row);
  c.logarithmic = row == kRowC2 || row == kRowBeta;
  c.centre = row == kRowUDc ? start : c.of(info.magnitude);
  return c;
}

}  // namespace

std::vector<FitCoordinate> ExplanationFits::coordinatesOf(const BatteryModel& model) const {
  std::vector<FitCoordinate> all;
  const std::vector<KnownParameter> known = knownOf(options_.priors, model.effects());
  for (Eigen::Index j = 0; j < model.parameterCount(); ++j) {
    const ParameterInfo& info = model.parameters()[j];
    if (info.held) continue;
    all.push_back(j < kBaseRows ? baseCoordinate(info, j, base_.parameters[kRowUDc])
                                : effectCoordinate(info, j, table_.context.span));
    if (const KnownParameter* one = find(known, info.name)) all.back().take(*one);
  }
  for (Eigen::Index k = 0; k < model.stateCount(); ++k) {
    const StateInfo& info = model.states()[k];
    if (k == 0) {
      FitCoordinate c;
      c.row = model.parameterCount();
      c.centre = base_.state[0];
      c.std = baseDirectionStd(kBaseDirections - 1);
      all.push_back(c);
    } else if (info.initial_std) {
      all.push_back(coordinateOf(info, model.parameterCount() + k));
      if (info.begins_as_u_c2) all.back().centre = all.back().of(base_.state[0]);
    }
  }
  return all;
}

BatteryModel enlarged(const BatteryModel& model, const std::string& id) {
  std::vector<std::string> effects = model.effects();
  const auto add = [&](const std::string& one) {
    if (!contains(effects, one)) effects.push_back(one);
  };
  for (const std::string& needed : effectInfo(id).needs) add(needed);
  add(id);
  return BatteryModel(effects);
}

}  // namespace battery_sof
