#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "battery_sof/csv.hpp"
#include "simulator/simulate_command.hpp"
#include "support/base_drive.hpp"
#include "support/limited_process.hpp"
#include "support/sof_command.hpp"
#include "util/files.hpp"

namespace battery_sof {
namespace {

namespace fs = std::filesystem;
using test::Outcome;
using test::sof;

const std::string kHeader = "time_s,current_a,voltage_v\n";

/// What careless or hostile calls of the command meet.
class HardUsage : public test::InFolder {
 protected:
  HardUsage() : InFolder("hard usage") {}

  std::string bytesOf(const std::string& file) const {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  std::string drive() const {
    writeCsv(path("drive.csv"), test::baseDrive(1, 300.0));
    return path("drive.csv");
  }

  std::string model() const {
    const std::string file = drive();
    EXPECT_EQ(
        sof({"identify", file, "--from", "0", "--to", "240", "--out", path("model.yaml")}).code, 0);
    return path("model.yaml");
  }

  /// A call is refused as wrong usage that names both files, and leaves a file as it was.
  void expectKept(const std::string& kept, const std::vector<std::string>& call) const {
    const std::string before = bytesOf(kept);
    const Outcome outcome = sof(call);
    EXPECT_EQ(outcome.code, 2) << call[0];
    EXPECT_NE(outcome.err.find("written over"), std::string::npos)
        << call[0] << " said " << outcome.err;
    EXPECT_TRUE(bytesOf(kept) == before) << call[0] << " changed " << kept;
  }
};

TEST_F(HardUsage, ThreeSamplesAtAKilohertzAreTooFewForEveryCommandAndSaidToBe) {
  const std::string file = write("short.csv", kHeader + "0,1,12\n0.001,2,12.1\n0.002,3,12.2\n");
  const Outcome identified = sof({"identify", file, "--out", path("m.yaml")});
  EXPECT_EQ(identified.code, 1);
  EXPECT_NE(identified.err.find("nothing is left of it"), std::string::npos) << identified.err;
  const Outcome predicted = sof({"predict", model(), file});
  EXPECT_EQ(predicted.code, 2);
  EXPECT_NE(predicted.err.find("nothing is left of it"), std::string::npos) << predicted.err;
  EXPECT_EQ(sof({"check", file}).code, 0);
  EXPECT_EQ(sof({"diagnose", file}).code, 1);
}

TEST_F(HardUsage, TimesThatAreNoSecondsAreToldAsOutOfRange) {
  std::string rows = kHeader, dense = kHeader;
  for (int n = 0; n < 500; ++n) {
    rows += std::to_string(n) + "e15," + std::to_string(n % 3 - 5) + ",12.1\n";
    dense += std::to_string(n) + "e-12," + std::to_string(n % 3 - 5) + ",12.1\n";
  }
  for (const std::string& file : {write("far.csv", rows), write("dense.csv", dense)}) {
    EXPECT_EQ(sof({"check", file}).code, 0) << file;
    EXPECT_EQ(sof({"identify", file, "--out", path("m.yaml")}).code, 1) << file;
    EXPECT_EQ(sof({"diagnose", file}).code, 1) << file;
  }
  EXPECT_NE(sof({"check", path("far.csv")}).out.find("499"), std::string::npos);
}

TEST_F(HardUsage, NoCommandWritesOverWhatItReads) {
  const std::string yaml = model(), csv = path("drive.csv");
  expectKept(csv, {"check", csv, "--json", csv});
  expectKept(csv, {"identify", csv, "--out", csv});
  expectKept(csv, {"identify", csv, "--out", path("m.yaml"), "--json", csv});
  expectKept(csv, {"convert", csv, csv});
  expectKept(csv, {"diagnose", csv, "--report", csv});
  expectKept(csv, {"diagnose", csv, "--out", csv});
  expectKept(csv, {"diagnose", csv, "--base-out", csv});
  expectKept(csv, {"predict", yaml, csv, "--csv", csv});
  expectKept(yaml, {"predict", yaml, csv, "--json", yaml});
  expectKept(yaml, {"crank", yaml, "--i-load", "-20", "--t-stop", "10", "--i-cranking", "-200",
                    "--json", yaml});
  expectKept(yaml, {"stop-time", yaml, "--i-load", "-20", "--i-cranking", "-200", "--u-required",
                    "8", "--json", yaml});
  expectKept(yaml, {"charge", yaml, "--u-boost", "14", "--json", yaml});
  expectKept(yaml, {"map", yaml, "--u-boost", "14", "--t-sof2", "10", "--json", yaml});
  const std::string profile = write("profile.csv", "time_s,current_a\n0,-20\n");
  expectKept(profile,
             {"crank", yaml, "--load-profile", profile, "--i-cranking", "-200", "--json", profile});
  fs::create_symlink(csv, path("link.csv"));
  expectKept(csv, {"identify", csv, "--out", path("link.csv")});
}

TEST_F(HardUsage, TwoOutputsAreTwoFiles) {
  const Outcome outcome = sof({"identify", drive(), "--out", path("s"), "--json", path("s")});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.err.find("one file to write"), std::string::npos) << outcome.err;
  EXPECT_FALSE(fs::exists(path("s")));
  EXPECT_EQ(sof({"check", path("drive.csv"), "--json", "/dev/null"}).code, 0);
}

TEST_F(HardUsage, TheSimulatorIsToldWhichFilesItWouldReadAndWrite) {
  const std::string scenario = write("scenario.yaml", "name: x\n");
  const auto run = [](const auto& arguments, std::ostream& out, std::ostream& err) {
    return battery_sof_simulator::runSimulate(arguments, out, err, requireSeparateFiles);
  };
  const Outcome outcome = test::outcomeOf(run, {scenario, path("out.csv"), "--json", scenario});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.err.find("written over"), std::string::npos) << outcome.err;
}

TEST_F(HardUsage, NumbersAreDecimal) {
  const std::string file = drive();
  EXPECT_NE(sof({"identify", file, "--out", path("m.yaml"), "--from", "0x10"})
                .err.find("expected seconds"),
            std::string::npos);
  EXPECT_NE(sof({"charge", model(), "--u-boost", "0x0e"})
                .err.find("--u-boost is \"0x0e\", expected a decimal number"),
            std::string::npos);
  const Outcome seed =
      test::outcomeOf([](auto&... all) { return battery_sof_simulator::runSimulate(all...); },
                      {path("s.yaml"), path("o.csv"), "--seed", "-1"});
  EXPECT_EQ(seed.code, 2);
  EXPECT_NE(seed.err.find("is not a seed"), std::string::npos) << seed.err;
}

TEST_F(HardUsage, ControlCharactersOfInputAreShownAsTheirCodes) {
  const std::string file = write("escape.csv", "time_s,current_a,volt\x1b[31mage\n0,1,12\n");
  const Outcome outcome = sof({"check", file});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_EQ(outcome.err.find('\x1b'), std::string::npos);
  EXPECT_NE(outcome.err.find("volt\\x1b[31mage"), std::string::npos) << outcome.err;
  const Outcome usage = sof({"check", file, "--\x1b[31m"});
  EXPECT_EQ(usage.err.find('\x1b'), std::string::npos);
  EXPECT_EQ(sof({"\x1b[31m"}).err.find('\x1b'), std::string::npos);
}

TEST_F(HardUsage, NamesAreShownOnOneLine) {
  fs::rename(drive(), path("a\nb\x1b.csv"));
  const std::string file = path("a\nb\x1b.csv"), name = "a\\nb\\x1b.csv";
  EXPECT_EQ(sof({"check", file}).out.rfind(name + "\n", 0), 0u) << sof({"check", file}).out;
  const Outcome converted = sof({"convert", file, path("c\nd.csv"), "--json", path("c.json")});
  EXPECT_NE(converted.out.find("c\\nd.csv, 0 rejected"), std::string::npos) << converted.out;
  EXPECT_NE(bytesOf(path("c.json")).find("c\\\\nd.csv"), std::string::npos);
  const Outcome usage = sof({"check", file, "--a\nb"});
  EXPECT_NE(usage.err.find("--a\\nb"), std::string::npos) << usage.err;
}

TEST_F(HardUsage, ErrorsAreBounded) {
  EXPECT_LT(sof({"check", path("none.csv"), "--" + std::string(100000, 'x')}).err.size(), 12000u);
}

TEST_F(HardUsage, AModelOfAPipeHasTheDigestOfItsBytes) {
  const std::string file = drive(), pipe = path("pipe");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const auto hashOf = [&](const std::string& recording) {
    const Outcome outcome = sof({"identify", recording, "--from", "0", "--to", "240", "--out",
                                 path("m.yaml"), "--json", "-"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    const std::string yaml = bytesOf(path("m.yaml"));
    return yaml.substr(yaml.find("sha256:"), 71);
  };
  std::thread writer([&] { std::ofstream(pipe, std::ios::binary) << bytesOf(file); });
  const std::string piped = hashOf(pipe);
  writer.join();
  EXPECT_EQ(piped, hashOf(file));
}

/// In a process of its own: what it may write is limited for good.
TEST_F(HardUsage, AFileBeyondTheProcessesLimitIsToldAndNotLeftHalfWritten) {
  const std::string file = drive(), out = path("limited.csv");
  const std::string error = test::limitedTo(10000, [&](std::ostream& err) {
    std::ostringstream ignored;
    return runSof({"convert", file, out}, ignored, err);
  });
  EXPECT_NE(error.find("limited.csv: File too large"), std::string::npos) << error;
  EXPECT_FALSE(fs::exists(out));
}

TEST_F(HardUsage, StandardOutputThatCannotBeWrittenIsTold) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "this system has no /dev/full";
  std::ofstream full("/dev/full");
  std::ostringstream err;
  EXPECT_EQ(runSof({"effects"}, full, err), 2);
  EXPECT_NE(err.str().find("standard output cannot be written: No space left"), std::string::npos)
      << err.str();
}

TEST_F(HardUsage, AFileNameThatIsNoUtf8IsNoObstacle) {
  fs::rename(drive(), path("dr\xFFive.csv"));
  const Outcome outcome =
      sof({"identify", path("dr\xFFive.csv"), "--out", path("m.yaml"), "--json", path("o.json")});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_TRUE(nlohmann::json::accept(bytesOf(path("o.json"))));
  EXPECT_EQ(
      sof({"crank", path("m.yaml"), "--i-load", "-20", "--t-stop", "10", "--i-cranking", "-200"})
          .code,
      0);
}

}  // namespace
}  // namespace battery_sof
