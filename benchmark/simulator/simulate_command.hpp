#pragma once

#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

namespace battery_sof_simulator {

using FileCheck = std::function<void(const std::vector<std::string>& read,
                                     const std::vector<std::string>& written)>;

/// The command `sof simulate SCENARIO.yaml OUT.{csv,bag}`: a simulated recording, its charge and
/// energy balance, the small-signal impedance at the scenario's SOC and impedance_current_a.
/// @param arguments without `sof simulate`.  @param out, err standard output and error.
/// @param check is reported the files that are read and those to be written before anything is
/// done, and throws where that cannot be.
/// @return 0 done, 1 the equations have no solution on this drive, 2 wrong usage or input.
int runSimulate(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err,
                const FileCheck& check = nullptr);

/// The command `sof demo [OUT.{csv,bag}]`: the recording of config/scenarios/city_drive.yaml, and
/// what to do with it. Arguments and codes as runSimulate().
int runDemo(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err,
            const FileCheck& check = nullptr);

}  // namespace battery_sof_simulator
