#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "battery_sof/csv.hpp"
#include "support/base_drive.hpp"
#include "support/sof_command.hpp"

namespace battery_sof::test {

/// A five-minute drive in a folder.
class DriveInFolder : public InFolder {
 protected:
  DriveInFolder() : InFolder("cli") {
    inputs_ = path("drive.csv");
    writeCsv(inputs_, baseDrive(1, 300.0));
    model_ = path("model.yaml");
  }

  Outcome identify() const {
    return sof({"identify", inputs_, "--from", "0", "--to", "240", "--out", model_});
  }

  /// check, identify and convert all refuse a recording with one line that holds every given piece.
  void expectRefused(const std::string& file, const std::vector<std::string>& pieces) const {
    const std::vector<std::vector<std::string>> calls = {{"check", file},
                                                         {"identify", file, "--out", model_},
                                                         {"convert", file, path("converted.csv")}};
    for (const auto& call : calls) {
      const Outcome outcome = sof(call);
      EXPECT_EQ(outcome.code, 2) << call[0];
      for (const auto& piece : pieces)
        EXPECT_NE(outcome.err.find(piece), std::string::npos) << outcome.err;
    }
    EXPECT_FALSE(std::filesystem::exists(model_));
    EXPECT_FALSE(std::filesystem::exists(path("converted.csv")));
  }

  std::string inputs_, model_;
};

}  // namespace battery_sof::test
