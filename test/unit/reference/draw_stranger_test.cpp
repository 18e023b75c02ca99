#include "reference/draw_stranger_command.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

namespace battery_sof_reference {
namespace {

namespace fs = std::filesystem;

std::string contentOf(const fs::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

class DrawStranger : public ::testing::Test {
 protected:
  DrawStranger()
      : folder_(fs::temp_directory_path() / ("draw_stranger_" + std::to_string(::getpid()))) {
    fs::create_directories(folder_);
  }
  ~DrawStranger() override { fs::remove_all(folder_); }

  int run(const std::vector<std::string>& arguments) {
    out_.str("");
    err_.str("");
    return runDrawStranger(arguments, out_, err_);
  }
  int draw(std::vector<std::string> more) {
    for (const std::string& one :
         {std::string("--duration"), std::string("240"), std::string("--rate"), std::string("10"),
          std::string("--out"), recording().string(), std::string("--label"), label().string()})
      more.push_back(one);
    return run(more);
  }
  fs::path recording() const { return folder_ / "case.csv"; }
  fs::path label() const { return folder_ / "case.json"; }

  fs::path folder_;
  std::ostringstream out_, err_;
};

TEST_F(DrawStranger, ListsKindsFamiliesAndForms) {
  EXPECT_EQ(run({"--list"}), 0);
  EXPECT_NE(out_.str().find("null - -\nimperfect_null - -\n"), std::string::npos);
  EXPECT_NE(out_.str().find("other_form acid pore_diffusion\n"), std::string::npos);
  EXPECT_NE(out_.str().find("other_form instrument dead_band\n"), std::string::npos);
}

TEST_F(DrawStranger, TheSameOptionsGiveTheSameBytes) {
  const std::vector<std::string> options{"--family", "structure", "--seed", "9"};
  ASSERT_EQ(draw(options), 0) << err_.str();
  const std::string recording_once = contentOf(recording()), label_once = contentOf(label());
  ASSERT_EQ(draw(options), 0);
  EXPECT_EQ(contentOf(recording()), recording_once);
  EXPECT_EQ(contentOf(label()), label_once);
}

TEST_F(DrawStranger, TheRecordingHasNothingOfTheLabel) {
  ASSERT_EQ(draw({"--kind", "imperfect_null", "--seed", "2"}), 0) << err_.str();
  const std::string rows = contentOf(recording());
  EXPECT_EQ(rows.find("time_s,current_a,voltage_v\n0,"), 0u);
  EXPECT_EQ(rows.find_first_not_of("0123456789.,-+e\n", rows.find('\n')), std::string::npos);
}

TEST_F(DrawStranger, TheLabelSaysWhatIsTrue) {
  ASSERT_EQ(draw({"--family", "acid", "--form", "separator_delay", "--seed", "4"}), 0)
      << err_.str();
  const auto json = nlohmann::json::parse(contentOf(label()));
  EXPECT_EQ(json["kind"], "other_form");
  EXPECT_EQ(json["family"], "acid");
  EXPECT_EQ(json["form"], "separator_delay");
  EXPECT_EQ(json["duration_s"], 240.0);
  EXPECT_GT(json["visible_rms_v"]["training"].get<double>(), 4e-3);
  EXPECT_GT(json["rms_v"]["holdout"].get<double>(), 0.0);
  EXPECT_GT(json["noise"]["voltage_white_v"].get<double>(), 0.0);
  ASSERT_EQ(draw({"--kind", "null", "--seed", "4"}), 0) << err_.str();
  const auto null = nlohmann::json::parse(contentOf(label()));
  EXPECT_TRUE(null["family"].is_null());
  EXPECT_EQ(null["strength"], 0.0);
  EXPECT_EQ(null["visible_rms_v"]["training"], 0.0);
}

TEST_F(DrawStranger, WrongUsageIsSaidInASentence) {
  EXPECT_EQ(run({"--kind", "friend", "--out", recording().string(), "--label", label().string()}),
            2);
  EXPECT_NE(err_.str().find("--list"), std::string::npos);
  EXPECT_EQ(run({"--seed", "1"}), 2);
  EXPECT_EQ(run({"--out", "case.txt", "--label", label().string()}), 2);
  EXPECT_EQ(run({"--kind", "null", "--rate", "7", "--out", recording().string(), "--label",
                 label().string()}),
            2);
  EXPECT_FALSE(fs::exists(recording()));
}

}  // namespace
}  // namespace battery_sof_reference
