#include "battery_sof/report/model_yaml.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "battery_sof/identify/identification.hpp"
#include "battery_sof/predict/cranking.hpp"
#include "support/composed.hpp"

namespace battery_sof {
namespace {

FittedModel fittedModel() {
  Series series = test::baseDrive(1);
  series.temperature_time = {0.0};
  series.temperature = {298.15};
  FittedModel model = identify(series, {0, series.size()});
  model.recording = "drive \"one\": a test.csv";
  model.recording_hash = "sha256:0123";
  model.fit_ms = 4.25;
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
  EXPECT_DOUBLE_EQ(back.parameters.r_discharge, model.parameters.r_discharge);
  EXPECT_DOUBLE_EQ(back.parameters.beta, model.parameters.beta);
  EXPECT_DOUBLE_EQ(back.parameters.u_dc, model.parameters.u_dc);
  EXPECT_DOUBLE_EQ(back.state.u_c2, model.state.u_c2);
  EXPECT_DOUBLE_EQ(back.state.time, model.state.time);
  EXPECT_TRUE(back.covariance.isApprox(model.covariance, 1e-12));
  EXPECT_EQ(back.status, model.status);
  EXPECT_EQ(back.recording, model.recording);
  EXPECT_EQ(back.recording_hash, model.recording_hash);
  EXPECT_DOUBLE_EQ(*back.excited.temperature, *model.excited.temperature);
  EXPECT_EQ(back.window.samples, model.window.samples);
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

TEST(ModelYaml, KeepsAMissingStandardErrorMissing) {
  FittedModel model = fittedModel();
  model.estimates[1].std.reset();
  model.covariance.row(1).setZero();
  model.covariance.col(1).setZero();
  EXPECT_FALSE(parseModelYaml(modelYaml(model), "model.yaml").estimates[1].std.has_value());
}

TEST(ModelYaml, NamesFileFieldAndExpectationOfEveryFault) {
  const std::string good = modelYaml(fittedModel());
  EXPECT_NE(errorOf("{").find("not YAML"), std::string::npos);
  EXPECT_NE(errorOf("- 1\n").find("expected a YAML map"), std::string::npos);
  EXPECT_NE(errorOf("").find("model.yaml"), std::string::npos);
  EXPECT_NE(errorOf(with(good, "battery_sof/model/1", "battery_sof/model/9")).find("schema"),
            std::string::npos);
  EXPECT_NE(errorOf(with(good, "  beta:", "  gamma:")).find("parameters.beta is missing"),
            std::string::npos);
  EXPECT_NE(errorOf(with(good, "alpha: 0.5", "alpha: two"))
                .find("fixed.alpha is \"two\", expected a number"),
            std::string::npos);
  EXPECT_NE(errorOf(with(good, "alpha: 0.5", "alpha: 1.5")).find("alpha"), std::string::npos);
  EXPECT_NE(errorOf(with(good, "alpha: 0.5", "alpha: .nan")).find("not finite"), std::string::npos);
  EXPECT_NE(
      errorOf(with(good, "status: converged", "status: lucky")).find("fit.status is \"lucky\""),
      std::string::npos);
  EXPECT_NE(errorOf(with(good, "correlation:\n", "correlation: []\nunused:\n")).find("correlation"),
            std::string::npos);
}

/// A composition fitted to data of the base model: values and correlations of every kind, some held, some at a bound.
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
    EXPECT_EQ(back.effects, model.effects) << info.id;
    ASSERT_EQ(back.estimates.size(), model.estimates.size()) << info.id;
    for (std::size_t j = 0; j < model.estimates.size(); ++j) {
      EXPECT_EQ(back.estimates[j].name, model.estimates[j].name);
      EXPECT_EQ(back.estimates[j].value, model.estimates[j].value);
      EXPECT_EQ(back.estimates[j].std, model.estimates[j].std);
      EXPECT_EQ(back.estimates[j].held, model.estimates[j].held);
      EXPECT_EQ(back.estimates[j].at_bound, model.estimates[j].at_bound);
    }
    EXPECT_EQ(back.state.further, model.state.further) << info.id;
    ASSERT_EQ(back.covariance.rows(), model.covariance.rows()) << info.id;
    for (Eigen::Index j = 0; j < model.covariance.rows(); ++j)
      for (Eigen::Index k = 0; k < model.covariance.rows(); ++k)
        EXPECT_NEAR(back.covariance(j, k), model.covariance(j, k),
                    1e-9 * std::sqrt(model.covariance(j, j) * model.covariance(k, k)))
            << info.id << " " << j << " " << k;
    EXPECT_EQ(modelYaml(back), modelYaml(model)) << info.id;
  }
}

TEST(ModelYaml, NamesWhatIsWrongWithTheEffectsOfAFile) {
  const std::string good = modelYaml(fittedComposition({"acid_transport", "ocv_soc"}));
  ASSERT_EQ(errorOf(good), "");
  const auto error = [&](const char* from, const char* to) { return errorOf(with(good, from, to)); };
  EXPECT_NE(error("[acid_transport, ocv_soc]", "[acid_transport, ocv_sock]").find("\"ocv_sock\" is not known"),
            std::string::npos);
  EXPECT_NE(error("[acid_transport, ocv_soc]", "[sulphate_history]").find("charge_acceptance"), std::string::npos);
  EXPECT_NE(error("[acid_transport, ocv_soc]", "[ocv_soc, ocv_soc]").find("twice"), std::string::npos);
  EXPECT_NE(error("[acid_transport, ocv_soc]", "5").find("effects is \"5\", expected a list of ids"),
            std::string::npos);
  EXPECT_NE(error("  ocv_slope:", "  ocv_steepness:").find("parameters.ocv_slope is missing"), std::string::npos);
  EXPECT_NE(error("    acid_current_2:", "    acid_current_3:").find("state.further.acid_current_2 is missing"),
            std::string::npos);
  EXPECT_NE(error("  further:", "  other:").find("state.further is missing"), std::string::npos);
  // Without ocv_soc the file has a row for its parameter and one for its state too many.
  EXPECT_NE(error("[acid_transport, ocv_soc]", "[acid_transport]").find("correlation must be 12 rows of 12 numbers"),
            std::string::npos);
}

TEST(ModelYaml, KeepsTheMarkOfAHeldParameter) {
  const FittedModel model = fittedComposition({"gassing"});
  const std::string text = modelYaml(model);
  const auto at = text.find("  oxygen_limit:");
  ASSERT_NE(at, std::string::npos);
  EXPECT_NE(text.substr(at, text.find('\n', at) - at).find("held: true"), std::string::npos);
  EXPECT_TRUE(parseModelYaml(text, "model.yaml").estimates.back().held);
}

TEST(ModelYaml, OfACompositionAnswersQueriesAsTheModelItCameFrom) {
  const FittedModel model = fittedComposition({"acid_transport", "charge_acceptance"});
  const FittedModel back = parseModelYaml(modelYaml(model), "model.yaml");
  CrankingQuery query;
  query.i_load = -20.0;
  query.t_stop = 10.0;
  query.i_cranking = -200.0;
  const Interval before = *predictCranking(model, query).u_min, after = *predictCranking(back, query).u_min;
  EXPECT_NEAR(after.value, before.value, 1e-12);
  EXPECT_NEAR(after.lower, before.lower, 1e-6);
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
