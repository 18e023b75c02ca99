#include "discrepancy_yaml.hpp"

#include <array>

namespace battery_sof {
namespace {

/// Numbers of a regressor: those of its kind, then where it was seen and what it weighs.
constexpr std::array<const char*, 8> kRegressorNumbers = {"time",  "scale",  "charge", "lower",
                                                          "upper", "centre", "spread", "weight_v"};

YAML::Node regressorNode(const DiscrepancyModel& discrepancy, std::size_t k) {
  const Regressor& regressor = discrepancy.regressors[k];
  const auto j = static_cast<Eigen::Index>(k);
  YAML::Node node;
  node["kind"] = kindId(regressor.kind);
  node["mechanism"] = mechanismId(regressor.mechanism);
  node["numbers"] = flow({regressor.time, regressor.scale, regressor.charge, discrepancy.lower[j],
                          discrepancy.upper[j], discrepancy.centre[j], discrepancy.scale[j],
                          discrepancy.weight[j]});
  node.SetStyle(YAML::EmitterStyle::Flow);
  return node;
}

/// An id that must be one of a few.
template <typename T, typename All, typename Name>
T oneOf(const Reader& node, const char* key, const All& all, const Name& name) {
  const std::string id = node.text(key);
  std::string known;
  for (const T each : all) {
    if (name(each) == id) return each;
    known += (known.empty() ? "" : ", ") + name(each);
  }
  node.fail(key, "is \"" + id + "\", expected one of " + known);
}

void addRegressor(const Reader& node, Eigen::Index j, DiscrepancyModel& discrepancy) {
  const auto x = node.finiteNumbers("numbers", kRegressorNumbers.size());
  discrepancy.regressors.push_back(
      {oneOf<RegressorKind>(node, "kind", allRegressorKinds(), kindId),
       oneOf<Mechanism>(node, "mechanism", kAllMechanisms, mechanismId), x[0], x[1], x[2]});
  discrepancy.lower[j] = x[3];
  discrepancy.upper[j] = x[4];
  discrepancy.centre[j] = x[5];
  discrepancy.scale[j] = x[6];
  discrepancy.weight[j] = x[7];
}

}  // namespace

YAML::Node discrepancyNode(const DiscrepancyModel& discrepancy) {
  YAML::Node node;
  node["context"] =
      flow({discrepancy.context.interval, discrepancy.context.span, discrepancy.context.beta,
            discrepancy.context.high, discrepancy.context.high_width});
  node["circuit"] = flow({discrepancy.base_change.data(),
                          discrepancy.base_change.data() + discrepancy.base_change.size()});
  for (const DiscrepancyModel::Part& part : discrepancy.parts)
    node["factor_std"][mechanismId(part.mechanism)] = scalar(part.std);
  for (const char* name : kRegressorNumbers) node["numbers"].push_back(name);
  node["numbers"].SetStyle(YAML::EmitterStyle::Flow);
  node["regressors"] = YAML::Node(YAML::NodeType::Sequence);
  for (std::size_t k = 0; k < discrepancy.regressors.size(); ++k)
    node["regressors"].push_back(regressorNode(discrepancy, k));
  return node;
}

DiscrepancyModel discrepancyOf(const Reader& node) {
  DiscrepancyModel discrepancy;
  const auto context = node.finiteNumbers("context", 5);
  discrepancy.context = {context[0], context[1], context[2], context[3], context[4]};
  if (!(context[0] >= 0.0 && context[1] > 0.0 && context[2] > 0.0 && context[4] > 0.0))
    node.fail("context",
              "must be interval (0 or more), span, beta (above 0), high and its width (above 0)");
  const auto circuit = node.finiteNumbers("circuit", static_cast<std::size_t>(kBaseDirections));
  discrepancy.base_change = Eigen::Map<const Eigen::VectorXd>(circuit.data(), kBaseDirections);
  const std::vector<Reader> regressors = node.listAt("regressors");
  const auto size = static_cast<Eigen::Index>(regressors.size());
  for (Eigen::VectorXd* each : {&discrepancy.lower, &discrepancy.upper, &discrepancy.centre,
                                &discrepancy.scale, &discrepancy.weight})
    each->setZero(size);
  for (Eigen::Index j = 0; j < size; ++j)
    addRegressor(regressors[static_cast<std::size_t>(j)], j, discrepancy);
  for (const Mechanism mechanism : kAllMechanisms)
    if (node.at("factor_std").has(mechanismId(mechanism)))
      discrepancy.parts.push_back(
          {mechanism, node.at("factor_std").number(mechanismId(mechanism), {-1e6, 1e6})});
  try {
    discrepancyInfo(discrepancy);
  } catch (const std::invalid_argument& error) {
    node.fail("regressors", std::string("cannot be used: ") + error.what());
  }
  return discrepancy;
}

}  // namespace battery_sof
