#include "cli/sof.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "battery_sof/csv.hpp"
#include "support/drive_in_folder.hpp"
#include "support/start_stop.hpp"

namespace battery_sof {
namespace {

namespace fs = std::filesystem;

using test::Outcome;
using test::sof;
using testing::HasSubstr;
using testing::StartsWith;

using Sof = test::DriveInFolder;

TEST_F(Sof, PrintsItsVersionAndHelpAndSucceeds) {
  EXPECT_EQ(sof({"--version"}).code, 0);
  EXPECT_NE(sof({"--version"}).out.find("sof "), std::string::npos);
  for (const char* command : {"check", "convert", "identify", "predict", "crank", "stop-time",
                              "charge", "map", "effects", "diagnose"}) {
    EXPECT_NE(sof({"--help"}).out.find(command), std::string::npos);
    EXPECT_EQ(sof({command, "--help"}).code, 0);
  }
}

TEST_F(Sof, ExitsWithTwoOnWrongUsage) {
  EXPECT_EQ(sof({}).code, 2);
  EXPECT_EQ(sof({"dance"}).code, 2);
  EXPECT_EQ(sof({"identify", inputs_}).code, 2);
  EXPECT_EQ(sof({"identify", inputs_, "--out", model_, "--from", "soon"}).code, 2);
  EXPECT_EQ(sof({"identify", inputs_, "--out", model_, "--from", "5000"}).code, 2);
  EXPECT_EQ(sof({"identify", inputs_, "--out", model_, "--start", "lucky"}).code, 2);
  EXPECT_EQ(sof({"identify", inputs_, "--out", model_, "--effects", "gasing"}).code, 2);
  EXPECT_EQ(sof({"convert", inputs_, path("drive.txt")}).code, 2);
}

TEST_F(Sof, MovesTheCurrentAgainstTheVoltage) {
  const std::string moved = path("moved.csv");
  const Outcome done = sof({"convert", inputs_, moved, "--shift-current", "0.5", "--json", "-"});
  ASSERT_EQ(done.code, 0) << done.err;
  EXPECT_EQ(nlohmann::json::parse(done.out)["shift_current_s"], 0.5);
  const Series before = readCsv(inputs_).series, after = readCsv(moved).series;
  const double first = after.time.front();
  EXPECT_NEAR(first, before.time.front() + 0.5, 0.011);
  EXPECT_NEAR(after.time.back(), before.time.back(), 1e-6);
  EXPECT_NEAR(after.current.front(), before.current.front(), 1.0);
  EXPECT_NEAR(after.voltage.front(), before.voltage[indexRange(before, first, first + 1.0).first],
              1e-4);
  const Outcome far = sof({"convert", inputs_, path("far.csv"), "--shift-current", "-1e7"});
  EXPECT_EQ(far.code, 2);
  EXPECT_NE(far.err.find("leaves no sample"), std::string::npos) << far.err;
}

/// Refused before anything is written, with what is wrong.
TEST_F(Sof, SaysWhichWordOfTheUsageIsWrong) {
  const auto said = [](const std::vector<std::string>& call) {
    const Outcome outcome = sof(call);
    EXPECT_EQ(outcome.code, 2);
    return outcome.err;
  };
  EXPECT_NE(said({"crnk"}).find("crnk is not a command, expected one of check,"),
            std::string::npos);
  EXPECT_NE(said({"check", inputs_, "--json", ""}).find("--json"), std::string::npos);
  EXPECT_NE(said({"identify", inputs_, "--out", "-"}).find("expected the name of a file"),
            std::string::npos);
  EXPECT_FALSE(fs::exists("-"));
  EXPECT_NE(said({"diagnose", inputs_, "--min-charge", "-1"}).find("min-charge is -1"),
            std::string::npos);
}

TEST_F(Sof, IdentifiesAWindowAndWritesTheModel) {
  const Outcome outcome =
      sof({"identify", inputs_, "--from", "0", "--to", "240", "--out", model_, "--json", "-"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json["status"], "converged");
  EXPECT_DOUBLE_EQ(json["window"]["to_s"], 240.0);
  EXPECT_NEAR(json["parameters"][0]["value"].get<double>(), 0.006, 1e-4);
  EXPECT_NEAR(json["state"]["time_s"].get<double>(), 240.0, 1e-9) << "the state is carried to --to";
  std::ifstream file(model_);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  EXPECT_NE(text.find("sha256:"), std::string::npos);
}

TEST_F(Sof, ChoosesTheWindowUnlessBothEndsAreGivenAndCarriesTheStateToTheEnd) {
  const Outcome outcome =
      sof({"identify", inputs_, "--from", "30", "--out", model_, "--json", path("result.json")});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("r_discharge"), std::string::npos);
  std::ifstream file(path("result.json"));
  const auto json = nlohmann::json::parse(file);
  EXPECT_GE(json["window"]["from_s"].get<double>(), 30.0);
  EXPECT_NEAR(json["state"]["time_s"].get<double>(), 299.99, 1e-6);
}

TEST_F(Sof, CountsTimesWithAPlusFromTheFirstSample) {
  Series late = test::baseDrive(1, 300.0);
  for (double& t : late.time) t += 1.7e9;
  writeCsv(path("late.csv"), late);
  for (const auto& from_to :
       {std::pair("+0", "+240"), std::pair("0", "240"), std::pair("1700000000", "1700000240")}) {
    const Outcome outcome = sof({"identify", path("late.csv"), "--from", from_to.first, "--to",
                                 from_to.second, "--out", model_, "--json", "-"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NEAR(nlohmann::json::parse(outcome.out)["window"]["to_s"].get<double>(), 1.70000024e9,
                1e-3);
  }
}

TEST_F(Sof, SaysSoWhenAWindowCannotBeIdentified) {
  Series rest =
      test::answered(test::drivenBattery(), std::vector<double>(3000, -1.0), 0.01, 0.002, 1);
  writeCsv(path("rest.csv"), rest);
  const Outcome outcome =
      sof({"identify", path("rest.csv"), "--out", model_, "--json", path("result.json")});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.err.find("no model"), std::string::npos);
  EXPECT_FALSE(fs::exists(model_));
  std::ifstream file(path("result.json"));
  const auto json = nlohmann::json::parse(file);
  EXPECT_EQ(json["status"], "not_excited");
  for (const char* of_a_fit : {"q_dyn_percent", "rmse_v"})
    EXPECT_TRUE(json[of_a_fit].is_null()) << of_a_fit;
  EXPECT_TRUE(json["state"]["time_s"].is_null() && json["state"]["u_c2_v"].is_null());
  EXPECT_EQ(outcome.out.find("RMS error"), std::string::npos);
}

TEST_F(Sof, RefusesATimeThatIsEmpty) {
  for (const char* option : {"--from", "--to"}) {
    const Outcome outcome = sof({"identify", inputs_, option, "", "--out", model_});
    EXPECT_EQ(outcome.code, 2);
    EXPECT_NE(outcome.err.find("expected seconds"), std::string::npos) << outcome.err;
  }
}

TEST_F(Sof, WarnsOfPriorsThatAreNotOfTheModelsEffects) {
  const auto warned = [&](const std::string& effects) {
    std::ofstream(path("priors.yaml"))
        << "schema: battery_sof/priors/1\n"
           "priors: [{vehicle_type: \"\", effects: [" +
               effects +
               "], "
               "parameters: {c2: {value: 200, std: 1, logarithmic: true}}}]\n";
    const Outcome outcome = sof({"identify", inputs_, "--from", "0", "--to", "240", "--out", model_,
                                 "--priors", path("priors.yaml")});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return outcome.err.find("the catalogue's priors are used") != std::string::npos;
  };
  EXPECT_FALSE(warned(""));
  EXPECT_TRUE(warned("gassing"));
}

TEST_F(Sof, PredictsAndWritesThePredictionSampleBySample) {
  ASSERT_EQ(identify().code, 0);
  const Outcome outcome = sof({"predict", model_, inputs_, "--from", "240", "--csv",
                               path("prediction.csv"), "--json", "-"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json["schema"], "battery_sof/prediction/1");
  EXPECT_GT(json["q_dyn_percent"].get<double>(), 95.0);
  std::ifstream file(path("prediction.csv"));
  std::string header;
  std::getline(file, header);
  EXPECT_EQ(header,
            "time_s,current_a,voltage_v,predicted_v,lower_v,upper_v,driven_by,predicted_a,lower_a,"
            "upper_a");
}

namespace {

/// A quarter of an hour of a start-stop car at 1 Hz.
Series startStop() {
  const BatteryModel composition({"fresh_sulphate"});
  test::StartStopOptions options;
  options.duration = 1200.0;
  options.current_noise = 0.1;
  options.voltage_noise = 0.01;
  return test::startStopDrive(composition, test::freshBattery(composition), options).series;
}

std::vector<std::string> column(const std::string& path, const std::string& name) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  std::size_t at = 0;
  for (std::stringstream header(line); std::getline(header, line, ',') && line != name;) ++at;
  std::vector<std::string> values;
  while (std::getline(file, line)) {
    std::stringstream row(line);
    std::string value;
    for (std::size_t k = 0; k <= at; ++k) std::getline(row, value, ',');
    values.push_back(value);
  }
  return values;
}

}  // namespace

TEST_F(Sof, PredictsInTheDirectionThatASourceImposesAndFromTheCurrentAlone) {
  writeCsv(path("car.csv"), startStop());
  const Outcome fit = sof(
      {"identify", path("car.csv"), "--from", "0", "--to", "900", "--out", model_, "--json", "-"});
  ASSERT_EQ(fit.code, 0) << fit.err;
  EXPECT_EQ(nlohmann::json::parse(fit.out)["effects"], nlohmann::json({"fresh_sulphate"}));
  const auto predict = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments = {"predict",       model_,   path("car.csv"),
                                          "--from",        "900",    "--csv",
                                          path("out.csv"), "--json", "-"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = sof(arguments);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out);
  };
  const auto fitted = predict({});
  ASSERT_TRUE(fitted["mixed"].is_object());
  EXPECT_GT(fitted["mixed"]["share_percent"].get<double>(), 80.0);
  EXPECT_GT(fitted["mixed"]["share_percent"].get<double>(),
            fitted["baseline"]["share_percent"].get<double>());
  EXPECT_FALSE(fitted["mixed"]["charges"].empty());
  const auto driven = column(path("out.csv"), "driven_by");
  EXPECT_GT(std::count(driven.begin(), driven.end(), "voltage"), 100);
  EXPECT_GT(std::count(driven.begin(), driven.end(), "current"), 30);
  EXPECT_EQ(predict({"--mode", "mixed"}), fitted);

  const auto from_current = predict({"--mode", "current"});
  EXPECT_TRUE(from_current["mixed"].is_null());
  EXPECT_EQ(from_current["q_dyn_percent"], fitted["q_dyn_percent"]);
  const auto by_current = column(path("out.csv"), "driven_by");
  EXPECT_EQ(std::count(by_current.begin(), by_current.end(), "current"),
            static_cast<long>(by_current.size()));
  EXPECT_EQ(column(path("out.csv"), "predicted_a").size(), by_current.size());

  const Outcome text = sof({"predict", model_, path("car.csv"), "--from", "900"});
  EXPECT_NE(text.out.find("input: the voltage where a source controls it"), std::string::npos);
  EXPECT_NE(text.out.find("baseline"), std::string::npos);
}

TEST_F(Sof, PredictsBothWaysWithAModelThatWasFittedWithoutASourceWhereItIsAskedTo) {
  writeCsv(path("car.csv"), startStop());
  ASSERT_EQ(identify().code, 0);
  const auto share = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments = {"predict", model_, path("car.csv"), "--json", "-"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return nlohmann::json::parse(sof(arguments).out)["mixed"];
  };
  EXPECT_TRUE(share({}).is_null());
  EXPECT_TRUE(share({"--mode", "mixed"}).is_object());
}

TEST_F(Sof, RefusesAMixedDriveWhereNoSourceIsSeenAndAnotherDrive) {
  Series rest =
      test::answered(test::drivenBattery(), std::vector<double>(3000, 0.0), 0.1, 0.001, 1);
  for (std::size_t n = 0; n < rest.size(); ++n) rest.current[n] = n % 100 < 50 ? -20.0 : -1.0;
  writeCsv(path("loads.csv"), rest);
  ASSERT_EQ(identify().code, 0);
  const Outcome none = sof({"predict", model_, path("loads.csv"), "--mode", "mixed"});
  EXPECT_EQ(none.code, 2);
  EXPECT_NE(none.err.find("--mode mixed: no source is seen in"), std::string::npos) << none.err;
  const Outcome wrong = sof({"predict", model_, inputs_, "--mode", "voltage"});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_NE(wrong.err.find("--mode"), std::string::npos) << wrong.err;
}

TEST_F(Sof, AnswersACrank) {
  ASSERT_EQ(identify().code, 0);
  const Outcome outcome =
      sof({"crank", model_, "--i-load", "-20", "--t-stop", "30", "--i-cranking", "-200",
           "--t-cranking", "0.8", "--u-required", "7.2", "--json", "-"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json["capable"], true);
  EXPECT_LT(json["lower"].get<double>(), json["u_min"].get<double>());
}

TEST_F(Sof, AnswersACrankOfARestedBattery) {
  ASSERT_EQ(identify().code, 0);
  const std::vector<std::string> query = {"crank", model_,         "--i-load", "0",      "--t-stop",
                                          "0",     "--i-cranking", "-200",     "--json", "-"};
  auto rested = query;
  rested.push_back("--rested");
  const double now = nlohmann::json::parse(sof(query).out)["u_min"];
  EXPECT_NE(now, nlohmann::json::parse(sof(rested).out)["u_min"].get<double>());
}

TEST_F(Sof, ExitsWithOneWhenTheAnswerIsAnExtrapolation) {
  ASSERT_EQ(identify().code, 0);
  const Outcome outcome =
      sof({"crank", model_, "--i-load", "-20", "--t-stop", "30", "--i-cranking", "-900"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.out.find("draws -900 A"), std::string::npos) << outcome.out;
}

TEST_F(Sof, RefusesImpossibleCranksByName) {
  ASSERT_EQ(identify().code, 0);
  const auto refused = [&](const std::string& load, const std::string& stop,
                           const std::string& cranking, const char* name) {
    const Outcome outcome =
        sof({"crank", model_, "--i-load", load, "--t-stop", stop, "--i-cranking", cranking});
    EXPECT_EQ(outcome.code, 2) << name;
    EXPECT_NE(outcome.err.find(name), std::string::npos) << outcome.err;
    EXPECT_TRUE(outcome.out.empty());
  };
  refused("-20", "nan", "-200", "t_stop");
  refused("nan", "30", "-200", "i_load");
  refused("-20", "30", "200", "i_cranking");
  refused("-20", "-5", "-200", "t_stop");
  refused("-20", "31536000", "-200", "t_stop");
}

TEST_F(Sof, AnswersACrankOfProfilesAsOneOfTheHeldCurrentsTheyStandFor) {
  ASSERT_EQ(identify().code, 0);
  const std::string load = write("load.csv", "time_s,current_a\n0,-20\n30,-20\n");
  const std::string crank = write("crank.csv", "current_a, time_s\r\n-200,0\r\n-200,0.8\r\n");
  const Outcome held = sof({"crank", model_, "--i-load", "-20", "--t-stop", "30", "--i-cranking",
                            "-200", "--t-cranking", "0.8", "--json", "-"});
  const Outcome profiled =
      sof({"crank", model_, "--load-profile", load, "--crank-profile", crank, "--json", "-"});
  ASSERT_EQ(profiled.code, 0) << profiled.err;
  EXPECT_NEAR(nlohmann::json::parse(profiled.out)["u_min"].get<double>(),
              nlohmann::json::parse(held.out)["u_min"].get<double>(), 1e-9);
}

TEST_F(Sof, ReadsProfilesOfAnyLoggerAsARecordingOfIt) {
  ASSERT_EQ(identify().code, 0);
  const auto lowest = [&](const std::string& load) {
    const Outcome outcome = sof({"crank", model_, "--load-profile", write("load.csv", load),
                                 "--i-cranking", "-200", "--json", "-"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out)["u_min"].get<double>();
  };
  const double plain = lowest("time_s,current_a\n0,-20\n30,-10.5\n");
  EXPECT_DOUBLE_EQ(lowest("t_ms;Current (A)\nms;A\n# a logger\n0;-20\n30000;-10,5\n"), plain);
  EXPECT_NEAR(lowest("timestamp\ti\n1700000000000\t-20\n1700000030000\t-10.5\n"), plain, 1e-9);
  EXPECT_NEAR(lowest("time,i\n2023-11-14 22:13:20,-20\n2023-11-14 22:13:50,-10.5\n"), plain, 1e-9);
}

TEST_F(Sof, RefusesProfilesWithAFaultAndNamesFileLineAndExpectation) {
  ASSERT_EQ(identify().code, 0);
  const auto refused = [&](const std::string& content, const std::vector<std::string>& pieces) {
    const Outcome outcome = sof(
        {"crank", model_, "--i-cranking", "-200", "--load-profile", write("load.csv", content)});
    EXPECT_EQ(outcome.code, 2) << content;
    EXPECT_NE(outcome.err.find("load.csv"), std::string::npos) << outcome.err;
    for (const auto& piece : pieces)
      EXPECT_NE(outcome.err.find(piece), std::string::npos) << outcome.err;
  };
  refused("", {"is empty", "time_s, current_a"});
  refused("time_s,current_a\n", {"no row"});
  refused("t,load\n0,-20\n", {"no column \"current_a\"", "t, load"});
  refused("time_s,current_a\n0,-20\n1,lots\n",
          {"line 3", "\"current_a\": \"lots\"", "not a number"});
  refused("time_s,current_a\n0,nan\n", {"line 2", "current is nan", "expected a finite number"});
  refused("time_s,current_a\n0,\n", {"line 2", "current", "expected a finite number"});
  refused("time_s,current_a\n0\n", {"line 2", "1 cells, the header has 2"});
  refused("time_s,current_a\n0,-5\n0,-5\n", {"line 3", "time is 0", "expected more than"});
  refused("time_s,current_a\n-1,-5\n", {"line 2", "time is -1", "expected 0 or more"});
  EXPECT_EQ(sof({"crank", model_, "--i-cranking", "-200", "--load-profile", path("none.csv")}).code,
            2);
}

TEST_F(Sof, WantsEitherNumbersOrAProfile) {
  ASSERT_EQ(identify().code, 0);
  const Outcome missing = sof({"crank", model_, "--i-load", "-20", "--i-cranking", "-200"});
  EXPECT_EQ(missing.code, 2);
  EXPECT_NE(missing.err.find("--t-stop or --load-profile"), std::string::npos) << missing.err;
  const std::string load = write("load.csv", "time_s,current_a\n0,-20\n");
  EXPECT_EQ(
      sof({"crank", model_, "--i-load", "-20", "--load-profile", load, "--i-cranking", "-200"})
          .code,
      2);
}

TEST_F(Sof, AnswersTheLongestStop) {
  ASSERT_EQ(identify().code, 0);
  const Outcome finite =
      sof({"stop-time", model_, "--i-load", "-25", "--i-cranking", "-200", "--u-required", "11.3",
           "--capacity-ah", "1000", "--rested", "--json", "-"});
  ASSERT_EQ(finite.code, 0) << finite.err;
  const auto json = nlohmann::json::parse(finite.out);
  EXPECT_EQ(json["outcome"], "finite");
  EXPECT_LT(json["lower"].get<double>(), json["t_stop"].get<double>());
  const Outcome least = sof({"stop-time", model_, "--i-load", "-25", "--i-cranking", "-200",
                             "--u-required", "7.2", "--json", "-"});
  ASSERT_EQ(least.code, 0) << least.err;
  EXPECT_EQ(nlohmann::json::parse(least.out)["outcome"], "at_least");
  EXPECT_NEAR(nlohmann::json::parse(least.out)["t_stop"].get<double>(), 144.0, 1e-9);
  const Outcome always = sof({"stop-time", model_, "--i-load", "0", "--i-cranking", "-200",
                              "--u-required", "7.2", "--json", "-"});
  ASSERT_EQ(always.code, 0) << always.err;
  EXPECT_TRUE(nlohmann::json::parse(always.out)["t_stop"].is_null());
  EXPECT_EQ(nlohmann::json::parse(always.out)["outcome"], "always");
  EXPECT_EQ(sof({"stop-time", model_, "--i-load", "-25", "--i-cranking", "-200"}).code, 2);
  EXPECT_EQ(
      sof({"stop-time", model_, "--i-load", "-25", "--i-cranking", "-200", "--u-required", "nan"})
          .code,
      2);
}

TEST_F(Sof, AnswersACharge) {
  ASSERT_EQ(identify().code, 0);
  const Outcome outcome =
      sof({"charge", model_, "--u-boost", "13", "--t-sof2", "5", "--json", "-"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_GT(json["i_boost"].get<double>(), 0.0);
  EXPECT_LT(json["lower"].get<double>(), json["upper"].get<double>());
  const Outcome beyond = sof({"charge", model_, "--u-boost", "16"});
  EXPECT_EQ(beyond.code, 1);
  EXPECT_THAT(beyond.out, HasSubstr("\nnot valid: mean current "));
  EXPECT_EQ(beyond.err, "") << "said once, in the text";
  const Outcome wrong = sof({"charge", model_, "--u-boost", "13", "--i-limit", "-3"});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_NE(wrong.err.find("i_limit"), std::string::npos) << wrong.err;
}

TEST_F(Sof, ALimitThatMayBeMissedIsNotAssured) {
  ASSERT_EQ(identify().code, 0);
  const auto expect_not_assured = [&](std::vector<std::string> query) {
    const Outcome outcome = sof(query);
    EXPECT_EQ(outcome.code, 1) << query.front();
    EXPECT_THAT(outcome.out, HasSubstr("\nnot assured: ")) << query.front();
    EXPECT_EQ(outcome.err, "") << query.front();
    query.insert(query.end(), {"--json", "-"});
    const Outcome as_json = sof(query);
    EXPECT_EQ(as_json.code, 1) << query.front();
    EXPECT_THAT(nlohmann::json::parse(as_json.out)["message"].get<std::string>(),
                StartsWith("not assured: "));
    EXPECT_THAT(as_json.err, StartsWith("sof: not assured: "));
  };
  expect_not_assured({"crank", model_, "--i-load", "-20", "--t-stop", "30", "--i-cranking", "-200",
                      "--u-required", "12"});
  expect_not_assured(
      {"stop-time", model_, "--i-load", "-20", "--i-cranking", "-200", "--u-required", "12"});
  expect_not_assured({"charge", model_, "--u-boost", "12"});
  EXPECT_THAT(sof({"crank", model_, "--i-load", "-20", "--t-stop", "30", "--i-cranking", "-200",
                   "--u-required", "7.2"})
                  .out,
              HasSubstr("\nholds: lowest voltage "));
}

TEST_F(Sof, PrintsMaps) {
  ASSERT_EQ(identify().code, 0);
  const Outcome outcome =
      sof({"map", model_, "--i-load", "-10,-20,-30", "--t-stop", "0,10", "--i-cranking", "-200",
           "--u-boost", "13", "--t-sof2", "1,5", "--json", "-"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json["u_min"].size(), 6u);
  EXPECT_EQ(json["i_boost"].size(), 2u);
  const auto alone = nlohmann::json::parse(sof({"crank", model_, "--i-load", "-20", "--t-stop",
                                                "10", "--i-cranking", "-200", "--json", "-"})
                                               .out);
  EXPECT_EQ(json["u_min"][3], alone["u_min"]);
  EXPECT_EQ(sof({"map", model_}).code, 2);
  EXPECT_EQ(sof({"map", model_, "--i-load", "-10", "--t-stop", "0,x", "--i-cranking", "-200"}).code,
            2);
  EXPECT_EQ(sof({"map", model_, "--i-load", "-10", "--t-stop", "0"}).code, 2);
  EXPECT_EQ(sof({"map", model_, "--i-load", "-10,5", "--t-stop", "0", "--i-cranking", "-200"}).code,
            2);
}

TEST_F(Sof, RefusesAModelFileThatIsNone) {
  EXPECT_EQ(sof({"predict", path("nothing.yaml"), inputs_}).code, 2);
  const Outcome outcome = sof({"predict", write("broken.yaml", "schema: other\n"), inputs_});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.err.find("broken.yaml: schema"), std::string::npos);
}

TEST_F(Sof, RefusesAMissingFile) { expectRefused(path("nothing.csv"), {"nothing.csv"}); }

TEST_F(Sof, RefusesAnEmptyFile) { expectRefused(write("empty.csv", ""), {"empty.csv", "empty"}); }

TEST_F(Sof, RefusesAHeaderOnly) {
  expectRefused(write("header.csv", "time_s,current_a,voltage_v\n"), {"header.csv"});
}

TEST_F(Sof, RefusesAWrongColumnAndListsTheFilesColumns) {
  expectRefused(write("columns.csv", "time_s,shunt_mv,voltage_v\n0,1,12\n"),
                {"current_a", "shunt_mv"});
}

TEST_F(Sof, RefusesTextInANumberAndSaysWhere) {
  expectRefused(write("text.csv", "time_s,current_a,voltage_v\n0,1,12\n1,lots,12\n"),
                {"text.csv", "3", "current_a", "lots"});
}

TEST_F(Sof, RefusesAnUnsortedFile) {
  std::string text = "time_s,current_a,voltage_v\n";
  for (int k = 0; k < 100; ++k) text += std::to_string((k * 37) % 100) + ",1,12\n";
  expectRefused(write("unsorted.csv", text), {"unsorted.csv", "sorted"});
}

TEST_F(Sof, RefusesAFileWithoutASingleFiniteSample) {
  expectRefused(write("nan.csv", "time_s,current_a,voltage_v\n0,nan,12\n1,,12\n2,inf,12\n"),
                {"nan.csv"});
}

TEST_F(Sof, CountsMissingInfiniteAndRepeatedSamplesByReason) {
  std::ostringstream text;
  text << "time_s,current_a,voltage_v\n";
  for (int k = 0; k < 200; ++k) text << k << "," << (k % 20 < 10 ? -5 : 5) << ",12.5\n";
  text << "200,nan,12\n201,inf,12\n202,1,12.5\n202,1,12.5\n150,1,12.5\n";
  const Outcome outcome = sof({"check", write("faulty.csv", text.str()), "--json", "-"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto rejected = nlohmann::json::parse(outcome.out)["rejected"];
  EXPECT_EQ(rejected["missing_value"], 1);
  EXPECT_EQ(rejected["not_finite"], 1);
  EXPECT_EQ(rejected["duplicate_stamp"], 1);
  EXPECT_EQ(rejected["clock_step_back"], 1);
}

TEST_F(Sof, LeavesNoHalfWrittenFileWhenTheFolderDoesNotExist) {
  const Outcome outcome = sof({"identify", inputs_, "--out", path("missing folder/model.yaml")});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_FALSE(fs::exists(path("missing folder")));
}

/// Real recordings: a model or a clear reason for none, never a crash.
TEST_F(Sof, HasAnAnswerForEveryRealRecording) {
  const fs::path data = fs::path(BATTERY_SOF_SOURCE_DIR) / ".." / "shared" / "data";
  if (!fs::exists(data)) GTEST_SKIP() << "no recordings at ../shared/data beside the checkout";
  const std::vector<std::vector<std::string>> recordings = {
      {"startstop_car/drive_1.csv", "t_s", "current_A", "voltage_V"},
      {"startstop_car/drive_2.csv", "t_s", "current_A", "voltage_V"},
      {"startstop_car/other_car_1.csv", "t_s", "current_A", "voltage_V"},
      {"frc_robot/match.csv", "t_s", "current_A_minus_sum_of_channels", "voltage_V_roborio"},
      {"agm_bench/full_cycle.csv", "t_s", "current_A", "voltage_V"},
      {"solar_vrla/ten_days.csv", "time", "current", "voltage", "--discharge-positive"},
      {"leaf_cell/hppc_25c.csv", "Time(s)", "Current(A)", "Voltage(V)"}};
  for (const auto& recording : recordings) {
    SCOPED_TRACE(recording[0]);
    const std::string file = (data / recording[0]).string();
    std::vector<std::string> columns = {"--time-column", recording[1],       "--current-column",
                                        recording[2],    "--voltage-column", recording[3]};
    columns.insert(columns.end(), recording.begin() + 4, recording.end());
    const auto call = [&](std::vector<std::string> arguments) {
      arguments.insert(arguments.end(), columns.begin(), columns.end());
      return sof(arguments);
    };
    EXPECT_EQ(call({"check", file}).code, 0);
    const Outcome outcome = call({"identify", file, "--out", model_});
    if (outcome.code == 0) {
      EXPECT_EQ(call({"predict", model_, file}).code, 0);
    } else {
      EXPECT_EQ(outcome.code, 1);
      EXPECT_NE(outcome.err.find("no model: "), std::string::npos);
    }
  }
}

/// Of a bench's cycle fresh sulphate says nothing. The cycle moves its capacity: the open-circuit voltage is taken with both of its ends, since the window was charged
/// at a held voltage and discharged, but not where the capacity is said to be ten times larger.
TEST_F(Sof, IdentifyTakesWhatABenchsCycleHolds) {
  const fs::path file =
      fs::path(BATTERY_SOF_SOURCE_DIR) / ".." / "shared" / "data" / "agm_bench/full_cycle.csv";
  if (!fs::exists(file)) GTEST_SKIP() << "no agm_bench/full_cycle.csv beside the checkout";
  const auto effectsAt = [&](const std::string& capacity) {
    const Outcome outcome = sof({"identify", file.string(), "--from", "0", "--to", "61571.25",
                                 "--capacity-ah", capacity, "--out", model_, "--json", "-"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out)["effects"];
  };
  EXPECT_EQ(effectsAt("100"),
            nlohmann::json::array({"ocv_soc", "end_of_discharge", "acceptance_soc"}));
  EXPECT_TRUE(effectsAt("1000").empty());
}

}  // namespace
}  // namespace battery_sof
