#include "command.hpp"

#include <openssl/evp.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <ostream>
#include <string_view>
#include <system_error>

#include "api/identified.hpp"
#include "can_log.hpp"
#include "recording/series_blocks.hpp"
#include "report/priors_yaml.hpp"
#include "report/results.hpp"
#include "util/files.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr double kEpochClock = 1e8;  // [s]; a clock above it counts from 1970

/// A pipe is not looked into: what is read of it is gone.
bool isBag(const std::string& path) {
  if (std::filesystem::path(path).extension() == ".bag") return true;
  std::error_code none;
  if (!std::filesystem::is_regular_file(path, none)) return false;
  std::array<char, 8> magic{};
  std::ifstream file(path, std::ios::binary);
  file.read(magic.data(), magic.size() - 1);
  return std::string(magic.data()) == "#ROSBAG";
}

/// The SHA-256 digest of bytes that come one after the other.
class Digest {
 public:
  Digest() { EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr); }
  void add(std::string_view bytes) { EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()); }
  void addFile(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::array<char, 65536> buffer{};
    while (file.read(buffer.data(), buffer.size()) || file.gcount() > 0)
      add({buffer.data(), static_cast<std::size_t>(file.gcount())});
  }
  /// Ends it. @return "sha256:" and the digest in hexadecimal.
  std::string text() {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
    unsigned int length = 0;
    EVP_DigestFinal_ex(context_.get(), digest.data(), &length);
    std::string text = "sha256:";
    for (unsigned int k = 0; k < length; ++k) text += format("%02x", digest[k]);
    return text;
  }

 private:
  std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX*)> context_{EVP_MD_CTX_new(), &EVP_MD_CTX_free};
};

Recording readRecording(const RecordingArguments& arguments, std::string* hash,
                        std::vector<std::string>* told) {
  if (isCanLog(arguments.path)) throw RecordingError(canLogAdvice(arguments.path));
  const bool is_bag = isBag(arguments.path);
  CsvColumns columns = arguments.columns;
  const auto& unit = arguments.time_unit;
  if (!unit.empty()) columns.time_unit = unit == "s" ? 1.0 : unit == "ms" ? 1e-3 : 1e-6;
  if (is_bag && !(columns == CsvColumns()))
    throw UsageError(
        arguments.path +
        " is a bag, expected none of the options for the columns, sign and unit of a CSV file");
  Digest digest;
  std::vector<std::string> notes;
  Recording recording = is_bag
                            ? readBag(arguments.path, arguments.topic)
                            : readCsv(
                                  arguments.path, columns,
                                  [&digest](std::string_view bytes) { digest.add(bytes); }, &notes);
  for (const std::string& note : notes)
    std::fprintf(stderr, "sof: %s: %s\n", arguments.path.c_str(), note.c_str());
  if (told) *told = notes;
  if (!hash) return recording;
  if (is_bag) digest.addFile(arguments.path);
  *hash = digest.text();
  return recording;
}

}  // namespace

void addModelOption(CLI::App& command, std::string& model) {
  addFile(command, kReadFile, "MODEL", model, "model file of sof identify")->required();
}

void addRecordingOptions(CLI::App& command, RecordingArguments& arguments, bool with_path) {
  if (with_path) addFile(command, kReadFile, "REC", arguments.path, kRecordingFile)->required();
  auto& columns = arguments.columns;
  addOption(command, "--time-column", columns.time,
            "CSV column of time [s, the unit in its name or below the header, or a date]");
  addOption(command, "--current-column", columns.current,
            "CSV column of current [A, or mA or kA by its name or the row below the header]");
  addOption(command, "--voltage-column", columns.voltage,
            "CSV column of voltage [V, or mV likewise]");
  addOption(command, "--temperature-column", columns.temperature,
            "CSV column of temperature [degC, or K likewise]");
  command.add_flag("--discharge-positive", columns.discharge_positive,
                   "the CSV counts current out of the battery as positive");
  addOption(command, "--time-unit", arguments.time_unit,
            "unit of the CSV's time column: s, ms or us, whatever the file says")
      ->check(CLI::IsMember({"s", "ms", "us"}));
  addOption(command, "--topic", arguments.topic, "bag topic");
}

void addRenamedOption(CLI::App& command, const std::string& old, const std::string& now) {
  const auto refuse = [old, now](const std::vector<std::string>&) {
    throw CLI::ValidationError(old, "is " + now + " since 0.3");
  };
  command.add_option_function<std::vector<std::string>>(old, refuse)
      ->expected(0, CLI::detail::expected_max_vector_size)
      ->group("");
}

void addCrankCurrentOption(CLI::App& command, RecordingArguments& arguments) {
  const auto take = [&arguments](const double& given) {
    if (given == 0.0 || !std::isfinite(given))
      throw CLI::ValidationError(
          "--crank-current", "is " + format("%g", given) + ", expected amperes above 0, e.g. 120");
    arguments.crank_current = -std::abs(given);
  };
  command.add_option_function<double>(
      "--crank-current", take,
      "a discharge by this many amperes or more, for at most 5 s, counts as an engine start; half "
      "of what the starter draws while it turns the engine is a good value. Default: read off the "
      "recording's largest repeated pulses, at most 150 A; sof check prints it");
}

void requireCapacity(const std::optional<double>& capacity_ah) {
  if (capacity_ah && !(*capacity_ah > 0.0 && std::isfinite(*capacity_ah)))
    throw UsageError(format("--capacity-ah is %g, expected above 0", *capacity_ah));
}

void addSeriesBlocksOption(CLI::App& command, RecordingArguments& arguments) {
  addOption(command, "--series-blocks", arguments.series_blocks,
            "blocks of 12 V in series: 0.5 for a battery of 6 V, 2 for 24 V, 4 for 48 V; bounds "
            "and limits are those of one block");
  addRenamedOption(command, "--blocks", "--series-blocks");
}

void addWindowOptions(CLI::App& command, WindowArguments& arguments) {
  const auto fault = [](const std::string& given) -> std::string {
    return given.empty() ? "is \"\", expected seconds, e.g. 60 or +60" : "";
  };
  addOption(command, "--from", arguments.from,
            "start [s] on the recording's clock; +T counts from its first sample")
      ->check(fault);
  addOption(command, "--to", arguments.to, "end [s], as --from")->check(fault);
}

void addAnywayOption(CLI::App& command, bool& anyway) {
  command.add_flag("--anyway", anyway, "accept a recording for which sof check reports a problem");
}

void addPriorsOptions(CLI::App& command, PriorsArguments& arguments) {
  addFile(command, kReadFile, "--priors", arguments.file,
          "PRIORS.yaml: what is known of such batteries, in place of the catalogue's priors");
  addOption(command, "--vehicle-type", arguments.vehicle_type,
            "vehicle type whose priors are used; all types if not given");
}

void addJsonOption(CLI::App& command, std::string& json) {
  addFile(command, kWrittenFile, kJsonOption, json,
          "write the result as JSON; - for standard output");
}

std::vector<KnownPopulation> loadPriors(const PriorsArguments& arguments) {
  if (!arguments.file.empty()) return readPriorsFile(arguments.file, arguments.vehicle_type);
  if (!arguments.vehicle_type.empty())
    throw UsageError("--vehicle-type is " + arguments.vehicle_type +
                     ", expected only with --priors, a file with such types");
  return {};
}

Recording loadRecording(const RecordingArguments& arguments, std::string* hash,
                        std::vector<std::string>* notes) {
  if (!areSeriesBlocks(arguments.series_blocks))
    throw UsageError(format("--series-blocks is %g, expected ", arguments.series_blocks) +
                     kAllowedSeriesBlocks);
  Recording recording = readRecording(arguments, hash, notes);
  recording.series = perBlock(std::move(recording.series), arguments.series_blocks);
  return recording;
}

std::optional<double> parseTime(const std::string& text, const Series& series, const char* option) {
  if (text.empty()) return std::nullopt;
  const std::optional<double> value = numberOf(text);
  if (!value || !std::isfinite(*value))
    throw UsageError(std::string(option) + " is \"" + text +
                     "\", expected seconds, e.g. 60 or +60");
  if (series.empty()) return value;
  const bool relative =
      text[0] == '+' || (series.time.front() > kEpochClock && *value < kEpochClock);
  return relative ? series.time.front() + *value : *value;
}

IndexRange rangeOf(const WindowArguments& arguments, const Series& series) {
  if (series.empty()) throw UsageError(kTooShortForDesignRate);
  return samplesBetween(series, parseTime(arguments.from, series, "--from"),
                        parseTime(arguments.to, series, "--to"));
}

void emit(const CommandLine& line, const std::string& text, const nlohmann::json& json,
          const std::string& json_target) {
  const std::string document = jsonText(json, 2) + "\n";
  if (json_target == "-") {
    line.out << document;
    return;
  }
  line.out << printable(text, LineBreaks::kKept);
  if (!json_target.empty()) writeFileAtomically(json_target, document);
}

void complain(std::ostream& err, const std::string& what) {
  constexpr std::size_t kMost = 10000;  // [bytes]
  err << "sof: " << printable(shortened(what, kMost)) << "\n";
}

}  // namespace battery_sof
