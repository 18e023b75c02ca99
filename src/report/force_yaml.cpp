#include "force_yaml.hpp"

#include <array>

namespace battery_sof {
namespace {

/// Numbers of a column: those of its kind, then where it was seen and what it weighs.
constexpr std::array<const char*, 8> kColumnNumbers = {"time", "scale", "charge", "lower", "upper", "centre", "spread", "weight_v"};

YAML::Node columnNode(const LearnedForce& force, std::size_t k) {
  const ForceColumn& column = force.columns[k];
  const auto j = static_cast<Eigen::Index>(k);
  YAML::Node node;
  node["kind"] = kindId(column.kind);
  node["family"] = familyId(column.family);
  node["numbers"] =
      flow({column.time, column.scale, column.charge, force.lower[j], force.upper[j], force.centre[j], force.scale[j], force.weight[j]});
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

void addColumn(const Reader& node, Eigen::Index j, LearnedForce& force) {
  const auto x = node.finiteNumbers("numbers", kColumnNumbers.size());
  force.columns.push_back(
      {oneOf<ForceKind>(node, "kind", allForceKinds(), kindId), oneOf<Family>(node, "family", kAllFamilies, familyId), x[0], x[1], x[2]});
  force.lower[j] = x[3];
  force.upper[j] = x[4];
  force.centre[j] = x[5];
  force.scale[j] = x[6];
  force.weight[j] = x[7];
}

}  // namespace

YAML::Node forceNode(const LearnedForce& force) {
  YAML::Node node;
  node["context"] = flow({force.context.interval, force.context.span, force.context.beta, force.context.high, force.context.high_width});
  node["circuit"] = flow({force.base_change.data(), force.base_change.data() + force.base_change.size()});
  for (const LearnedForce::Part& part : force.parts) node["factor_std"][familyId(part.family)] = scalar(part.std);
  for (const char* name : kColumnNumbers) node["numbers"].push_back(name);
  node["numbers"].SetStyle(YAML::EmitterStyle::Flow);
  node["columns"] = YAML::Node(YAML::NodeType::Sequence);
  for (std::size_t k = 0; k < force.columns.size(); ++k) node["columns"].push_back(columnNode(force, k));
  return node;
}

LearnedForce forceOf(const Reader& node) {
  LearnedForce force;
  const auto context = node.finiteNumbers("context", 5);
  force.context = {context[0], context[1], context[2], context[3], context[4]};
  if (!(context[0] >= 0.0 && context[1] > 0.0 && context[2] > 0.0 && context[4] > 0.0))
    node.fail("context", "must be interval (0 or more), span, beta (above 0), high and its width (above 0)");
  const auto circuit = node.finiteNumbers("circuit", static_cast<std::size_t>(kBaseDirections));
  force.base_change = Eigen::Map<const Eigen::VectorXd>(circuit.data(), kBaseDirections);
  const std::vector<Reader> columns = node.listAt("columns");
  const auto size = static_cast<Eigen::Index>(columns.size());
  for (Eigen::VectorXd* each : {&force.lower, &force.upper, &force.centre, &force.scale, &force.weight}) each->setZero(size);
  for (Eigen::Index j = 0; j < size; ++j) addColumn(columns[static_cast<std::size_t>(j)], j, force);
  for (const Family family : kAllFamilies)
    if (node.at("factor_std").has(familyId(family)))
      force.parts.push_back({family, node.at("factor_std").number(familyId(family), {-1e6, 1e6})});
  try {
    learnedInfo(force);
  } catch (const std::invalid_argument& error) {
    node.fail("columns", std::string("cannot be used: ") + error.what());
  }
  return force;
}

}  // namespace battery_sof
