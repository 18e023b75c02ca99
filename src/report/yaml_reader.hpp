#pragma once

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "report/model_yaml.hpp"
#include "util/number_text.hpp"
#include "util/printable.hpp"
#include "util/text.hpp"

namespace battery_sof {

// Numbers go through text in the classic locale: yaml-cpp's own conversions obey
// std::locale::global().

/// @return a number in the digits that read back exactly, a whole number as it is.
inline YAML::Node scalar(double value) {
  if (!std::isfinite(value))
    return YAML::Node(std::isnan(value) ? ".nan" : value > 0.0 ? ".inf" : "-.inf");
  return YAML::Node(format("%.17g", value));
}
inline YAML::Node scalar(int value) { return YAML::Node(std::to_string(value)); }
inline YAML::Node scalar(std::size_t value) { return YAML::Node(std::to_string(value)); }

/// A number to be read from a document; .inf and .nan are numbers that are not finite.
struct Decimal {
  double value = 0.0;
};

}  // namespace battery_sof

template <>
struct YAML::convert<battery_sof::Decimal> {
  static bool decode(const Node& node, battery_sof::Decimal& decimal) {
    if (!node.IsScalar()) return false;
    const std::string& text = node.Scalar();
    const std::size_t sign = text.find_first_not_of("+-") == 1 ? 1 : 0;
    const bool special =
        text.compare(sign, 1, ".") == 0 && text.find_first_of("nN") != std::string::npos;
    const auto value = battery_sof::numberOf(special ? text.substr(sign + 1) : text);
    decimal.value = value.value_or(0.0);
    return value.has_value();
  }
};

namespace battery_sof {

/// A list of numbers on one line.
inline YAML::Node flow(const std::vector<double>& values) {
  YAML::Node node(YAML::NodeType::Sequence);
  for (const double value : values) node.push_back(scalar(value));
  node.SetStyle(YAML::EmitterStyle::Flow);
  return node;
}

/// What a number can be.
struct Range {
  double least, most;
  bool holds(double value) const { return value >= least && value <= most; }
};

constexpr Range kTimes{-1e10, 1e10};  // [s], as IntakeLimits
// [A], twice IntakeLimits: an estimate may go beyond what is measured
constexpr Range kCurrents{-1e4, 1e4};
constexpr Range kVoltages{-200.0, 200.0};  // [V], likewise
constexpr Range kNumbers{-1e12, 1e12};     // of any unit: what is larger comes from no battery

/// Access to a document's fields with messages that name file, field, finding and expectation.
class Reader {
 public:
  /// Refuses what a decimal comma makes of {std: 1,5}: a key 5 without a value.
  Reader(const YAML::Node& node, std::string source, std::string path)
      : node_(node), source_(std::move(source)), path_(std::move(path)) {
    if (!node_.IsMap() || node_.Style() != YAML::EmitterStyle::Flow) return;
    for (const auto& entry : node_)
      if (entry.second.IsNull() || (entry.first.IsScalar() && numberOf(entry.first.Scalar())))
        fail(textOf(entry.first), "is no key with a value" + std::string(kPoint));
  }

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
    const double value = get<Decimal>(key, "a number").value;
    if (!std::isfinite(value)) fail(key, "is not finite, expected a finite number");
    return value;
  }
  std::vector<double> numbers(const std::string& key, const char* expected) const {
    const auto values = valuesOf(get<std::vector<Decimal>>(key, expected));
    if (isUnevenlySpaced(at(key).node_))
      fail(key, "has some commas with a space behind them and some without" + std::string(kPoint));
    return values;
  }
  /// A count.
  template <typename T>
  T whole(const std::string& key) const {
    constexpr double kMost = std::min(1e15, static_cast<double>(std::numeric_limits<T>::max()));
    const double value = get<Decimal>(key, "a whole number").value;
    if (!(value >= 0.0 && value <= kMost && value == std::floor(value)))
      fail(key, "is \"" + textOf(at(key).node_) + "\", expected a whole number");
    return static_cast<T>(value);
  }
  std::vector<std::vector<double>> rows(const std::string& key, const char* expected) const {
    std::vector<std::vector<double>> rows;
    for (const auto& row : get<std::vector<std::vector<Decimal>>>(key, expected))
      rows.push_back(valuesOf(row));
    return rows;
  }
  double number(const std::string& key, Range range) const {
    const double value = number(key);
    if (range.holds(value)) return value;
    ClassicStream text;
    text << "is " << value << ", expected " << range.least << " to " << range.most;
    fail(key, text.str());
  }
  /// A list of finite numbers; of a count when that is not zero.
  std::vector<double> finiteNumbers(const std::string& key, std::size_t count,
                                    Range range = kNumbers) const {
    const std::string expected = (count > 0 ? std::to_string(count) + " " : "") + "numbers";
    const auto values = numbers(key, expected.c_str());
    if (count > 0 && values.size() != count)
      fail(key,
           "has " + std::to_string(values.size()) + " numbers, expected " + std::to_string(count));
    for (const double value : values) requireIn(key, value, range);
    return values;
  }
  void requireIn(const std::string& key, double value, Range range) const {
    if (!std::isfinite(value)) fail(key, "holds a number that is not finite");
    if (range.holds(value)) return;
    ClassicStream text;
    text << "holds " << value << ", expected numbers of " << range.least << " to " << range.most;
    fail(key, text.str());
  }
  /// Entries of a list.
  std::vector<Reader> listAt(const std::string& key) const {
    const Reader list = at(key);
    if (!list.node_.IsSequence()) fail(key, "is \"" + textOf(list.node_) + "\", expected a list");
    std::vector<Reader> entries;
    for (std::size_t k = 0; k < list.node_.size(); ++k)
      entries.push_back({list.node_[k], source_, list.path_ + "[" + std::to_string(k) + "]"});
    return entries;
  }
  /// printable(): a file may hold any bytes.
  std::string text(const std::string& key) const {
    return printable(get<std::string>(key, "text"));
  }
  const YAML::Node& node() const { return node_; }

  [[noreturn]] void fail(const std::string& key, const std::string& what) const {
    constexpr std::size_t kMost = 1000;  // [bytes]
    throw ModelFileError(source_ + ": " +
                         shortened((path_ + "." + key).substr(1) + " " + what, kMost));
  }

 private:
  static constexpr char kPoint[] = ": a comma ends a number, expected a decimal point";

  /// What decimal commas make of a list, as in [0,5, 0,7].
  static bool isUnevenlySpaced(const YAML::Node& list) {
    std::size_t spaced = 0;
    for (std::size_t k = 1; k < list.size(); ++k)
      if (list[k].Mark().pos >
          list[k - 1].Mark().pos + static_cast<int>(list[k - 1].Scalar().size()) + 1)
        ++spaced;
    return spaced > 0 && spaced + 1 < list.size();
  }
  static std::vector<double> valuesOf(const std::vector<Decimal>& decimals) {
    std::vector<double> values;
    for (const Decimal& decimal : decimals) values.push_back(decimal.value);
    return values;
  }
  static std::string textOf(const YAML::Node& node) {
    ClassicStream text;
    text << node;
    return text.str().substr(0, 60);
  }
  YAML::Node node_;
  std::string source_, path_;
};

}  // namespace battery_sof
