#include <gtest/gtest.h>

#include <cmath>

#include "prediction/online_session.hpp"
#include "support/known_model.hpp"

namespace battery_sof {
namespace {

const CrankingQuery kQuery{-25.0, 20.0, -200.0, 0.5, 7.2};
constexpr double kStart = 1000.0;  // [s]

class LostModel : public ::testing::Test {
 protected:
  LostModel() : inputs_(test::baseDrive(3, 400.0)) {
    SessionOptions options;
    options.window_length = 60.0;
    options.buffer = 120.0;
    options.min_window_quality = 0.0;
    session_ = OnlineSession(options);
    session_.restore(test::overflowingModel(kStart - 10.0));
  }

  void pushUntil(double time) {
    for (; next_ < inputs_.size() && inputs_.time[next_] < time; ++next_) {
      session_.push(
          {kStart + inputs_.time[next_], inputs_.current[next_], inputs_.voltage[next_], {}});
      if (const auto job = session_.takeDueJob()) session_.finish(runIdentification(*job));
    }
  }

  Series inputs_;
  OnlineSession session_;
  std::size_t next_ = 0;
};

TEST_F(LostModel, IsInUseWhileItsNumbersAreFinite) {
  pushUntil(20.0);
  EXPECT_FALSE(session_.whyNoModel()) << *session_.whyNoModel();
}

TEST_F(LostModel, IsDroppedAndToldOfWhenItsNumbersAreNot) {
  std::string said;
  for (double time = 20.0; time < 300.0 && said.empty(); time += 1.0) {
    pushUntil(time);
    if (session_.status().basis == AnswerBasis::kPopulation) said = session_.status().reason;
  }
  EXPECT_NE(said.find("the model was dropped because its state was not finite"), std::string::npos)
      << said;
}

TEST_F(LostModel, IsFollowedByAnotherIdentification) {
  pushUntil(400.0);
  ASSERT_FALSE(session_.whyNoModel()) << *session_.whyNoModel();
  const CrankingAnswer answer = session_.live().predictCranking(kQuery);
  ASSERT_TRUE(answer.u_min);
  EXPECT_NEAR(answer.u_min->value, 10.8, 1.5);
}

}  // namespace
}  // namespace battery_sof
