#include "battery_sof/model/learned_force.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "force_kernel.hpp"

namespace battery_sof {
namespace {

constexpr double kRest = 1e4;  // [s]
constexpr double kLeastFactor = -1.0, kMostFactor = 3.0;
constexpr double kLeastStd = 0.01;  // [1], of a factor: nothing is learnt better

void require(bool sound, const std::string& what) {
  if (!sound) throw std::invalid_argument("a learnt force: " + what);
}

void requireSound(const LearnedForce& force) {
  const auto columns = static_cast<Eigen::Index>(force.columns.size());
  for (const Eigen::VectorXd* each : {&force.lower, &force.upper, &force.centre, &force.scale, &force.weight})
    require(each->size() == columns && each->allFinite(), std::to_string(columns) + " columns need as many finite numbers each");
  require(force.base_change.size() == kBaseDirections && force.base_change.allFinite(),
          "the circuit's change must be " + std::to_string(kBaseDirections) + " finite numbers");
  require((force.scale.array() > 0.0).all(), "scales must be above 0");
  require((force.lower.array() <= force.upper.array()).all(), "ranges must rise");
  require(force.context.span > 0.0 && std::isfinite(force.context.span), "the span must be above 0");
  for (const ForceColumn& column : force.columns) {
    require(std::isfinite(column.time) && std::isfinite(column.scale) && std::isfinite(column.charge), "a column's numbers must be finite");
    require(std::any_of(force.parts.begin(), force.parts.end(), [&](const auto& part) { return part.family == column.family; }),
            "columns of " + familyId(column.family) + " have no factor");
  }
  for (const LearnedForce::Part& part : force.parts)
    require(part.std >= 0.0 && std::isfinite(part.std), "a factor's deviation must be finite and at least 0");
}

}  // namespace

std::size_t LearnedForce::memorySize() const { return columns.size() + kSharedStates + 1; }

bool isUnbounded(ForceKind kind) { return kind == ForceKind::kCharge || kind == ForceKind::kSlowCharge; }

EffectInfo learnedInfo(const LearnedForce& force) {
  requireSound(force);
  EffectInfo info;
  info.id = kLearnedEffect;
  info.code = "L1";
  info.title = "what currents and their memory say beside the equations";
  info.equations = "u = u_m + S d + sum of a_f w_k (x_k - centre_k) / scale_k";
  for (const LearnedForce::Part& part : force.parts) {
    ParameterInfo factor =
        linearStrength(kLearnedEffect + "_" + familyId(part.family), "a", "1", 1.0, kLeastFactor, kMostFactor, "learnt from a recording");
    factor.prior_std = std::max(part.std, kLeastStd);
    info.parameters.push_back(factor);
  }
  return info;
}

std::vector<double> restedMemory(const LearnedForce& force, std::vector<double> memory) {
  ForceMemory columns(force.columns, force.context);
  if (!memory.empty()) columns.setState({memory.begin(), memory.end() - 1});
  Eigen::VectorXd values(static_cast<Eigen::Index>(force.columns.size()));
  columns.advance({0.0, 0.0, 0.0, false, 0.0, 0.0}, values);
  columns.advance({kRest, 0.0, 0.0, false, 0.0, 0.0}, values);
  memory = columns.state();
  memory.push_back(0.0);  // the circuit's change has settled
  return memory;
}

}  // namespace battery_sof
