#include <gtest/gtest.h>

#include <memory>

#include "diagnosis/effect_search.hpp"
#include "estimation/identification.hpp"
#include "support/sourced_drive.hpp"

/// Explanations of drives whose source controls the voltage.
namespace battery_sof {
namespace {

using namespace test;

constexpr std::size_t kSamples = 1500;

std::unique_ptr<ExplanationFits> fitsTo(const Series& series,
                                        const std::vector<char>& voltage_controlled) {
  const InputSequence inputs = inputSequence(series, {0, series.size()}, {}, voltage_controlled);
  const CompositionPoint base{typicalPoint(BatteryModel()), BatteryModel().restState()};
  return std::make_unique<ExplanationFits>(inputs, base, DiagnoseOptions());
}

std::unique_ptr<ExplanationFits> fitsTo(const std::vector<std::string>& law) {
  const Series series = sourcedDrive(kSamples, knownModel(law), 11);
  return fitsTo(series, chargerControl(series).value().voltage_controlled);
}

/// Whether fresh_sulphate predicts as well as a mechanism's regressors.
bool predictsAsWell(ExplanationFits& fits, Mechanism mechanism = Mechanism::kAcceptance) {
  EffectSearch search(fits, {"fresh_sulphate"});
  ExplanationState circuit = fits.baseState();
  fits.evaluateEvidence(circuit);
  search.takeGrid();
  return fits.predictsAsWell(search.with(circuit, "fresh_sulphate").value(),
                             fits.withRegressors(circuit, mechanism));
}

TEST(RegulatedVoltage, AnEquationPredictsAsWellAsRegressorsWhereItIsTheLawAndNotWhereTheyHoldIt) {
  EXPECT_TRUE(predictsAsWell(*fitsTo({"fresh_sulphate"})));
  EXPECT_FALSE(predictsAsWell(*fitsTo({"second_electrode"}), Mechanism::kStructure));
}

/// Rows that bend: by ln evidence alone the fit ends 2.6 above at half the circuit, where the rows
/// are missed by more.
TEST(RegulatedVoltage, ACircuitFarOffComesToTheSameFit) {
  const std::unique_ptr<ExplanationFits> fits = fitsTo(std::vector<std::string>{"ocv_hysteresis"});
  ExplanationState near = fits->baseState();
  fits->begin(near, ExplanationFits::kMaxIterations);
  for (const double factor : {0.1, 0.5, 2.0, 8.0}) {
    ExplanationState far = fits->baseState();
    far.point.parameters.head(kRowUDc) *= factor;
    fits->begin(far, ExplanationFits::kMaxIterations);
    EXPECT_NEAR(near.evidence, far.evidence, 0.1) << factor;
    EXPECT_NEAR(near.fit.noise, far.fit.noise, 1e-6) << factor;
  }
}

/// By how far each misses the rows once the columns are fitted along, prior included: the formula of
/// StepCost over the rows themselves. Of a law of no strength the shape moves the prior alone.
TEST(RegulatedVoltage, TheBetterOfTwoStartsIsTheOneThatMissesTheRowsByLess) {
  const std::unique_ptr<ExplanationFits> fits = fitsTo(std::vector<std::string>{"ocv_hysteresis"});
  ExplanationState circuit = fits->baseState();
  circuit.model = BatteryModel({"ocv_hysteresis"});
  circuit.coordinates = fits->coordinatesOf(circuit.model);
  circuit.point = embedded(BatteryModel(), circuit.point, circuit.model);
  const Eigen::Index shape = *circuit.model.parameterRow("hysteresis_charge");
  std::vector<ExplanationState> starts;
  for (const Eigen::Index row :
       {Eigen::Index{kRowRDischarge}, Eigen::Index{kRowC2}, Eigen::Index{kRowBeta}, shape})
    for (const double factor : {0.5, 0.9, 1.1, 2.0}) {
      ExplanationState start = circuit;
      start.point.parameters[row] *= factor;
      ASSERT_TRUE(fits->linearize(start));
      fits->evaluateEvidence(start);
      starts.push_back(start);
    }
  int pairs_unlike_evidence = 0;
  for (const ExplanationState& other : starts) {
    const ExplanationSums sums = fits->sumsOf(other, false);
    const Eigen::Index known = sums.problem.known(), free = sums.problem.products.rows() - known;
    const Eigen::MatrixXd columns =
        fits->penalised(sums, other).bottomRightCorner(free, free).eval();
    const auto missed = [&](const ExplanationState& state) {
      Eigen::VectorXd std;
      const Eigen::VectorXd prior = ExplanationFits::expectedFrom(state, std).cwiseQuotient(std);
      const Eigen::VectorXd rows = fits->whitened(state.error);
      const Eigen::VectorXd h = sums.columns.along(rows).tail(free);
      return rows.squaredNorm() - h.dot(columns.ldlt().solve(h)) +
             prior.squaredNorm() * other.fit.noise * other.fit.noise /
                 fits->effectiveSampleFraction();
    };
    for (const ExplanationState& one : starts) {
      if (&one == &other) continue;
      const bool is_better = missed(one) < missed(other);
      EXPECT_EQ(is_better, fits->fitsBetter(one, other))
          << one.point.parameters.transpose() << " and " << other.point.parameters.transpose();
      pairs_unlike_evidence += is_better != (one.evidence > other.evidence) ? 1 : 0;
    }
  }
  EXPECT_GT(pairs_unlike_evidence, 0);
}

/// Ten minutes between samples: forward sensitivities of the implicit steps grow without a bound
/// there, and no step could be solved for.
TEST(RegulatedVoltage, DerivativesThatDivergeAreNoLinearization) {
  Series series = sourcedDrive(kSamples, knownModel({"fresh_sulphate"}), 11);
  for (double& time : series.time) time *= 600.0;
  const auto fits = fitsTo(series, std::vector<char>(series.size(), 1));
  ExplanationState state = fits->baseState();
  EXPECT_TRUE(fits->linearize(state));
  state.model = BatteryModel({"fresh_sulphate"});
  state.coordinates = fits->coordinatesOf(state.model);
  state.point = embedded(BatteryModel(), state.point, state.model);
  state.point.parameters << 0.0103, 0.0085, 108.0, 7.28, 13.155, 1.0, 2.942, 9.683, 0.3, 1.4713,
      16.218, 0.02553, 5.246;
  state.point.state << 0.6, 1.0, 18.0;
  EXPECT_FALSE(fits->linearize(state));
  EXPECT_LT(state.error.cwiseAbs().maxCoeff(), 100.0);  // a voltage there is

  // What is left without a part begins at the base circuit then.
  const CompositionPoint there = state.point;
  state.members = {"fresh_sulphate", "ocv_soc"};
  state.model = BatteryModel(state.members);
  state.coordinates = fits->coordinatesOf(state.model);
  state.point = embedded(BatteryModel({"fresh_sulphate"}), there, state.model);
  state.evidence = 1e9;
  const ExplanationState without = fits->withoutMembers(state, {"ocv_soc"});
  EXPECT_TRUE(std::isfinite(without.evidence));
  EXPECT_LT(without.evidence, 1e6);
}

TEST(RegulatedVoltage, TheRuleIsForVoltagesThatAreControlled) {
  const Series series = sourcedDrive(kSamples, knownModel({"fresh_sulphate"}), 11);
  EXPECT_FALSE(predictsAsWell(*fitsTo(series, {})));
}

TEST(RegulatedVoltage, AnEquationStandsWithAnotherEffectThatIsNotWeighed) {
  for (const char* other : {"charge_transfer", "gassing"}) {
    const Explanation found = explain(*fitsTo({"fresh_sulphate", other}), {"fresh_sulphate"}, {});
    ASSERT_EQ(1u, found.terms.size()) << other;
    EXPECT_EQ("fresh_sulphate", found.terms.front().member) << other;
  }
}

TEST(RegulatedVoltage, AnotherLawOfTheMechanismGetsItsRegressors) {
  const Explanation found = explain(*fitsTo({"charge_acceptance"}), {"fresh_sulphate"}, {});
  ASSERT_FALSE(found.terms.empty());
  EXPECT_EQ(Mechanism::kAcceptance, found.terms.front().mechanism);
  EXPECT_EQ("", found.terms.front().member);
}

}  // namespace
}  // namespace battery_sof
