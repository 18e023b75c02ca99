#pragma once

#include <unistd.h>

#include <clocale>
#include <cstdlib>
#include <filesystem>
#include <locale>
#include <string>

/// Surroundings in which numbers are written with a comma, as programs around the core may set
/// them.
namespace battery_sof::test {

/// While it lives, C++ streams write and read 1.234,5.
class CommaStreams {
 public:
  CommaStreams() : before_(std::locale::global(std::locale(std::locale::classic(), new German))) {}
  ~CommaStreams() { std::locale::global(before_); }

 private:
  struct German : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  std::locale before_;
};

/// While it lives, printf and strtod of the process write and read 1234,5, where a German locale is
/// installed or the package `locales` is there to make one of.
class CommaPrintf {
 public:
  CommaPrintf() : before_(std::setlocale(LC_ALL, nullptr)), set_(setGerman() || makeGerman()) {}
  ~CommaPrintf() {
    std::setlocale(LC_ALL, before_.c_str());
    if (!made_.empty()) {
      unsetenv("LOCPATH");
      std::filesystem::remove_all(made_);
    }
  }
  bool set() const { return set_; }

 private:
  static bool setGerman() {
    for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "de_DE"})
      if (std::setlocale(LC_ALL, name) != nullptr) return true;
    return false;
  }
  bool makeGerman() {
    made_ =
        std::filesystem::temp_directory_path() / ("battery_sof_locale_" + std::to_string(getpid()));
    std::filesystem::create_directories(made_);
    const std::string call =
        "localedef -i de_DE -f UTF-8 '" + (made_ / "de_DE.UTF-8").string() + "' >/dev/null 2>&1";
    if (std::system(call.c_str()) != 0) return false;
    setenv("LOCPATH", made_.c_str(), 1);
    return setGerman();
  }
  std::filesystem::path made_;
  std::string before_;
  bool set_;
};

}  // namespace battery_sof::test
