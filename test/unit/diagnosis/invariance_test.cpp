#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "battery_sof/csv.hpp"
#include "diagnosis/diagnose.hpp"
#include "recording/series_blocks.hpp"
#include "report/results.hpp"
#include "support/base_drive.hpp"

namespace battery_sof {
namespace {

// What a diagnosis names must not depend on how the same drive was written down. One short drive,
// whose open-circuit voltage follows the charge, for all of them.

Recording recordingOf(Series series) {
  Recording recording;
  recording.name = "drive";
  recording.offered = series.size();
  recording.series = std::move(series);
  return recording;
}

Recording slopedDrive() {
  // [s], [V/Ah], [A]: clearly seen in ten minutes
  constexpr double kInterval = 0.125, kSlope = 0.1, kOffset = 2.0;
  Series series = test::answered(
      test::drivenBattery(), test::dataSetOneCurrent(600.0, kInterval, 14), kInterval, 0.001, 14);
  double charge = 0.0;
  for (std::size_t k = 1; k < series.size(); ++k) {
    charge += (series.current[k] + kOffset) * kInterval / 3600.0;
    series.voltage[k] += kSlope * charge;
  }
  return recordingOf(std::move(series));
}

DiagnoseOptions weighing(std::vector<std::string> hypotheses) {
  DiagnoseOptions options;
  options.hypotheses = std::move(hypotheses);
  options.lists_detection_limits = false;
  return options;
}

const std::vector<std::string> kHypotheses = {"ocv_soc", "acid_transport", "time_skew",
                                              "current_offset", "charge_transfer"};

std::string saidOf(const Recording& recording,
                   const DiagnoseOptions& options = weighing(kHypotheses)) {
  return resultJson(diagnose(recording, options)).dump(1);
}

class Invariance : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    inputs_ = new Recording(slopedDrive());
    diagnosis_ = new Diagnosis(diagnose(*inputs_, weighing(kHypotheses)));
  }
  static void TearDownTestSuite() {
    delete diagnosis_;
    delete inputs_;
  }

  static const Recording& drive() { return *inputs_; }
  static const Diagnosis& diagnosis() { return *diagnosis_; }
  static std::string said() { return resultJson(diagnosis()).dump(1); }

 private:
  static Recording* inputs_;
  static Diagnosis* diagnosis_;
};

Recording* Invariance::inputs_ = nullptr;
Diagnosis* Invariance::diagnosis_ = nullptr;

TEST_F(Invariance, TheDriveHasSomethingToName) {
  ASSERT_FALSE(diagnosis().effects.empty()) << diagnosis().summary;
  EXPECT_GT(diagnosis().candidates.size(), 1U);
}

TEST_F(Invariance, ProbabilitiesAreSharesOfOneAndTheNamedEffectHasTheMostOfItsFamily) {
  for (const NamedEffect& effect : diagnosis().effects) {
    EXPECT_GE(effect.probability, 0.0) << effect.id;
    EXPECT_LE(effect.probability, 1.0) << effect.id;
    for (const Candidate& candidate : diagnosis().candidates) {
      EXPECT_GE(candidate.confidence, 0.0) << candidate.id;
      EXPECT_LE(candidate.confidence, 1.0) << candidate.id;
      if (candidate.mechanism == effect.mechanism && candidate.id != effect.id) {
        EXPECT_LE(candidate.confidence, effect.confidence) << candidate.id;
      }
    }
  }
}

TEST_F(Invariance, TheOrderOfTheHypothesesChangesNoByte) {
  std::vector<std::string> order = kHypotheses;
  std::reverse(order.begin(), order.end());
  EXPECT_EQ(said(), saidOf(drive(), weighing(order)));
}

/// Times and their differences are exact in binary, so nothing but the clock may change. With steps
/// that round (0.1 s) the same names and probabilities come out, but parameters that the recording
/// hardly distinguishes (two of one ridge) move by some of their standard error.
TEST_F(Invariance, AnotherBeginningOfTheClockChangesNothingButTimes) {
  constexpr double kShift = 4096.0;
  Recording later = drive();
  for (double& time : later.series.time) time += kShift;
  const Diagnosis shifted = diagnose(later, weighing(kHypotheses));
  EXPECT_EQ(diagnosis().verdict, shifted.verdict);
  EXPECT_EQ(diagnosis().mechanism, shifted.mechanism);
  EXPECT_EQ(diagnosis().probability, shifted.probability);
  EXPECT_EQ(diagnosis().fit.holdout.from + kShift, shifted.fit.holdout.from);
  const nlohmann::json one = resultJson(diagnosis()), other = resultJson(shifted);
  for (const char* part : {"effects", "candidates", "parameter_bias", "evidence"})
    EXPECT_EQ(one[part].dump(1), other[part].dump(1)) << part;
}

/// Volts and amperes in other columns, another sign, semicolons and decimal commas, through a file;
/// a row of two blocks: 24 V.
TEST_F(Invariance, TheSameDriveFromAnotherFormOfFileChangesNoByte) {
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("invariance_" + std::to_string(getpid()) + ".csv");
  {
    std::ofstream out(path);
    out << "u;t;discharge\n";
    const Series& series = drive().series;
    for (std::size_t k = 0; k < series.size(); ++k) {
      std::string row = formatExactly(2.0 * series.voltage[k]) + ";" +
                        formatExactly(series.time[k]) + ";" + formatExactly(-series.current[k]);
      std::replace(row.begin(), row.end(), '.', ',');
      out << row << "\n";
    }
  }
  CsvColumns columns;
  columns.time = "t";
  columns.current = "discharge";
  columns.voltage = "u";
  columns.discharge_positive = true;
  Recording read = readCsv(path, columns);
  std::filesystem::remove(path);
  read.name = drive().name;
  read.series = perBlock(std::move(read.series), 2.0);
  EXPECT_EQ(said(), saidOf(read));
}

}  // namespace
}  // namespace battery_sof
