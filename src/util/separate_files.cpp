#include "util/separate_files.hpp"

#include <filesystem>
#include <stdexcept>
#include <system_error>

namespace battery_sof {
namespace {

namespace fs = std::filesystem;

bool isCompared(const std::string& name) {
  std::error_code ignored;
  const fs::file_status status = fs::status(name, ignored);
  return !name.empty() && name != "-" && (!fs::exists(status) || fs::is_regular_file(status));
}

fs::path placeOf(const fs::path& name) {
  std::error_code ignored;
  const fs::path folder = fs::weakly_canonical(fs::absolute(name, ignored).parent_path(), ignored);
  return folder / name.filename();
}

bool isOneFile(const std::string& a, const std::string& b) {
  std::error_code ignored;
  return fs::equivalent(a, b, ignored) || placeOf(a) == placeOf(b);
}

}  // namespace

void requireSeparateFiles(const std::vector<std::string>& read,
                          const std::vector<std::string>& written) {
  for (std::size_t k = 0; k < written.size(); ++k) {
    if (!isCompared(written[k])) continue;
    for (const std::string& input : read)
      if (isCompared(input) && isOneFile(input, written[k]))
        throw std::invalid_argument(written[k] + " would be written over " + input +
                                    ", which is read: expected another file");
    for (std::size_t j = 0; j < k; ++j)
      if (isCompared(written[j]) && isOneFile(written[j], written[k]))
        throw std::invalid_argument(written[k] + " and " + written[j] +
                                    " are one file to write: expected two");
  }
}

}  // namespace battery_sof
