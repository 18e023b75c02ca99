// What recordings say for each mechanism (mechanism_evidence.hpp): one JSON object a line. Given to
// scripts/train_mechanisms, which fits the table that the diagnosis weighs mechanisms by.
//
//     mechanism_evidence REC.csv...

#include <cstdio>
#include <exception>

#include "battery_sof/csv.hpp"
#include "diagnosis/diagnose.hpp"

namespace {

using namespace battery_sof;

void print(const std::string& name, const MechanismEvidence& found) {
  std::printf("{\"recording\":\"%s\"", name.c_str());
  for (std::size_t k = 0; k < kMechanisms; ++k)
    std::printf(",\"%s\":[%.6g,%.6g,%.6g]", mechanismId(kAllMechanisms[k]).c_str(), found[k].alone,
                found[k].lost, found[k].effect);
  std::printf("}\n");
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  int failed = 0;
  for (int k = 1; k < argc; ++k) {
    try {
      print(argv[k], mechanismEvidence(readCsv(argv[k])));
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s: %s\n", argv[k], error.what());
      failed = 1;
    }
  }
  return failed;
}
