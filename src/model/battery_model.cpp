#include "battery_sof/model/battery_model.hpp"

#include <algorithm>
#include <stdexcept>

namespace battery_sof {
namespace {

bool contains(const std::vector<std::string>& ids, const std::string& id) {
  return std::find(ids.begin(), ids.end(), id) != ids.end();
}

void requireSound(const std::vector<std::string>& effects) {
  for (std::size_t k = 0; k < effects.size(); ++k) {
    const EffectInfo& info = effectInfo(effects[k]);
    if (std::count(effects.begin(), effects.end(), info.id) > 1)
      throw std::invalid_argument("effect \"" + info.id + "\" is given twice");
    for (const std::string& need : info.needs)
      if (!contains(effects, need))
        throw std::invalid_argument("effect \"" + info.id + "\" has no meaning without \"" + need +
                                    "\"");
  }
}

}  // namespace

BatteryModel::BatteryModel(const std::vector<std::string>& effects) {
  requireSound(effects);
  for (const ParameterInfo& info : tableOne()) {
    parameters_.push_back(info);
    parameters_.back().logarithmic = info.name == "c2" || info.name == "beta";
    parameters_.back().linear = !parameters_.back().logarithmic;
  }
  parameters_.push_back({"u_dc", "u_dc", "V", BaseParameters{}.u_dc, 0.0, 100.0, "paper, eq. 4"});
  parameters_.back().linear = true;
  states_.push_back({"u_c2", "V", 0.0, 0.2, -2.0, 2.0});
  for (const EffectInfo& info : effectCatalogue()) {
    if (!contains(effects, info.id)) continue;
    effects_.push_back(info.id);
    first_parameter_.push_back(parameterCount());
    first_state_.push_back(stateCount());
    parameters_.insert(parameters_.end(), info.parameters.begin(), info.parameters.end());
    states_.insert(states_.end(), info.states.begin(), info.states.end());
  }
  for (const std::string& id : effects_)
    for (const ParameterInfo& info : effectInfo(id).beside)
      if (const auto row = parameterRow(info.name)) parameters_[static_cast<std::size_t>(*row)] = info;
  for (const std::string& id : effects_)
    for (const std::string& bent : effectInfo(id).bends)
      if (const auto row = parameterRow(bent)) parameters_[static_cast<std::size_t>(*row)].linear = false;
}

std::optional<Eigen::Index> BatteryModel::parameterRow(const std::string& name) const {
  for (Eigen::Index j = 0; j < parameterCount(); ++j)
    if (parameters_[static_cast<std::size_t>(j)].name == name) return j;
  return std::nullopt;
}

Eigen::VectorXd BatteryModel::typicalParameters() const {
  Eigen::VectorXd typical(parameterCount());
  for (Eigen::Index j = 0; j < parameterCount(); ++j)
    typical[j] = parameters_[static_cast<std::size_t>(j)].magnitude;
  return typical;
}

Eigen::VectorXd BatteryModel::restState() const {
  Eigen::VectorXd rest(stateCount());
  for (Eigen::Index j = 0; j < stateCount(); ++j) rest[j] = states_[static_cast<std::size_t>(j)].rest;
  return rest;
}

BaseParameters baseParameters(const Eigen::VectorXd& parameters) {
  BaseParameters base;
  base.r_discharge = parameters[kRowRDischarge];
  base.r_charge = parameters[kRowRCharge];
  base.c2 = parameters[kRowC2];
  base.beta = parameters[kRowBeta];
  base.u_dc = parameters[kRowUDc];
  return base;
}

}  // namespace battery_sof
