#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "battery_sof/csv.hpp"
#include "prediction/questions.hpp"
#include "report/descriptions.hpp"
#include "report/model_yaml.hpp"
#include "report/results.hpp"
#include "support/comma_locale.hpp"
#include "support/known_model.hpp"

namespace battery_sof {
namespace {

/// Files and answers, as written in the locale of C++ programs and as in that of the test.
class Locale : public ::testing::Test {
 protected:
  Locale()
      : file_(std::filesystem::temp_directory_path() /
              ("battery_sof_locale_" + std::to_string(getpid()) + ".csv")) {
    series_.time = {1024.5, 1024.75, 1025.0};
    series_.current = {-12345.678 / 3.0, -0.1, 1.0 / 3.0};
    series_.voltage = {12.5, 11.875, 14.2};
    series_.temperature_time = {1024.5};
    series_.temperature = {293.15 + 1.0 / 3.0};
    model_ = test::knownModel();
    model_.fit.window.samples = 24000;
  }
  ~Locale() override { std::filesystem::remove(file_); }

  std::string writtenCsv() const {
    writeCsv(file_, series_);
    std::ifstream in(file_, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  std::string answer() const {
    CrankingQuery query;
    query.i_load = -10.5;
    query.t_stop = 60.25;
    query.i_cranking = -400.5;
    const CrankingAnswer answer = predictCranking(model_, query);
    return resultText(query, answer) + jsonOf(answer).dump() + resultText(model_);
  }

  /// @param surroundings is made and set back around what is to come out as without.
  template <typename Surroundings>
  void expectNothingChanges() {
    const std::string csv = writtenCsv(), yaml = modelYaml(model_), said = answer();
    const Surroundings surroundings;
    EXPECT_EQ(writtenCsv(), csv);
    const Series read = readCsv(file_).series;
    EXPECT_EQ(read.time, series_.time);
    EXPECT_EQ(read.current, series_.current);
    EXPECT_EQ(read.voltage, series_.voltage);
    EXPECT_EQ(read.temperature, series_.temperature);
    EXPECT_EQ(modelYaml(model_), yaml);
    EXPECT_EQ(modelYaml(parseModelYaml(yaml, "model.yaml")), yaml);
    EXPECT_EQ(answer(), said);
    EXPECT_EQ(formatExactly(1234567.25), "1234567.25");
  }

  std::filesystem::path file_;
  Series series_;
  FittedModel model_;
};

TEST_F(Locale, TheCommaOfCppStreamsIsSeenByWhoDoesNotTakeCare) {
  const test::CommaStreams comma;
  std::ostringstream text;
  text << 1234.5;
  EXPECT_EQ(text.str(), "1.234,5");
}

TEST_F(Locale, TheCommaOfCppStreamsChangesNoFileAndNoAnswer) {
  expectNothingChanges<test::CommaStreams>();
}

TEST_F(Locale, TheCommaOfPrintfChangesNoFileAndNoAnswer) {
  {
    const test::CommaPrintf comma;
    if (!comma.set()) GTEST_SKIP() << "no German locale, and no package `locales` to make one of";
    char text[16];
    std::snprintf(text, sizeof text, "%.1f", 1234.5);
    ASSERT_STREQ(text, "1234,5");
  }
  expectNothingChanges<test::CommaPrintf>();
}

}  // namespace
}  // namespace battery_sof
