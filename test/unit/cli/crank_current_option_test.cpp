#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "report/model_yaml.hpp"
#include "support/drive_in_folder.hpp"
#include "support/sof_command.hpp"

/// --crank-current: what counts as an engine start, the same in every command.
namespace battery_sof {
namespace {

using test::Outcome;
using test::sof;
using Json = nlohmann::json;

/// A drive of ten minutes whose starter draws 120 A once a minute.
class CrankCurrentOption : public test::DriveInFolder {
 protected:
  CrankCurrentOption() {
    std::vector<double> current;
    for (int k = 0; k < 6000; ++k) {
      const double since = 0.1 * (k % 600) - 30.0;
      current.push_back(since < 0.0   ? -5.0
                        : since < 0.8 ? -120.0
                                      : 12.0 * std::exp(-(since - 0.8) / 20.0) - 2.0);
    }
    small_ = path("small.csv");
    writeCsv(small_, test::answered(battery(), current, 0.1, 0.002, 3));
  }

  /// A small one, whose resistance a starter of 120 A shows.
  static BaseParameters battery() {
    BaseParameters battery = test::drivenBattery();
    battery.r_discharge *= 2.0;
    return battery;
  }

  static Json told(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--json", "-"});
    const Outcome outcome = sof(arguments);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return outcome.code == 0 ? Json::parse(outcome.out) : Json();
  }

  std::string small_;
};

TEST_F(CrankCurrentOption, IsReadOffARecordingOfASmallEngineAndSaid) {
  const Json check = told({"check", small_});
  EXPECT_EQ(check["crank_current_a"], -72.0);
  EXPECT_EQ(check["crank_current_from"], "recording");
  EXPECT_EQ(check["events"]["crank"]["count"], 10);
  EXPECT_NE(sof({"check", small_}).out.find("10 pulses are taken as engine starts"),
            std::string::npos);
}

TEST_F(CrankCurrentOption, OfEitherSignIsTheSameInEveryCommand) {
  for (const char* given : {"150", "-150"}) {
    const Json check = told({"check", small_, "--crank-current", given});
    EXPECT_EQ(check["crank_current_a"], -150.0);
    EXPECT_EQ(check["crank_current_from"], "given");
    EXPECT_EQ(check["events"]["crank"]["count"], 0);
    EXPECT_EQ(told({"convert", small_, path("out.csv"), "--crank-current", given})["cranks"], 0);
  }
  EXPECT_EQ(told({"convert", small_, path("out.csv")})["cranks"], 10);
}

TEST_F(CrankCurrentOption, OfAnIdentificationIsThatOfItsPredictions) {
  ASSERT_EQ(sof({"identify", small_, "--effects", "none", "--out", model_}).code, 0);
  EXPECT_EQ(readModelFile(model_).fit.crank_current, -72.0);
  EXPECT_EQ(told({"predict", model_, small_})["cranks"].size(), 10u);
  EXPECT_EQ(told({"predict", model_, small_, "--crank-current", "150"})["cranks"].size(), 0u);
  ASSERT_EQ(
      sof({"identify", small_, "--effects", "none", "--crank-current", "100", "--out", model_})
          .code,
      0);
  EXPECT_EQ(readModelFile(model_).fit.crank_current, -100.0);
}

TEST_F(CrankCurrentOption, OfNothingIsRefusedAndSoIsItsOldName) {
  EXPECT_EQ(sof({"check", small_, "--crank-current", "0"}).code, 2);
  const Outcome old = sof({"identify", small_, "--crank-weight-current", "-100", "--out", model_});
  EXPECT_EQ(old.code, 2);
  EXPECT_NE(old.err.find("--crank-current"), std::string::npos) << old.err;
}

}  // namespace
}  // namespace battery_sof
