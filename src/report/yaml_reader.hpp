#pragma once

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "battery_sof/report/model_yaml.hpp"

namespace battery_sof {

/// A list of numbers on one line.
inline YAML::Node flow(const std::vector<double>& values) {
  YAML::Node node(YAML::NodeType::Sequence);
  for (const double value : values) node.push_back(value);
  node.SetStyle(YAML::EmitterStyle::Flow);
  return node;
}

/// Access to a document's fields with messages that name file, field, finding and expectation.
class Reader {
 public:
  Reader(YAML::Node node, std::string source, std::string path)
      : node_(std::move(node)), source_(std::move(source)), path_(std::move(path)) {}

  Reader at(const std::string& key) const {
    if (!node_.IsMap() || !node_[key]) fail(key, "is missing");
    return {node_[key], source_, path_ + "." + key};
  }
  bool has(const std::string& key) const { return node_.IsMap() && node_[key]; }

  template <typename T>
  T get(const std::string& key, const char* expected) const {
    const Reader field = at(key);
    try {
      return field.node_.as<T>();
    } catch (const YAML::Exception&) {
      fail(key, "is \"" + textOf(field.node_) + "\", expected " + expected);
    }
  }
  double number(const std::string& key) const {
    const double value = get<double>(key, "a number");
    if (!std::isfinite(value)) fail(key, "is not finite, expected a finite number");
    return value;
  }
  /// Entries of a list.
  std::vector<Reader> listAt(const std::string& key) const {
    const Reader list = at(key);
    if (!list.node_.IsSequence()) fail(key, "is \"" + textOf(list.node_) + "\", expected a list");
    std::vector<Reader> entries;
    for (std::size_t k = 0; k < list.node_.size(); ++k) entries.push_back({list.node_[k], source_, list.path_ + "[" + std::to_string(k) + "]"});
    return entries;
  }
  std::string text(const std::string& key) const { return get<std::string>(key, "text"); }
  const YAML::Node& node() const { return node_; }

  [[noreturn]] void fail(const std::string& key, const std::string& what) const {
    throw ModelFileError(source_ + ": " + (path_ + "." + key).substr(1) + " " + what);
  }

 private:
  static std::string textOf(const YAML::Node& node) {
    std::ostringstream text;
    text << node;
    return text.str().substr(0, 60);
  }
  YAML::Node node_;
  std::string source_, path_;
};

}  // namespace battery_sof
