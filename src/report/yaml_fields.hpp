#pragma once

#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <locale>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "report/model_yaml.hpp"
#include "util/files.hpp"
#include "util/text.hpp"

namespace battery_sof {

// Numbers go through text in the classic locale: yaml-cpp's own conversions obey
// std::locale::global().

/// @return a number in as few digits as read back exactly, 15 or 17.
inline YAML::Node scalar(double value) {
  if (!std::isfinite(value))
    return YAML::Node(std::isnan(value) ? ".nan" : value > 0.0 ? ".inf" : "-.inf");
  const std::string brief = format("%.15g", value);
  return YAML::Node(numberOf(brief) == value ? brief : format("%.17g", value));
}

/// @return a number of a document, where .inf and .nan are numbers that are not finite; none for
/// other text.
inline std::optional<double> decimalOf(const std::string& text) {
  const std::size_t sign = text.find_first_not_of("+-") == 1 ? 1 : 0;
  const bool special =
      text.compare(sign, 1, ".") == 0 && text.find_first_of("nN") != std::string::npos;
  return numberOf(special ? text.substr(sign + 1) : text);
}

/// A list of numbers on one line.
inline YAML::Node flow(const std::vector<double>& values) {
  YAML::Node node(YAML::NodeType::Sequence);
  for (const double value : values) node.push_back(scalar(value));
  node.SetStyle(YAML::EmitterStyle::Flow);
  return node;
}

inline std::string shown(double value) { return format("%g", value); }

/// What a number can be.
struct Range {
  double least = -std::numeric_limits<double>::infinity(),
         most = std::numeric_limits<double>::infinity();
  bool holds(double value) const { return value >= least && value <= most; }
  std::string shown() const {
    return battery_sof::shown(least) + " to " + battery_sof::shown(most);
  }
};

constexpr Range kTimes{-1e10, 1e10};  // [s], as IntakeLimits
// [A], twice IntakeLimits: an estimate may go beyond what is measured
constexpr Range kCurrents{-1e4, 1e4};
constexpr Range kVoltages{-200.0, 200.0};  // [V], likewise
constexpr Range kNumbers{-1e12, 1e12};     // of any unit: what is larger comes from no battery
constexpr double kSame = 1e-9;             // files hold correlations with twelve digits

/// @throws ModelFileError where the text is not YAML. @param source name for messages.
inline YAML::Node documentOf(const std::string& text, const std::string& source) {
  try {
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw ModelFileError(source + ": not YAML at line " + std::to_string(error.mark.line + 1) +
                         ", column " + std::to_string(error.mark.column + 1));
  }
}

/// @throws ModelFileError for a file that cannot be read or is larger than that.
inline std::string textOfFile(const std::filesystem::path& path, std::size_t most) {
  try {
    return readRegularFile(path, most);
  } catch (const std::runtime_error& error) {
    throw ModelFileError(error.what());
  }
}

// A file's fields are described once, for both directions: describe(file, part) calls the same
// functions of a FieldWriter, which makes them keys in that order, and of a FieldReader, which
// holds each against what it can be and puts it into the part. What is optional is a key only where
// it is there: has(key, whether the part to be written has it).

/// What a map looks like.
enum class MapStyle { kBlock, kFlow };

class FieldWriter {
 public:
  static constexpr bool kReads = false;

  explicit FieldWriter(const YAML::Node& node) : node_(node) {}

  void number(const std::string& key, double value, Range = {}) { node_[key] = scalar(value); }
  void number(const std::string& key, const std::optional<double>& value, Range = {}) {
    if (value) node_[key] = scalar(*value);
  }
  template <typename Count>
  void count(const char* key, Count value, std::size_t = 0) {
    node_[key] = std::to_string(value);
  }
  void flag(const char* key, bool value) { node_[key] = value; }
  void text(const char* key, const std::string& value) { node_[key] = printable(value); }
  void texts(const char* key, const std::vector<std::string>& values, const char*) {
    node_[key] = values;
    node_[key].SetStyle(YAML::EmitterStyle::Flow);
  }
  template <typename T, typename All, typename Name>
  void oneOf(const char* key, T value, const All&, Name&& name) {
    node_[key] = name(value);
  }
  /// A list of numbers on one line; what each is, docs/model-file.md says.
  template <typename... Numbers>
  void row(const char* key, const Numbers&... numbers) {
    node_[key] = flow({static_cast<double>(numbers)...});
  }
  template <typename Numbers>
  void numbers(const char* key, const Numbers& numbers, std::size_t = 0, Range = {}) {
    node_[key] = flow({numbers.data(), numbers.data() + numbers.size()});
  }
  /// Lists of numbers. @param numbersOf (item, take) calls take with an item's numbers.
  template <typename Item, typename NumbersOf>
  void rows(const char* key, const std::vector<Item>& items, const std::vector<Range>&,
            NumbersOf&& numbersOf) {
    for (const Item& item : items)
      numbersOf(item, [&](const auto&... numbers) { node_[key].push_back(flow({numbers...})); });
  }
  void matrix(const char* key, const Eigen::MatrixXd& matrix) {
    for (Eigen::Index j = 0; j < matrix.rows(); ++j) {
      const Eigen::VectorXd row = matrix.row(j);
      node_[key].push_back(flow({row.data(), row.data() + row.size()}));
    }
  }
  template <typename Describe>
  void map(const std::string& key, Describe&& describe, MapStyle style = MapStyle::kBlock) {
    node_[key] = mapOf(describe, style);
  }
  /// A map where there is a part.
  template <typename Part, typename Describe>
  void part(const char* key, const std::optional<Part>& part, Describe&& describe) {
    if (part) describe(*this, key, *part);
  }
  /// A list of maps on a line each. @param describe (file, k). @param prepare of the reader.
  template <typename Prepare, typename Describe>
  void list(const char* key, std::size_t size, Prepare&&, Describe&& describe) {
    node_[key] = YAML::Node(YAML::NodeType::Sequence);
    for (std::size_t k = 0; k < size; ++k)
      node_[key].push_back(mapOf([&](FieldWriter& file) { describe(file, k); }, MapStyle::kFlow));
  }
  /// Of the reader alone: what a part must fulfil.
  void require(bool, const char*, const std::string&) const {}
  bool has(const std::string&, bool is_there = true) const { return is_there; }

 private:
  template <typename Describe>
  static YAML::Node mapOf(Describe&& describe, MapStyle style) {
    YAML::Node node(YAML::NodeType::Map);
    if (style == MapStyle::kFlow) node.SetStyle(YAML::EmitterStyle::Flow);
    FieldWriter file(node);
    describe(file);
    return node;
  }
  YAML::Node node_;
};

/// Messages name file, field, finding and expectation.
class FieldReader {
 public:
  static constexpr bool kReads = true;
  using Asked = std::map<std::string, std::set<std::string>>;  ///< keys, by the path of their map

  /// Refuses what a decimal comma makes of {std: 1,5}: a key 5 without a value.
  /// @param source name for messages. @param path of the node in the document.
  FieldReader(const YAML::Node& node, std::string source, std::string path = "",
              std::shared_ptr<Asked> asked = std::make_shared<Asked>())
      : node_(node), source_(std::move(source)), path_(std::move(path)), asked_(std::move(asked)) {
    if (path_.empty())
      return;  // a whole file in this style is JSON, which has values that are null
    if (!node_.IsMap() || node_.Style() != YAML::EmitterStyle::Flow) return;
    for (const auto& entry : node_)
      require(!entry.second.IsNull() && !(entry.first.IsScalar() && numberOf(entry.first.Scalar())),
              textOf(entry.first), "is not a key with a value" + std::string(kPoint));
  }

  void number(const std::string& key, double& value, Range range = {}) const {
    value = decimal(key, get<std::string>(key, "a number"), "a number");
    require(std::isfinite(value), key, "is not finite, expected a finite number");
    if (!range.holds(value)) fail(key, "is " + shown(value) + ", expected " + range.shown());
  }
  void number(const std::string& key, std::optional<double>& value, Range range = {}) const {
    if (has(key)) number(key, value.emplace(), range);
  }
  template <typename Count>
  void count(const std::string& key, Count& value, std::size_t most = 0) const {
    constexpr double kMost = std::min(1e15, static_cast<double>(std::numeric_limits<Count>::max()));
    const double read = decimal(key, get<std::string>(key, "a whole number"), "a whole number");
    if (!(read >= 0.0 && read <= kMost && read == std::floor(read))) misfit(key, "a whole number");
    value = static_cast<Count>(read);
    if (most > 0 && static_cast<std::size_t>(value) > most)
      fail(key, "is " + std::to_string(value) + ", expected 0 to " + std::to_string(most));
  }
  void flag(const std::string& key, bool& value) const { value = get<bool>(key, "true or false"); }
  void text(const std::string& key, std::string& value) const { value = text(key); }
  /// printable(): a file may hold any bytes.
  std::string text(const std::string& key) const {
    return printable(get<std::string>(key, "text"));
  }
  void texts(const std::string& key, std::vector<std::string>& values, const char* expected) const {
    values = get<std::vector<std::string>>(key, expected);
  }
  template <typename T, typename All, typename Name>
  void oneOf(const char* key, T& value, const All& all, Name&& name) const {
    const std::string id = text(key);
    std::vector<std::string> known;
    for (const T each : all) {
      if (name(each) == id) return void(value = each);
      known.push_back(name(each));
    }
    fail(key, "is \"" + id + "\", expected " +
                  (known.size() == 2 ? join(known, " or ") : "one of " + join(known, ", ")));
  }
  template <typename... Numbers>
  void row(const char* key, Numbers&... numbers) const {
    std::vector<double> values;
    this->numbers(key, values, sizeof...(Numbers));
    std::size_t k = 0;
    (put(key, values[k++], numbers), ...);
  }
  /// @param count 0: any.
  template <typename Numbers>
  void numbers(const char* key, Numbers& numbers, std::size_t count = 0,
               Range range = kNumbers) const {
    const std::string expected = (count > 0 ? std::to_string(count) + " " : "") + "numbers";
    const auto values = decimals(key, get<std::vector<std::string>>(key, expected), expected);
    require(!isUnevenlySpaced(at(key).node_), key,
            "has some commas with a space behind them and some without" + std::string(kPoint));
    if (count > 0 && values.size() != count)
      fail(key,
           "has " + std::to_string(values.size()) + " numbers, expected " + std::to_string(count));
    for (const double value : values) requireIn(key, value, range);
    numbers.resize(static_cast<decltype(numbers.size())>(values.size()));
    std::copy(values.begin(), values.end(), numbers.data());
  }
  template <typename Item, typename NumbersOf>
  void rows(const char* key, std::vector<Item>& items, const std::vector<Range>& ranges,
            NumbersOf&& numbersOf) const {
    if (!has(key)) return;
    const std::string expected = "rows of " + std::to_string(ranges.size()) + " numbers";
    for (const auto& row : rowsOf(key, expected)) {
      require(row.size() == ranges.size(), key, "must be " + expected);
      for (std::size_t k = 0; k < row.size(); ++k) requireIn(key, row[k], ranges[k]);
      std::size_t k = 0;
      numbersOf(items.emplace_back(), [&](auto&... numbers) { ((numbers = row[k++]), ...); });
    }
  }
  /// @param matrix of the size that is expected; its entries lie between -1 and 1.
  void matrix(const char* key, Eigen::MatrixXd& matrix) const {
    const auto size = static_cast<std::size_t>(matrix.rows());
    const std::string expected =
        std::to_string(size) + " rows of " + std::to_string(size) + " numbers";
    const auto rows = rowsOf(key, expected);
    for (std::size_t j = 0; j < size; ++j)
      for (std::size_t k = 0; k < size; ++k) {
        require(
            rows.size() == size && rows[j].size() == size && std::abs(rows[j][k]) <= 1.0 + kSame,
            key, "must be " + expected + " between -1 and 1");
        matrix(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(k)) = rows[j][k];
      }
  }
  template <typename Describe>
  void map(const std::string& key, Describe&& describe, MapStyle = MapStyle::kBlock) const {
    const FieldReader file = at(key);
    describe(file);
  }
  template <typename Part, typename Describe>
  void part(const char* key, std::optional<Part>& part, Describe&& describe) const {
    if (has(key)) describe(*this, key, part.emplace());
  }
  /// @param prepare gets the length.
  template <typename Prepare, typename Describe>
  void list(const char* key, std::size_t, Prepare&& prepare, Describe&& describe) const {
    const FieldReader whole = at(key);
    if (!whole.node_.IsSequence()) misfit(key, "a list");
    prepare(whole.node_.size());
    for (std::size_t k = 0; k < whole.node_.size(); ++k) {
      const FieldReader file(whole.node_[k], source_, placeOf(whole.path_, k), asked_);
      describe(file, k);
    }
  }
  /// Refuses keys that nothing has asked for, in all that was read: a part whose name is mistyped is
  /// not one that is absent.
  void refuseOthers() const { refuseOthers(node_, path_); }
  void require(bool holds, const std::string& key, const std::string& what) const {
    if (!holds) fail(key, what);
  }
  bool has(const std::string& key, bool = true) const {
    (*asked_)[path_].insert(key);
    return node_.IsMap() && node_[key];
  }
  const YAML::Node& node() const { return node_; }

  [[noreturn]] void fail(const std::string& key, const std::string& what) const {
    constexpr std::size_t kMost = 1000;  // [bytes]
    throw ModelFileError(source_ + ": " +
                         shortened((path_ + "." + key).substr(1) + " " + what, kMost));
  }

 private:
  static constexpr char kPoint[] = ": a comma ends a number, expected a decimal point";
  static constexpr double kMostCounted = 1e12;  // samples or events

  static std::string placeOf(const std::string& path, std::size_t k) {
    return path + "[" + std::to_string(k) + "]";
  }
  void refuseOthers(const YAML::Node& node, const std::string& path) const {
    for (std::size_t k = 0; node.IsSequence() && k < node.size(); ++k)
      refuseOthers(node[k], placeOf(path, k));
    const auto asked = asked_->find(path);
    if (!node.IsMap() || asked == asked_->end()) return;
    for (const auto& entry : node) {
      const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : textOf(entry.first);
      if (asked->second.count(key) == 0)
        FieldReader(node, source_, path)
            .fail(printable(key),
                  "is not a known key here, expected " +
                      join(std::vector<std::string>(asked->second.begin(), asked->second.end())));
      refuseOthers(entry.second, path + "." + key);
    }
  }
  FieldReader at(const std::string& key) const {
    require(has(key), key, "is missing");
    return {node_[key], source_, path_ + "." + key, asked_};
  }
  [[noreturn]] void misfit(const std::string& key, const std::string& expected) const {
    fail(key, "is \"" + textOf(at(key).node_) + "\", expected " + expected);
  }
  template <typename T>
  T get(const std::string& key, const std::string& expected) const {
    const FieldReader field = at(key);
    try {
      return field.node_.as<T>();
    } catch (const YAML::Exception&) {
      misfit(key, expected);
    }
  }
  double decimal(const std::string& key, const std::string& text,
                 const std::string& expected) const {
    const std::optional<double> value = decimalOf(text);
    if (!value) misfit(key, expected);
    return *value;
  }
  std::vector<double> decimals(const std::string& key, const std::vector<std::string>& texts,
                               const std::string& expected) const {
    std::vector<double> values;
    for (const std::string& text : texts) values.push_back(decimal(key, text, expected));
    return values;
  }
  std::vector<std::vector<double>> rowsOf(const char* key, const std::string& expected) const {
    std::vector<std::vector<double>> rows;
    for (const auto& row : get<std::vector<std::vector<std::string>>>(key, expected))
      rows.push_back(decimals(key, row, expected));
    return rows;
  }
  void requireIn(const char* key, double value, Range range) const {
    require(std::isfinite(value), key, "holds a number that is not finite");
    if (!range.holds(value))
      fail(key, "holds " + shown(value) + ", expected numbers of " + range.shown());
  }
  void put(const char*, double value, double& number) const { number = value; }
  void put(const char* key, double value, std::size_t& count) const {
    require(value >= 0.0 && value <= kMostCounted, key,
            "counts a number of samples or events that cannot be");
    count = static_cast<std::size_t>(value);
  }
  /// What decimal commas make of a list, as in [0,5, 0,7].
  static bool isUnevenlySpaced(const YAML::Node& list) {
    std::size_t spaced = 0;
    for (std::size_t k = 1; k < list.size(); ++k)
      if (list[k].Mark().pos >
          list[k - 1].Mark().pos + static_cast<int>(list[k - 1].Scalar().size()) + 1)
        ++spaced;
    return spaced > 0 && spaced + 1 < list.size();
  }
  static std::string textOf(const YAML::Node& node) {
    std::ostringstream text;
    text.imbue(std::locale::classic());
    text << node;
    return text.str().substr(0, 60);
  }

  YAML::Node node_;
  std::string source_, path_;
  std::shared_ptr<Asked> asked_;
};

}  // namespace battery_sof
