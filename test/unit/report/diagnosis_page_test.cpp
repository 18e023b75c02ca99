#include "report/diagnosis_page.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>

#include "report/page.hpp"
#include "report/results.hpp"
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

TEST(DiagnosisPage, SaysInTheHeadlinesSecondSentenceWhatTheVerdictMeansForTheBattery) {
  test::MadeDiagnosis made = test::madeNamed();
  for (const Verdict verdict : {Verdict::kEffect, Verdict::kSeveral, Verdict::kAmbiguous,
                                Verdict::kMechanism, Verdict::kUnexplained}) {
    made.diagnosis.verdict = verdict;
    const std::string markup = markupOf(pageOf(made));
    const std::string headline =
        markup.substr(markup.find("<h1>"), markup.find("</h1>") - markup.find("<h1>"));
    EXPECT_NE(
        headline.find(
            ". This is a shortcoming of the model and does not mean that the battery is faulty."),
        std::string::npos)
        << headline;
    EXPECT_NE(markup.find("missing from the model</p>"), std::string::npos) << toString(verdict);
  }
  made.diagnosis.verdict = Verdict::kSensorFault;
  EXPECT_NE(pageOf(made).find("the measurement or the wiring, not in the battery.</h1>"),
            std::string::npos);
}

TEST(DiagnosisPage, GivesNoVerdictTheColourOfAnAlarm) {
  const std::string page = kPageCss;
  const std::regex rule(R"(\.badge[^{]*\{[^}]*background: #(\w\w)(\w\w))");
  int rules = 0;
  for (std::sregex_iterator at(page.begin(), page.end(), rule), end; at != end; ++at, ++rules) {
    const int red = std::stoi((*at)[1], nullptr, 16), green = std::stoi((*at)[2], nullptr, 16);
    EXPECT_LT(red, 2 * green) << at->str();
  }
  EXPECT_GE(rules, 4);
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

/// Tests of plots; Ubuntu 20.04 (ROS Noetic) has no package of the library, and a build without ROS
/// need not have it.
class PlottedPage : public testing::Test {
 protected:
  void SetUp() override {
    if (hasPlotLibrary()) return;
    if (std::filesystem::exists("/opt/ros/noetic"))
      GTEST_SKIP() << "no package libjs-dygraphs here";
#ifdef BATTERY_SOF_WITHOUT_ROS
    GTEST_SKIP() << "package libjs-dygraphs was not installed when this was built";
#endif
    FAIL() << "package libjs-dygraphs was not installed when this was built";
  }
};

TEST_F(PlottedPage, BringsTheLibraryAlong) {
  const std::string page = pageOf(test::madeNamed());
  for (const char* piece : {"Dygraph", "diagnosisPlots", "id=\"drive-data\"", "\"extended\":[",
                            "plot-error", "Permission is hereby granted"})
    EXPECT_NE(page.find(piece), std::string::npos) << piece;
}

TEST(DiagnosisPage, ListsNothingWhereNoStrengthIsPromised) {
  test::MadeDiagnosis made = test::madeNoMismatch();
  for (DetectionLimit& one : made.diagnosis.detection_limits)
    one = {one.id, one.parameter, one.unit, std::nullopt, one.typical, false};
  made.diagnosis.unexplained.noise = 0.031;
  const std::string page = pageOf(made, false);
  EXPECT_NE(page.find("31.0 mV RMS remain unexplained"), std::string::npos);
  EXPECT_EQ(page.find("at no strength"), std::string::npos);
}

TEST(DiagnosisPage, EscapesWhatOthersNamed) {
  const std::string page = pageOf(test::madeNamed());
  EXPECT_EQ(page.find("<b>of</b>"), std::string::npos);
  EXPECT_NE(page.find("drive &lt;b&gt;of&lt;/b&gt; &quot;Monday&quot; &amp; &lt;/script&gt;"),
            std::string::npos);
}

TEST(DiagnosisPage, EscapesEverySentenceOfADiagnosis) {
  test::MadeDiagnosis made = test::madeUnknown();
  Diagnosis& d = made.diagnosis;
  const std::string evil = "<i>evil</i>";
  d.summary = d.next_experiment = d.discrepancy->description = d.source.summary =
      d.source.totals[0].reason = evil;
  // the nearest to what was estimated
  d.candidates.push_back({evil, 1.0, 0.0, evil, "acceptance"});
  d.discrepancy->terms = d.instrument = d.outside = {evil};
  d.mismatch[0].regime = d.candidates[0].id = d.candidates[0].rejected_because =
      d.candidates[0].mechanism = evil;
  d.regimes = {{evil, "mean", 5, 0.1, 0.0, 0.2, 0.01, true}};
  d.parameter_bias = {{evil, evil, 5.0, 0.1}};
  d.fit.regimes = {{evil, 10, 0.1, 0.1, 0.0, -0.1, 0.1}};
  NamedEffect effect;
  effect.id = effect.mechanism = evil;
  effect.biased_parameters = effect.indistinguishable_from = {evil};
  effect.parameters = {{evil, evil, 1.0, 0.1, 0.9, 1.1, false}};
  d.effects = {effect};
  d.detection_limits = {{evil, evil, evil, 1.0, 2.0, false}};
  EXPECT_EQ(pageOf(made).find("<i>evil"), std::string::npos);
}

TEST(DiagnosisPage, TellsWhatBecameWorse) {
  const std::string page = pageOf(test::madeNamed());
  EXPECT_NE(page.find("class=\"verdict-chip worse\""), std::string::npos);
  EXPECT_NE(page.find("class=\"verdict-chip better\""), std::string::npos);
}

TEST(DiagnosisPage, TheBetterOfTwoIsBoldWhicheverColumnItStandsIn) {
  test::MadeDiagnosis made = test::madeNamed();
  Comparison& fit = made.diagnosis.fit;
  fit.base_holdout.max_abs = 0.0123;
  fit.extended_holdout.max_abs = 0.0456;
  fit.base_holdout.q_dyn_percent = 61.3;
  fit.extended_holdout.q_dyn_percent = 78.9;
  const std::string markup = markupOf(pageOf(made));
  for (const char* better : {"<strong>12.3</strong>", "<strong>78.9</strong>"})
    EXPECT_NE(markup.find(better), std::string::npos) << better;
  for (const char* worse : {"<strong>45.6</strong>", "<strong>61.3</strong>"})
    EXPECT_EQ(markup.find(worse), std::string::npos) << worse;
}

TEST(DiagnosisPage, SaysOfWhatAProbabilityIs) {
  test::MadeDiagnosis made = test::madeNamed();
  made.diagnosis.candidates[0].confidence = 0.09;
  EXPECT_NE(markupOf(pageOf(made))
                .find("The probability that its mechanism is missing and that this equation "
                      "describes it is 9 %"),
            std::string::npos);
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
  for (const char* piece : {"moves the voltage by 61.0 mV RMS", "It is part of the extended model",
                            "charging is limited by how fast", "memory of charging over 10 s",
                            "current of 20 A", "+113.0",
                            "\xe2\x88\x92"
                            "1.1"})
    EXPECT_NE(page.find(piece), std::string::npos) << piece;
}

TEST(DiagnosisPage, ComparesTheModelThatHoldsALearntForceWithTheBaseModel) {
  const std::string page = pageOf(test::madeUnknown());
  EXPECT_EQ(page.find("Nothing was added"), std::string::npos);
  EXPECT_NE(page.find("hold-out, extended"), std::string::npos);
}

std::size_t countOf(const std::string& text, const std::string& piece) {
  std::size_t count = 0;
  for (std::size_t at = text.find(piece); at != std::string::npos; at = text.find(piece, at + 1))
    ++count;
  return count;
}

TEST(DiagnosisPage, DrawsALearntForceOverTimeAndOverTheCurrent) {
  const std::string markup = markupOf(pageOf(test::madeUnknown()));
  EXPECT_EQ(countOf(markup, "<figure class=\"chart\">"), 2u);
  EXPECT_EQ(countOf(markup, "<circle"), 4u + 5u);
  EXPECT_EQ(countOf(markup, "<rect"), 4u + 5u);
  EXPECT_EQ(countOf(markup, "stroke-dasharray"), 2u);
}

TEST(DiagnosisPage, DrawsABandWhereTheDeviationIsKnown) {
  test::MadeDiagnosis made = test::madeUnknown();
  // over time; the curve over the current has none here
  EXPECT_EQ(countOf(markupOf(pageOf(made)), "class=\"band\""), 2u);
  EXPECT_NE(pageOf(made).find("The bands are 95 % intervals"), std::string::npos);
  for (DiscrepancyAnswer& one : made.diagnosis.discrepancy->answers)
    one.charging_std.reset(), one.discharging_std.reset();
  EXPECT_EQ(countOf(markupOf(pageOf(made)), "class=\"band\""), 0u);
  EXPECT_EQ(pageOf(made).find("The bands are 95 % intervals"), std::string::npos);
}

TEST(DiagnosisPage, ABandOfVoltsWidensNoChart) {
  test::MadeDiagnosis made = test::madeUnknown();
  for (DiscrepancyAnswer& one : made.diagnosis.discrepancy->answers)
    one.charging_std = one.discharging_std = 3.0;
  const std::string markup = markupOf(pageOf(made));
  EXPECT_EQ(countOf(markup, "class=\"band\""), 2u);
  for (const char* tick : {">1000<", ">2000<", ">5000<"})
    EXPECT_EQ(markup.find(tick), std::string::npos) << tick;
}

TEST(DiagnosisPage, DrawsADecadeOfTimeAsWideAsTheNext) {
  const std::string markup = markupOf(pageOf(test::madeUnknown()));
  for (const char* at : {"cx=\"56.0\"", "cx=\"246.7\"", "cx=\"437.3\"", "cx=\"628.0\""})
    EXPECT_NE(markup.find(at), std::string::npos) << at;
}

TEST(DiagnosisPage, DrawsNoPointThatIsNotANumberAndNoChartOfOnePoint) {
  test::MadeDiagnosis made = test::madeUnknown();
  made.diagnosis.discrepancy->curve[2].early = std::nan("");
  EXPECT_EQ(countOf(markupOf(pageOf(made)), "<circle"), 4u + 4u);
  EXPECT_EQ(countOf(markupOf(pageOf(made)), "<rect"), 4u + 5u);
  made.diagnosis.discrepancy->answers.resize(1);
  made.diagnosis.discrepancy->curve.clear();
  EXPECT_EQ(countOf(markupOf(pageOf(made)), "<figure class=\"chart\">"), 0u);
}

TEST(DiagnosisPage, NamesTheNearestEquationOfTheFamilyThatALearntForceFollows) {
  test::MadeDiagnosis made = test::madeUnknown();
  EXPECT_NE(pageOf(made).find("No equation of this mechanism was tested."), std::string::npos);
  made.diagnosis.candidates.push_back({"sulphate_history", 12.0, 0.0, "too little", "acceptance"});
  made.diagnosis.candidates.push_back(
      {"charge_acceptance", 31.0, 0.0, "leaves what matters", "acceptance"});
  EXPECT_NE(pageOf(made).find("<code>charge_acceptance</code> (evidence 31; leaves what matters)."),
            std::string::npos);
}

TEST(DiagnosisPage, OfALearntForceThatForetellsNothingSaysThatItIsNotUsed) {
  test::MadeDiagnosis made = test::madeUnknown();
  made.diagnosis.discrepancy->is_used = false;
  const std::string page = markupOf(pageOf(made));
  EXPECT_NE(page.find("It is not used."), std::string::npos);
  EXPECT_EQ(page.find("memory of charging over 10 s"), std::string::npos);
}

/// Of a page: its one line of JSON that begins with a name.
std::string dataOf(const std::string& page, const std::string& name) {
  const std::size_t begin = page.find("\n\"" + name + "\":");
  return begin == std::string::npos
             ? ""
             : page.substr(begin + 1, page.find('\n', begin + 1) - begin - 1);
}

TEST_F(PlottedPage, DrawsWhereASourceImposesTheVoltage) {
  const test::MadeDiagnosis made = test::madeNamed();
  EXPECT_EQ(dataOf(pageOf(made), "controlled").rfind("\"controlled\":[[25.8,75],[175.8,225]", 0),
            0u)
      << dataOf(pageOf(made), "controlled");
  EXPECT_NE(pageOf(made).find("hatched: a source controls the voltage (8 stretches)"),
            std::string::npos);
}

TEST(DiagnosisPage, TellsTheSharesOfWhatIsImposedInWords) {
  const test::MadeDiagnosis made = test::madeNamed();
  const double share = 100.0 * made.diagnosis.source.share;
  char words[120];
  std::snprintf(
      words, sizeof words,
      "aria-label=\"voltage controlled %.1f %%, current controlled %.1f %% of the samples\"", share,
      100.0 - share);
  for (const bool zoomable : {true, false}) {
    const std::string markup = markupOf(pageOf(made, zoomable));
    for (const std::string& piece : std::vector<std::string>{
             words, "class=\"strip\"", "the voltage is held while the current moves",
             "A source holds the voltage"})
      EXPECT_NE(markup.find(piece), std::string::npos) << piece;
  }
}

TEST(DiagnosisPage, WithoutASourceDrawsNoShareAndNoStretch) {
  test::MadeDiagnosis made = test::madeNamed();
  made.diagnosis.source = {
      false,
      0.0,
      "Nothing charges the battery, so the current is controlled throughout.",
      {{"nothing in the recording charges the battery", ControlMode::kCurrent, 1, 10}},
      {}};
  for (const bool zoomable : {true, false}) {
    const std::string markup = markupOf(pageOf(made, zoomable));
    EXPECT_NE(markup.find("Nothing charges the battery"), std::string::npos);
    EXPECT_EQ(markup.find("class=\"strip\""), std::string::npos);
    EXPECT_EQ(markup.find("swatch controlled"), std::string::npos);
  }
}

TEST(DiagnosisPage, DrawsWhatIsImposedWithoutTheLibraryToo) {
  test::MadeDiagnosis made = test::madeNamed();
  const auto feetOf = [](const std::string& page) {
    const std::size_t begin = page.find("class=\"foot\" d=\"");
    const std::string feet =
        begin == std::string::npos ? "" : page.substr(begin, page.find('>', begin) - begin);
    return std::count(feet.begin(), feet.end(), 'z');
  };
  EXPECT_EQ(feetOf(pageOf(made, false)), 8);
  made.diagnosis.source.times.clear();
  EXPECT_EQ(feetOf(pageOf(made, false)), 0);
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
  for (MismatchSegment& segment : made.diagnosis.mismatch)
    segment.from += 1.6e9, segment.to += 1.6e9;
  const std::string page = pageOf(made);
  EXPECT_NE(page.find("\"time\":[0,"), std::string::npos);
  EXPECT_NE(page.find("37.0 to 75.0 s"), std::string::npos);
}

TEST_F(PlottedPage, StaysSmallForADayOfDriving) {
  test::MadeDiagnosis made = test::madeNamed();
  Series& series = made.recording.series;
  test::Random random(1);
  for (long n = 0; n < 800000; ++n) {
    series.append(
        {series.time.back() + 0.1, random.uniform(-300.0, 100.0), random.uniform(9.0, 15.0)});
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
  EXPECT_EQ(countOf(page, "<script"), countOf(page, "<script type=\"application/json\""));
  EXPECT_NE(page.find("<svg"), std::string::npos);
  EXPECT_NE(page.find("libjs-dygraphs"), std::string::npos);
}

TEST(DiagnosisPage, HoldsTheResultAsJsonWhateverItsTextsSay) {
  test::MadeDiagnosis made = test::madeNamed();
  made.diagnosis.summary = "</script><script>alert(1)</script><!--";
  for (const bool zoomable : {false, true}) {
    const std::string page = pageOf(made, zoomable);
    const std::string begin = "<script type=\"application/json\" id=\"result\">";
    ASSERT_EQ(countOf(page, begin), 1u);
    const std::size_t from = page.find(begin) + begin.size();
    const std::string held = page.substr(from, page.find("</script>", from) - from);
    EXPECT_EQ(held.find('<'), std::string::npos);
    EXPECT_EQ(nlohmann::json::parse(held), resultJson(made.diagnosis));
  }
}

TEST(DiagnosisPage, RefusesVoltagesOfAnotherRecording) {
  test::MadeDiagnosis made = test::madeNamed();
  made.diagnosis.base_voltage.pop_back();
  EXPECT_THROW(pageOf(made), std::invalid_argument);
}

}  // namespace
}  // namespace battery_sof
