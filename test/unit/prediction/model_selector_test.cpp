#include "prediction/model_monitor.hpp"

#include <gtest/gtest.h>

#include "support/known_model.hpp"

namespace battery_sof {
namespace {

using namespace test;

/// Two resting models, 12.7 V and 12.7 V + `off`, and a voltage that is right for one of them.
class Rivals {
 public:
  explicit Rivals(double off) : off_(off), base_(EventLimits()), extended_(EventLimits()) {
    FittedModel model = knownModel();
    base_.install(model, 5.0);
    model.fit.parameters.u_dc += off;
    model.fit.estimates[4].value += off;
    extended_.install(model, 5.0);
  }

  /// Seconds at 2 Hz in which the base model is wrong by `base_error` [V].
  void pass(double seconds, double base_error) {
    for (int n = 0; n < 2 * seconds; ++n) {
      time_ += 0.5;
      const Sample sample{time_, 0.0, drivenBattery().u_dc + base_error};
      const SessionEvents of_base = base_.follow(sample, 5.0),
                          of_extended = extended_.follow(sample, 5.0);
      selector.add(sample, base_, of_base, extended_, of_extended);
    }
  }

  /// A crank, read `base_error` [V] above what the base model says and as the extended one does.
  void crank(double base_error) {
    EventComparison of_base, of_extended;
    of_base.expected.value = 10.0;
    of_base.measured = of_extended.measured = 10.0 + base_error;
    of_extended.expected.value = 10.0 + off_;
    time_ += 0.5;
    const Sample sample{time_, 0.0, drivenBattery().u_dc};
    base_.follow(sample, 5.0);
    extended_.follow(sample, 5.0);
    selector.add(sample, base_, {{of_base}, {}, {}}, extended_, {{of_extended}, {}, {}});
  }

  ModelSelector selector;

 private:
  double off_, time_ = 100.0;
  ModelMonitor base_, extended_;
};

TEST(ModelSelector, BaseModelAnswersUntilTwoMinutesWereCompared) {
  Rivals rivals(0.1);
  rivals.pass(100.0, 0.1);
  EXPECT_FALSE(rivals.selector.doesExtendedAnswer());
  EXPECT_NEAR(rivals.selector.score().base_rmse, 0.1, 1e-9);
  EXPECT_NEAR(rivals.selector.score().extended_rmse, 0.0, 1e-9);
  rivals.pass(60.0, 0.1);
  EXPECT_TRUE(rivals.selector.doesExtendedAnswer());
}

TEST(ModelSelector, ExtendedModelThatErrsMoreNeverAnswers) {
  Rivals rivals(0.1);
  for (int minute = 0; minute < 30; ++minute) {
    rivals.pass(60.0, 0.04);
    EXPECT_FALSE(rivals.selector.doesExtendedAnswer());
  }
}

TEST(ModelSelector, ExtendedModelIsDroppedOnceItErrsMore) {
  Rivals rivals(0.1);
  rivals.pass(300.0, 0.1);
  ASSERT_TRUE(rivals.selector.doesExtendedAnswer());
  rivals.pass(200.0, 0.0);
  EXPECT_TRUE(rivals.selector.doesExtendedAnswer()) << "the past still speaks for it";
  rivals.pass(200.0, 0.0);
  EXPECT_FALSE(rivals.selector.doesExtendedAnswer());
}

TEST(ModelSelector, OnlyTheLastQuarterOfAnHourCounts) {
  Rivals rivals(0.1);
  rivals.pass(3000.0, 0.1);
  rivals.pass(1000.0, 0.0);
  EXPECT_NEAR(rivals.selector.score().base_rmse, 0.0, 1e-9);
  EXPECT_NEAR(rivals.selector.score().duration, 900.0, 60.0);
}

TEST(ModelSelector, OneThatIsHardlyBetterDoesNotTakeOverAndOneThatAnswersIsNotChangedForLittle) {
  Rivals hardly(0.1);
  hardly.pass(300.0, 0.0506);  // errors 50.6 mV and 49.4 mV
  EXPECT_FALSE(hardly.selector.doesExtendedAnswer());
  Rivals answers(0.1);
  answers.pass(150.0, 0.1);
  answers.pass(2000.0, 0.0506);
  EXPECT_TRUE(answers.selector.doesExtendedAnswer());
}

TEST(ModelSelector, WorseCranksOutweighABetterVoltage) {
  Rivals rivals(0.1);
  for (int n = 0; n < 3; ++n) {
    rivals.pass(60.0, 0.1);
    rivals.crank(0.0);
  }
  rivals.pass(60.0, 0.1);
  EXPECT_FALSE(rivals.selector.doesExtendedAnswer());
}

TEST(ModelSelector, ForgettingThePastLeavesWhoAnswersToTheNextTwoMinutes) {
  Rivals rivals(0.1);
  rivals.pass(300.0, 0.1);
  rivals.selector.forgetPast();
  rivals.pass(60.0, 0.0);
  EXPECT_TRUE(rivals.selector.doesExtendedAnswer());
  rivals.pass(90.0, 0.0);
  EXPECT_FALSE(rivals.selector.doesExtendedAnswer());
}

}  // namespace
}  // namespace battery_sof
