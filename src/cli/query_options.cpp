#include "query_options.hpp"

#include <cmath>
#include <sstream>

#include "recording/text_lines.hpp"
#include "report/model_yaml.hpp"
#include "util/number_text.hpp"
#include "util/printable.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr const char* kColumns[] = {"time_s", "current_a"};

std::vector<std::string> cellsOf(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream text(line);
  for (std::string cell; std::getline(text, cell, ',');) {
    const std::size_t first = cell.find_first_not_of(" \t\r\""),
                      last = cell.find_last_not_of(" \t\r\"");
    cells.push_back(first == std::string::npos ? "" : cell.substr(first, last - first + 1));
  }
  return cells;
}

/// The rows of a file, and refusals that name file and line.
class ProfileFile {
 public:
  explicit ProfileFile(const std::string& path) : path_(path), lines_(path) {}

  bool next() {
    if (!lines_.next()) return false;
    cells_ = cellsOf(std::string(lines_.line()));
    return true;
  }

  std::size_t column(const char* name) const {
    for (std::size_t k = 0; k < cells_.size(); ++k)
      if (cells_[k] == name) return k;
    refuse(format("has no column \"%s\", expected the header time_s,current_a", name));
  }

  double number(std::size_t column, const char* name) const {
    if (column >= cells_.size()) refuse(format("has no %s, expected a finite number", name));
    const std::string& cell = cells_[column];
    const std::optional<double> value = numberOf(cell);
    if (!value || !std::isfinite(*value))
      refuse(format("%s is \"%s\", expected a finite number", name, shortened(cell).c_str()));
    return *value;
  }

  [[noreturn]] void refuse(const std::string& fault) const {
    const std::string place =
        lines_.number() > 0 ? ", line " + std::to_string(lines_.number()) : "";
    throw UsageError(path_ + place + ": " + fault);
  }

 private:
  std::string path_;
  TextLines lines_;
  std::vector<std::string> cells_;
};

}  // namespace

void addQueryOptions(CLI::App& command, QueryArguments& arguments) {
  command.add_option("MODEL", arguments.model, "model file of sof identify")
      ->required()
      ->type_name(kReadFile);
  command.add_option("--capacity-ah", arguments.capacity_ah, "nominal capacity [Ah]")
      ->capture_default_str();
  command.add_flag("--rested", arguments.rested,
                   "begin from a rested battery, not from the saved state");
  addJsonOption(command, arguments.json);
}

FittedModel modelOf(const QueryArguments& arguments) {
  if (!(arguments.capacity_ah > 0.0))
    throw UsageError(format("--capacity-ah is %g, expected above 0", arguments.capacity_ah));
  const FittedModel saved = readModelFile(arguments.model);
  return arguments.rested ? rested(saved) : saved;
}

CurrentProfile readProfile(const std::string& path) {
  ProfileFile file(path);
  if (!file.next()) file.refuse("is empty, expected the header time_s,current_a");
  const std::size_t time = file.column(kColumns[0]), current = file.column(kColumns[1]);
  CurrentProfile profile;
  while (file.next()) {
    const double t = file.number(time, kColumns[0]);
    if (t < 0.0) file.refuse(format("time_s is %g, expected 0 or more", t));
    if (!profile.empty() && t <= profile.time.back())
      file.refuse(
          format("time_s is %g, expected more than the %g before it", t, profile.time.back()));
    profile.time.push_back(t);
    profile.current.push_back(file.number(current, kColumns[1]));
  }
  if (profile.empty()) file.refuse("has a header line but no row below it");
  return profile;
}

}  // namespace battery_sof
