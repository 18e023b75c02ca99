#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "battery_sof/cli/sof.hpp"
#include "battery_sof/recording/csv.hpp"
#include "support/base_drive.hpp"

namespace battery_sof {
namespace {

namespace fs = std::filesystem;

struct Outcome {
  int code;
  std::string out, err;
};

Outcome sof(const std::vector<std::string>& arguments) {
  std::ostringstream out, err;
  const int code = runSof(arguments, out, err);
  return {code, out.str(), err.str()};
}

class SofDiagnose : public testing::Test {
 protected:
  SofDiagnose() : folder_(fs::temp_directory_path() / ("battery_sof diagnose " + std::to_string(getpid()))) {
    fs::create_directories(folder_);
    stub_ = path("stub.csv");
    writeCsv(stub_, test::baseDrive(1, 2.0));
  }
  ~SofDiagnose() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  fs::path folder_;
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

TEST_F(SofDiagnose, ExitsWithOneOnTooLittleDataAndTellsWhy) {
  const Outcome outcome = sof({"diagnose", stub_, "--json", path("d.json"), "--report", path("page.html"), "--out",
                               path("m.yaml"), "--base-out", path("b.yaml")});
  EXPECT_EQ(outcome.code, 1) << outcome.err;
  EXPECT_NE(outcome.err.find("no diagnosis"), std::string::npos);
  EXPECT_NE(outcome.out.find("insufficient_data"), std::string::npos);
  std::ifstream file(path("d.json"));
  EXPECT_EQ(nlohmann::json::parse(file)["verdict"], "insufficient_data");
  EXPECT_TRUE(fs::exists(path("page.html")));
  EXPECT_FALSE(fs::exists(path("m.yaml")));
  EXPECT_FALSE(fs::exists(path("b.yaml")));
}

TEST_F(SofDiagnose, WritesJsonAloneToStandardOutput) {
  const Outcome outcome = sof({"diagnose", stub_, "--json", "-"});
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json["schema"], "battery_sof/diagnosis/1");
  EXPECT_EQ(json["recording"], "stub.csv");
}

}  // namespace
}  // namespace battery_sof
