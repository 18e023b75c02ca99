#include "regression/ridge.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <stdexcept>
#include <string>

#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

struct Regression {
  Eigen::MatrixXd X;
  Eigen::VectorXd y;
};

/// y = 3 + 2 x_0 - 0.5 x_1 and noise; columns of unequal centre and scale.
Regression regression(Eigen::Index rows, double noise, Eigen::Index columns = 3) {
  test::Random random(11);
  Regression made{Eigen::MatrixXd(rows, columns), Eigen::VectorXd(rows)};
  for (Eigen::Index n = 0; n < rows; ++n) {
    for (Eigen::Index j = 0; j < columns; ++j)
      made.X(n, j) =
          5.0 * static_cast<double>(j) + (1.0 + static_cast<double>(j)) * random.normal();
    made.y[n] = 3.0 + 2.0 * made.X(n, 0) - 0.5 * made.X(n, 1) + noise * random.normal();
  }
  return made;
}

RidgeOptions with(std::vector<double> penalties) {
  RidgeOptions options;
  options.penalties = std::move(penalties);
  return options;
}

/// argmin |y - c - Z w|^2 + lambda (|w|^2 + p c^2) by its normal equations, and what it predicts of
/// `at`.
double closedForm(const Regression& of, double penalty, double constant_penalty,
                  const Eigen::VectorXd& at) {
  const Eigen::RowVectorXd mean = of.X.colwise().mean();
  const Eigen::MatrixXd centred = of.X.rowwise() - mean;
  const Eigen::RowVectorXd scale =
      (centred.colwise().squaredNorm() / static_cast<double>(of.X.rows())).cwiseSqrt();
  Eigen::MatrixXd Z(of.X.rows(), of.X.cols() + 1);
  Z << Eigen::VectorXd::Ones(of.X.rows()), (centred.array().rowwise() / scale.array()).matrix();
  Eigen::VectorXd penalties = Eigen::VectorXd::Constant(Z.cols(), penalty);
  penalties[0] *= constant_penalty;
  const Eigen::MatrixXd products = Z.transpose() * Z + Eigen::MatrixXd(penalties.asDiagonal());
  const Eigen::VectorXd w = products.fullPivLu().solve(Z.transpose() * of.y);
  return w[0] +
         ((at.transpose() - mean).array() / scale.array() * w.tail(of.X.cols()).transpose().array())
             .sum();
}

TEST(FitRidge, APenaltyOfTheMeanIsOneOfTheSumTimesTheRows) {
  const Regression made = regression(60, 0.3);
  RidgeOptions options = with({0.01});
  options.of_mean = true;
  Eigen::VectorXd left_out;
  const RidgeFit fit = fitRidge(made.X, made.y, options, &left_out);
  EXPECT_EQ(fit.penalty, 0.01);
  Eigen::VectorXd values = Eigen::VectorXd::Constant(60, fit.constant);
  for (Eigen::Index j = 0; j < made.X.cols(); ++j) values += fit.ofColumn(j, made.X.col(j));
  for (Eigen::Index n = 0; n < 60; ++n) {
    const Eigen::VectorXd at = made.X.row(n).transpose();
    EXPECT_NEAR(values[n], closedForm(made, 0.01 * 60.0, 0.0, at), 1e-9);
    EXPECT_NEAR(values[n], fit.at(at), 1e-12);
  }
  // A block of ten is predicted from fifty rows.
  RidgeOptions of_sum = with({0.01 * 50.0});
  Eigen::VectorXd by_sum;
  fitRidge(made.X, made.y, of_sum, &by_sum);
  EXPECT_TRUE(left_out.isApprox(by_sum, 1e-12));
}

TEST(FitRidge, IsTheClosedFormOfItsNormalEquations) {
  const Regression made = regression(60, 0.3);
  Eigen::VectorXd at(3);
  at << 0.4, 7.0, 9.0;
  for (const double penalty : {1e-6, 1.0, 100.0})
    for (const double constant_penalty : {0.0, 0.1, 1.0}) {
      RidgeOptions options = with({penalty});
      options.constant_penalty = constant_penalty;
      const RidgeFit fit = fitRidge(made.X, made.y, options);
      EXPECT_NEAR(fit.at(at), closedForm(made, penalty, constant_penalty, at), 1e-10);
      EXPECT_EQ(fit.penalty, penalty);
    }
}

TEST(FitRidge, LeftOutPredictionsAreThoseOfFitsWithoutTheBlock) {
  const Regression made = regression(60, 0.3);
  Eigen::VectorXd left_out;
  const RidgeFit fit = fitRidge(made.X, made.y, with({2.0}), &left_out);
  // Columns are scaled once, over all rows: without a penalty scaling makes no difference.
  ASSERT_EQ(left_out.size(), 60);
  Eigen::VectorXd free;
  fitRidge(made.X, made.y, with({1e-9}), &free);
  for (int block = 0; block < 6; ++block) {
    Regression others{Eigen::MatrixXd(50, 3), Eigen::VectorXd(50)};
    others.X << made.X.topRows(10 * block), made.X.bottomRows(50 - 10 * block);
    others.y << made.y.head(10 * block), made.y.tail(50 - 10 * block);
    for (Eigen::Index n = 10 * block; n < 10 * (block + 1); ++n)
      EXPECT_NEAR(free[n], closedForm(others, 0.0, 0.0, made.X.row(n).transpose()), 1e-7);
  }
  EXPECT_NEAR(fit.gain, 1.0 - (made.y - left_out).squaredNorm() / made.y.squaredNorm(), 1e-12);
}

TEST(FitRidge, TakesThePenaltyThatErrsLeastOnLeftOutBlocks) {
  // Thirty columns that say nothing, forty rows: a small penalty learns the noise, a large one
  // loses the two that count.
  const Regression made = regression(60, 1.0, 30);
  const std::vector<double> penalties = {1e-3, 1.0, 30.0, 1e5};
  double least = HUGE_VAL, best = 0.0;
  for (const double penalty : penalties) {
    Eigen::VectorXd left_out;
    fitRidge(made.X, made.y, with({penalty}), &left_out);
    const double error = (made.y - left_out).squaredNorm();
    if (error < least) {
      least = error;
      best = penalty;
    }
  }
  EXPECT_EQ(fitRidge(made.X, made.y, with(penalties)).penalty, best);
  EXPECT_GT(best, 1e-3);
  EXPECT_LT(best, 1e5);
}

TEST(FitRidge, ShrinksToNothingOnNoise) {
  // Of twenty draws of noise alone the left-out blocks ask for nothing in most and for little in
  // the rest.
  test::Random random(5);
  int nothing = 0;
  for (int draw = 0; draw < 20; ++draw) {
    Eigen::MatrixXd X(120, 8);
    Eigen::VectorXd y(120);
    for (Eigen::Index n = 0; n < 120; ++n) {
      for (Eigen::Index j = 0; j < 8; ++j) X(n, j) = random.normal();
      y[n] = random.normal();
    }
    RidgeOptions options = with({1.0, 10.0, 100.0, 1e3, 1e4});
    options.constant_penalty = 0.1;
    options.shrunk = true;
    Eigen::VectorXd left_out;
    const RidgeFit fit = fitRidge(X, y, options, &left_out);
    if (fit.empty()) {
      ++nothing;
      EXPECT_EQ(fit.at(X.row(0).transpose()), 0.0);
      EXPECT_EQ(left_out, Eigen::VectorXd::Zero(120));
    } else {
      EXPECT_LT(fit.gain, 0.1);  // 8 columns of 120 rows: a fifteenth by chance
      EXPECT_LT((left_out - y).squaredNorm(), y.squaredNorm());
    }
  }
  EXPECT_GE(nothing, 10);
}

TEST(FitRidge, WhereEverythingIsExplainedNothingIsShrunk) {
  const Regression made = regression(60, 0.0);
  RidgeOptions options = with({1e-6});
  options.shrunk = true;
  const RidgeFit fit = fitRidge(made.X, made.y, options);
  EXPECT_NEAR(fit.gain, 1.0, 1e-6);
  for (Eigen::Index n = 0; n < 60; ++n)
    EXPECT_NEAR(fit.at(made.X.row(n).transpose()), made.y[n], 1e-5);
}

TEST(FitRidge, ClippedColumnsStayInsideWhatTheFitSaw) {
  const Regression made = regression(60, 0.1);
  RidgeOptions options = with({0.1});
  const RidgeFit free = fitRidge(made.X, made.y, options);
  options.clipped = true;
  const RidgeFit clipped = fitRidge(made.X, made.y, options);
  Eigen::VectorXd at = made.X.row(7).transpose();
  EXPECT_NEAR(clipped.at(at), free.at(at), 1e-12);
  at[0] = 1000.0;
  Eigen::VectorXd held = at;
  held[0] = made.X.col(0).maxCoeff();
  EXPECT_NEAR(clipped.at(at), free.at(held), 1e-12);
  EXPECT_GT(free.at(at) - clipped.at(at), 1000.0);
  at[0] = -1000.0;
  held[0] = made.X.col(0).minCoeff();
  EXPECT_NEAR(clipped.at(at), free.at(held), 1e-12);
}

TEST(FitRidge, AColumnThatNeverMovesWeighsNothing) {
  Regression made = regression(60, 0.1);
  made.X.col(2).setConstant(4.0);
  const RidgeFit fit = fitRidge(made.X, made.y, with({0.1}));
  EXPECT_EQ(fit.weight[2], 0.0);
  Eigen::VectorXd at = made.X.row(0).transpose();
  const double before = fit.at(at);
  at[2] = 1e6;
  EXPECT_EQ(fit.at(at), before);
}

TEST(FitRidge, RefusesWhatDoesNotFit) {
  const Regression made = regression(60, 0.1);
  EXPECT_THROW(fitRidge(made.X, made.y.head(59), with({1.0})), std::invalid_argument);
  EXPECT_THROW(fitRidge(made.X.topRows(11), made.y.head(11), with({1.0})), std::invalid_argument);
  EXPECT_THROW(fitRidge(made.X, made.y, with({})), std::invalid_argument);
}

TEST(RidgeFit, DefaultConstructedPredictsZero) {
  EXPECT_TRUE(RidgeFit().empty());
  EXPECT_EQ(RidgeFit().at(Eigen::VectorXd::Ones(4)), 0.0);
}

}  // namespace
}  // namespace battery_sof
