#include "battery_sof/report/diagnosis_results.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <sstream>

#include "support/made_diagnosis.hpp"

namespace battery_sof {
namespace {

using Json = nlohmann::json;

void expectKeys(const Json& json, const std::vector<const char*>& keys) {
  for (const char* key : keys) EXPECT_TRUE(json.contains(key)) << key << " in " << json.dump().substr(0, 200);
}

TEST(DiagnosisJson, HoldsTheContractsFields) {
  const Json json = diagnosisJson(test::madeNamed().diagnosis);
  EXPECT_EQ(json["schema"], "battery_sof/diagnosis/1");
  EXPECT_EQ(json["verdict"], "named");
  expectKeys(json, {"summary", "effects", "candidates", "mismatch", "fit", "next_experiment"});
  expectKeys(json["effects"].at(0), {"id", "confidence", "absorbed_into", "parameters"});
  expectKeys(json["effects"][0]["parameters"].at(0), {"name", "value", "std", "unit"});
  expectKeys(json["candidates"].at(0), {"id", "holdout_gain_percent", "evidence", "confidence", "rejected_because"});
  expectKeys(json["mismatch"].at(0), {"from_s", "to_s", "regime", "mean_error_v", "peak_error_v", "p_value"});
  for (const char* part : {"train", "holdout"}) {
    expectKeys(json["fit"][part], {"from_s", "to_s"});
    for (const char* model : {"base", "extended"})
      expectKeys(json["fit"][model][part], {"q_dyn_percent", "rmse_v", "max_abs_v", "crank_mae_v", "charge_bias_v"});
  }
  EXPECT_EQ(json["fit"]["extended"]["holdout"]["rmse_v"], 0.0064);
}

TEST(DiagnosisJson, HasNullForWhatIsAbsentOrNotFinite) {
  test::MadeDiagnosis made = test::madeUnknown();
  made.diagnosis.mismatch[0].peak_error = std::numeric_limits<double>::infinity();
  const Json json = diagnosisJson(made.diagnosis);
  EXPECT_TRUE(json["fit"]["base"]["holdout"]["q_dyn_percent"].is_null());
  EXPECT_TRUE(json["fit"]["base"]["holdout"]["crank_mae_v"].is_null());
  EXPECT_TRUE(json["mismatch"][0]["peak_error_v"].is_null());
  EXPECT_TRUE(json["candidates"][0]["holdout_gain_percent"].is_number());
  EXPECT_TRUE(diagnosisJson(test::madeNoMismatch().diagnosis)["force"].is_null());
  EXPECT_EQ(Json::parse(json.dump()), json);
}

TEST(DiagnosisJson, OfAnEmptyDiagnosisHasEveryField) {
  const Json json = diagnosisJson({});
  EXPECT_EQ(json["verdict"], "insufficient_data");
  EXPECT_TRUE(json["effects"].empty() && json["effects"].is_array());
  expectKeys(json, {"summary", "candidates", "mismatch", "fit", "next_experiment"});
}

TEST(DiagnosisJson, SurvivesFileNamesOfAnyBytes) {
  Diagnosis diagnosis;
  diagnosis.base.recording = "\xff\xfe drive.bag";
  EXPECT_NO_THROW(diagnosisJson(diagnosis).dump());
}

TEST(DiagnosisText, StaysInsideAHundredColumns) {
  for (const auto& made : {test::madeNamed(), test::madeNoMismatch(), test::madeUnknown()}) {
    std::istringstream lines(diagnosisText(made.diagnosis));
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << line;
  }
}

TEST(DiagnosisText, TellsWhatAMailNeeds) {
  const std::string text = diagnosisText(test::madeNamed().diagnosis);
  for (const char* piece : {"named: The battery takes charge", "charge_acceptance", "hidden before in r_charge", "at a bound",
                            "long charge", "95 %", "hold-out", "121.0", "6.4", "became worse in post charge rest",
                            "could be here unseen: gassing", "14.4 V"})
    EXPECT_NE(text.find(piece), std::string::npos) << piece << "\n" << text;
}

TEST(DiagnosisText, OfAnEmptyDiagnosisIsItsVerdict) {
  Diagnosis diagnosis;
  diagnosis.summary = "Too short.";
  EXPECT_EQ(diagnosisText(diagnosis), "verdict      insufficient_data: Too short.\n");
}

}  // namespace
}  // namespace battery_sof
