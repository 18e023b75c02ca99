#include "battery_sof/diagnose/naming.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace battery_sof {
namespace {

constexpr double kAll = std::numeric_limits<double>::infinity();

/// Evidence that a name takes beside structure of evidence 5000 on the grid without edges.
double besideStructure(const std::string& id, double share, double left, double structure = 5000.0) {
  std::vector<Accepted> accepted(2);
  accepted[0].id = "cpe2";
  accepted[0].evidence = structure;
  accepted[1].id = "fast_arc";  // at edges: no measure of what the slow structure leaves
  accepted[1].evidence = 1e6;
  return evidenceNeeded(id, accepted, DiagnosisThresholds(), {share, left});
}

TEST(EvidenceNeeded, WithoutStructureIsTheThreshold) {
  const DiagnosisThresholds thresholds;
  EXPECT_EQ(thresholds.name_evidence, evidenceNeeded("ocv_soc", {}, thresholds, {0.2, kAll}));
  EXPECT_EQ(thresholds.structure_evidence, evidenceNeeded("cpe2", {}, thresholds, {0.2, 1e3}));
}

TEST(EvidenceNeeded, OfStructureKnowsNoOtherStructure) {
  EXPECT_EQ(DiagnosisThresholds().structure_evidence, besideStructure("second_electrode", 0.0, kAll));
}

TEST(EvidenceNeeded, OfLittleOfTheErrorIsATenthOfTheStructures) {
  EXPECT_DOUBLE_EQ(500.0, besideStructure("acid_transport", 0.49, 0.0));
  EXPECT_DOUBLE_EQ(500.0, besideStructure("current_offset", -0.3, 499.0));
}

TEST(EvidenceNeeded, OfLittleOfTheErrorIsNoLessThanWhatStaysUnexplained) {
  EXPECT_DOUBLE_EQ(1860.0, besideStructure("fresh_sulphate", 0.12, 1860.0));
}

TEST(EvidenceNeeded, OfMuchOfTheErrorIsWhatStaysUnexplained) {
  EXPECT_DOUBLE_EQ(60.0, besideStructure("acid_transport", 0.51, 60.0));
  EXPECT_DOUBLE_EQ(100.0, besideStructure("acid_transport", 0.51, kAll)) << "2 % of the structure's evidence at most";
  EXPECT_DOUBLE_EQ(DiagnosisThresholds().name_evidence, besideStructure("acid_transport", 0.51, 0.0));
}

TEST(EvidenceNeeded, OfWhatActsAtEdgesAloneIsTwoHundredths) {
  EXPECT_DOUBLE_EQ(100.0, besideStructure("time_skew", 0.04, 0.0));
  EXPECT_DOUBLE_EQ(100.0, besideStructure("time_skew", 0.9, 0.0));
}

TEST(EvidenceNeeded, BesideWeakStructureIsTheThreshold) {
  EXPECT_EQ(DiagnosisThresholds().name_evidence, besideStructure("acid_transport", 0.2, 0.0, 150.0));
}

}  // namespace
}  // namespace battery_sof
