#include "report/results.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "support/made_diagnosis.hpp"

namespace battery_sof {
namespace {

using Json = nlohmann::json;

void expectKeys(const Json& json, const std::vector<const char*>& keys) {
  for (const char* key : keys)
    EXPECT_TRUE(json.contains(key)) << key << " in " << json.dump().substr(0, 200);
}

TEST(DiagnosisJson, HoldsTheContractsFields) {
  const Json json = resultJson(test::madeNamed().diagnosis);
  EXPECT_EQ(json["schema"], "battery_sof/diagnosis/2");
  EXPECT_EQ(json["verdict"], "effect");
  expectKeys(json, {"summary", "effects", "candidates", "mismatch", "fit", "next_experiment",
                    "mechanism", "probability", "relevance", "discrepancy", "evidence"});
  expectKeys(json["effects"].at(0),
             {"id", "mechanism", "probability", "confidence", "biased_parameters", "parameters"});
  expectKeys(json["effects"][0]["parameters"].at(0), {"name", "value", "std", "unit"});
  expectKeys(json["candidates"].at(0), {"id", "mechanism", "holdout_gain_percent", "evidence",
                                        "confidence", "rejected_because"});
  EXPECT_FALSE(json["candidates"][0].contains("probability")) << "one name: confidence";
  EXPECT_FALSE(json["effects"][0].contains("absorbed_into")) << "one name: biased_parameters";
  expectKeys(json["mismatch"].at(0),
             {"from_s", "to_s", "regime", "mean_error_v", "peak_error_v", "p_value"});
  for (const char* part : {"train", "holdout"}) {
    expectKeys(json["fit"][part], {"from_s", "to_s"});
    for (const char* model : {"base", "extended"})
      expectKeys(json["fit"][model][part], {"q_dyn_percent", "rmse_v", "max_abs_v", "crank_mae_v",
                                            "cranks", "charge_bias_v"});
  }
  EXPECT_EQ(json["fit"]["extended"]["holdout"]["rmse_v"], 0.0064);
  EXPECT_EQ(json["candidates"][0]["holdout_gain_percent"], 95.0);
  EXPECT_EQ(json["mechanism"], "acceptance");
  EXPECT_EQ(json["probability"], 0.97);
}

TEST(DiagnosisJson, TellsWhoImposesWhatBesideTheShare) {
  const test::MadeDiagnosis made = test::madeNamed();
  const Json json = resultJson(made.diagnosis);
  EXPECT_EQ(json["charger_share"], made.diagnosis.source.share);
  EXPECT_EQ(json["operating_mode"]["seen"], true);
  EXPECT_EQ(json["operating_mode"]["voltage"].size(), 8u);
  EXPECT_EQ(json["operating_mode"]["voltage"][0]["from_s"], 25.8);
  EXPECT_EQ(json["operating_mode"]["voltage"][0]["to_s"], 75.0);
  expectKeys(json["operating_mode"]["reasons"].at(1), {"mode", "reason", "stretches", "samples"});
  EXPECT_EQ(json["operating_mode"]["reasons"][1]["mode"], "voltage");
}

TEST(DiagnosisJson, HoldsWhatIsLeftBesideItsLimits) {
  const Json relevance = resultJson(test::madeNamed().diagnosis)["relevance"];
  EXPECT_EQ(relevance,
            (Json{{"rmse_v", 0.0004},
                  {"crank_v", 0.002},
                  {"charge_share", 0.006},
                  {"noise_v", 0.0007},
                  {"limits", {{"rmse_v", 0.0015}, {"crank_v", 0.010}, {"charge_share", 0.03}}}}));
}

TEST(DiagnosisJson, HoldsWhatWasLearnt) {
  const Json discrepancy = resultJson(test::madeUnknown().diagnosis)["discrepancy"];
  EXPECT_EQ(discrepancy["used"], true);
  EXPECT_EQ(discrepancy["left_out_base_rmse_v"], 0.064);
  EXPECT_EQ(discrepancy["left_out_rmse_v"], 0.021);
  EXPECT_EQ(discrepancy["mechanisms"].at(0),
            (Json{{"mechanism", "acceptance"}, {"gain", 340.0}, {"rms_v", 0.058}}));
  EXPECT_EQ(discrepancy["answers_to_a"], 20.0);
  EXPECT_EQ(discrepancy["answers"].at(2), (Json{{"time_s", 10.0},
                                                {"charging_v", 0.052},
                                                {"discharging_v", -0.0004},
                                                {"charging_std_v", 0.004},
                                                {"discharging_std_v", 0.002}}));
  EXPECT_EQ(discrepancy["curve"].size(), 5u);
  EXPECT_EQ(discrepancy["curve"].at(3), (Json{{"current_a", 10.0},
                                              {"early_v", 0.0001},
                                              {"late_v", 0.05},
                                              {"early_std_v", nullptr},
                                              {"late_std_v", nullptr}}));
  EXPECT_EQ(discrepancy["terms"].at(0), "memory of charging over 10 s");
}

TEST(DiagnosisText, SaysWhereNoStretchStandsOut) {
  const std::string sentence = "No stretch of time stands out";
  test::MadeDiagnosis made = test::madeUnknown();
  EXPECT_EQ(resultText(made.diagnosis).find(sentence), std::string::npos);
  made.diagnosis.mismatch.clear();
  EXPECT_NE(resultText(made.diagnosis).find(sentence), std::string::npos);
  EXPECT_EQ(resultText(test::madeNoMismatch().diagnosis).find(sentence), std::string::npos);
}

TEST(DiagnosisJson, HasNullForWhatIsAbsentOrNotFinite) {
  test::MadeDiagnosis made = test::madeUnknown();
  made.diagnosis.mismatch[0].peak_error = std::numeric_limits<double>::infinity();
  const Json json = resultJson(made.diagnosis);
  EXPECT_TRUE(json["fit"]["base"]["holdout"]["q_dyn_percent"].is_null());
  EXPECT_TRUE(json["fit"]["base"]["holdout"]["crank_mae_v"].is_null());
  EXPECT_TRUE(json["mismatch"][0]["peak_error_v"].is_null());
  EXPECT_TRUE(json["candidates"][0]["holdout_gain_percent"].is_null());
  const Json nothing = resultJson(test::madeNoMismatch().diagnosis);
  for (const char* key : {"discrepancy", "mechanism", "probability"})
    EXPECT_TRUE(nothing.at(key).is_null()) << key;
  EXPECT_EQ(Json::parse(json.dump()), json);
}

TEST(DiagnosisJson, HasTheLikelyMechanismsWithTheirProbabilities) {
  test::MadeDiagnosis made = test::madeUnknown();
  made.diagnosis.mechanisms = {{Mechanism::kAcceptance, 0.6}, {Mechanism::kAcid, 0.35}};
  const Json json = resultJson(made.diagnosis);
  EXPECT_EQ(
      (Json{{{"id", "acceptance"}, {"probability", 0.6}}, {{"id", "acid"}, {"probability", 0.35}}}),
      json["mechanisms"]);
  EXPECT_NE(std::string::npos,
            resultText(made.diagnosis).find("likely       acceptance 0.60, acid 0.35"));
  made.diagnosis.mechanisms = {{Mechanism::kStructure, 0.0}};
  EXPECT_TRUE(resultJson(made.diagnosis)["mechanisms"][0]["probability"].is_null());
  made.diagnosis.mechanisms.clear();
  EXPECT_EQ(Json::array(), resultJson(made.diagnosis)["mechanisms"]);
}

TEST(DiagnosisText, ListsSignificantRegimesAlone) {
  Diagnosis diagnosis;
  diagnosis.regimes = {{"crank", "mean", 6, -1.0, -2.0, 0.5, 0.3, false},
                       {"high_voltage_charge", "mean", 5, 0.899, 0.864, 0.933, 1e-6, true},
                       {"post_charge_rest", "mean", 9, 0.158, 0.0895, 0.226, 0.06, false},
                       {"short_charge", "end", 650, 1.2, 1.1, 1.3, 0.06, false}};
  const std::string text = resultText(diagnosis);
  EXPECT_NE(std::string::npos, text.find("high voltage charge: mean 899 mV, 95 % interval 864"));
  for (const char* other : {"crank", "post charge rest", "short charge"})
    EXPECT_EQ(std::string::npos, text.find(other)) << other;
}

TEST(DiagnosisText, NamesEffectsFoundInAMechanismWithoutAnEquation) {
  Diagnosis diagnosis;
  diagnosis.verdict = Verdict::kMechanism;
  diagnosis.mechanism = Mechanism::kAcid;
  diagnosis.candidates = {{"contact_resistance", 200.0, 0.9, "", "instrument"},
                          {"ocv_soc", 100.0, 0.0, "others explain more of it", "open_circuit"}};
  EXPECT_NE(std::string::npos, resultText(diagnosis).find("; with contact_resistance\n"));
}

TEST(DiagnosisJson, OfAFamilyThatNoProbabilityIsSaidOfHasNull) {
  test::MadeDiagnosis made = test::madeUnknown();
  made.diagnosis.mechanism = Mechanism::kAcceptance;
  made.diagnosis.probability = 0.0;
  EXPECT_EQ(resultJson(made.diagnosis)["mechanism"], "acceptance");
  EXPECT_TRUE(resultJson(made.diagnosis)["probability"].is_null());
}

TEST(DiagnosisJson, OfAnEmptyDiagnosisHasEveryField) {
  const Json json = resultJson(Diagnosis{});
  EXPECT_EQ(json["verdict"], "insufficient_data");
  EXPECT_TRUE(json["effects"].empty() && json["effects"].is_array());
  expectKeys(json, {"summary", "candidates", "mismatch", "fit", "next_experiment", "mechanism",
                    "probability", "relevance", "discrepancy"});
}

TEST(DiagnosisJson, SurvivesFileNamesOfAnyBytes) {
  Diagnosis diagnosis;
  diagnosis.base.provenance.recording = "\xff\xfe drive.bag";
  EXPECT_NO_THROW(resultJson(diagnosis).dump());
}

TEST(DiagnosisText, StaysInsideAHundredColumns) {
  for (const auto& made : {test::madeNamed(), test::madeNoMismatch(), test::madeUnknown()}) {
    std::istringstream lines(resultText(made.diagnosis));
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << line;
  }
}

TEST(DiagnosisText, TellsWhatAMailNeeds) {
  const std::string text = resultText(test::madeNamed().diagnosis);
  for (const char* piece :
       {"effect: The battery takes charge", "charge_acceptance",
        "parameters biased without it: r_charge", "at a bound", "long charge", "95 %", "hold-out",
        "121.0", "6.4", "the error grows in post charge rest",
        "could be present without being detected: gassing", "14.4 V", "are estimates"})
    EXPECT_NE(text.find(piece), std::string::npos) << piece << "\n" << text;
}

TEST(DiagnosisText, PromisesNoStrengthWhereTooMuchIsLeft) {
  test::MadeDiagnosis made = test::madeNoMismatch();
  for (DetectionLimit& one : made.diagnosis.detection_limits)
    one = {one.id, one.parameter, one.unit, std::nullopt, one.typical, false};
  made.diagnosis.unexplained.noise = 0.031;
  std::string text = resultText(made.diagnosis);
  std::replace(text.begin(), text.end(), '\n', ' ');
  EXPECT_NE(text.find("limits       31.0 mV RMS remain unexplained"), std::string::npos) << text;
  EXPECT_EQ(text.find("could be present without being detected"), std::string::npos) << text;
  made.diagnosis.unexplained.noise = 0.001;
  made.diagnosis.unexplained.rmse = 2.0 * made.diagnosis.unexplained.limits.rmse;
  EXPECT_NE(
      resultText(made.diagnosis).find("RMS of the error still depends on the currents; an effect"),
      std::string::npos);
}

TEST(DiagnosisText, TellsTheFamilyWhatWasLearntAndWhatIsTooSmallToMatter) {
  const std::string text = resultText(test::madeUnknown().diagnosis);
  for (const char* piece :
       {"mechanism    acceptance", "0.94", "discrepancy  The discrepancy, a function",
        "memory of charging over 10 s",
        "unexplained  0.4 mV RMS of the error still depends on the currents"})
    EXPECT_NE(text.find(piece), std::string::npos) << piece << "\n" << text;
}

TEST(DiagnosisText, SaysOfHowManyCranksTheirErrorIsTheMean) {
  Diagnosis diagnosis = test::madeNamed().diagnosis;
  EXPECT_EQ(resultText(diagnosis).find("  cranks:"), std::string::npos);
  diagnosis.fit.base_holdout.cranks = 2;
  diagnosis.fit.base_train.cranks = 6;
  EXPECT_NE(resultText(diagnosis).find("  cranks: 2 in the hold-out, 6 in the training part\n"),
            std::string::npos);
  EXPECT_EQ(resultJson(diagnosis)["fit"]["base"]["holdout"]["cranks"], 2);
}

TEST(DiagnosisText, OfAnEmptyDiagnosisIsItsVerdict) {
  Diagnosis diagnosis;
  diagnosis.summary = "Too short.";
  EXPECT_EQ(resultText(diagnosis),
            "verdict      insufficient_data: Too short. This says nothing about the battery.\n");
}

}  // namespace
}  // namespace battery_sof
