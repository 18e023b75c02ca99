#include "diagnosis/change.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "diagnosis/model_distance.hpp"
#include "diagnosis/response_comparison.hpp"
#include "diagnosis/response_table.hpp"
#include "prediction/scores.hpp"
#include "support/start_stop.hpp"
#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

using test::startStopDrive;
using test::StartStopOptions;

/// A trip at 1 Hz of a battery with fresh sulphate, of 45 minutes with about thirty engine starts.
/// @param other a battery of half the resistances, which takes a third of the charge current.
Series trip(std::uint64_t seed, double duration = 2700.0, bool other = false) {
  const BatteryModel model({"fresh_sulphate"});
  StartStopOptions options;
  options.duration = duration;
  options.lowest = 12.6;
  options.current_noise = 0.1;
  options.voltage_noise = 0.01;
  options.seed = seed;
  Eigen::VectorXd battery = test::freshBattery(model);
  if (other) {
    for (const char* name : {"r_discharge", "r_charge"}) battery[*model.parameterRow(name)] *= 0.5;
    battery[*model.parameterRow("fresh_exchange_current")] /= 3.0;
  }
  return startStopDrive(model, battery, options).series;
}

Series withContact(Series series, double resistance) {
  for (std::size_t n = 0; n < series.size(); ++n)
    series.voltage[n] += resistance * series.current[n];
  return series;
}

Series withLateCurrent(Series series, std::size_t rows) {
  const std::vector<double> current = series.current;
  for (std::size_t n = rows; n < series.size(); ++n) series.current[n] = current[n - rows];
  return series;
}

Series withLateVoltage(Series series, std::size_t rows) {
  const std::vector<double> voltage = series.voltage;
  for (std::size_t n = rows; n < series.size(); ++n) series.voltage[n] = voltage[n - rows];
  return series;
}

Series withOffset(Series series, double offset) {
  for (double& current : series.current) current += offset;
  return series;
}

Series withLaggingCurrent(Series series, double constant) {
  const double kept = std::exp(-1.0 / constant);
  for (std::size_t n = 1; n < series.size(); ++n)
    series.current[n] = kept * series.current[n - 1] + (1.0 - kept) * series.current[n];
  return series;
}

ChangeDiagnosis responsesOf(const Series& now, const Series& then) {
  ChangeOptions options;
  options.runs_models = false;
  return diagnoseChange({now}, {{then}, {}}, options);
}

constexpr std::uint64_t kTrips = 10;

TEST(Changes, AreSaidOfAtMostOneInTenSoundTrips) {
  const Series then = trip(1);
  int changed = 0;
  for (std::uint64_t seed = 2; seed < 2 + kTrips; ++seed) {
    const ChangeDiagnosis found = responsesOf(trip(seed), then);
    EXPECT_NE(found.verdict, ChangeVerdict::kInsufficientData) << found.summary;
    changed += found.verdict == ChangeVerdict::kChanged;
  }
  EXPECT_LE(changed, 1);
}

/// A model that holds what its file keeps of a recording, and nothing that could be run.
FittedModel keptOf(const Series& series) {
  FittedModel model;
  model.responses = responseTable(series);
  return model;
}

TEST(Changes, AgainstAModelFileAreThoseAgainstItsRecording) {
  const Series then = trip(1);
  const FittedModel kept = keptOf(then);
  ASSERT_TRUE(kept.responses);
  ChangeOptions options;
  options.runs_models = false;
  for (std::uint64_t seed = 2; seed < 6; ++seed)
    for (const Series& now : {trip(seed), withContact(trip(seed), 0.004),
                              withOffset(trip(seed), 1.2), withLateCurrent(trip(seed), 2)}) {
      const ChangeDiagnosis one = responsesOf(now, then);
      const ChangeDiagnosis other = diagnoseChange({now}, {{}, {kept}}, options);
      EXPECT_EQ(one.verdict, other.verdict) << one.summary << "\n" << other.summary;
      ASSERT_EQ(one.changes.size(), other.changes.size());
      if (one.changes.empty()) continue;
      EXPECT_EQ(one.changes[0].id, other.changes[0].id);
      EXPECT_NEAR(one.changes[0].now, other.changes[0].now, 0.1 * std::abs(one.changes[0].now));
    }
}

/// A logger that looks at the voltage a row late shows a contact's voltage late, too.
TEST(Changes, OfAContactAreNamedWhereTheVoltageIsLate) {
  const Series then = withLateVoltage(trip(1), 1);
  const FittedModel kept = keptOf(then);
  ChangeOptions options;
  options.runs_models = false;
  for (std::uint64_t seed = 2; seed < 6; ++seed) {
    const Series now = withLateVoltage(withContact(trip(seed), 0.006), 1);
    for (const ChangeDiagnosis& found :
         {responsesOf(now, then), diagnoseChange({now}, {{}, {kept}}, options)}) {
      ASSERT_EQ(found.changes.size(), 1U) << found.summary;
      EXPECT_EQ(found.changes[0].id, "contact_resistance") << found.summary;
      EXPECT_LT(found.changes[0].lower, 0.006);
      EXPECT_GT(found.changes[0].upper, 0.006);
    }
  }
}

TEST(Changes, AgainstAModelFileWithoutResponsesAreNotJudged) {
  const ChangeDiagnosis found = diagnoseChange({trip(1)}, {{}, {FittedModel()}});
  EXPECT_EQ(found.verdict, ChangeVerdict::kInsufficientData);
  EXPECT_NE(found.summary.find("a model file without the responses of its recording"),
            std::string::npos)
      << found.summary;
}

/// The reference with the responses of drives since, each with a contact.
std::shared_ptr<const ResponseTable> afterDrives(std::uint64_t first, std::uint64_t last,
                                                 double contact) {
  auto table = std::make_shared<ResponseTable>(*responseTable(trip(1)));
  table->since.emplace();
  for (std::uint64_t seed = first; seed <= last; ++seed)
    table->since->add(
        responseFeatures(responseRows(withContact(trip(seed), contact)), table->scale));
  return table;
}

TEST(Changes, OfDrivesSinceAReferenceAreThoseOfTheirMean) {
  EXPECT_EQ(diagnoseChange(afterDrives(2, 4, 0.0)).verdict, ChangeVerdict::kNoChange);
  const ChangeDiagnosis found = diagnoseChange(afterDrives(2, 4, 0.004));
  ASSERT_EQ(found.verdict, ChangeVerdict::kChanged) << found.summary;
  EXPECT_EQ(found.changes[0].id, "contact_resistance");
  EXPECT_LT(found.changes[0].lower, 0.004);
  EXPECT_GT(found.changes[0].upper, 0.004);
}

TEST(Changes, AreNotSaidBeforeADriveWasCompared) {
  const ChangeDiagnosis found = diagnoseChange(responseTable(trip(1)));
  EXPECT_EQ(found.verdict, ChangeVerdict::kInsufficientData);
  EXPECT_NE(found.summary.find("no drive has been compared"), std::string::npos) << found.summary;
  EXPECT_EQ(diagnoseChange(nullptr).verdict, ChangeVerdict::kInsufficientData);
}

/// Drives that differ among themselves by as much as the reference differs from their mean.
TEST(Changes, OfDrivesThatScatterAsWidelyAreNone) {
  auto table = std::make_shared<ResponseTable>(*responseTable(trip(1)));
  table->since.emplace();
  for (std::uint64_t seed = 2; seed < 8; ++seed)
    table->since->add(responseFeatures(
        responseRows(withContact(trip(seed), seed % 2 == 0 ? 0.004 : 0.0)), table->scale));
  EXPECT_EQ(diagnoseChange(table).verdict, ChangeVerdict::kNoChange);
  auto steady = std::make_shared<ResponseTable>(*table);
  steady->since->scatter.setZero();
  EXPECT_EQ(diagnoseChange(steady).verdict, ChangeVerdict::kChanged);
}

/// A change raises what the drives differ by, and is seen all the same.
TEST(Changes, OfALateDriveIsNoScatter) {
  auto table = std::make_shared<ResponseTable>(*afterDrives(2, 3, 0.0));
  table->since->add(responseFeatures(responseRows(withContact(trip(4), 0.02)), table->scale));
  const ChangeDiagnosis found = diagnoseChange(table);
  ASSERT_EQ(found.verdict, ChangeVerdict::kChanged) << found.summary;
  EXPECT_EQ(found.changes[0].id, "contact_resistance");
}

/// What is learnt from drives with these contacts, one after the other.
std::shared_ptr<const ResponseTable> drivesWith(const std::vector<double>& contacts) {
  std::shared_ptr<const ResponseTable> reference;
  std::uint64_t seed = 1;
  for (const double contact : contacts)
    reference = withDrive(reference, withContact(trip(seed++), contact));
  return reference;
}

TEST(Changes, AreSaidOnceFiveDrivesMakeUpTheReference) {
  for (std::size_t drives = 1; drives <= kSoundDrives; ++drives) {
    const ChangeDiagnosis found = diagnoseChange(drivesWith(std::vector<double>(drives, 0.0)));
    EXPECT_EQ(found.verdict, ChangeVerdict::kInsufficientData);
    EXPECT_NE(found.summary.find(std::to_string(drives) + " of the 5 drives are known"),
              std::string::npos)
        << found.summary;
  }
  EXPECT_EQ(diagnoseChange(drivesWith(std::vector<double>(8, 0.0))).verdict,
            ChangeVerdict::kNoChange);
  const ChangeDiagnosis worse = diagnoseChange(drivesWith({0, 0, 0, 0, 0, 0, 0.01, 0.01}));
  ASSERT_EQ(worse.verdict, ChangeVerdict::kChanged) << worse.summary;
  EXPECT_EQ(worse.changes[0].id, "contact_resistance");
}

/// One drive as the reference cannot know what five show: that they differ by this much.
TEST(Changes, WithinWhatTheReferencesDrivesDifferByAreNone) {
  const std::vector<double> unsteady = {0.004, 0.0, 0.008, 0.0, 0.008, 0.008, 0.008};
  EXPECT_EQ(diagnoseChange(drivesWith(unsteady)).verdict, ChangeVerdict::kNoChange);
  auto steady = std::make_shared<ResponseTable>(*drivesWith(unsteady));
  steady->sound->scatter.setZero();
  EXPECT_EQ(diagnoseChange(steady).verdict, ChangeVerdict::kChanged);
}

TEST(ResponseTable, OfSeveralDrivesHasTheirMean) {
  const auto one = drivesWith({0.0}), all = drivesWith({0.0, 0.005, 0.005});
  const auto resistance = [](const std::shared_ptr<const ResponseTable>& table, double contact) {
    return featuresWith(*table, ChangeKind::kContact, contact).value[kEdgeResistance];
  };
  EXPECT_EQ(resistance(one, 0.0), one->unchanged.value[kEdgeResistance]);
  EXPECT_NEAR(resistance(all, 0.0) - resistance(one, 0.0), 2.0 / 3.0 * 0.005, 5e-4);
  EXPECT_NEAR(resistance(all, 0.004) - resistance(all, 0.0), 0.004, 5e-4);
  EXPECT_LT(featuresWith(*all, ChangeKind::kContact, 0.0).covariance(0, 0),
            one->unchanged.covariance(0, 0));
}

TEST(ResponseTable, IsLeftAsItIsByADriveThatCannotServe) {
  EXPECT_FALSE(withDrive(drivesWith({0.0}), slice(trip(2), {0, 200})));
  EXPECT_FALSE(withDrive(nullptr, slice(trip(2), {0, 200})));
}

TEST(RecentResponses, KnowByHowMuchDrivesDiffer) {
  ResponseFeatures one;
  one.known.fill(true);
  RecentResponses recent;
  for (int drive = 0; drive < 4; ++drive) {
    one.value.setConstant(drive % 2 == 0 ? 1.0 : 3.0);
    recent.add(one);
  }
  EXPECT_NEAR(recent.scatter[0], 1.0, 1e-12);
}

/// Steps of 25 mV show changes of 1.5 A as none or as 17 mOhm: the large ones say what it is.
TEST(ResponseFeatures, OfSmallEdgesUnderACoarseVoltageCountLittle) {
  for (const double resistance : {0.005, 0.007, 0.010}) {
    test::Random random(5);
    Series series;
    double current = -10.0;
    for (int n = 0; n < 2400; ++n) {
      if (n % 3 == 0) current = n % 2 == 0 ? -10.0 : -11.5;
      if (n % 60 == 0) current = -30.0 - 10.0 * random.uniform(0.0, 1.0);
      const double voltage = 12.5 + 0.3 * std::sin(n / 200.0) + resistance * current;
      series.append({static_cast<double>(n), current + 0.01 * random.normal(),
                     0.025 * std::round(voltage / 0.025)});
    }
    ResponseScale scale;
    scale.current = 0.12;  // changes of 1 A and more
    const ResponseFeatures found = responseFeatures(responseRows(series), scale);
    ASSERT_TRUE(found.known[kEdgeResistance]);
    EXPECT_NEAR(found.value[kEdgeResistance], resistance, 1e-4);
    EXPECT_LT(std::sqrt(found.covariance(kEdgeResistance, kEdgeResistance)), 1e-4);
  }
}

/// The instants of a logger's channels are a part of a row further apart in one trip than in another:
/// that moves all of the pulse response together.
TEST(ResponseComparison, APartOfARowBetweenTheChannelsIsNoChange) {
  const auto table = responseTable(trip(1));
  const auto distance = [&](double sign_of_odd) {
    ResponseTable with = *table;
    ResponseFeatures drive = table->unchanged;
    for (int tap = 0; tap < kTaps; ++tap) {
      const int row = kFirstTap + tap;
      const double before = tap > 0 ? table->unchanged.value[row - 1] : 0.0;
      drive.value[row] +=
          0.3 * (tap % 2 == 0 ? 1.0 : sign_of_odd) * (before - table->unchanged.value[row]);
    }
    with.since.emplace().add(drive);
    return ResponseComparison(std::make_shared<const ResponseTable>(with)).nothing();
  };
  EXPECT_LT(distance(1.0), 1.5);
  EXPECT_GT(distance(-1.0), 2.0 * distance(1.0));
}

/// What would be detected follows from the later recording, too.
TEST(ResponseComparison, ANoisierRecordingShowsLargerChangesOnly) {
  const auto limitOf = [](double noise) {
    Series now = trip(3);
    test::Random random(7);
    for (double& voltage : now.voltage) voltage += noise * random.normal();
    const ResponseComparison comparison({now}, {{trip(1)}, {}});
    return visibleStrength(comparison, candidateChanges().front(), 7.0);
  };
  EXPECT_GT(limitOf(0.4), 1.1 * limitOf(0.0));
}

TEST(RecentResponses, WeighTheNewestByAFifthAndForgetTheOldest) {
  ResponseFeatures one;
  one.known.fill(true);
  one.covariance.setIdentity();
  RecentResponses recent;
  for (int drive = 0; drive < 3; ++drive) {
    one.value.setConstant(drive);
    recent.add(one);
  }
  EXPECT_DOUBLE_EQ(recent.mean.value[0], 1.0);
  EXPECT_NEAR(recent.squares, 1.0 / 3.0, 1e-12);
  EXPECT_NEAR(recent.mean.covariance(0, 0), 1.0 / 3.0, 1e-12);
  one.value.setConstant(10.0);
  one.known[kBlockedCurrent] = false;
  for (int drive = 0; drive < 30; ++drive) recent.add(one);
  EXPECT_NEAR(recent.mean.value[0], 10.0, 0.02);
  EXPECT_DOUBLE_EQ(recent.mean.value[kBlockedCurrent], 1.0);
  EXPECT_NEAR(recent.squares, 1.0 / 9.0, 1e-3);
  EXPECT_EQ(recent.drives, 33u);
}

struct Named {
  int first_or_alike = 0, interval_holds = 0;
};

template <typename Change>
Named namedOf(const std::string& id, double strength, Change&& change) {
  const Series then = trip(1);
  Named named;
  for (std::uint64_t seed = 2; seed < 2 + kTrips; ++seed) {
    const ChangeDiagnosis found = responsesOf(change(trip(seed)), then);
    if (found.changes.empty()) continue;
    const auto& first = found.changes.front();
    const auto& alike = first.indistinguishable;
    named.first_or_alike +=
        first.id == id || std::find(alike.begin(), alike.end(), id) != alike.end();
    named.interval_holds += first.id == id && first.lower <= strength && strength <= first.upper;
  }
  return named;
}

TEST(Changes, AreShownBesideAModelThatHasNotSeenTheLastQuarter) {
  Series now = trip(3);
  const IndexRange quarter{now.size() - now.size() / 4, now.size()};
  const Series before = slice(now, {0, quarter.first});
  for (std::size_t n = quarter.first; n < quarter.last; ++n) now.current[n] *= 0.3;
  const ChangeReference then{{trip(4)}, {}};
  const auto of_before = diagnoseChange({before}, then).model;
  const auto of_all = diagnoseChange({now}, then);
  ASSERT_TRUE(of_before && of_all.model);
  const auto shareOf = [&](const FittedModel& model) {
    return predictRange(model, now, quarter).report.both_ways.value().mixed.share_percent;
  };
  EXPECT_NEAR(of_all.own_model.share_percent.value(), shareOf(*of_before).value(), 0.5);
  EXPECT_GT(std::abs(shareOf(*of_all.model).value() - shareOf(*of_before).value()), 2.0);
}

TEST(Changes, AreNotSaidOfAnotherBatteryWhoseModelMissesTheRecording) {
  constexpr double kDuration = 7200.0;
  const ChangeReference then{{trip(1, kDuration)}, {}};
  const ChangeDiagnosis other = diagnoseChange({trip(2, kDuration, true)}, then);
  EXPECT_EQ(other.verdict, ChangeVerdict::kAnotherBattery) << other.summary;
  EXPECT_TRUE(other.changes.empty());
  EXPECT_GT(other.model_distance.value(), other.largest_model_distance.value());
  const ChangeDiagnosis same = diagnoseChange({trip(2, kDuration)}, then);
  EXPECT_EQ(same.verdict, ChangeVerdict::kNoChange) << same.summary;
  EXPECT_LT(same.model_distance.value(), 0.3);
  const ChangeDiagnosis reverse = diagnoseChange(then.recordings, {{trip(2, kDuration)}, {}});
  EXPECT_NEAR(reverse.model_distance.value(), same.model_distance.value(), 1e-9);
}

TEST(Changes, ThatAreClearAreNoOtherBattery) {
  constexpr double kDuration = 7200.0;
  const ChangeReference then{{trip(1, kDuration)}, {}};
  const ChangeDiagnosis late = diagnoseChange({withLateCurrent(trip(2, kDuration), 3)}, then);
  EXPECT_EQ(late.verdict, ChangeVerdict::kChanged) << late.summary;
  EXPECT_LT(late.model_distance.value(), 0.5);
}

TEST(ModelDistance, OfOneBatteryMayBeLargerWhereARecordingIsShort) {
  const auto lasting = [](double duration) { return Series{{0.0, duration}, {}, {}, {}, {}}; };
  EXPECT_DOUBLE_EQ(largestDistance(lasting(1500.0), lasting(6000.0), false), 2.0);
  EXPECT_DOUBLE_EQ(largestDistance(lasting(6000.0), lasting(1500.0), true), 2.0);
  EXPECT_DOUBLE_EQ(largestDistance(lasting(60000.0), lasting(70000.0), false), 0.7);
  EXPECT_DOUBLE_EQ(largestDistance(lasting(60000.0), lasting(70000.0), true), 1.0);
}

TEST(Changes, OfAModelMayBeLargerWhereARecordingIsShort) {
  const Series now = trip(2, 600.0, true);
  const ChangeDiagnosis other = diagnoseChange({now}, {{trip(1)}, {}});
  EXPECT_GT(other.model_distance.value(), 0.5);
  EXPECT_NEAR(other.largest_model_distance.value(), std::sqrt(6000.0 / now.time.back()), 1e-9);
  EXPECT_NE(other.verdict, ChangeVerdict::kAnotherBattery) << other.summary;
}

TEST(Changes, OfAContactAreNamedWithTheirStrength) {
  const Named named = namedOf("contact_resistance", 0.004,
                              [](const Series& series) { return withContact(series, 0.004); });
  EXPECT_GE(named.first_or_alike, 9);
  EXPECT_GE(named.interval_holds, 8);
}

TEST(Changes, OfTheCurrentsZeroAreNamedWithTheirStrength) {
  const Named named =
      namedOf("current_offset", 1.2, [](const Series& series) { return withOffset(series, 1.2); });
  EXPECT_GE(named.first_or_alike, 9);
  EXPECT_GE(named.interval_holds, 8);
}

TEST(Changes, OfADelayAreNamedWithTheSignOfTimeSkew) {
  const Named named =
      namedOf("time_skew", -2.0, [](const Series& series) { return withLateCurrent(series, 2); });
  EXPECT_GE(named.first_or_alike, 9);
  EXPECT_GE(named.interval_holds, 9);
}

TEST(Changes, OfALagOfTheCurrentAreNamedWithTheSignOfSensorLag) {
  const Named named = namedOf("sensor_lag", -2.0,
                              [](const Series& series) { return withLaggingCurrent(series, 2.0); });
  EXPECT_GE(named.first_or_alike, 9);
}

TEST(Changes, OfAContactCannotBeToldFromTheBatterysOwnResistance) {
  const ChangeDiagnosis found = responsesOf(withContact(trip(2), 0.006), trip(1));
  ASSERT_EQ(found.changes.size(), 1u);
  EXPECT_EQ(found.changes.front().mechanism, "instrument");
  const auto& alike = found.changes.front().indistinguishable;
  EXPECT_NE(std::find(alike.begin(), alike.end(), "r_discharge"), alike.end());
}

TEST(Changes, OfTwoKindsAtOnceAreBothNamed) {
  int both = 0, second_of_one = 0;
  const Series then = trip(1);
  for (std::uint64_t seed = 2; seed < 2 + kTrips; ++seed) {
    const ChangeDiagnosis two = responsesOf(withOffset(withContact(trip(seed), 0.006), 1.5), then);
    const auto isNamed = [&](const char* id) {
      return std::any_of(two.changes.begin(), two.changes.end(),
                         [&](const Change& one) { return one.id == id; });
    };
    both += isNamed("contact_resistance") && isNamed("current_offset");
    EXPECT_LE(two.changes.size(), 2u);
    second_of_one += responsesOf(withContact(trip(seed), 0.006), then).changes.size() == 2;
  }
  EXPECT_GE(both, 8);
  EXPECT_LE(second_of_one, 1);
}

TEST(Changes, AmongTheReferencesAreSaidOfTheOneThatDiffersMost) {
  ChangeOptions options;
  options.runs_models = false;
  const auto summaryOf = [&](const Series& third) {
    return diagnoseChange({trip(2)}, {{trip(1), trip(4), third}, {}}, options).summary;
  };
  EXPECT_EQ(summaryOf(trip(5)).find("do not agree"), std::string::npos) << summaryOf(trip(5));
  const std::string summary = summaryOf(withContact(trip(5), 0.006));
  EXPECT_NE(summary.find("in recording 3 of them, compared with the others, the ohmic resistance"),
            std::string::npos)
      << summary;
  EXPECT_NE(summary.find("higher"), std::string::npos) << summary;
}

TEST(Changes, OfSeveralTripsAreNamedAtASmallerStrength) {
  const auto limitOf = [](const std::vector<Series>& now, const std::vector<Series>& then) {
    ChangeOptions options;
    options.runs_models = false;
    for (const ChangeLimit& limit : diagnoseChange(now, {then, {}}, options).detection_limits)
      if (limit.id == "contact_resistance") return limit.strength;
    return HUGE_VAL;
  };
  EXPECT_LT(limitOf({trip(2), trip(3)}, {trip(1), trip(4)}), limitOf({trip(2)}, {trip(1)}));
}

TEST(Changes, OfAShortRecordingAreNotJudged) {
  Series part = trip(2);
  part = slice(part, {0, 200});
  const ChangeDiagnosis found = responsesOf(part, trip(1));
  EXPECT_EQ(found.verdict, ChangeVerdict::kInsufficientData);
  EXPECT_NE(found.summary.find("the recording has 200 samples"), std::string::npos)
      << found.summary;
}

TEST(Changes, NeedARecordingAndAReference) {
  EXPECT_THROW(diagnoseChange({}, {{trip(1)}, {}}), std::invalid_argument);
  EXPECT_THROW(diagnoseChange({trip(1)}, {}), std::invalid_argument);
}

TEST(ResponseFeatures, FindTheResistanceAtEdgesAndTheRowOfTheLargestResponse) {
  const ResponseRows rows = responseRows(withContact(trip(3), 0.003));
  const ResponseScale scale = responseScale(withCurrentMoved(rows, 1));
  EXPECT_EQ(scale.moved, -1);
  const ResponseFeatures plain = responseFeatures(responseRows(trip(3)), {});
  const ResponseFeatures more = responseFeatures(rows, {});
  ASSERT_TRUE(plain.known[kEdgeResistance]);
  EXPECT_NEAR(more.value[kEdgeResistance] - plain.value[kEdgeResistance], 0.003, 2e-4);
}

TEST(ResponseTable, IsExactAtItsStrengthsAndCloseBetweenThem) {
  const Series series = trip(3);
  const auto table = responseTable(series);
  ASSERT_TRUE(table);
  const ResponseRows rows = responseRows(series);
  for (const auto& [kind, strength] : {std::pair(ChangeKind::kContact, 0.004),
                                       {ChangeKind::kContact, 0.0051},
                                       {ChangeKind::kGain, -0.08},
                                       {ChangeKind::kOffset, 1.0},
                                       {ChangeKind::kSkew, 2.0},
                                       {ChangeKind::kLag, -1.6},
                                       {ChangeKind::kLag, 0.5}}) {
    const ResponseFeatures exact = responseFeatures(withChange(rows, kind, strength), table->scale);
    const ResponseFeatures kept = featuresWith(*table, kind, strength);
    for (int k = 0; k < kResponseFeatures; ++k) {
      if (!kept.known[k]) continue;
      const double unit = k < kBlockedCurrent ? 4e-4 : k == kBlockedCurrent ? 0.1 : 0.03;
      EXPECT_NEAR(kept.value[k], exact.value[k], unit) << featureId(k) << " " << strength;
    }
  }
}

TEST(ResponseTable, OfARecordingThatCannotServeIsNone) {
  EXPECT_FALSE(responseTable(slice(trip(1), {0, 200})));
  Series quiet = trip(1);
  for (double& current : quiet.current) current = -5.0;
  EXPECT_FALSE(responseTable(quiet, true));
}

TEST(ResponseFeatures, OfTooFewRowsAreUnknown) {
  EXPECT_EQ(responseFeatures(ResponseRows(), {}).count(), 0u);
  EXPECT_EQ(responseFeatures(responseRows(slice(trip(1), {0, 40})), {}).count(), 0u);
}

}  // namespace
}  // namespace battery_sof
