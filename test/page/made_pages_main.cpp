#include <cstdio>
#include <fstream>
#include <string>

#include "report/diagnosis_page.hpp"
#include "support/made_diagnosis.hpp"

/// Writes the pages that the browser test opens into the folder of its first argument.
int main(int argc, char** argv) {
  using namespace battery_sof;
  if (argc != 2) {
    std::fprintf(stderr, "usage: made_pages FOLDER\n");
    return 2;
  }
  const std::string folder = std::string(argv[1]) + "/";
  const auto write = [&](const std::string& name, const test::MadeDiagnosis& made, bool zoomable) {
    std::ofstream(folder + name) << diagnosisPage(made.recording, made.diagnosis, zoomable);
  };
  write("named.html", test::madeNamed(), true);
  write("no_mismatch.html", test::madeNoMismatch(), true);
  write("unknown.html", test::madeUnknown(), true);
  write("without_library.html", test::madeNamed(), false);
  return 0;
}
