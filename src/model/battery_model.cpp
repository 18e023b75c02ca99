#include "model/battery_model.hpp"

#include <algorithm>
#include <stdexcept>

#include "util/text.hpp"

namespace battery_sof {
namespace {

void requireSound(const std::vector<std::string>& effects, bool has_discrepancy) {
  for (const std::string& id : effects) {
    if (std::count(effects.begin(), effects.end(), id) > 1)
      throw std::invalid_argument("effect \"" + id + "\" is given twice");
    if (id == kDiscrepancyEffect) continue;
    for (const std::string& need : effectInfo(id).needs)
      if (!contains(effects, need))
        throw std::invalid_argument(
            format("effect \"%s\" has no meaning without \"%s\"", id.c_str(), need.c_str()));
  }
  if (contains(effects, kDiscrepancyEffect) != has_discrepancy)
    throw std::invalid_argument(has_discrepancy
                                    ? "a discrepancy model is given, and \"" + kDiscrepancyEffect +
                                          "\" is not among the effects"
                                    : "effect \"" + kDiscrepancyEffect +
                                          "\" has no meaning without the estimated discrepancy, "
                                          "as a model file holds it");
}

}  // namespace

BatteryModel::BatteryModel(const std::vector<std::string>& effects,
                           std::shared_ptr<const DiscrepancyModel> discrepancy)
    : discrepancy_(std::move(discrepancy)) {
  requireSound(effects, discrepancy_ != nullptr);
  for (const ParameterInfo& info : tableOne()) {
    parameters_.push_back(info);
    parameters_.back().logarithmic = info.name == "c2" || info.name == "beta";
    parameters_.back().linear = !parameters_.back().logarithmic;
  }
  parameters_.push_back({"u_dc", "u_dc", "V", BaseParameters{}.u_dc, 0.0, 100.0, "paper, eq. 4"});
  parameters_.back().linear = true;
  states_.push_back({"u_c2", "V", 0.0, 0.2, -2.0, 2.0});
  std::vector<EffectInfo> infos;
  for (const EffectInfo& info : effectCatalogue())
    if (contains(effects, info.id)) infos.push_back(info);
  if (discrepancy_) infos.push_back(discrepancyInfo(*discrepancy_));
  for (const EffectInfo& info : infos) {
    effects_.push_back(info.id);
    first_parameter_.push_back(parameterCount());
    first_state_.push_back(stateCount());
    parameters_.insert(parameters_.end(), info.parameters.begin(), info.parameters.end());
    states_.insert(states_.end(), info.states.begin(), info.states.end());
  }
  for (const EffectInfo& effect : infos)
    for (const ParameterInfo& info : effect.overrides)
      if (const auto row = parameterRow(info.name)) parameters_[*row] = info;
  for (const EffectInfo& effect : infos)
    for (const std::string& bent : effect.is_nonlinear)
      if (const auto row = parameterRow(bent)) parameters_[*row].linear = false;
}

std::optional<Eigen::Index> BatteryModel::parameterRow(const std::string& name) const {
  for (Eigen::Index j = 0; j < parameterCount(); ++j)
    if (parameters_[j].name == name) return j;
  return std::nullopt;
}

Eigen::VectorXd BatteryModel::typicalParameters() const {
  Eigen::VectorXd typical(parameterCount());
  for (Eigen::Index j = 0; j < parameterCount(); ++j) typical[j] = parameters_[j].magnitude;
  return typical;
}

Eigen::VectorXd BatteryModel::restState() const {
  Eigen::VectorXd rest(stateCount());
  for (Eigen::Index j = 0; j < stateCount(); ++j) rest[j] = states_[j].rest;
  return rest;
}

BaseParameters baseParameters(const Eigen::VectorXd& parameters) {
  return {parameters[kRowRDischarge], parameters[kRowRCharge], parameters[kRowC2],
          parameters[kRowBeta], parameters[kRowUDc]};
}

}  // namespace battery_sof
