#include "report/model_yaml.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "diagnosis/response_table.hpp"
#include "estimation/identification.hpp"
#include "prediction/questions.hpp"
#include "prediction/scores.hpp"
#include "report/results.hpp"
#include "state/state_estimator.hpp"
#include "support/start_stop.hpp"

namespace battery_sof {
namespace {

FittedModel fittedModel() {
  Series series = test::baseDrive(1);
  series.temperature_time = {0.0};
  series.temperature = {298.15};
  FittedModel model = identify(series, {0, series.size()});
  model.provenance.recording = "drive \"one\": a test.csv";
  model.provenance.recording_hash = "sha256:0123";
  model.provenance.fit_ms = 4.25;
  return model;
}

/// The text with one line's beginning replaced.
std::string with(const std::string& text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return std::string(text).replace(at, from.size(), to);
}

std::string errorOf(const std::string& text) {
  try {
    parseModelYaml(text, "model.yaml");
  } catch (const ModelFileError& error) {
    return error.what();
  }
  return "";
}

TEST(ModelYaml, ReadsBackWhatItWrote) {
  const FittedModel model = fittedModel();
  const FittedModel back = parseModelYaml(modelYaml(model), "model.yaml");
  EXPECT_DOUBLE_EQ(back.fit.parameters.r_discharge, model.fit.parameters.r_discharge);
  EXPECT_DOUBLE_EQ(back.fit.parameters.beta, model.fit.parameters.beta);
  EXPECT_DOUBLE_EQ(back.fit.parameters.u_dc, model.fit.parameters.u_dc);
  EXPECT_DOUBLE_EQ(back.state.states[0], model.state.states[0]);
  EXPECT_DOUBLE_EQ(back.state.time, model.state.time);
  EXPECT_TRUE(back.fit.covariance.isApprox(model.fit.covariance, 1e-12));
  EXPECT_EQ(back.fit.status, model.fit.status);
  EXPECT_EQ(back.provenance.recording, model.provenance.recording);
  EXPECT_EQ(back.provenance.recording_hash, model.provenance.recording_hash);
  EXPECT_DOUBLE_EQ(*back.fit.excited.temperature, *model.fit.excited.temperature);
  EXPECT_EQ(back.fit.window.samples, model.fit.window.samples);
  EXPECT_EQ(modelYaml(back), modelYaml(model));
}

TEST(ModelYaml, AnswersQueriesAsTheModelItCameFrom) {
  const FittedModel model = fittedModel();
  const FittedModel back = parseModelYaml(modelYaml(model), "model.yaml");
  CrankingQuery query;
  query.i_load = -20.0;
  query.t_stop = 10.0;
  query.i_cranking = -200.0;
  EXPECT_NEAR(predictCranking(back, query).u_min->value, predictCranking(model, query).u_min->value,
              1e-12);
  EXPECT_NEAR(predictCranking(back, query).u_min->lower, predictCranking(model, query).u_min->lower,
              1e-9);
}

TEST(ModelYaml, KeepsWhatIsMissedAtThePresentLoadAndTheAnswerThatWasMissed) {
  FittedModel model = fittedModel();
  PresentError& present = model.state.residual_state.present;
  present = {-12.5, 40.0, -0.8, 250.0, {1e-6, 4e-6, 9e-5}, {10.0, 5.0, 4.0}};
  model.intervals.missed_answer = MissedAnswer{95.0, 6.5, 11.4, 11.6};
  const FittedModel read = parseModelYaml(modelYaml(model), "m.yaml");
  const PresentError& back = read.state.residual_state.present;
  EXPECT_EQ(back.current, present.current);
  EXPECT_EQ(back.since, present.since);
  EXPECT_EQ(back.level, present.level);
  EXPECT_EQ(back.largest, present.largest);
  EXPECT_EQ(back.squares, present.squares);
  EXPECT_EQ(back.weights, present.weights);
  ASSERT_TRUE(read.intervals.missed_answer);
  EXPECT_EQ(read.intervals.missed_answer->measured, 6.5);
  EXPECT_EQ(read.intervals.missed_answer->upper, 11.6);
}

TEST(ModelYaml, KeepsAMissingStandardErrorMissing) {
  FittedModel model = fittedModel();
  model.fit.estimates[1].std.reset();
  model.fit.covariance.row(1).setZero();
  model.fit.covariance.col(1).setZero();
  EXPECT_FALSE(parseModelYaml(modelYaml(model), "model.yaml").fit.estimates[1].std.has_value());
}

TEST(ModelYaml, TheJsonOfAnIdentificationHasAnIdOfItsOwnAndIsRefusedForWhatItIs) {
  const nlohmann::json json = resultJson(fittedModel());
  EXPECT_EQ(json["schema"], kIdentificationSchema);
  EXPECT_STRNE(kIdentificationSchema, kModelSchema);
  const std::string error = errorOf(json.dump());
  for (const char* part : {"that of the JSON of sof identify", "of model files before 0.3",
                           "sof identify REC --out MODEL.yaml"})
    EXPECT_NE(error.find(part), std::string::npos) << error;
}

TEST(ModelYaml, NamesFileFieldAndExpectationOfEveryFault) {
  const std::string good = modelYaml(fittedModel());
  EXPECT_NE(errorOf("{").find("not YAML"), std::string::npos);
  EXPECT_NE(errorOf("- 1\n").find("expected a YAML map"), std::string::npos);
  EXPECT_NE(errorOf("").find("model.yaml"), std::string::npos);
  EXPECT_NE(errorOf(with(good, "battery_sof/model/2", "battery_sof/model/9")).find("schema"),
            std::string::npos);
  EXPECT_NE(errorOf(with(good, "  beta:", "  gamma:")).find("parameters.beta is missing"),
            std::string::npos);
  EXPECT_NE(errorOf(with(good, "alpha: 0.5", "alpha: two"))
                .find("fixed.alpha is \"two\", expected a number"),
            std::string::npos);
  EXPECT_NE(errorOf(with(good, "alpha: 0.5", "alpha: 0.3"))
                .find("fixed.alpha is 0.3, expected 0.5 to 0.5"),
            std::string::npos);
  EXPECT_NE(errorOf(with(good, "i0_a: 1", "i0_a: 2")).find("fixed.i0_a is 2, expected 1 to 1"),
            std::string::npos);
  EXPECT_NE(errorOf(with(good, "alpha: 0.5", "alpha: .nan")).find("not finite"), std::string::npos);
  EXPECT_NE(
      errorOf(with(good, "status: converged", "status: lucky")).find("fit.status is \"lucky\""),
      std::string::npos);
  // a part whose name is mistyped is not one that is absent
  EXPECT_NE(errorOf(with(good, "errors:", "error:")).find("errors is missing"), std::string::npos);
  EXPECT_NE(errorOf(with(good, "window:", "event_histry: {}\nwindow:"))
                .find("event_histry is not a known key here, expected "),
            std::string::npos);
  EXPECT_NE(errorOf(with(good, "alpha: 0.5", "alpha: 0.5\n  bta: 1"))
                .find("fixed.bta is not a known key"),
            std::string::npos);
  EXPECT_NE(errorOf(with(good, "correlation:\n", "correlation: []\nunused:\n")).find("correlation"),
            std::string::npos);
}

/// A composition fitted to data of the base model: values and correlations of every kind, some
/// held, some at a bound.
FittedModel fittedComposition(const std::vector<std::string>& effects) {
  Series series = test::everyNth(test::baseDrive(1, 120.0), 10);
  IdentifyOptions options;
  options.effects = effects;
  options.more_starts = 0;
  return identify(series, {0, series.size()}, options);
}

TEST(ModelYaml, ReadsBackEveryEffectWithItsParametersStatesAndCorrelations) {
  for (const EffectInfo& info : effectCatalogue()) {
    const FittedModel model = fittedComposition(test::withNeeds(info.id));
    const FittedModel back = parseModelYaml(modelYaml(model), "model.yaml");
    EXPECT_EQ(back.fit.effects, model.fit.effects) << info.id;
    ASSERT_EQ(back.fit.estimates.size(), model.fit.estimates.size()) << info.id;
    for (std::size_t j = 0; j < model.fit.estimates.size(); ++j) {
      EXPECT_EQ(back.fit.estimates[j].name, model.fit.estimates[j].name);
      EXPECT_EQ(back.fit.estimates[j].value, model.fit.estimates[j].value);
      EXPECT_EQ(back.fit.estimates[j].std, model.fit.estimates[j].std);
      EXPECT_EQ(back.fit.estimates[j].held, model.fit.estimates[j].held);
      EXPECT_EQ(back.fit.estimates[j].at_bound, model.fit.estimates[j].at_bound);
    }
    EXPECT_EQ(back.state.states, model.state.states) << info.id;
    ASSERT_EQ(back.fit.covariance.rows(), model.fit.covariance.rows()) << info.id;
    for (Eigen::Index j = 0; j < model.fit.covariance.rows(); ++j)
      for (Eigen::Index k = 0; k < model.fit.covariance.rows(); ++k)
        EXPECT_NEAR(back.fit.covariance(j, k), model.fit.covariance(j, k),
                    1e-9 * std::sqrt(model.fit.covariance(j, j) * model.fit.covariance(k, k)))
            << info.id << " " << j << " " << k;
    EXPECT_EQ(modelYaml(back), modelYaml(model)) << info.id;
  }
}

TEST(ModelYaml, NamesWhatIsWrongWithTheEffectsOfAFile) {
  const std::string good = modelYaml(fittedComposition({"acid_transport", "ocv_soc"}));
  ASSERT_EQ(errorOf(good), "");
  const auto error = [&](const char* from, const char* to) {
    return errorOf(with(good, from, to));
  };
  EXPECT_NE(error("[acid_transport, ocv_soc]", "[acid_transport, ocv_sock]")
                .find("\"ocv_sock\" is not known"),
            std::string::npos);
  EXPECT_NE(error("[acid_transport, ocv_soc]", "[sulphate_history]").find("charge_acceptance"),
            std::string::npos);
  EXPECT_NE(error("[acid_transport, ocv_soc]", "[ocv_soc, ocv_soc]").find("twice"),
            std::string::npos);
  EXPECT_NE(
      error("[acid_transport, ocv_soc]", "5").find("effects is \"5\", expected a list of ids"),
      std::string::npos);
  EXPECT_NE(error("  ocv_slope:", "  ocv_steepness:").find("parameters.ocv_slope is missing"),
            std::string::npos);
  EXPECT_NE(error("    acid_current_2:", "    acid_current_3:")
                .find("state.further.acid_current_2 is missing"),
            std::string::npos);
  EXPECT_NE(error("  further:", "  other:").find("state.further is missing"), std::string::npos);
  // Without ocv_soc the file has a row for its parameter and one for its state too many.
  EXPECT_NE(error("[acid_transport, ocv_soc]", "[acid_transport]")
                .find("correlation must be 12 rows of 12 numbers"),
            std::string::npos);
}

TEST(ModelYaml, KeepsTheMarkOfAHeldParameter) {
  const FittedModel model = fittedComposition({"gassing"});
  const std::string text = modelYaml(model);
  const auto at = text.find("  oxygen_limit:");
  ASSERT_NE(at, std::string::npos);
  EXPECT_NE(text.substr(at, text.find('\n', at) - at).find("held: true"), std::string::npos);
  EXPECT_TRUE(parseModelYaml(text, "model.yaml").fit.estimates.back().held);
}

TEST(ModelYaml, OfACompositionAnswersQueriesAsTheModelItCameFrom) {
  const FittedModel model = fittedComposition({"acid_transport", "charge_acceptance"});
  const FittedModel back = parseModelYaml(modelYaml(model), "model.yaml");
  CrankingQuery query;
  query.i_load = -20.0;
  query.t_stop = 10.0;
  query.i_cranking = -200.0;
  const Interval before = *predictCranking(model, query).u_min,
                 after = *predictCranking(back, query).u_min;
  EXPECT_NEAR(after.value, before.value, 1e-12);
  EXPECT_NEAR(after.lower, before.lower, 1e-6);
}

/// A model with everything that a source brings: rule, lag, baseline predictors, past events, what
/// was estimated and its memory.
class ModelYamlBothWays : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    const BatteryModel composition({"fresh_sulphate"});
    test::StartStopOptions options;
    options.duration = 1500.0;
    options.current_noise = 0.1;
    options.voltage_noise = 0.01;
    inputs_ = new test::StartStopDrive(
        test::startStopDrive(composition, test::freshBattery(composition), options));
    IdentifyOptions identification;
    identification.source = test::knownSource(*inputs_);
    identification.source->repair.lag = 1;
    identification.effects = {"fresh_sulphate"};
    // A battery of which the equations miss something.
    Series series = inputs_->series;
    for (std::size_t n = 1; n < series.size(); ++n)
      if (inputs_->controlled[n]) series.current[n] += 3.0 * (series.voltage[n] - 13.8);
    model_ = new FittedModel(identify(series, {0, 900}, identification));
    fitErrors(*model_, series, {0, 900});
    text_ = new std::string(modelYaml(*model_));
  }
  static void TearDownTestSuite() {
    delete inputs_;
    delete model_;
    delete text_;
  }
  /// What is said of the text with one line's beginning replaced.
  static std::string error(const std::string& from, const std::string& to) {
    return errorOf(with(*text_, from, to));
  }
  /// The text with the value of one line replaced.
  static std::string withValue(const std::string& key, const std::string& value) {
    const auto at = text_->rfind(key);
    EXPECT_NE(at, std::string::npos) << key;
    const auto begin = at + key.size();
    return std::string(*text_).replace(begin, text_->find('\n', begin) - begin, " " + value);
  }
  static void expectError(const std::string& text, const std::string& piece) {
    const std::string said = errorOf(text);
    EXPECT_NE(said.find(piece), std::string::npos) << "said: " << said << "\nexpected: " << piece;
  }

  static test::StartStopDrive* inputs_;
  static FittedModel* model_;
  static std::string* text_;
};
test::StartStopDrive* ModelYamlBothWays::inputs_ = nullptr;
FittedModel* ModelYamlBothWays::model_ = nullptr;
std::string* ModelYamlBothWays::text_ = nullptr;

TEST_F(ModelYamlBothWays, ReadsBackSourceNaivePredictorsPastEventsAndWhatWasLearnt) {
  const FittedModel& model = *model_;
  ASSERT_TRUE(model.fit.source);
  ASSERT_FALSE(model.fit.residual_regression.current.empty());
  ASSERT_FALSE(model.intervals.event_history.cranks.empty());
  ASSERT_FALSE(model.intervals.event_history.charges.empty());
  ASSERT_TRUE(model.fit.baseline.current_from_voltage && model.fit.baseline.voltage_from_current &&
              model.fit.baseline.cranks);
  const FittedModel back = parseModelYaml(*text_, "model.yaml");
  ASSERT_TRUE(back.fit.source);
  EXPECT_TRUE(back.fit.source->present);
  EXPECT_EQ(back.fit.source->min_current, model.fit.source->min_current);
  EXPECT_EQ(back.fit.source->charge_begins, model.fit.source->charge_begins);
  EXPECT_EQ(back.fit.source->current_noise, model.fit.source->current_noise);
  EXPECT_EQ(back.fit.source->voltage_noise, model.fit.source->voltage_noise);
  EXPECT_EQ(back.fit.source->resistance, model.fit.source->resistance);
  EXPECT_EQ(back.fit.source->max_gap, model.fit.source->max_gap);
  EXPECT_EQ(back.fit.voltage_lag, 1u);
  EXPECT_EQ(back.fit.baseline.current_from_voltage->slope,
            model.fit.baseline.current_from_voltage->slope);
  EXPECT_EQ(back.fit.baseline.voltage_from_current->samples,
            model.fit.baseline.voltage_from_current->samples);
  EXPECT_EQ(back.fit.baseline.cranks->intercept, model.fit.baseline.cranks->intercept);
  EXPECT_EQ(back.fit.baseline.phase.has_value(), model.fit.baseline.phase.has_value());
  ASSERT_EQ(back.intervals.event_history.cranks.size(),
            model.intervals.event_history.cranks.size());
  EXPECT_EQ(back.intervals.event_history.cranks.back().modelled,
            model.intervals.event_history.cranks.back().modelled);
  ASSERT_EQ(back.intervals.event_history.charges.size(),
            model.intervals.event_history.charges.size());
  EXPECT_EQ(back.intervals.event_history.charges.front().first_voltage,
            model.intervals.event_history.charges.front().first_voltage);
  EXPECT_EQ(back.fit.residual_regression.current.weight,
            model.fit.residual_regression.current.weight);
  EXPECT_EQ(back.fit.residual_regression.current.upper,
            model.fit.residual_regression.current.upper);
  EXPECT_EQ(back.fit.residual_regression.min_current, model.fit.residual_regression.min_current);
  EXPECT_EQ(back.fit.residual_regression.max_current, model.fit.residual_regression.max_current);
  EXPECT_EQ(back.fit.residual_regression.voltage.weight,
            model.fit.residual_regression.voltage.weight);
  EXPECT_EQ(back.state.memory.numbers(), model.state.memory.numbers());
  EXPECT_EQ(back.fit.scores.current_rmse, model.fit.scores.current_rmse);
  ASSERT_TRUE(model.fit.scores.left_out_share_percent);
  EXPECT_EQ(back.fit.scores.left_out_share_percent, model.fit.scores.left_out_share_percent);
  EXPECT_EQ(modelYaml(back), *text_);
}

TEST_F(ModelYamlBothWays, PredictsAsTheModelItCameFrom) {
  const FittedModel back = parseModelYaml(*text_, "model.yaml");
  const IndexRange rest{900, inputs_->series.size()};
  const FollowedPrediction before = predictSeries(*model_, inputs_->series, rest);
  const FollowedPrediction after = predictSeries(back, inputs_->series, rest);
  EXPECT_EQ(after.voltage_controlled, before.voltage_controlled);
  for (std::size_t k = 0; k < rest.size(); ++k) {
    ASSERT_NEAR(after.current[k], before.current[k], 1e-9);
    ASSERT_NEAR(after.voltage[k], before.voltage[k], 1e-9);
    ASSERT_NEAR(after.current_upper[k], before.current_upper[k], 1e-4);
  }
}

TEST_F(ModelYamlBothWays, AFileWithoutThemIsAModelWithoutThem) {
  const FittedModel back = parseModelYaml(modelYaml(fittedModel()), "model.yaml");
  EXPECT_FALSE(back.fit.source);
  EXPECT_TRUE(back.fit.residual_regression.empty());
  EXPECT_TRUE(back.intervals.event_history.cranks.empty() &&
              back.intervals.event_history.charges.empty());
  EXPECT_FALSE(back.state.memory.begun);
  EXPECT_EQ(back.fit.voltage_lag, 0u);
  EXPECT_FALSE(back.fit.scores.left_out_share_percent);
}

TEST_F(ModelYamlBothWays, NamesWhatIsWrongWithASource) {
  expectError(withValue("  charge_begins:", "power"),
              "source.charge_begins is \"power\", expected voltage or current");
  expectError(withValue("  min_current_a:", ".nan"), "source.min_current_a is not finite");
  expectError(withValue("  current_noise_a:", "-1"),
              "source.min_current_a and its neighbours cannot be used");
  expectError(withValue("  max_gap_s:", "long"), "source.max_gap_s is \"long\", expected a number");
  expectError(withValue("  voltage_lag_samples:", "-1"),
              "source.voltage_lag_samples is \"-1\", expected a whole number");
  expectError(with(*text_, "  voltage_lag_samples:", "  voltage_lag:"),
              "source.voltage_lag_samples is missing");
}

TEST_F(ModelYamlBothWays, NamesWhatIsWrongWithNaivePredictors) {
  expectError(withValue("  current_from_voltage:", "[1, 2]"),
              "baseline.current_from_voltage has 2 numbers, expected 8");
  expectError(withValue("  voltage_from_current:", "none"),
              "baseline.voltage_from_current is \"none\", expected 8 numbers");
  expectError(withValue("  charge_10s:", "[1, 2, 3, 4, .inf]"),
              "baseline.charge_10s holds a number that is not finite");
}

TEST_F(ModelYamlBothWays, NamesWhatIsWrongWithPastEvents) {
  expectError(with(*text_, "event_history:\n", "event_history:\n  cranks: [[1, 2, 3]]\nunused:\n"),
              "event_history.cranks must be rows of 4 numbers");
  expectError(with(*text_, "event_history:\n", "event_history:\n  charges: 7\nunused:\n"),
              "event_history.charges is \"7\", expected rows of 6 numbers");
  expectError(
      with(*text_, "event_history:\n", "event_history:\n  cranks: [[1, 2, 3, .nan]]\nunused:\n"),
      "event_history.cranks holds a number that is not finite");
}

TEST_F(ModelYamlBothWays, NamesWhatIsWrongWithWhatWasLearnt) {
  expectError(withValue("  current_range_a:", "[5, -5]"),
              "residual_regression.current_range_a must rise");
  expectError(withValue("  current_range_a:", "[5]"),
              "residual_regression.current_range_a has 1 numbers, expected 2");
  expectError(withValue("    weight:", "[1, 2]"),
              "and its neighbours must be as many finite numbers");
  expectError(withValue("    constant:", ".inf"), "constant is not finite");
  expectError(withValue("  memory:", "[1, 2, 3]"), "state.memory has 3 numbers, expected 20");
  // A scale of nothing would divide by it.
  std::string zeros = "[";
  for (Eigen::Index j = 0; j < InputMemory::kCurrentColumns; ++j) zeros += j ? ", 0" : "0";
  expectError(withValue("    scale:", zeros + "]"),
              "and its neighbours must be as many finite numbers, scales above 0");
}

TEST(ModelYaml, HoldsTheBlocksOfARowAndNothingOfOneBlock) {
  FittedModel model = fittedModel();
  EXPECT_FALSE(modelYaml(model).find("blocks:") != std::string::npos);
  EXPECT_EQ(parseModelYaml(modelYaml(model), "m.yaml").fit.series_blocks, 1.0);
  model.fit.series_blocks = 2.0;
  EXPECT_EQ(parseModelYaml(modelYaml(model), "m.yaml").fit.series_blocks, 2.0);
  EXPECT_EQ(modelYaml(parseModelYaml(modelYaml(model), "m.yaml")), modelYaml(model));
  try {
    parseModelYaml(with(modelYaml(model), "blocks: 2", "blocks: 2.2"), "m.yaml");
    FAIL() << "2.2 blocks were taken";
  } catch (const ModelFileError& error) {
    EXPECT_NE(std::string(error.what())
                  .find("m.yaml: series_blocks is 2.2, expected 0.5 (6 V), 1 (12 V), 2 (24 V)"),
              std::string::npos)
        << error.what();
  }
}

/// A model of a start-stop drive with the responses of its recording.
FittedModel modelWithResponses() {
  const BatteryModel composition({"fresh_sulphate"});
  test::StartStopOptions options;
  options.duration = 1500.0;
  FittedModel model = fittedModel();
  model.responses = responseTable(
      test::startStopDrive(composition, test::freshBattery(composition), options).series);
  return model;
}

TEST(ModelYaml, KeepsTheResponsesOfItsRecording) {
  const FittedModel model = modelWithResponses();
  ASSERT_TRUE(model.responses);
  const std::string text = modelYaml(model);
  const FittedModel back = parseModelYaml(text, "model.yaml");
  ASSERT_TRUE(back.responses);
  EXPECT_EQ(modelYaml(back), text);
  EXPECT_LT(text.size(), 60000u);
  for (const auto& [kind, strength] : {std::pair(ChangeKind::kContact, 0.0),
                                       {ChangeKind::kContact, 0.0033},
                                       {ChangeKind::kSkew, -2.0},
                                       {ChangeKind::kLag, 1.1}}) {
    const ResponseFeatures one = featuresWith(*model.responses, kind, strength);
    const ResponseFeatures other = featuresWith(*back.responses, kind, strength);
    EXPECT_EQ(one.known, other.known);
    EXPECT_TRUE(one.value.isApprox(other.value, 1e-12));
    EXPECT_TRUE(one.covariance.isApprox(other.covariance, 1e-9));
  }
  EXPECT_FALSE(parseModelYaml(modelYaml(fittedModel()), "model.yaml").responses);
}

TEST(ModelYaml, KeepsTheResponsesOfDrivesSinceAReference) {
  FittedModel model = modelWithResponses();
  auto table = std::make_shared<ResponseTable>(*model.responses);
  table->since.emplace();
  for (int drive = 0; drive < 2; ++drive) table->since->add(table->unchanged);
  table->since->scatter.setLinSpaced(0.0, 0.3);
  table->sound.emplace().add(table->unchanged);
  model.responses = table;
  const FittedModel back = parseModelYaml(modelYaml(model), "model.yaml");
  ASSERT_TRUE(back.responses && back.responses->since);
  EXPECT_EQ(back.responses->since->drives, 2u);
  ASSERT_TRUE(back.responses->sound);
  EXPECT_EQ(back.responses->sound->drives, 1u);
  EXPECT_DOUBLE_EQ(back.responses->since->squares, 0.5);
  EXPECT_TRUE(back.responses->since->scatter.isApprox(table->since->scatter, 1e-12));
  EXPECT_TRUE(back.responses->since->mean.value.isApprox(table->unchanged.value, 1e-12));
  EXPECT_TRUE(
      back.responses->since->mean.covariance.isApprox(0.5 * table->unchanged.covariance, 1e-9));
}

TEST(ModelYaml, NamesWhatIsWrongWithResponses) {
  const std::string text = modelYaml(modelWithResponses());
  const auto wrong = [&](const std::string& from, const std::string& to) {
    const auto at = text.find("responses:");
    return errorOf(text.substr(0, at) + with(text.substr(at), from, to));
  };
  EXPECT_EQ(wrong("version: 3", "version: 1"),
            "model.yaml: responses.version is 1, expected 3: identify again");
  EXPECT_EQ(wrong("features: [edge_resistance", "features: [edge_resistence"),
            "model.yaml: responses.features must be ids of features in their order");
  EXPECT_NE(wrong("strength: [-0.004, -0.002", "strength: [-0.002, -0.004")
                .find("responses.changes.contact_resistance.strength must rise, without 0"),
            std::string::npos);
  EXPECT_NE(
      wrong("current_gain:", "current_grain:").find("responses.changes.current_gain is missing"),
      std::string::npos);
  EXPECT_NE(wrong("interval_s: 1", "interval_s: 0").find("responses.interval_s is 0, expected"),
            std::string::npos);
}

TEST(ReadModelFile, SaysThatAFileCannotBeRead) {
  EXPECT_THROW(readModelFile("/nonexistent/model.yaml"), ModelFileError);
}

TEST(WriteModelFile, WritesAFileThatReadsBack) {
  const auto path = std::filesystem::temp_directory_path() / "battery_sof model yaml test.yaml";
  const FittedModel model = fittedModel();
  writeModelFile(path, model);
  EXPECT_EQ(modelYaml(readModelFile(path)), modelYaml(model));
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace battery_sof
