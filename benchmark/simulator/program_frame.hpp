#pragma once

#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace battery_sof_simulator {

/// @return a text of outside (a file's name, a piece of a scenario) as one line of UTF-8 that a
/// terminal shows and does not obey: control characters and bytes that are not UTF-8 become \xNN.
/// What is longer than some thousands of bytes is cut off.
std::string shown(const std::string& text);

/// Exit codes of the simulator's programs.
constexpr int kDone = 0;      ///< done, or help was asked for
constexpr int kNegative = 1;  ///< a battery's equations have no solution
constexpr int kUsage = 2;     ///< wrong usage or input

/// @return why a text is no seed (a whole number, 0 or more, decimal digits); empty when it is one.
std::string isSeed(const std::string& text);

/// Reads a program's arguments and does its work; faults become one sentence on err, shown().
/// @param app  its options, bound to where work finds them.
/// @param arguments without the program's name.
/// @param name begins each sentence.
/// @return kDone; kNegative when work throws NoSolution; kUsage for arguments that app refuses and
/// for every other exception. Never throws. From then on the process ignores SIGXFSZ.
int runProgram(CLI::App& app, const std::vector<std::string>& arguments, const std::string& name,
               const std::function<void()>& work, std::ostream& out, std::ostream& err);

}  // namespace battery_sof_simulator
