#pragma once

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

namespace battery_sof_bench {

/// Runs a benchmark whose first argument is a number above 0; faults become one sentence on
/// standard error.
/// @param usage "name NUMBER OUT.json", with as many words as the program takes.
/// @param work is given the number.
/// @return 0 done, 1 the work threw, 2 wrong usage.
template <typename Number, typename Work>
int runBenchmark(int argc, char** argv, const std::string& usage, const Work& work) {
  const auto number = static_cast<Number>(argc > 1 ? std::atof(argv[1]) : 0.0);
  if (argc != 1 + std::count(usage.begin(), usage.end(), ' ') || !(number > 0)) {
    std::cerr << "usage: " << usage << "\n";
    return 2;
  }
  try {
    work(number);
  } catch (const std::exception& error) {
    std::cerr << usage.substr(0, usage.find(' ')) << ": " << error.what() << "\n";
    return 1;
  }
  return 0;
}

/// @throws std::runtime_error when it cannot be written.
inline void writeJson(const std::string& path, const nlohmann::json& json) {
  std::ofstream file(path);
  file << json;
  file.close();
  if (!file) throw std::runtime_error(path + ": cannot be written");
}

}  // namespace battery_sof_bench
