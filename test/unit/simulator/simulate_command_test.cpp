#include "simulator/simulate_command.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "support/commands.hpp"
#include "support/limited_process.hpp"

namespace battery_sof_simulator {
namespace {

namespace fs = std::filesystem;

using battery_sof::test::Outcome;

/// A short scenario in a folder.
class SimulateCommand : public battery_sof::test::InFolder {
 protected:
  SimulateCommand() : InFolder("simulate") {
    scenario_ =
        write("drive.yaml", "{name: drive, seed: 3, duration_s: 20, profile: {kind: city_drive}}");
  }

  static std::string read(const std::string& file) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
  }
  static Outcome simulate(const std::vector<std::string>& arguments) {
    return battery_sof::test::outcomeOf([](auto&... all) { return runSimulate(all...); },
                                        arguments);
  }
  static Outcome demo(const std::vector<std::string>& arguments) {
    return battery_sof::test::outcomeOf([](auto&... all) { return runDemo(all...); }, arguments);
  }
  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), {}));
  }

  std::string scenario_;
};

TEST_F(SimulateCommand, WritesCsvWithTheContractsColumns) {
  const Outcome outcome = simulate({scenario_, path("out.csv")});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("2000 samples"), std::string::npos) << outcome.out;
  std::istringstream lines(read(path("out.csv")));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "time_s,current_a,voltage_v");
  int count = 0;
  std::string last;
  for (; std::getline(lines, line); last = line) ++count;
  EXPECT_EQ(count, 2000);
  EXPECT_EQ(last.rfind("19.99,", 0), 0u) << last;
}

TEST_F(SimulateCommand, CsvAndBagHoldTheSameSeedsDrive) {
  ASSERT_EQ(simulate({scenario_, path("a.csv")}).code, 0);
  ASSERT_EQ(simulate({scenario_, path("b.csv"), "--seed", "3"}).code, 0);
  ASSERT_EQ(simulate({scenario_, path("c.csv"), "--seed", "4"}).code, 0);
  EXPECT_EQ(read(path("a.csv")), read(path("b.csv")));
  EXPECT_NE(read(path("a.csv")), read(path("c.csv")));
}

TEST_F(SimulateCommand, DurationAndJsonAreObeyed) {
  const Outcome outcome = simulate({scenario_, path("out.csv"), "--duration", "5", "--json", "-"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json["schema"], "battery_sof/simulation/1");
  EXPECT_EQ(json["samples"], 500);
  EXPECT_EQ(json["seed"], 3);
  EXPECT_NEAR(json["charge_error_as"].get<double>(), 0.0, 1e-6);
  ASSERT_EQ(simulate({scenario_, path("out.csv"), "--json", path("out.json")}).code, 0);
  EXPECT_EQ(nlohmann::json::parse(read(path("out.json")))["duration_s"], 20.0);
}

TEST_F(SimulateCommand, SelfHeatedBatteryReportsItsTemperature) {
  const std::string warm = write(
      "warm.yaml", "{duration_s: 5, effects: {self_heating: true}, profile: {kind: city_drive}}");
  ASSERT_EQ(simulate({warm, path("out.csv")}).code, 0);
  EXPECT_EQ(read(path("out.csv")).rfind("time_s,current_a,voltage_v,temperature_c\n", 0), 0u);
}

TEST_F(SimulateCommand, PrintsTheImpedanceBesideTheAnalyticOne) {
  const Outcome outcome = simulate({scenario_, "--impedance", path("z.csv")});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  std::istringstream lines(read(path("z.csv")));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "frequency_hz,real_ohm,imag_ohm,analytic_real_ohm,analytic_imag_ohm");
  int rows = 0;
  double f, re, im, analytic_re, analytic_im;
  while (std::getline(lines, line)) {
    ASSERT_EQ(
        std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf,%lf", &f, &re, &im, &analytic_re, &analytic_im),
        5);
    EXPECT_LT(std::hypot(re - analytic_re, im - analytic_im),
              0.01 * std::hypot(analytic_re, analytic_im))
        << f;
    if (rows++ == 0) {
      EXPECT_NEAR(f, 1e-3, 1e-12);
    }
  }
  EXPECT_NEAR(f, 1e3, 1e-6);
  EXPECT_EQ(rows, 121);
}

TEST_F(SimulateCommand, WrongUsageOrInputGivesTwoAndLeavesNoFile) {
  const std::string wrong = write("wrong.yaml", "{profile: {kind: city_drive, speed: 3}}");
  const std::size_t before = files();
  EXPECT_EQ(simulate({}).code, 2);
  EXPECT_EQ(simulate({scenario_}).code, 2);
  EXPECT_EQ(simulate({scenario_, path("out.txt")}).code, 2);
  EXPECT_EQ(simulate({wrong, path("out.csv")}).code, 2);
  EXPECT_EQ(simulate({path("none.yaml"), path("out.csv")}).code, 2);
  EXPECT_EQ(simulate({scenario_, path("out.csv"), "--duration", "-4"}).code, 2);
  EXPECT_EQ(simulate({scenario_, path("out.csv"), "--sead", "4"}).code, 2);
  EXPECT_EQ(simulate({scenario_, path("no folder/out.csv")}).code, 2);
  EXPECT_EQ(simulate({scenario_, path("no folder/out.bag")}).code, 2);
  EXPECT_EQ(files(), before);
  EXPECT_NE(simulate({wrong, path("out.csv")}).err.find("profile.speed is not a known key"),
            std::string::npos);
}

TEST_F(SimulateCommand, HelpGivesZero) {
  const Outcome outcome = simulate({"--help"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_NE(outcome.out.find("sof simulate"), std::string::npos);
}

TEST_F(SimulateCommand, DemoWritesTheDriveOfTheShippedScenarioAndSaysWhatIsNext) {
  const Outcome made = demo({path("demo.csv"), "--duration", "30"});
  EXPECT_EQ(made.code, 0) << made.err;
  EXPECT_NE(made.out.find("sof identify " + path("demo.csv")), std::string::npos) << made.out;
  const std::string shipped =
      std::string(BATTERY_SOF_SOURCE_DIR) + "/config/scenarios/city_drive.yaml";
  ASSERT_EQ(simulate({shipped, path("shipped.csv"), "--duration", "30"}).code, 0);
  EXPECT_EQ(read(path("demo.csv")), read(path("shipped.csv")));
  EXPECT_EQ(demo({path("demo.txt")}).code, 2);
}

TEST_F(SimulateCommand, NamesAreShownOnOneLineAndObeyedByNoTerminal) {
  const std::string raw = "a\n\x1b[31m\xC2\x9B\xFF\xC3\xA4.csv",
                    name = "a\\x0a\\x1b[31m\\xc2\\x9b\\xff\xC3\xA4.csv";
  const Outcome made = demo({path(raw), "--duration", "2", "--json", path("o.json")});
  EXPECT_EQ(made.code, 0) << made.err;
  EXPECT_NE(made.out.find("written to " + path(name) + "; SOC"), std::string::npos) << made.out;
  EXPECT_NE(made.out.find("sof identify " + path(name)), std::string::npos) << made.out;
  EXPECT_EQ(std::count(made.out.begin(), made.out.end(), '\n'), 2);
  EXPECT_EQ(nlohmann::json::parse(read(path("o.json")))["out"], path(name));
  EXPECT_EQ(demo({"\x1b.txt"}).err, "sof: \\x1b.txt: expected a name ending in .csv or .bag\n");
  EXPECT_NE(demo({"a.csv", "--\x1b\n"}).err.find("--\\x1b\\x0a"), std::string::npos);
}

TEST_F(SimulateCommand, AFileBeyondTheProcessesLimitIsToldAndNotLeftHalfWritten) {
  for (const char* name : {"limited.csv", "limited.bag"}) {
    const std::string said = battery_sof::test::limitedTo(10000, [&](std::ostream& err) {
      std::ostringstream out;
      return runDemo({path(name), "--duration", "20"}, out, err);
    });
    EXPECT_NE(said.find(std::string(name) + ": cannot be written ("), std::string::npos) << said;
    EXPECT_FALSE(fs::exists(path(name)));
  }
  EXPECT_EQ(files(), 1u);
}

}  // namespace
}  // namespace battery_sof_simulator
