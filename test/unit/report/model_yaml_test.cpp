#include "battery_sof/report/model_yaml.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "battery_sof/identify/identification.hpp"
#include "battery_sof/predict/cranking.hpp"
#include "support/base_drive.hpp"

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
