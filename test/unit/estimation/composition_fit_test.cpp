#include "estimation/composition_fit.hpp"
#include "estimation/identification.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "support/composed.hpp"

namespace battery_sof {
namespace {

using namespace test;

/// A composition's answer to the current of data set 1, with white noise.
Series answeredBy(const BatteryModel& model, const Eigen::VectorXd& parameters, double duration,
                  double noise, std::uint64_t seed, double interval = 0.1) {
  Series series;
  series.current = dataSetOneCurrent(duration, interval, seed);
  for (std::size_t n = 0; n < series.current.size(); ++n)
    series.time.push_back(interval * static_cast<double>(n));
  series.voltage.assign(series.time.size(), 0.0);
  series.voltage =
      voltages(model, pointOf(model, parameters), inputSequence(series, whole(series)));
  Random random(seed ^ 0xA015EULL);
  for (double& u : series.voltage) u += noise * random.normal();
  return series;
}

/// Parameters at their magnitudes, or where these say something in a record of minutes.
Eigen::VectorXd livelyPoint(const BatteryModel& model) {
  Eigen::VectorXd p = typicalPoint(model);
  const auto set = [&](const char* name, double value) {
    if (const auto row = model.parameterRow(name)) p[*row] = value;
  };
  set("contact_time", 60.0);
  set("exchange_current", 1.6);
  set("transfer_symmetry", 0.46);
  set("gassing_current", 1.0);
  set("transition_width", 3.0);
  set("transition_current", 0.5);
  set("gain_error", 0.01);
  return p;
}

std::vector<std::string> allIds() {
  std::vector<std::string> ids;
  for (const EffectInfo& info : effectCatalogue()) ids.push_back(info.id);
  return ids;
}

/// The ids with what they need, each once.
std::vector<std::string> together(const std::vector<std::string>& ids) {
  std::vector<std::string> all;
  for (const std::string& id : ids)
    for (const std::string& more : withNeeds(id))
      if (std::find(all.begin(), all.end(), more) == all.end()) all.push_back(more);
  return all;
}

std::string join(const BatteryModel& model) {
  std::string names = "base";
  for (const std::string& id : model.effects()) names += " + " + id;
  return names;
}

bool stepsImplicitly(const BatteryModel& model) {
  for (const std::string& id : model.effects())
    if (id == "gassing" || id == "charge_acceptance" || id == "cpe2" || id == "fresh_sulphate")
      return true;
  return false;
}

/// A law of its own has its strength held where it acts, so that a fit of it holds no smaller
/// model; this is where it holds one.
CompositionPoint withHeldStrengthsVanished(const BatteryModel& model, CompositionPoint point) {
  for (Eigen::Index j = 0; j < model.parameterCount(); ++j) {
    const ParameterInfo& info = model.parameters()[static_cast<std::size_t>(j)];
    if (info.held && info.vanishes_at) point.parameters[j] = *info.vanishes_at;
  }
  return point;
}

FitCost whitened(double white_std, double ar_std = 0.0) {
  FitCost cost;
  cost.noise = NoiseModel{white_std, ar_std, 2.0, 0.0};
  return cost;
}

Eigen::VectorXd standardErrors(const Eigen::MatrixXd& information) {
  const Eigen::Index n = information.rows();
  return information.ldlt().solve(Eigen::MatrixXd::Identity(n, n)).diagonal().cwiseSqrt();
}

/// Where a fit of a window begins: the base model's own optimum, embedded.
CompositionPoint baseOptimum(const InputSequence& inputs, const FitCost& cost) {
  const BatteryModel base;
  const CompositionPoint start = typicalStart(base, inputs);
  const CompositionProblem problem(base, inputs, cost, start);
  return fitComposition(problem, {start}).point;
}

class EveryEffect : public ::testing::TestWithParam<std::string> {
 protected:
  BatteryModel model_{withNeeds(GetParam())};
};

}  // namespace

// ---------------------------------------------------------------------------------- simulate, then
// fit

class Recovered : public ::testing::TestWithParam<std::vector<std::string>> {};

TEST_P(Recovered, ParametersLieWithinFourStandardErrorsOfTheTruth) {
  const BatteryModel model(GetParam());
  Eigen::VectorXd truth = typicalPoint(model);
  if (const auto row = model.parameterRow("exchange_current")) truth[*row] = 1.3;
  if (const auto row = model.parameterRow("transfer_symmetry")) truth[*row] = 0.46;
  const Series series = answeredBy(model, truth, 240.0, 0.001, 3);
  const InputSequence inputs = inputSequence(series, whole(series));
  const FitCost cost = whitened(0.001);
  const CompositionPoint nested = embedded(BatteryModel(), baseOptimum(inputs, cost), model);
  CompositionPoint strong = nested;
  strong.parameters.tail(truth.size() - kBaseRows) =
      model.typicalParameters().tail(truth.size() - kBaseRows);
  const CompositionProblem problem(model, inputs, cost, nested);
  const CompositionFit fit = fitComposition(problem, {nested, strong});
  EXPECT_EQ(fit.status, FitStatus::kConverged) << join(model);
  EXPECT_NEAR(fit.at.cost / static_cast<double>(series.size()), 1.0, 0.1) << join(model);
  const Eigen::VectorXd x_true = problem.coordinatesOf({truth, model.restState()});
  const Eigen::VectorXd error = standardErrors(fit.at.hessian);
  for (Eigen::Index k = 0; k < problem.size(); ++k)
    EXPECT_LT(std::abs(fit.x[k] - x_true[k]), 4.0 * error[k])
        << join(model) << ", row " << problem.rowOf(k) << ": " << fit.x[k] << " for " << x_true[k];
}

INSTANTIATE_TEST_SUITE_P(
    Compositions, Recovered,
    ::testing::Values(std::vector<std::string>{}, std::vector<std::string>{"ocv_soc"},
                      std::vector<std::string>{"charge_acceptance"},
                      std::vector<std::string>{"cpe2"}, std::vector<std::string>{"charge_transfer"},
                      std::vector<std::string>{"second_electrode"},
                      std::vector<std::string>{"time_skew", "fast_arc"},
                      std::vector<std::string>{"high_rate_depletion", "voltage_drift"},
                      std::vector<std::string>{"current_dependent_resistance", "acid_transport"},
                      std::vector<std::string>{"charge_acceptance", "acid_transport",
                                               "time_skew"}));

// ---------------------------------------------------------------------------------- one pass

class Pass : public ::testing::TestWithParam<bool> {};

TEST_P(Pass, GradientAndHessianAreThoseOfTheResiduals) {
  for (const std::vector<std::string>& ids :
       {std::vector<std::string>{},
        {"acid_transport", "current_dependent_resistance", "time_skew"},
        {"charge_acceptance", "gassing", "cpe2"},
        {"second_electrode", "sensor_lag", "self_heating"}}) {
    const BatteryModel model(ids);
    const Series series = answeredBy(model, livelyPoint(model), 60.0, 0.005, 4);
    const InputSequence inputs = compressedInputs(series, whole(series));
    FitCost cost = GetParam() ? whitened(0.002, 0.003) : FitCost();
    cost.priors = false;
    CompositionPoint point{livelyPoint(model), model.restState()};
    point.state[0] = 0.03;
    const CompositionProblem problem(model, inputs, cost, point);
    const Eigen::VectorXd x = problem.coordinatesOf(point);
    const auto weighted = [&](const Eigen::VectorXd& at) -> Eigen::VectorXd {
      Eigen::VectorXd e = problem.residual(at);
      if (cost.noise) return Whitening(*cost.noise, inputs.samples).whitened(e);
      for (Eigen::Index k = 0; k < e.size(); ++k)
        e[k] *= std::sqrt(problem.weightOf(static_cast<std::size_t>(k)));
      return e;
    };
    const Eigen::VectorXd e = weighted(x);
    Eigen::MatrixXd J(e.size(), problem.size());
    for (Eigen::Index k = 0; k < problem.size(); ++k) {
      const double h = 2e-4;
      const Eigen::VectorXd step = h * Eigen::VectorXd::Unit(problem.size(), k);
      J.col(k) = (weighted(x + step) - weighted(x - step)) / (2.0 * h);
    }
    NormalEquations at;
    ASSERT_TRUE(problem.evaluate(x, at));
    EXPECT_NEAR(at.cost, e.squaredNorm(), 1e-7 * e.squaredNorm());
    const Eigen::VectorXd norm = J.colwise().norm();
    for (Eigen::Index j = 0; j < problem.size(); ++j) {
      EXPECT_NEAR(at.gradient[j], J.col(j).dot(e), 3e-3 * norm[j] * e.norm() + 1e-9)
          << join(model) << " row " << problem.rowOf(j);
      for (Eigen::Index k = 0; k < problem.size(); ++k)
        EXPECT_NEAR(at.hessian(j, k), J.col(j).dot(J.col(k)), 6e-3 * norm[j] * norm[k] + 1e-9)
            << join(model) << " rows " << problem.rowOf(j) << ", " << problem.rowOf(k);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Costs, Pass, ::testing::Bool(), [](const auto& instance) {
  return instance.param ? std::string("Whitened") : std::string("Weighted");
});

TEST(CompositionProblem, PriorsAddTheirSquaresInStandardDeviations) {
  const BatteryModel model({"charge_transfer", "acid_transport"});
  const Series series = answeredBy(model, typicalPoint(model), 60.0, 0.002, 5);
  const InputSequence inputs = inputSequence(series, whole(series));
  const CompositionPoint start = {typicalPoint(model), model.restState()};
  for (const bool white : {false, true}) {
    FitCost with = white ? whitened(0.002) : FitCost();
    FitCost without = with;
    without.priors = false;
    const CompositionProblem priors(model, inputs, with, start),
        bare(model, inputs, without, start);
    Eigen::VectorXd x = priors.coordinatesOf(start);
    NormalEquations a, b;
    ASSERT_TRUE(priors.evaluate(x, a) && bare.evaluate(x, b));
    EXPECT_NEAR(a.cost, b.cost, 1e-12 * b.cost)
        << "at its magnitudes and at rest nothing is surprising";
    // One standard deviation each: e^0.5 in a time constant, 0.05 in alpha, 0.2 V in u_c2,
    // 20 A in another state.
    CompositionPoint moved = start;
    moved.parameters[*model.parameterRow("acid_time_1")] *= std::exp(0.5);
    moved.parameters[*model.parameterRow("transfer_symmetry")] += 0.05;
    moved.state[0] += 0.2;
    moved.state[1] += 20.0;
    x = priors.coordinatesOf(moved);
    ASSERT_TRUE(priors.evaluate(x, a) && bare.evaluate(x, b));
    EXPECT_NEAR(a.cost - b.cost, 4.0 * priors.priorWeight(), 1e-9 * b.cost);
    EXPECT_TRUE(
        (a.hessian - b.hessian).isApprox(priors.priorWeight() * priors.priorInformation(x), 1e-6));
    EXPECT_EQ(bare.priorInformation(x).norm(), 0.0);
    EXPECT_NEAR(priors.priorWeight(), white ? 1.0 : 1e-4 * 50.0, 1e-6) << "5 s of 10 Hz at 10 mV";
  }
}

TEST(CompositionProblem, HeldParametersStayUnlessSetFreeAndFixedOnesStay) {
  const BatteryModel model({"gassing"});
  const Series series = answeredBy(model, livelyPoint(model), 30.0, 0.002, 5);
  const InputSequence inputs = inputSequence(series, whole(series));
  const CompositionPoint start = {livelyPoint(model), model.restState()};
  const CompositionProblem usual(model, inputs, {}, start),
      fixed(model, inputs, {}, start, {"beta", "gassing_slope"});
  EXPECT_EQ(usual.size(), 8);  // five, two of gassing, u_c2
  EXPECT_EQ(fixed.size(), 6);
  const CompositionPoint moved = fixed.pointAt(fixed.coordinatesOf(start) * 1.01);
  EXPECT_EQ(moved.parameters[kRowBeta], start.parameters[kRowBeta]);
  EXPECT_NE(moved.parameters[kRowC2], start.parameters[kRowC2]);
  EXPECT_THROW(CompositionProblem(model, inputs, {}, start, {"r3"}), std::invalid_argument);
  EXPECT_THROW(CompositionProblem(model, InputSequence(), {}, start), std::invalid_argument);
}

TEST(CompositionProblem, CoordinatesAndPointsAreEachOthersInverse) {
  for (const std::string& id : allIds()) {
    const BatteryModel model(withNeeds(id));
    const Series series = baseDrive(1, 5.0);
    const InputSequence inputs = inputSequence(series, whole(series));
    CompositionPoint start{typicalPoint(model), model.restState()};
    start.state[0] = 0.1;
    // An instant of the recording lies inside it.
    if (const auto row = model.parameterRow("contact_time")) start.parameters[*row] = 2.0;
    const CompositionProblem problem(model, inputs, {}, start);
    const Eigen::VectorXd x = problem.coordinatesOf(start);
    const CompositionPoint back = problem.pointAt(x);
    EXPECT_TRUE(back.parameters.isApprox(start.parameters, 1e-12)) << id;
    EXPECT_TRUE(problem.coordinatesOf(back).isApprox(x, 1e-12)) << id;
    for (Eigen::Index j = 0; j < model.stateCount(); ++j) {
      const bool follows = model.states()[static_cast<std::size_t>(j)].begins_as_u_c2;
      if (follows) {
        EXPECT_EQ(back.state[j], 0.1) << id;
      }
    }
  }
}

// ---------------------------------------------------------------------------------- linear
// coordinates

namespace {

/// Largest second difference of the voltage along a direction of all linear parameters at once [V].
double curvature(const BatteryModel& model, const InputSequence& inputs, std::uint64_t seed) {
  Random random(seed);
  const Eigen::VectorXd p = livelyPoint(model);
  Eigen::VectorXd step = Eigen::VectorXd::Zero(p.size());
  for (Eigen::Index j = 0; j < p.size(); ++j) {
    const ParameterInfo& info = model.parameters()[static_cast<std::size_t>(j)];
    if (info.linear) step[j] = random.uniform(0.2, 0.8) * std::abs(info.magnitude);
  }
  const auto at = [&](double share) {
    return voltages(model, pointOf(model, p + share * step), inputs);
  };
  const auto a = at(0.0), b = at(0.5), c = at(1.0);
  double most = 0.0;
  for (std::size_t n = 0; n < a.size(); ++n)
    most = std::max(most, std::abs(a[n] - 2.0 * b[n] + c[n]));
  return most;
}

}  // namespace

TEST(LinearParameters, AreThoseTheVoltageIsLinearInForEveryEffectAloneAndForEveryPair) {
  const Series series = livelyMinute(0.25);
  const InputSequence inputs = inputSequence(series, whole(series));
  const auto ids = allIds();
  for (std::size_t a = 0; a < ids.size(); ++a)
    for (std::size_t b = a; b < ids.size(); ++b) {
      const BatteryModel model(together({ids[a], ids[b]}));
      EXPECT_LT(curvature(model, inputs, 100 * a + b), 1e-10) << join(model);
    }
}

TEST(LinearParameters, OfTheBaseModelAreTheResistancesAndTheRestVoltage) {
  const BatteryModel base;
  EXPECT_TRUE(base.parameters()[kRowRDischarge].linear);
  EXPECT_TRUE(base.parameters()[kRowRCharge].linear);
  EXPECT_FALSE(base.parameters()[kRowC2].linear);
  EXPECT_FALSE(base.parameters()[kRowBeta].linear);
  EXPECT_TRUE(base.parameters()[kRowUDc].linear);
  EXPECT_FALSE(BatteryModel({"gassing"}).parameters()[kRowUDc].linear);
}

// ---------------------------------------------------------------------------------- the search

TEST_P(EveryEffect, NeverCostsMoreThanTheOptimumOfTheModelNestedInIt) {
  // A battery with more physics than either model, so that the optima lie where they like, and one
  // with none, so that nothing is there to be gained.
  for (const BatteryModel& battery :
       {BatteryModel({"acid_transport", "current_dependent_resistance", "charge_acceptance"}),
        BatteryModel()}) {
    const Series series = answeredBy(battery, typicalPoint(battery), 120.0, 0.002, 8);
    const InputSequence inputs = inputSequence(series, whole(series));
    for (FitCost cost : {FitCost(), whitened(0.002, 0.002)}) {
      // Where a law has priors of its own for the base parameters nothing is nested beside them.
      if (!effectInfo(GetParam()).overrides.empty()) cost.priors = false;
      const BatteryModel smaller(effectInfo(GetParam()).needs);
      const CompositionPoint start = embedded(BatteryModel(), baseOptimum(inputs, cost), smaller);
      const CompositionProblem nested(smaller, inputs, cost, start);
      const CompositionFit before = fitComposition(nested, {start});
      const CompositionPoint from =
          withHeldStrengthsVanished(model_, embedded(smaller, before.point, model_));
      const CompositionProblem problem(model_, inputs, cost, from);
      CompositionSearch search;
      search.max_iterations = 15;
      const CompositionFit after = fitComposition(problem, {from}, search);
      // An implicit step in place of the exact one moves the start itself by its tolerance of 0.04
      // mV.
      const bool differs = stepsImplicitly(model_) && !stepsImplicitly(smaller);
      // Evaluated at both points: the cost of a search may be what its last step promised.
      NormalEquations at_before, at_after;
      ASSERT_TRUE(nested.evaluate(nested.coordinatesOf(before.point), at_before));
      ASSERT_TRUE(problem.evaluate(problem.coordinatesOf(after.point), at_after));
      EXPECT_LE(at_after.cost, at_before.cost * (1.0 + (differs ? 1e-3 : 1e-9)))
          << "on data of " << join(battery) << (cost.noise ? ", whitened" : ", weighted");
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Catalogue, EveryEffect, ::testing::ValuesIn(allIds()),
                         [](const auto& instance) { return instance.param; });

TEST(FitComposition, GivesTheSameBitsWithOneThreadAndWithTwo) {
  const BatteryModel model({"charge_acceptance", "acid_transport"});
  const Series series = answeredBy(model, typicalPoint(model), 90.0, 0.002, 9);
  const InputSequence inputs = inputSequence(series, whole(series));
  const CompositionPoint start = typicalStart(model, inputs);
  const CompositionProblem problem(model, inputs, {}, start);
  CompositionSearch search;
  search.more_starts = 3;
  search.max_iterations = 12;
  const CompositionFit one = fitComposition(problem, {start}, search);
  search.threads = 2;
  const CompositionFit two = fitComposition(problem, {start}, search);
  EXPECT_EQ(one.x, two.x);
  EXPECT_EQ(one.at.cost, two.at.cost);
  EXPECT_EQ(one.at.gradient, two.at.gradient);
  EXPECT_EQ(one.at.hessian, two.at.hessian);
  EXPECT_EQ(one.best_start, two.best_start);
  EXPECT_EQ(one.iterations, two.iterations);
}

/// A problem in which no coordinate counts as linear, so none is eliminated.
class NothingEliminated final : public LeastSquaresProblem {
 public:
  explicit NothingEliminated(const CompositionProblem& problem)
      : LeastSquaresProblem(problem), problem_(problem) {
    for (FitCoordinate& coordinate : coordinates_) coordinate.linear = false;
  }
  bool evaluate(const Eigen::VectorXd& x, NormalEquations& equations) const override {
    return problem_.evaluate(x, equations);
  }

 private:
  const CompositionProblem& problem_;
};

TEST(FitComposition, ReachesTheSameOptimumWithEliminationAndWithout) {
  for (const std::vector<std::string>& ids : {std::vector<std::string>{},
                                              {"ocv_soc"},
                                              {"current_dependent_resistance", "acid_transport"},
                                              {"charge_acceptance"}}) {
    const BatteryModel model(ids);
    const Series series = answeredBy(model, typicalPoint(model), 240.0, 0.002, 10);
    const InputSequence inputs = inputSequence(series, whole(series));
    const CompositionPoint start = typicalStart(model, inputs);
    const CompositionProblem problem(model, inputs, whitened(0.002), start);
    const CompositionFit with = fitComposition(problem, {start});
    const CompositionFit without = fitComposition(NothingEliminated(problem), {start});
    EXPECT_NEAR(with.at.cost, without.at.cost, 1e-3) << join(model);
    const Eigen::VectorXd error = standardErrors(with.at.hessian);
    for (Eigen::Index k = 0; k < problem.size(); ++k)
      EXPECT_NEAR(with.x[k], without.x[k], 0.05 * error[k])
          << join(model) << " row " << problem.rowOf(k);
  }
}

TEST(FitComposition, WithEliminationFindsTheOptimumInsideTheBoundsOfManyLinearStrengths) {
  // Strengths of either sign in the data, of one sign in the bounds: which bounds hold is part of
  // the question. With the rest fixed the cost has one optimum, which a search without elimination
  // finds too.
  const BatteryModel model({"ocv_soc", "fast_arc", "current_dependent_resistance",
                            "contact_resistance", "coup_de_fouet", "voltage_drift"});
  std::vector<std::string> fixed;
  for (const ParameterInfo& info : model.parameters())
    if (!info.linear) fixed.push_back(info.name);
  Random random(5);
  for (int draw = 0; draw < 30; ++draw) {
    Eigen::VectorXd truth = livelyPoint(model);
    CompositionPoint start{truth, model.restState()};
    for (Eigen::Index j = kBaseRows; j < truth.size(); ++j) {
      const ParameterInfo& info = model.parameters()[static_cast<std::size_t>(j)];
      if (info.linear) truth[j] *= random.uniform(-1.0, 1.0);
      if (info.vanishes_at) start.parameters[j] = *info.vanishes_at;
    }
    const Series series =
        answeredBy(model, truth, 120.0, 0.002, 100 + static_cast<std::uint64_t>(draw));
    const InputSequence inputs = inputSequence(series, whole(series));
    const CompositionProblem problem(model, inputs, whitened(0.002), start, fixed);
    const CompositionFit with = fitComposition(problem, {start});
    CompositionSearch search;
    search.max_iterations = 300;
    const CompositionFit without = fitComposition(NothingEliminated(problem), {start}, search);
    EXPECT_LE(with.at.cost, without.at.cost + 1e-2) << "draw " << draw;
    EXPECT_TRUE((with.x.array() >= problem.lower().array()).all() &&
                (with.x.array() <= problem.upper().array()).all());
  }
}

TEST(FitComposition, OfACompressedDriveEndsWithinAThirdOfAStandardErrorOfTheFullRate) {
  for (const std::vector<std::string>& ids :
       {std::vector<std::string>{"current_dependent_resistance", "acid_transport"},
        {"charge_acceptance"}}) {
    const BatteryModel model(ids);
    const Series series = answeredBy(model, typicalPoint(model), 240.0, 0.002, 12, 0.01);
    const InputSequence full = inputSequence(series, whole(series)),
                        compressed = compressedInputs(series, whole(series));
    const CompositionPoint start{typicalPoint(model), model.restState()};
    const CompositionProblem at_full(model, full, whitened(0.002), start),
        at_compressed(model, compressed, whitened(0.002), start);
    const CompositionFit fine = fitComposition(at_full, {start}),
                         coarse = fitComposition(at_compressed, {start});
    const Eigen::VectorXd error = standardErrors(fine.at.hessian);
    for (Eigen::Index k = 0; k < at_full.size(); ++k)
      EXPECT_LT(std::abs(fine.x[k] - coarse.x[k]), error[k] / 3.0)
          << join(model) << " row " << at_full.rowOf(k);
  }
}

TEST(FitComposition, KeepsTheBestOfItsStarts) {
  const BatteryModel model({"second_electrode"});
  const Series series = answeredBy(model, typicalPoint(model), 90.0, 0.002, 13);
  const InputSequence inputs = inputSequence(series, whole(series));
  const CompositionPoint start = embedded(BatteryModel(), baseOptimum(inputs, {}), model);
  CompositionPoint truth{typicalPoint(model), model.restState()};
  const CompositionProblem problem(model, inputs, {}, start);
  CompositionSearch one_step;
  one_step.max_iterations = 1;
  const CompositionFit both = fitComposition(problem, {start, truth}, one_step);
  EXPECT_EQ(both.best_start, 1);
  EXPECT_LE(both.at.cost, fitComposition(problem, {start}, one_step).at.cost);
}

// ---------------------------------------------------------------------------------- points

TEST(Embedded, KeepsWhatIsNestedAndPutsTheRestWhereItVanishesOrIsTypical) {
  const BatteryModel nested({"acid_transport"}),
      larger({"gassing", "acid_transport", "charge_transfer", "cpe2"});
  CompositionPoint point{typicalPoint(nested) * 1.1, nested.restState()};
  point.state << 0.05, 3.0, -2.0;
  const CompositionPoint out = embedded(nested, point, larger);
  for (Eigen::Index j = 0; j < nested.parameterCount(); ++j)
    EXPECT_EQ(
        out.parameters[*larger.parameterRow(nested.parameters()[static_cast<std::size_t>(j)].name)],
        point.parameters[j]);
  EXPECT_EQ(out.parameters[*larger.parameterRow("gassing_current")], 0.0);
  EXPECT_EQ(out.parameters[*larger.parameterRow("gassing_slope")], 1.83);
  EXPECT_EQ(out.parameters[*larger.parameterRow("exchange_current")], 1.0);
  EXPECT_EQ(out.parameters[*larger.parameterRow("dispersion")], 0.0);
  EXPECT_EQ(out.state[0], 0.05);
  EXPECT_EQ(out.state.tail(2), point.state.tail(2));
}

TEST(Embedded, PointOfTheLargerCompositionHasTheNestedVoltage) {
  const Series series = livelyMinute(0.1);
  const InputSequence inputs = inputSequence(series, whole(series));
  const BatteryModel base;
  CompositionPoint point{typicalPoint(base), base.restState()};
  point.state[0] = 0.05;
  const CompositionProblem nested(base, inputs, {}, point);
  const Eigen::VectorXd before = nested.residual(nested.coordinatesOf(point));
  for (const std::string& id : allIds()) {
    const BatteryModel model(withNeeds(id));
    const CompositionPoint start = withHeldStrengthsVanished(model, embedded(base, point, model));
    const CompositionProblem problem(model, inputs, {}, start);
    const Eigen::VectorXd after = problem.residual(problem.coordinatesOf(start));
    EXPECT_LT((after - before).cwiseAbs().maxCoeff(), stepsImplicitly(model) ? 2e-4 : 1e-12) << id;
  }
}

TEST(TypicalStart, TakesTheRestVoltageFromTheDrivesMean) {
  const Series series = baseDrive(2, 60.0);
  const BatteryModel model({"ocv_soc"});
  const CompositionPoint full = typicalStart(model, inputSequence(series, whole(series)));
  double sum = 0.0;
  for (double u : series.voltage) sum += u;
  EXPECT_NEAR(full.parameters[kRowUDc], sum / static_cast<double>(series.size()), 1e-9);
  EXPECT_NEAR(typicalStart(model, compressedInputs(series, whole(series))).parameters[kRowUDc],
              full.parameters[kRowUDc], 1e-9);
  EXPECT_EQ(full.parameters[kRowC2], 1000.0);
}

TEST(Identify, FindsWhenAContactChangedWhereverInTheWindowThatWas) {
  for (const double changed : {35.0, 200.0}) {
    Series series = baseDrive(11);
    for (std::size_t n = 0; n < series.size(); ++n)
      if (series.time[n] > changed) series.voltage[n] += 0.002 * series.current[n];
    IdentifyOptions options;
    options.effects = {"contact_resistance"};
    const FittedModel model = identify(series, {0, series.size()}, options);
    const auto of = [&](const char* name) {
      for (const ParameterEstimate& estimate : model.fit.estimates)
        if (estimate.name == name) return estimate.value;
      return std::nan("");
    };
    EXPECT_NEAR(of("contact_time"), changed, 2.0);
    EXPECT_NEAR(of("contact_step"), 0.002, 0.0002);
  }
}

}  // namespace battery_sof
