#include "diagnosis/explanation_fits.hpp"

#include "model/base_model.hpp"
#include "model/effect.hpp"
#include "regression/discrepancy_fit.hpp"
#include "util/text.hpp"

#include <algorithm>

namespace battery_sof {
namespace {

// standard deviation of a shape's logarithm where the catalogue has none
constexpr double kWideShape = 0.7;

}  // namespace

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

FitCoordinate stateCoordinate(const StateInfo& info, Eigen::Index row, double start) {
  FitCoordinate c = coordinateOf(info, row);
  if (info.begins_as_u_c2) c.centre = c.of(start);
  return c;
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

std::vector<std::string> hypothesesOf(const std::vector<std::string>& asked,
                                      bool voltage_controlled) {
  if (!asked.empty()) return asked;
  std::vector<std::string> ids;
  for (const EffectInfo& info : effectCatalogue())
    if (!info.on_request || voltage_controlled) ids.push_back(info.id);
  return ids;
}

}  // namespace battery_sof
