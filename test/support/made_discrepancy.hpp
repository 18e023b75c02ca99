#pragma once

#include <memory>

#include "model/battery_model.hpp"

/// A discrepancy model of every timeless kind, made rather than estimated, for tests.
namespace battery_sof::test {

inline DiscrepancyModel madeDiscrepancyModel() {
  DiscrepancyModel discrepancy;
  discrepancy.context.interval = 0.1;
  discrepancy.context.span = 300.0;
  discrepancy.context.high = 0.1;
  for (const Regressor& regressor : regressorLibrary(discrepancy.context))
    if (groupOf(regressor.kind) != RegressorGroup::kTime)
      discrepancy.regressors.push_back(regressor);
  const auto size = static_cast<Eigen::Index>(discrepancy.regressors.size());
  discrepancy.lower = Eigen::VectorXd::Constant(size, -1e6);
  discrepancy.upper = Eigen::VectorXd::Constant(size, 1e6);
  discrepancy.centre = Eigen::VectorXd::LinSpaced(size, -0.5, 0.5);
  discrepancy.scale = Eigen::VectorXd::Constant(size, 10.0);
  for (Eigen::Index k = 0; k < size; ++k)
    if (discrepancy.regressors[static_cast<std::size_t>(k)].kind == RegressorKind::kWarmCurrent)
      discrepancy.scale[k] = 1e4;
  discrepancy.weight = Eigen::VectorXd::LinSpaced(size, 0.001, 0.004);
  discrepancy.base_change.resize(kBaseDirections);
  discrepancy.base_change << 0.0005, 0.001, 0.1, -0.2, 0.05, 0.01;
  for (const Mechanism mechanism : kAllMechanisms)
    for (const Regressor& regressor : discrepancy.regressors)
      if (regressor.mechanism == mechanism &&
          (discrepancy.parts.empty() || discrepancy.parts.back().mechanism != mechanism))
        discrepancy.parts.push_back({mechanism, 0.1});
  return discrepancy;
}

inline BatteryModel madeModelWithDiscrepancy(std::vector<std::string> effects = {}) {
  effects.push_back(kDiscrepancyEffect);
  return BatteryModel(effects, std::make_shared<const DiscrepancyModel>(madeDiscrepancyModel()));
}

}  // namespace battery_sof::test
