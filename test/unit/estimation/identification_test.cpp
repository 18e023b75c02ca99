#include "estimation/identification.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "estimation/base_search.hpp"
#include "support/base_columns.hpp"
#include "support/base_drive.hpp"
#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

IndexRange whole(const Series& series) { return {0, series.size()}; }

const ParameterEstimate& estimate(const Fit& fit, const std::string& name) {
  for (const auto& e : fit.estimates)
    if (e.name == name) return e;
  throw std::out_of_range(name);
}

TEST(Identify, RecoversTheParametersOfANoiselessDrive) {
  const Series series = test::baseDrive(1, 240.0, 0.0);
  const FittedModel model = identify(series, whole(series));
  const BaseParameters truth = test::drivenBattery();
  EXPECT_EQ(model.fit.status, FitStatus::kConverged);
  EXPECT_NEAR(model.fit.parameters.r_discharge, truth.r_discharge, 1e-7);
  EXPECT_NEAR(model.fit.parameters.r_charge, truth.r_charge, 1e-7);
  EXPECT_NEAR(model.fit.parameters.c2, truth.c2, 1e-3 * truth.c2);
  EXPECT_NEAR(model.fit.parameters.beta, truth.beta, 1e-3 * truth.beta);
  EXPECT_NEAR(model.fit.parameters.u_dc, truth.u_dc, 1e-4);
  EXPECT_GT(model.fit.scores.q_dyn_percent, 99.9);
}

TEST(Identify, TakesWhatIsKnownOfBatteriesWithoutEffects) {
  const Series series = test::baseDrive(3);
  IdentifyOptions options;
  const double alone = identify(series, {0, series.size()}, options).fit.parameters.c2;
  options.priors = {{{}, {{"c2", 2.0 * alone, 1e-5, true}}}};
  EXPECT_NEAR(identify(series, {0, series.size()}, options).fit.parameters.c2, 2.0 * alone,
              0.02 * alone);
  options.priors = {{{"gassing"}, {{"c2", 2.0 * alone, 1e-5, true}}}};
  EXPECT_EQ(identify(series, {0, series.size()}, options).fit.parameters.c2, alone);
  options.priors = {{{}, {{"c2", 2.0 * alone, 1e-5, true}}}};
  options.start = FitStart::kPaper;
  EXPECT_NEAR(identify(series, {0, series.size()}, options).fit.parameters.c2, alone, 0.1 * alone)
      << "the paper's fit has Table I alone";
}

TEST(Identify, EstimatesTheStateOfAWindowThatOpensFarFromRest) {
  const BaseParameters truth = test::drivenBattery();
  const Series series =
      test::answered(truth, test::dataSetOneCurrent(240.0, 0.01, 5), 0.01, 0.002, 5, -0.35);
  const FittedModel model = identify(series, whole(series));
  EXPECT_NEAR(model.fit.parameters.c2, truth.c2, 0.02 * truth.c2);
  EXPECT_NEAR(model.fit.parameters.u_dc, truth.u_dc, 0.005);
}

TEST(Identify, LeavesTheStateAtTheWindowsLastSample) {
  const BaseParameters truth = test::drivenBattery();
  const Series series = test::baseDrive(3, 240.0, 0.0);
  const FittedModel model = identify(series, whole(series));
  EXPECT_DOUBLE_EQ(model.state.time, series.time.back());
  EXPECT_DOUBLE_EQ(model.state.current, series.current.back());
  const double ohmic = ohmicResistance(truth, series.current.back()) * series.current.back();
  EXPECT_NEAR(model.state.states[0], series.voltage.back() - truth.u_dc - ohmic, 1e-4);
}

TEST(Identify, ARobustStartSurvivesAWindowThatOpensOnACurrentEdgeThePapersDoesNot) {
  // The first sample's voltage belongs to another current, as a sample inside an edge does.
  Series series = test::baseDrive(7, 240.0, 0.002);
  series.voltage[0] -= 0.4;
  const double truth = test::drivenBattery().c2;
  IdentifyOptions paper;
  paper.start = FitStart::kPaper;
  const double robust_error =
      std::abs(identify(series, whole(series)).fit.parameters.c2 / truth - 1.0);
  const double paper_error =
      std::abs(identify(series, whole(series), paper).fit.parameters.c2 / truth - 1.0);
  EXPECT_LT(robust_error, 0.005);
  EXPECT_GT(paper_error, 0.02);
}

TEST(Identify, ThePapersStartFindsTheParametersOfACleanWindow) {
  const Series series = test::baseDrive(2, 240.0, 0.0);
  IdentifyOptions options;
  options.start = FitStart::kPaper;
  const FittedModel model = identify(series, whole(series), options);
  const BaseParameters truth = test::drivenBattery();
  EXPECT_EQ(model.fit.start, "paper");
  EXPECT_LE(model.fit.iterations, 20);
  EXPECT_NEAR(model.fit.parameters.r_discharge, truth.r_discharge, 1e-5);
  EXPECT_NEAR(model.fit.parameters.c2, truth.c2, 0.01 * truth.c2);
  EXPECT_NEAR(model.fit.parameters.beta, truth.beta, 0.01 * truth.beta);
}

TEST(Identify, ThePapersPenaltyKeepsParametersNearTableOne) {
  BaseParameters outside = test::drivenBattery();
  outside.r_charge = 0.0002;  // below the lower bound of 0.001
  const Series series =
      test::answered(outside, test::dataSetOneCurrent(240.0, 0.01, 2), 0.01, 0.002, 2);
  IdentifyOptions options;
  options.start = FitStart::kPaper;
  const FittedModel model = identify(series, whole(series), options);
  EXPECT_TRUE(estimate(model.fit, "r_charge").at_bound);
  EXPECT_GT(model.fit.parameters.r_charge, 0.0002);
}

TEST(Identify, ReportsAParameterThatEndsAtABoundWithoutAStandardError) {
  BaseParameters outside = test::drivenBattery();
  outside.r_charge = 0.0002;
  const Series series =
      test::answered(outside, test::dataSetOneCurrent(240.0, 0.01, 2), 0.01, 0.002, 2);
  const FittedModel model = identify(series, whole(series));
  const auto& r_charge = estimate(model.fit, "r_charge");
  EXPECT_TRUE(r_charge.at_bound);
  EXPECT_FALSE(r_charge.determined);
  EXPECT_FALSE(r_charge.std.has_value());
  EXPECT_DOUBLE_EQ(r_charge.value, 0.001);
  EXPECT_NE(model.fit.message.find("r_charge"), std::string::npos);
}

TEST(Identify, SaysThatADischargeOnlyWindowDoesNotDetermineTheChargeResistance) {
  auto current = test::dataSetOneCurrent(240.0, 0.01, 4);
  for (double& i : current) i = std::min(i, -1.0);
  const Series series = test::answered(test::drivenBattery(), current, 0.01, 0.002, 4);
  const FittedModel model = identify(series, whole(series));
  EXPECT_TRUE(estimate(model.fit, "r_discharge").determined);
  EXPECT_FALSE(estimate(model.fit, "r_charge").determined);
  EXPECT_FALSE(estimate(model.fit, "r_charge").std.has_value());
}

TEST(Identify, RefusesAWindowTooShortToFit) {
  const Series series = test::baseDrive(1, 0.2);
  const FittedModel model = identify(series, whole(series));
  EXPECT_EQ(model.fit.status, FitStatus::kWindowTooShort);
  EXPECT_FALSE(isUsable(model.fit));
  EXPECT_NE(model.fit.message.find("20 samples"), std::string::npos);
}

TEST(Identify, RefusesAWindowWhoseCurrentNeverChanges) {
  const Series series =
      test::answered(test::drivenBattery(), std::vector<double>(1000, -5.0), 0.01, 0.002, 1);
  const FittedModel model = identify(series, whole(series));
  EXPECT_EQ(model.fit.status, FitStatus::kNotExcited);
  EXPECT_FALSE(isUsable(model.fit));
}

/// A rest, then one load that stays: of it a bench knows how the voltage falls with the charge, and
/// hardly anything of the circuit.
Series benchDischarge() {
  test::Random random(3);
  Series series;
  for (int n = 0; n < 2000; ++n) {
    const double time = 5.0 * n, current = n < 200 ? 0.0 : -10.0;
    const double since = std::max(0.0, time - 1000.0), drawn = since * 10.0 / 3600.0,
                 slow = 0.55 * (1.0 - std::exp(-since / 640.0));
    series.append({time, current + 0.01 * random.normal(),
                   13.2 - 0.014 * drawn - slow + 0.001 * random.normal()});
  }
  return series;
}

TEST(Identify, OfABenchDischargeKnowsTheSlopeThoughNothingOfTheCircuit) {
  const Series series = benchDischarge();
  IdentifyOptions options;
  options.effects = {"acid_transport", "ocv_soc"};
  const FittedModel model = identify(series, whole(series), options);
  EXPECT_TRUE(isUsable(model.fit)) << model.fit.message;
  EXPECT_NEAR(estimate(model.fit, "ocv_slope").value, 0.014, 0.002);
}

/// 25 Ah are drawn: half of 50 Ah, a twelfth of 300.
TEST(Identify, TakesTheOpenCircuitVoltageByItselfWhereATenthOfTheCapacityWentOneWay) {
  const Series series = benchDischarge();
  FitRequest request;
  request.from = series.time.front();
  request.to = series.time.back();
  request.options.chooses_effects = true;
  FittedModel model = fitPlanned(series, planFit(series, request));
  EXPECT_TRUE(isUsable(model.fit)) << model.fit.message;
  EXPECT_EQ(model.fit.effects, (std::vector<std::string>{"ocv_soc", "end_of_discharge"}));
  request.options.capacity = 300.0;
  model = fitPlanned(series, planFit(series, request));
  EXPECT_TRUE(model.fit.effects.empty());
}

/// 10 Ah there and back, and a rest: not a few minutes of it.
TEST(Identify, OfADeepCycleThatEndsAtRestTakesTheWholeWindow) {
  Series series;
  double charge = 0.0;
  for (int n = 0; n < 1500; ++n) {
    const double current = n < 100 ? 0.0 : n < 700 ? -10.0 : n < 1300 ? 10.0 : 0.0;
    charge += current * 6.0 / 3600.0;
    series.append({6.0 * n, current, 12.8 + 0.02 * charge + 0.01 * current});
  }
  FitRequest request;
  FitPlan plan = planFit(series, request);
  ASSERT_TRUE(plan.window.range);
  EXPECT_EQ(plan.window.range->first, 0u);
  EXPECT_EQ(plan.window.range->last, series.size());
  request.options.capacity = 300.0;
  plan = planFit(series, request);
  ASSERT_TRUE(plan.window.range);
  EXPECT_LT(plan.window.range->size(), series.size());
}

TEST(Identify, TakesAGapInsideTheWindowForARest) {
  Series series = test::baseDrive(6, 120.0, 0.0);
  const std::size_t half = series.size() / 2;
  const test::BaseStep step(test::drivenBattery());
  // The drive stops, the car stands for ten minutes, and goes on from the state it rested to.
  double u = series.voltage[half - 1] -
             test::terminalVoltage(test::drivenBattery(), series.current[half - 1], 0.0);
  u = step.advance(u, 0.0, 600.0);
  for (std::size_t n = half; n < series.size(); ++n) {
    series.time[n] += 600.0 - 0.01;
    if (n > half) u = step.advance(u, 0.5 * (series.current[n - 1] + series.current[n]), 0.01);
    series.voltage[n] = test::terminalVoltage(test::drivenBattery(), series.current[n], u);
  }
  const FittedModel model = identify(series, whole(series));
  EXPECT_NEAR(model.fit.parameters.c2, test::drivenBattery().c2, 2.0);
  EXPECT_LT(model.fit.scores.rmse, 1e-4);
}

TEST(Identify, RefusesOptionsOutsideTheirRangesByName) {
  const Series series = test::baseDrive(1, 20.0);
  const auto messageOf = [&](const IdentifyOptions& options) -> std::string {
    try {
      identify(series, whole(series), options);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  IdentifyOptions options;
  options.crank_weight = 0.5;
  EXPECT_NE(messageOf(options).find("crank_weight"), std::string::npos);
  options = {};
  options.crank_current = 10.0;
  EXPECT_NE(messageOf(options).find("crank_current"), std::string::npos);
  options = {};
  options.capacity = 0.0;
  EXPECT_NE(messageOf(options).find("capacity"), std::string::npos);
  options = {};
  options.max_iterations = 0;
  EXPECT_NE(messageOf(options).find("max_iterations"), std::string::npos);
  options = {};
  options.initial[3] = 5000.0;
  EXPECT_NE(messageOf(options).find("beta"), std::string::npos);
  EXPECT_THROW(identify(series, {0, series.size() + 1}), std::invalid_argument);
}

TEST(CarryState, MovesTheStateAsTheModelWould) {
  const Series series = test::baseDrive(8, 300.0, 0.0);
  FittedModel model = identify(series, {0, 24000});
  carryState(model, series, series.size() - 1);
  EXPECT_DOUBLE_EQ(model.state.time, series.time.back());
  const double ohmic =
      ohmicResistance(test::drivenBattery(), series.current.back()) * series.current.back();
  EXPECT_NEAR(model.state.states[0], series.voltage.back() - test::drivenBattery().u_dc - ohmic,
              2e-4);
  EXPECT_THROW(carryState(model, series, 10), std::invalid_argument);
}

TEST(BaseNormalEquations, SumsAreThoseOfTheColumns) {
  const Series series = test::baseDrive(9, 33.0);
  const auto samples = test::fitSamples(series, whole(series));
  const BaseNormalEquations equations(samples, 1.0);
  const OverpotentialSweep::Point point{900.0, 25.0, 0.03};
  const auto columns = test::columnsOf(samples, point, equations.offset());
  Eigen::VectorXd weight(static_cast<Eigen::Index>(samples.size()));
  for (std::size_t n = 0; n < samples.size(); ++n)
    weight[static_cast<Eigen::Index>(n)] = samples[n].weight;
  const Eigen::MatrixXd expected = columns.transpose() * weight.asDiagonal() * columns;
  for (const auto set : {InstructionSet::kPlain, InstructionSet::kAvx2, InstructionSet::kAvx512}) {
    if (set > widestInstructionSet()) continue;
    const Eigen::MatrixXd sums = equations.sums(point, set);
    for (int j = 0; j < kBaseColumns; ++j)
      for (int k = 0; k < kBaseColumns; ++k)
        EXPECT_NEAR(sums(j, k), expected(j, k), 1e-10 * std::sqrt(expected(j, j) * expected(k, k)));
  }
}

TEST(SearchWindow, ItsTrustedLastStepLandsOnTheOptimum) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    // 20 mV of noise: the averages' optimum lies as far from that of all samples as it can.
    const Series series = test::baseDrive(seed, 240.0, 0.02);
    const std::vector<char> none;
    const WindowSamples samples{series, whole(series), {}, gapThreshold(series), none};
    const BaseNormalEquations equations(samples, 1.0);
    const CompositionFit quick = searchWindow(samples, equations, {});
    // What a Gauss-Newton step would still move: base_search.hpp promises less than 1e-4.
    const BaseParameters p = baseParameters(quick.point.parameters);
    const BaseSums sums = equations.sums({p.c2, p.beta, quick.point.state[0]});
    const Eigen::Matrix<double, 6, 1> linear =
        (Eigen::Matrix<double, 6, 1>() << p.r_discharge, p.r_charge, p.u_dc - equations.offset(),
         0.0, 0.0, 0.0)
            .finished();
    const Eigen::Matrix<double, 6, 6> normal = sums.topLeftCorner<6, 6>();
    const Eigen::Matrix<double, 6, 1> step =
        normal.ldlt().solve(sums.col(kColumnTarget).head<6>() - normal * linear);
    EXPECT_NEAR(step[kColumnLogC2], 0.0, 1e-4);
    EXPECT_NEAR(step[kColumnLogBeta], 0.0, 1e-4);
    EXPECT_NEAR(step[kColumnDischarge] / p.r_discharge, 0.0, 1e-4);
    EXPECT_NEAR(step[kColumnCharge] / p.r_charge, 0.0, 1e-4);
    EXPECT_LT(step.dot(normal * step) / quick.at.cost, 1e-7);
  }
}

TEST(SearchWindow, AStartFarOffLeadsToTheOptimumOfTheUsualOne) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Series series = test::baseDrive(seed, 240.0, 0.02);
    const std::vector<char> none;
    const WindowSamples samples{series, whole(series), {}, gapThreshold(series), none};
    const BaseNormalEquations equations(samples, 1.0);
    const double usual = searchWindow(samples, equations, {}).at.cost;
    for (const double c2 : {tableOne()[2].lower, tableOne()[2].upper})
      for (const double beta : {tableOne()[3].lower, tableOne()[3].upper}) {
        IdentifyOptions options;
        options.initial[2] = c2;
        options.initial[3] = beta;
        const CompositionFit found = searchWindow(samples, equations, options);
        EXPECT_LT(found.at.cost, usual * (1.0 + 1e-6));
      }
  }
}

TEST(WindowSamples, WeighsHighRateDischargeOnly) {
  Series series;
  series.time = {0.0, 0.01, 0.02, 0.03};
  series.current = {-150.0, -150.1, 20.0, -10.0};
  series.voltage = {12.0, 11.0, 13.0, 12.5};
  const auto samples = test::fitSamples(series, whole(series));
  EXPECT_DOUBLE_EQ(samples[0].weight, 1.0);
  EXPECT_DOUBLE_EQ(samples[1].weight, 100.0);
  EXPECT_DOUBLE_EQ(samples[2].weight, 1.0);
}

}  // namespace
}  // namespace battery_sof
