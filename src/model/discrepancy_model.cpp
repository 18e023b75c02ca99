#include "model/discrepancy_model.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "discrepancy_run.hpp"

namespace battery_sof {
namespace {

constexpr double kRest = 1e4;  // [s]
constexpr double kMinFactor = -1.0, kMaxFactor = 3.0;
constexpr double kMinStd = 0.01;  // [1], of a factor: nothing is estimated better

void require(bool sound, const std::string& what) {
  if (!sound) throw std::invalid_argument("a discrepancy model: " + what);
}

void requireSound(const DiscrepancyModel& discrepancy) {
  const Eigen::Index regressors = discrepancy.regressors.size();
  for (const Eigen::VectorXd* each : {&discrepancy.lower, &discrepancy.upper, &discrepancy.centre,
                                      &discrepancy.scale, &discrepancy.weight})
    require(each->size() == regressors && each->allFinite(),
            std::to_string(regressors) + " regressors need as many finite numbers each");
  require(discrepancy.base_change.size() == kBaseDirections && discrepancy.base_change.allFinite(),
          "the circuit's change must be " + std::to_string(kBaseDirections) + " finite numbers");
  require((discrepancy.scale.array() > 0.0).all(), "scales must be above 0");
  require((discrepancy.lower.array() <= discrepancy.upper.array()).all(), "ranges must rise");
  require(discrepancy.context.span > 0.0 && std::isfinite(discrepancy.context.span),
          "the span must be above 0");
  for (const Regressor& regressor : discrepancy.regressors) {
    require(std::isfinite(regressor.time) && std::isfinite(regressor.scale) &&
                std::isfinite(regressor.charge),
            "a regressor's numbers must be finite");
    require(std::any_of(discrepancy.parts.begin(), discrepancy.parts.end(),
                        [&](const auto& part) { return part.mechanism == regressor.mechanism; }),
            "regressors of " + mechanismId(regressor.mechanism) + " have no factor");
  }
  for (const DiscrepancyModel::Part& part : discrepancy.parts)
    require(part.std >= 0.0 && std::isfinite(part.std),
            "a factor's deviation must be finite and at least 0");
}

}  // namespace

std::size_t DiscrepancyModel::memorySize() const { return regressors.size() + kSharedStates + 1; }

double DiscrepancyModel::used(Eigen::Index k, double value) const {
  if (isUnbounded(regressors[k].kind)) return value;
  return std::clamp(value, lower[k], upper[k]);
}

bool isUnbounded(RegressorKind kind) {
  return kind == RegressorKind::kCharge || kind == RegressorKind::kSlowCharge;
}

EffectInfo discrepancyInfo(const DiscrepancyModel& discrepancy) {
  requireSound(discrepancy);
  EffectInfo info;
  info.id = kDiscrepancyEffect;
  info.code = "L1";
  info.title = "discrepancy: what currents and their memory add to the equations";
  info.equations = "u = u_m + S d + sum of a_f w_k (x_k - centre_k) / scale_k";
  for (const DiscrepancyModel::Part& part : discrepancy.parts) {
    ParameterInfo factor =
        linearStrength(kDiscrepancyEffect + "_" + mechanismId(part.mechanism), "a", "1", 1.0,
                       kMinFactor, kMaxFactor, "estimated from a recording");
    factor.prior_std = std::max(part.std, kMinStd);
    info.parameters.push_back(factor);
  }
  return info;
}

std::vector<double> restedMemory(const DiscrepancyModel& discrepancy, std::vector<double> memory) {
  memory = firstRegressorMemory<double>(discrepancy, std::move(memory));
  LowPassShares shares;
  std::vector<double> values(discrepancy.regressors.size());
  const RegressorKernel<double> regressors{discrepancy.regressors, discrepancy.context, shares,
                                           memory.data()};
  for (const double duration : {0.0, kRest})
    regressors.advance({duration, 0.0, 0.0, false, 0.0, 0.0}, values.data());
  memory.back() = 0.0;  // the circuit's change has settled
  return memory;
}

}  // namespace battery_sof
