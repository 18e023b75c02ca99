#include "recording/text_lines.hpp"

#include <sys/stat.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "battery_sof/recording_error.hpp"

namespace battery_sof {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

[[noreturn]] void refuse(const fs::path& path, const std::string& why) {
  throw RecordingError(path.string() + ": " + why);
}

std::string because(int error) {
  return "cannot be read: " + std::generic_category().message(error);
}

/// Opening a device may have effects, so it is looked at first.
std::ifstream opened(const fs::path& path) {
  struct stat facts {};
  if (::stat(path.c_str(), &facts) != 0) refuse(path, because(errno));
  if (S_ISDIR(facts.st_mode)) refuse(path, "is a directory, expected a file or a pipe");
  if (!S_ISREG(facts.st_mode) && !S_ISFIFO(facts.st_mode))
    refuse(path, "is a device or a socket, expected a file or a pipe");
  std::ifstream file(path, std::ios::binary);
  if (!file) refuse(path, because(errno));
  return file;
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::string_view unquoted(std::string_view cell) {
  cell = trimmed(cell);
  if (cell.size() < 2 || cell.front() != '"' || cell.back() != '"') return cell;
  return trimmed(cell.substr(1, cell.size() - 2));
}

/// Position of the separator that ends the cell beginning at first; those between quotes do not
/// count.
std::size_t endOfCell(std::string_view line, std::size_t first, char separator) {
  bool quoted = false;
  for (std::size_t k = first; k < line.size(); ++k) {
    if (line[k] == '"') quoted = !quoted;
    if (line[k] == separator && !quoted) return k;
  }
  return line.size();
}

}  // namespace

TextLines::TextLines(const fs::path& path, BytesSeen seen)
    : path_(path), seen_(std::move(seen)), file_(opened(path)), room_(kLongest + 2) {}

bool TextLines::next() {
  while (nextOfAny())
    if (line_.find_first_not_of(" \t\r") != std::string_view::npos) return true;
  return false;
}

bool TextLines::nextOfAny() {
  file_.getline(room_.data(), static_cast<std::streamsize>(room_.size()));
  if (file_.bad()) refuse(path_, because(errno));
  finished_ = file_.good();
  const auto count = static_cast<std::size_t>(file_.gcount());
  line_ = std::string_view(room_.data(), finished_ ? count - 1 : count);
  if (line_.empty() && !finished_) return false;
  ++number_;
  if (line_.size() > kLongest)
    refuse(path_, "line " + std::to_string(number_) +
                      " is too long, expected a CSV file with lines of at most " +
                      std::to_string(kLongest) + " bytes");
  if (seen_) seen_(line_);
  if (seen_ && finished_) seen_("\n");
  if (number_ == 1 && line_.substr(0, kByteOrderMark.size()) == kByteOrderMark)
    line_.remove_prefix(kByteOrderMark.size());
  return true;
}

void splitCells(std::string_view line, char separator, std::vector<std::string_view>& cells) {
  cells.clear();
  for (std::size_t first = 0; first <= line.size();) {
    const std::size_t last = endOfCell(line, first, separator);
    cells.push_back(unquoted(line.substr(first, last - first)));
    first = last + 1;
  }
}

}  // namespace battery_sof
