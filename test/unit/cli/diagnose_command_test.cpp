#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "battery_sof/csv.hpp"
#include "support/composed.hpp"
#include "support/sof_command.hpp"
#include "support/start_stop.hpp"

namespace battery_sof {
namespace {

namespace fs = std::filesystem;

using test::Outcome;
using test::sof;

class SofDiagnose : public test::InFolder {
 protected:
  SofDiagnose() : InFolder("diagnose") {
    stub_ = path("stub.csv");
    writeCsv(stub_, test::baseDrive(1, 2.0));
  }

  /// then.csv and now.csv: two trips of one battery, 8 mOhm of contact in the second.
  void writeTripsWithANewContact() {
    const BatteryModel model({"fresh_sulphate"});
    test::StartStopOptions options;
    options.duration = 1500.0;
    options.lowest = 12.6;
    options.current_noise = 0.1;
    options.voltage_noise = 0.01;
    const Series then = test::startStopDrive(model, test::freshBattery(model), options).series;
    options.seed = 2;
    Series now = test::startStopDrive(model, test::freshBattery(model), options).series;
    for (std::size_t n = 0; n < now.size(); ++n) now.voltage[n] += 0.008 * now.current[n];
    writeCsv(path("then.csv"), then);
    writeCsv(path("now.csv"), now);
  }

  std::string stub_;  ///< two seconds: too short for any diagnosis
};

TEST_F(SofDiagnose, ExitsWithTwoOnWrongUsage) {
  EXPECT_EQ(sof({"diagnose"}).code, 2);
  EXPECT_EQ(sof({"diagnose", path("none.bag")}).code, 2);
  EXPECT_EQ(sof({"diagnose", stub_, "--from", "soon"}).code, 2);
  EXPECT_EQ(sof({"diagnose", stub_, "--from", "5000"}).code, 2);
  EXPECT_EQ(sof({"diagnose", stub_, "--holdout", "most"}).code, 2);
  EXPECT_EQ(sof({"diagnose", stub_, "--voltage-column", "u"}).code, 2);
}

TEST_F(SofDiagnose, FindsAnUnwritableResultBeforeTheWork) {
  const Outcome outcome = sof({"diagnose", stub_, "--report", path("nowhere/page.html")});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.err.find("nowhere"), std::string::npos) << outcome.err;
}

TEST_F(SofDiagnose, ReadsWhatAFleetKnows) {
  std::ofstream(path("priors.yaml"))
      << "schema: battery_sof/priors/1\n"
         "priors: [{vehicle_type: van, effects: [], parameters: {}}]\n";
  std::ofstream(path("other.yaml")) << "schema: other\n";
  EXPECT_EQ(sof({"diagnose", stub_, "--priors", path("priors.yaml"), "--vehicle-type", "van"}).code,
            1)
      << "two seconds are too short";
  const Outcome refused = sof({"diagnose", stub_, "--priors", path("other.yaml")});
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("schema is \"other\""), std::string::npos) << refused.err;
  const Outcome without = sof({"diagnose", stub_, "--vehicle-type", "van"});
  EXPECT_EQ(without.code, 2);
  EXPECT_NE(without.err.find("expected only with --priors"), std::string::npos) << without.err;
}

TEST_F(SofDiagnose, ExitsWithOneOnTooLittleDataAndTellsWhy) {
  const Outcome outcome =
      sof({"diagnose", stub_, "--json", path("d.json"), "--report", path("page.html"), "--out",
           path("m.yaml"), "--base-out", path("b.yaml")});
  EXPECT_EQ(outcome.code, 1) << outcome.err;
  EXPECT_NE(outcome.err.find("This recording cannot be diagnosed: "), std::string::npos);
  EXPECT_NE(outcome.out.find("insufficient_data"), std::string::npos);
  std::ifstream file(path("d.json"));
  const nlohmann::json said = nlohmann::json::parse(file);
  EXPECT_EQ(said["verdict"], "insufficient_data");
  // nothing was compared: no numbers
  EXPECT_TRUE(said["fit"]["base"]["holdout"]["rmse_v"].is_null()) << said["fit"];
  EXPECT_TRUE(said["fit"]["train"]["from_s"].is_null()) << said["fit"];
  EXPECT_TRUE(fs::exists(path("page.html")));
  EXPECT_FALSE(fs::exists(path("m.yaml")));
  EXPECT_FALSE(fs::exists(path("b.yaml")));
}

TEST_F(SofDiagnose, WritesJsonAloneToStandardOutput) {
  const Outcome outcome = sof({"diagnose", stub_, "--json", "-"});
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json["schema"], "battery_sof/diagnosis/2");
  EXPECT_EQ(json["recording"], "stub.csv");
}

TEST_F(SofDiagnose, NamesWhatADriveHasAndWritesModelsThatPredict) {
  Series series;
  const BatteryModel truth({"current_dependent_resistance"});
  series.current = test::dataSetOneCurrent(600.0, 0.1, 5);
  for (std::size_t n = 0; n < series.current.size(); ++n)
    series.time.push_back(0.1 * static_cast<double>(n));
  series.voltage.assign(series.size(), 12.0);
  series.voltage = test::voltages(truth, test::pointOf(truth, test::typicalPoint(truth)),
                                  inputSequence(series, {0, series.size()}));
  test::Random random(3);
  for (double& u : series.voltage) u += 0.002 * random.normal();
  writeCsv(path("drive.csv"), series);
  const Outcome outcome =
      sof({"diagnose", path("drive.csv"), "--json", path("d.json"), "--report", path("page.html"),
           "--out", path("m.yaml"), "--base-out", path("b.yaml"), "--hypotheses",
           "current_dependent_resistance,gassing,time_skew"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("effect"), std::string::npos) << outcome.out;
  std::ifstream file(path("d.json"));
  const auto json = nlohmann::json::parse(file);
  EXPECT_EQ(json["effects"].at(0)["id"], "current_dependent_resistance") << json["summary"];
  EXPECT_LT(json["fit"]["extended"]["holdout"]["rmse_v"], json["fit"]["base"]["holdout"]["rmse_v"]);
  EXPECT_GT(fs::file_size(path("page.html")), 50000u);
  for (const char* model : {"m.yaml", "b.yaml"})
    EXPECT_EQ(sof({"predict", path(model), path("drive.csv")}).code, 0);
  std::ifstream extended(path("m.yaml"));
  std::stringstream yaml;
  yaml << extended.rdbuf();
  EXPECT_NE(yaml.str().find("current_dependent_resistance"), std::string::npos);
  EXPECT_NE(yaml.str().find("sha256:"), std::string::npos);
}

TEST_F(SofDiagnose, SeveralRecordingsGoWithAReferenceAlone) {
  writeCsv(path("again.csv"), test::baseDrive(2, 2.0));
  const Outcome outcome = sof({"diagnose", stub_, path("again.csv"), "--json", path("d.json")});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.err.find("2 recordings are given, expected one"), std::string::npos)
      << outcome.err;
  EXPECT_FALSE(fs::exists(path("d.json")));
}

TEST_F(SofDiagnose, NamesTheOneOfSeveralRecordingsThatCannotBeRead) {
  std::ofstream(path("broken.csv")) << "time_s,current_a,voltage_v\n1,2\n";
  writeCsv(path("again.csv"), test::baseDrive(2, 2.0));
  const std::vector<std::string> since = {"--reference", path("again.csv")};
  for (const std::string& bad : {path("broken.csv"), path("none.csv")}) {
    const Outcome outcome = sof({"diagnose", stub_, bad, since[0], since[1]});
    EXPECT_EQ(outcome.code, 2);
    EXPECT_NE(outcome.err.find(bad), std::string::npos) << outcome.err;
  }
  fs::copy(stub_, path("copy.csv"));
  const Outcome twice = sof({"diagnose", stub_, path("copy.csv"), since[0], since[1]});
  EXPECT_EQ(twice.code, 2);
  EXPECT_NE(twice.err.find("copy.csv is the same recording as"), std::string::npos) << twice.err;
}

TEST_F(SofDiagnose, WhatIsGivenLeavesNothingToWeigh) {
  const Outcome outcome =
      sof({"diagnose", path("any.csv"), "--given", "ocv_soc", "--hypotheses", "gassing"});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.err.find("--hypotheses"), std::string::npos) << outcome.err;
}

TEST_F(SofDiagnose, WhatIsConfirmedIsGone) {
  const Outcome outcome = sof({"diagnose", path("any.csv"), "--confirm", "gassing"});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.err.find("--confirm: is gone since 0.3"), std::string::npos) << outcome.err;
}

TEST_F(SofDiagnose, SaysWhatHasChangedSinceAReference) {
  writeTripsWithANewContact();
  const Outcome outcome = sof({"diagnose", path("now.csv"), "--reference", path("then.csv"),
                               "--json", path("change.json")});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("verdict      changed"), std::string::npos) << outcome.out;
  const auto json = nlohmann::json::parse(std::ifstream(path("change.json")));
  EXPECT_EQ(json["schema"], "battery_sof/change/1");
  EXPECT_EQ(json["verdict"], "changed");
  ASSERT_EQ(json["changes"].size(), 1u);
  const auto& change = json["changes"][0];
  EXPECT_EQ(change["id"], "contact_resistance");
  EXPECT_EQ(change["kind"], "effect");
  EXPECT_EQ(change["unit"], "ohm");
  EXPECT_LT(change["interval"][0], 0.008);
  EXPECT_GT(change["interval"][1], 0.008);
  EXPECT_GT(json["explained"]["changed_model"]["share_percent"],
            json["explained"]["reference_model"]["share_percent"]);
}

std::string textOf(const std::string& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST_F(SofDiagnose, TakesTheModelOfTheReferenceInItsPlace) {
  writeTripsWithANewContact();
  ASSERT_EQ(sof({"identify", path("then.csv"), "--out", path("then.yaml")}).code, 0);
  const Outcome outcome = sof({"diagnose", path("now.csv"), "--reference", path("then.yaml"),
                               "--json", path("change.json")});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(std::ifstream(path("change.json")));
  ASSERT_EQ(json["verdict"], "changed") << json;
  EXPECT_EQ(json["references"], nlohmann::json({"then.yaml"}));
  EXPECT_EQ(json["changes"][0]["id"], "contact_resistance");
  EXPECT_LT(json["changes"][0]["interval"][0], 0.008);
  EXPECT_GT(json["changes"][0]["interval"][1], 0.008);
  EXPECT_TRUE(json["explained"]["model_distance"].is_null());
  EXPECT_GT(json["explained"]["changed_model"]["share_percent"],
            json["explained"]["reference_model"]["share_percent"]);
  const Outcome same = sof({"diagnose", path("then.csv"), "--reference", path("then.yaml")});
  EXPECT_EQ(same.code, 2);
  EXPECT_NE(same.err.find("is a model of the same recording as"), std::string::npos) << same.err;
}

TEST_F(SofDiagnose, AReferenceModelWithoutResponsesIsToBeIdentifiedAgain) {
  writeCsv(path("then.csv"), test::baseDrive(1));
  ASSERT_EQ(
      sof({"identify", path("then.csv"), "--effects", "none", "--out", path("bare.yaml")}).code, 0);
  const std::string text = textOf(path("bare.yaml"));
  const auto at = text.find("responses:");
  if (at != std::string::npos) std::ofstream(path("bare.yaml")) << text.substr(0, at);
  writeCsv(path("other.csv"), test::baseDrive(3));
  const Outcome outcome = sof({"diagnose", path("other.csv"), "--reference", path("bare.yaml")});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.err.find("Identify again (sof identify)"), std::string::npos) << outcome.err;
}

TEST_F(SofDiagnose, ReferencesThatCannotServeAreRefused) {
  const Outcome same = sof({"diagnose", stub_, "--reference", stub_});
  EXPECT_EQ(same.code, 2);
  EXPECT_NE(same.err.find("is the same recording as"), std::string::npos) << same.err;
  EXPECT_EQ(sof({"diagnose", stub_, "--reference", path("none.csv")}).code, 2);
  EXPECT_EQ(sof({"diagnose", stub_, "--capacity-ah", "20", "--reference", stub_}).code, 2);
  EXPECT_NE(sof({"diagnose", stub_, "--capacity-ah", "0"}).err.find("--capacity-ah is 0"),
            std::string::npos);
  writeCsv(path("then.csv"), test::baseDrive(2, 2.0));
  const Outcome brief = sof({"diagnose", stub_, "--reference", path("then.csv")});
  EXPECT_EQ(brief.code, 1);
  EXPECT_NE(brief.err.find("samples, a comparison needs 300"), std::string::npos) << brief.err;
  const Outcome base = sof({"diagnose", stub_, "--reference", stub_, "--base-out", path("x.yaml")});
  EXPECT_EQ(base.code, 2);
  EXPECT_NE(base.err.find("--reference"), std::string::npos) << base.err;
}

TEST_F(SofDiagnose, WritesThePageOfAChangeAndTheModelOfTheRecording) {
  const BatteryModel model({"fresh_sulphate"});
  test::StartStopOptions options;
  options.duration = 1500.0;
  const Series then = test::startStopDrive(model, test::freshBattery(model), options).series;
  options.seed = 2;
  Series now = test::startStopDrive(model, test::freshBattery(model), options).series;
  for (std::size_t n = 0; n < now.size(); ++n) now.voltage[n] += 0.008 * now.current[n];
  writeCsv(path("then.csv"), then);
  writeCsv(path("now.csv"), now);
  const Outcome outcome =
      sof({"diagnose", path("now.csv"), "--reference", path("then.csv"), "--report",
           path("page.html"), "--out", path("now.yaml"), "--json", path("change.json")});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const std::string page = textOf(path("page.html"));
  for (const char* part :
       {"<!DOCTYPE html>", "Something has changed", "<code>contact_resistance</code>",
        "<h3>Then</h3>", "<h3>Now</h3>", "What contact_resistance explains", "then.csv", "now.csv",
        "the reference with the change", "edge_resistance"})
    EXPECT_NE(page.find(part), std::string::npos) << part;
  const std::string data = "<script type=\"application/json\" id=\"result\">";
  const std::size_t from = page.find(data);
  ASSERT_EQ(from, page.find("<script"));
  ASSERT_EQ(from, page.rfind("<script"));
  EXPECT_EQ(nlohmann::json::parse(
                page.substr(from + data.size(), page.find("</script>") - from - data.size())),
            nlohmann::json::parse(textOf(path("change.json"))));
  EXPECT_EQ(page.find("nan"), std::string::npos);
  // The next comparison takes it as its reference.
  const Outcome next = sof({"diagnose", path("then.csv"), "--reference", path("now.yaml"),
                            "--responses-only", "--report", path("next.html")});
  EXPECT_EQ(next.code, 0) << next.err;
  EXPECT_NE(textOf(path("next.html")).find("A model file keeps"), std::string::npos);
}

}  // namespace
}  // namespace battery_sof
