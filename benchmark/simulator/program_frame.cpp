#include "simulator/program_frame.hpp"

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <ostream>

#include "simulator/numerics.hpp"

namespace battery_sof_simulator {
namespace {

constexpr std::size_t kMost = 10000;  // [bytes], two paths

/// Bytes of the UTF-8 character there, 0 for none or one that a terminal obeys (C0, C1, DEL).
std::size_t characterLength(const std::string& text, std::size_t at) {
  const auto first = static_cast<unsigned char>(text[at]);
  const std::size_t length = first < 0x80u ? 1 : first < 0xE0u ? 2 : first < 0xF0u ? 3 : 4;
  const std::string character = text.substr(at, length);
  const bool is_control = first < 0x20u || first == 0x7Fu ||
                          (first == 0xC2u && length == character.size() &&
                           static_cast<unsigned char>(character[1]) < 0xA0u);
  if (is_control) return 0;
  try {
    static_cast<void>(nlohmann::json(character).dump());  // throws unless it is UTF-8
    return length;
  } catch (const nlohmann::json::exception&) {
    return 0;
  }
}

}  // namespace

std::string shown(const std::string& text) {
  std::string line;
  for (std::size_t at = 0; at < text.size();) {
    if (line.size() > kMost) return line + "...";
    const std::size_t length = characterLength(text, at);
    char code[8];
    std::snprintf(code, sizeof code, "\\x%02x",
                  static_cast<unsigned>(static_cast<unsigned char>(text[at])));
    line += length > 0 ? text.substr(at, length) : code;
    at += length > 0 ? length : 1;
  }
  return line;
}

std::string isSeed(const std::string& text) {
  const bool is_whole = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
  return is_whole ? "" : "\"" + text + "\" is not a seed, expected a whole number of 0 or more";
}

int runProgram(CLI::App& app, const std::vector<std::string>& arguments, const std::string& name,
               const std::function<void()>& work, std::ostream& out, std::ostream& err) {
  // a file larger than the process may write fails as one on a full disk does
  std::signal(SIGXFSZ, SIG_IGN);
  // CLI11 takes its arguments from the back.
  std::vector<std::string> backwards(arguments.rbegin(), arguments.rend());
  try {
    app.parse(backwards);
    work();
    return kDone;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error, out, err);
    err << name << ": " << shown(error.what()) << "\nRun with --help for more information.\n";
    return kUsage;
  } catch (const NoSolution& error) {
    err << name << ": " << shown(error.what()) << "\n";
    return kNegative;
  } catch (const std::exception& error) {
    err << name << ": " << shown(error.what()) << "\n";
    return kUsage;
  }
}

}  // namespace battery_sof_simulator
