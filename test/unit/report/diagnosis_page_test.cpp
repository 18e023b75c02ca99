#include "battery_sof/report/diagnosis_page.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "support/made_diagnosis.hpp"

namespace battery_sof {
namespace {

std::string pageOf(const test::MadeDiagnosis& made, bool zoomable = true) {
  return diagnosisPage(made.recording, made.diagnosis, zoomable);
}

/// The page's own HTML: without style and script elements.
std::string markupOf(const std::string& page) {
  std::string markup;
  std::size_t at = 0;
  while (at < page.size()) {
    const std::size_t begin = std::min(page.find("<script", at), page.find("<style", at));
    markup += page.substr(at, begin - at);
    if (begin == std::string::npos) break;
    at = page.find(page[begin + 2] == 'c' ? "</script>" : "</style>", begin);
  }
  return markup;
}

TEST(DiagnosisPage, LoadsNothing) {
  const std::string page = pageOf(test::madeNamed());
  const std::string markup = markupOf(page);
  EXPECT_EQ(markup.find("src="), std::string::npos);
  EXPECT_EQ(markup.find("href="), std::string::npos);
  EXPECT_EQ(page.find("@import"), std::string::npos);
  EXPECT_EQ(page.find("url("), std::string::npos);
  EXPECT_EQ(page.find("sourceMappingURL"), std::string::npos);
  EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
}

/// Tests of plots; Ubuntu 20.04 (ROS Noetic) has no package of the library.
class PlottedPage : public testing::Test {
 protected:
  void SetUp() override {
    if (hasPlotLibrary()) return;
    if (std::filesystem::exists("/opt/ros/noetic")) GTEST_SKIP() << "no package libjs-dygraphs here";
    FAIL() << "package libjs-dygraphs was not installed when this was built";
  }
};

TEST_F(PlottedPage, BringsTheLibraryAlong) {
  const std::string page = pageOf(test::madeNamed());
  for (const char* piece : {"Dygraph", "diagnosisPlots", "id=\"drive-data\"", "\"extended\":[", "plot-error", "Permission is hereby granted"})
    EXPECT_NE(page.find(piece), std::string::npos) << piece;
}

TEST(DiagnosisPage, EscapesWhatOthersNamed) {
  const std::string page = pageOf(test::madeNamed());
  EXPECT_EQ(page.find("<b>of</b>"), std::string::npos);
  EXPECT_NE(page.find("drive &lt;b&gt;of&lt;/b&gt; &quot;Monday&quot; &amp; &lt;/script&gt;"), std::string::npos);
}

TEST(DiagnosisPage, EscapesEverySentenceOfADiagnosis) {
  test::MadeDiagnosis made = test::madeUnknown();
  Diagnosis& d = made.diagnosis;
  const std::string evil = "<i>evil</i>";
  d.summary = d.next_experiment = d.learned->description = evil;
  d.learned->terms = d.instrument = d.outside = {evil};
  d.mismatch[0].regime = d.candidates[0].id = d.candidates[0].rejected_because = d.candidates[0].family = evil;
  d.regimes = {{evil, "mean", 5, 0.1, 0.0, 0.2, 0.01, true}};
  d.absorption = {{evil, evil, 5.0, 0.1}};
  d.fit.regimes = {{evil, 10, 0.1, 0.1, 0.0, -0.1, 0.1}};
  NamedEffect effect;
  effect.id = effect.family = evil;
  effect.absorbed_into = effect.tied_with = {evil};
  effect.parameters = {{evil, evil, 1.0, 0.1, 0.9, 1.1, false}};
  d.effects = {effect};
  d.detectable = {{evil, evil, evil, 1.0, 2.0, false}};
  EXPECT_EQ(pageOf(made).find("<i>evil"), std::string::npos);
}

TEST(DiagnosisPage, TellsWhatBecameWorse) {
  const std::string page = pageOf(test::madeNamed());
  EXPECT_NE(page.find("class=\"verdict-chip worse\""), std::string::npos);
  EXPECT_NE(page.find("class=\"verdict-chip better\""), std::string::npos);
}

TEST_F(PlottedPage, DrawsOneModelWhenNothingWasAdded) {
  const test::MadeDiagnosis made = test::madeNoMismatch();
  EXPECT_EQ(pageOf(made).find("\"extended\":["), std::string::npos);
  EXPECT_NE(pageOf(made).find("\"base\":["), std::string::npos);
}

TEST_F(PlottedPage, DrawsWhatWasLearntBesideTheBaseModel) {
  EXPECT_NE(pageOf(test::madeUnknown()).find("\"extended\":["), std::string::npos);
}

TEST(DiagnosisPage, TellsWhatWasLearntItsKindAndWhatItAddsUnderACurrent) {
  const std::string page = pageOf(test::madeUnknown());
  for (const char* piece : {"moves the voltage by 61.0 mV RMS", "It is in the extended model", "charging is limited by how fast",
                            "memory of charging over 10 s", "current of 20 A", "+113.0", "\xe2\x88\x92" "1.1"})
    EXPECT_NE(page.find(piece), std::string::npos) << piece;
}

TEST(DiagnosisPage, ComparesTheModelThatHoldsALearntForceWithTheBaseModel) {
  const std::string page = pageOf(test::madeUnknown());
  EXPECT_EQ(page.find("Nothing was added"), std::string::npos);
  EXPECT_NE(page.find("hold-out, extended"), std::string::npos);
}

TEST(DiagnosisPage, OfALearntForceThatForetellsNothingSaysThatItIsNotUsed) {
  test::MadeDiagnosis made = test::madeUnknown();
  made.diagnosis.learned->is_used = false;
  const std::string page = pageOf(made);
  EXPECT_NE(page.find("It is not used."), std::string::npos);
  EXPECT_EQ(page.find("memory of charging over 10 s"), std::string::npos);
}

TEST_F(PlottedPage, HoldsTheLowestVoltageOfALongDrive) {
  const test::MadeDiagnosis made = test::madeNamed();
  const auto& voltage = made.recording.series.voltage;
  char lowest[16];
  std::snprintf(lowest, sizeof lowest, "%.4f", *std::min_element(voltage.begin(), voltage.end()));
  std::string text = lowest;
  text.erase(text.find_last_not_of('0') + 1);
  EXPECT_NE(pageOf(made).find("," + text + ","), std::string::npos) << text;
}

TEST_F(PlottedPage, CountsTimeFromTheFirstSampleOfAClockThatCountsFrom1970) {
  test::MadeDiagnosis made = test::madeNamed();
  EXPECT_NE(pageOf(made).find("the recording\xe2\x80\x99s own clock"), std::string::npos);
  for (double& t : made.recording.series.time) t += 1.6e9;
  for (MismatchSegment& segment : made.diagnosis.mismatch) segment.from += 1.6e9, segment.to += 1.6e9;
  const std::string page = pageOf(made);
  EXPECT_NE(page.find("\"time\":[0,"), std::string::npos);
  EXPECT_NE(page.find("37.0 to 75.0 s"), std::string::npos);
}

TEST_F(PlottedPage, StaysSmallForADayOfDriving) {
  test::MadeDiagnosis made = test::madeNamed();
  Series& series = made.recording.series;
  test::Random random(1);
  for (long n = 0; n < 800000; ++n) {
    series.time.push_back(series.time.back() + 0.1);
    series.current.push_back(random.uniform(-300.0, 100.0));
    series.voltage.push_back(random.uniform(9.0, 15.0));
    made.diagnosis.base_voltage.push_back(random.uniform(9.0, 15.0));
    made.diagnosis.extended_voltage.push_back(random.uniform(9.0, 15.0));
  }
  EXPECT_LT(pageOf(made).size(), 3u << 20);
}

TEST(DiagnosisPage, OfTooLittleDataTellsWhy) {
  Diagnosis diagnosis;
  diagnosis.summary = "Only 3 samples.";
  EXPECT_NE(diagnosisPage({}, diagnosis).find("Only 3 samples."), std::string::npos);
}

TEST_F(PlottedPage, OfTooLittleDataShowsTheData) {
  EXPECT_NE(pageOf({test::madeNamed().recording, {}}).find("\"measured\":["), std::string::npos);
}

TEST(DiagnosisPage, DrawsWithoutTheLibraryAndSaysSo) {
  const std::string page = pageOf(test::madeNamed(), false);
  EXPECT_EQ(page.find("<script"), std::string::npos);
  EXPECT_NE(page.find("<svg"), std::string::npos);
  EXPECT_NE(page.find("libjs-dygraphs"), std::string::npos);
}

TEST(DiagnosisPage, RefusesVoltagesOfAnotherRecording) {
  test::MadeDiagnosis made = test::madeNamed();
  made.diagnosis.base_voltage.pop_back();
  EXPECT_THROW(pageOf(made), std::invalid_argument);
}

}  // namespace
}  // namespace battery_sof
