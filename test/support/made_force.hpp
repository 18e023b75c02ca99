#pragma once

#include <memory>

#include "battery_sof/model/battery_model.hpp"

/// A learnt force of every timeless kind, made rather than learnt, for tests.
namespace battery_sof::test {

inline LearnedForce madeForce() {
  LearnedForce force;
  force.context.interval = 0.1;
  force.context.span = 300.0;
  force.context.high = 0.1;
  for (const ForceColumn& column : forceLibrary(force.context))
    if (groupOf(column.kind) != ForceGroup::kTime) force.columns.push_back(column);
  const auto size = static_cast<Eigen::Index>(force.columns.size());
  force.lower = Eigen::VectorXd::Constant(size, -1e6);
  force.upper = Eigen::VectorXd::Constant(size, 1e6);
  force.centre = Eigen::VectorXd::LinSpaced(size, -0.5, 0.5);
  force.scale = Eigen::VectorXd::Constant(size, 10.0);
  for (Eigen::Index k = 0; k < size; ++k)
    if (force.columns[static_cast<std::size_t>(k)].kind == ForceKind::kWarmCurrent) force.scale[k] = 1e4;
  force.weight = Eigen::VectorXd::LinSpaced(size, 0.001, 0.004);
  force.base_change.resize(kBaseDirections);
  force.base_change << 0.0005, 0.001, 0.1, -0.2, 0.05, 0.01;
  for (const Family family : kAllFamilies)
    for (const ForceColumn& column : force.columns)
      if (column.family == family && (force.parts.empty() || force.parts.back().family != family)) force.parts.push_back({family, 0.1});
  return force;
}

inline BatteryModel madeForceModel(std::vector<std::string> effects = {}) {
  effects.push_back(kLearnedEffect);
  return BatteryModel(effects, std::make_shared<const LearnedForce>(madeForce()));
}

}  // namespace battery_sof::test
