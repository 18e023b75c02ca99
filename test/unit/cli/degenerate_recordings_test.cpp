#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "battery_sof/csv.hpp"
#include "support/drive_in_folder.hpp"
#include "support/synthetic_recording.hpp"

/// Every command ends with an exit code and a sentence, whatever a recording holds.
namespace battery_sof {
namespace {

using test::Outcome;
using test::sof;

constexpr std::size_t kSamples = 900;
constexpr double kInterval = 0.1;  // [s]

/// A sample of a channel: its sound value, one value of the channel's size, and how far the
/// recording is.
struct ChannelSample {
  double sound, level;
  std::size_t k;
};

/// A channel as a fault makes it.
struct Shape {
  const char* name;
  double (*of)(const ChannelSample& at, test::Random& random);
};

const Shape kShapes[] = {
    {"constant", [](const ChannelSample& at, test::Random&) { return at.level; }},
    {"stuck in the second half",
     [](const ChannelSample& at, test::Random&) {
       return at.k < kSamples / 2 ? at.sound : at.level;
     }},
    {"ramp", [](const ChannelSample& at,
                test::Random&) { return at.level * (1.0 - 2e-4 * static_cast<double>(at.k)); }},
    {"noise", [](const ChannelSample& at,
                 test::Random& random) { return at.level * (1.0 + 0.3 * random.normal()); }},
    {"zeros", [](const ChannelSample&, test::Random&) { return 0.0; }},
    {"two values", [](const ChannelSample& at,
                      test::Random&) { return at.k % 2 == 0 ? at.level : 0.9 * at.level; }},
    {"one pulse", [](const ChannelSample& at,
                     test::Random&) { return at.k == kSamples / 3 ? 0.5 * at.level : at.level; }},
    {"negated", [](const ChannelSample& at, test::Random&) { return -at.sound; }},
};

/// A load that switches between -40 A and 10 A, and a voltage that answers to it.
Series soundSeries() {
  test::Random random(7);
  test::SyntheticBattery battery;
  Series series;
  for (std::size_t k = 0; k < kSamples; ++k) {
    constexpr double kLevels[] = {10.0, -40.0, -8.0};  // [A]
    double current = kLevels[(k / 37) % 3];
    const double voltage = battery.step(current, kInterval) + 0.002 * random.normal();
    series.time.push_back(kInterval * static_cast<double>(k));
    series.current.push_back(current + 0.02 * random.normal());
    series.voltage.push_back(voltage);
  }
  return series;
}

class DegenerateRecordings : public test::DriveInFolder {
 protected:
  /// All commands on one recording.
  void expectSentences(const std::string& name, const Series& series) {
    SCOPED_TRACE(name);
    const std::string file = path("degenerate.csv"), own = path("own.yaml");
    writeCsv(file, series);
    std::filesystem::remove(own);
    expectSentence(name, {"check", file});
    expectSentence(name, {"convert", file, path("converted.csv")});
    expectSentence(name, {"predict", model_, file});
    expectSentence(name, {"diagnose", file});
    const int identified = expectSentence(name, {"identify", file, "--out", own});
    EXPECT_EQ(identified == 0, std::filesystem::exists(own));
    if (identified != 0) return;
    expectSentence(name, {"crank", own, "--i-load", "-5", "--t-stop", "10", "--i-cranking", "-40"});
    expectSentence(
        name, {"stop-time", own, "--i-load", "-5", "--i-cranking", "-40", "--u-required", "9"});
    expectSentence(name, {"charge", own, "--u-boost", "14"});
  }

  int expectSentence(const std::string& name, const std::vector<std::string>& call) {
    const Outcome outcome = sof(call);
    // An answer that is not valid or not assured says so in its text.
    const bool has_answer = outcome.code == 1 && outcome.err.empty();
    const std::string& said = outcome.code == 0 || has_answer ? outcome.out : outcome.err;
    EXPECT_GE(outcome.code, 0) << call[0];
    EXPECT_LE(outcome.code, 2) << call[0];
    EXPECT_GT(said.size(), 20u) << call[0] << " says nothing";
    EXPECT_EQ(said.find("nan"), std::string::npos) << call[0] << ": " << said;
    const std::size_t sentence = said.rfind(has_answer ? "\nnot " : "sof: ");
    EXPECT_TRUE(outcome.code == 0 || sentence != std::string::npos) << call[0];
    // The table: BATTERY_SOF_PRINT_TABLE=1 cli_test --gtest_filter=DegenerateRecordings.*
    const std::size_t begin = outcome.code == 0 ? 0 : sentence + (has_answer ? 1 : 0);
    const std::string line = said.substr(begin, said.find('\n', begin) - begin);
    table_ += name + " | " + call[0] + " | " + std::to_string(outcome.code) + " | " + line + "\n";
    return outcome.code;
  }

  void TearDown() override {
    if (std::getenv("BATTERY_SOF_PRINT_TABLE")) std::fputs(table_.c_str(), stdout);
  }

  std::string table_;
};

/// Of one channel at a time while the other is sound, and of both.
TEST_F(DegenerateRecordings, EndEveryCommandWithAnExitCodeAndASentence) {
  ASSERT_EQ(identify().code, 0);
  const Series sound = soundSeries();
  for (const Shape& shape : kShapes)
    for (const char* channel : {"current", "voltage", "both channels"}) {
      test::Random random(11);
      Series series = sound;
      for (std::size_t k = 0; k < kSamples; ++k) {
        if (channel[0] != 'v') series.current[k] = shape.of({sound.current[k], -5.0, k}, random);
        if (channel[0] != 'c') series.voltage[k] = shape.of({sound.voltage[k], 12.6, k}, random);
      }
      expectSentences(std::string(channel) + ": " + shape.name, series);
    }
}

TEST_F(DegenerateRecordings, DoNotMakeTheSoundOneFail) {
  const std::string file = path("sound.csv");
  writeCsv(file, soundSeries());
  EXPECT_EQ(sof({"identify", file, "--out", model_}).code, 0);
  EXPECT_EQ(sof({"diagnose", file}).code, 0);
}

/// The recording on which the search for mechanisms took the first of no samples.
TEST_F(DegenerateRecordings, AStuckVoltageIsInsufficientData) {
  Series series;
  for (std::size_t k = 0; k < 2000; ++k) {
    series.time.push_back(kInterval * static_cast<double>(k));
    series.current.push_back((k / 50) % 2 == 0 ? -20.0 : 10.0);
    series.voltage.push_back(12.6);
  }
  writeCsv(path("stuck.csv"), series);
  const Outcome outcome = sof({"diagnose", path("stuck.csv")});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.out.find("insufficient_data"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.err.find("are measurements"), std::string::npos) << outcome.err;
}

TEST_F(DegenerateRecordings, AConstantCurrentIsInsufficientData) {
  Series series;
  for (std::size_t k = 0; k < 2000; ++k) {
    series.time.push_back(kInterval * static_cast<double>(k));
    series.current.push_back(-5.0);
    series.voltage.push_back(12.5);
  }
  writeCsv(path("constant.csv"), series);
  const Outcome outcome = sof({"diagnose", path("constant.csv")});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.err.find("the current does not change"), std::string::npos) << outcome.err;
}

class FlippedRecordings : public DegenerateRecordings {
 protected:
  /// identify and diagnose refuse it, naming what mends it; identify takes it where it is meant.
  void expectRefused(const Series& series, const std::string& what, const std::string& remedy) {
    writeCsv(path("flipped.csv"), series);
    for (const std::vector<std::string>& call :
         {std::vector<std::string>{"identify", path("flipped.csv"), "--out", model_},
          {"diagnose", path("flipped.csv")}}) {
      const Outcome outcome = sof(call);
      EXPECT_EQ(outcome.code, 1) << call[0];
      EXPECT_NE(outcome.err.find(what), std::string::npos) << outcome.err;
      EXPECT_NE(outcome.err.find(remedy), std::string::npos) << outcome.err;
    }
    EXPECT_FALSE(std::filesystem::exists(model_));
    const Outcome meant = sof({"identify", path("flipped.csv"), "--anyway", "--out", model_});
    EXPECT_EQ(meant.err.find("--anyway"), std::string::npos) << meant.err;
  }
};

TEST_F(FlippedRecordings, OfCurrentAreRefusedWithTheOptionThatMendsThem) {
  Series series = soundSeries();
  for (double& current : series.current) current = -current;
  expectRefused(series, "voltage falls when current rises", "--discharge-positive");
  EXPECT_EQ(sof({"identify", path("flipped.csv"), "--discharge-positive", "--out", model_}).code,
            0);
}

TEST_F(FlippedRecordings, OfVoltageAreRefusedAndItsSignIsNamed) {
  Series series = soundSeries();
  for (double& voltage : series.voltage) voltage = -voltage;
  expectRefused(series, "the voltage is negative", "sign is flipped");
}

TEST_F(FlippedRecordings, MillisecondsReadAsSecondsAreRefusedWithTheOptionThatMendsThem) {
  Series series = test::baseDrive(1, 300.0);
  for (double& time : series.time) time *= 1e3;
  expectRefused(series, "in one direction", "--time-unit ms");
  const Outcome mended =
      sof({"identify", path("flipped.csv"), "--time-unit", "ms", "--out", model_, "--json", "-"});
  EXPECT_EQ(mended.code, 0) << mended.err;
}

}  // namespace
}  // namespace battery_sof
