#include <gtest/gtest.h>

#include <sys/stat.h>

#include <cctype>
#include <cmath>
#include <random>

#include "prediction/questions.hpp"
#include "report/model_yaml.hpp"
#include "support/commands.hpp"
#include "support/known_model.hpp"

namespace battery_sof {
namespace {

/// A model with noise, source, past events and baseline predictors.
FittedModel fullModel() {
  FittedModel model = test::uncertainModel(0.02);
  model.fit.noise = NoiseModel{0.002, 0.003, 10.0, 1e-4};
  model.state.residual_state = {0.001, 0.002, 1e-6, 2e-7, 3e-6};
  model.fit.covariance(5, 5) = 1e-4;
  ControlModeRule rule;
  rule.present = true;
  rule.min_current = -5.0;
  rule.current_noise = 0.1;
  rule.voltage_noise = 0.01;
  model.fit.source = rule;
  model.fit.baseline.voltage_from_current =
      BaselineLine{12.5, 0.006, 0.02, -0.03, 0.03, -10.0, 20.0, 1000};
  model.fit.baseline.cranks =
      BaselineCranks{{-200.0, 10.5}, {-210.0, 10.4}, 11.0, 0.006, -0.1, 0.1, 5};
  model.intervals.event_history.cranks = {
      {PastEvent::Kind::kCrank, 50.5, 0.0, -200.5, 0.0, 0.0, 10.5, 10.6}};
  model.intervals.event_history.charges = {
      {PastEvent::Kind::kCharge, 60.5, 10.0, 0.0, 14.2, 13.9, 30.5, 31.5}};
  return model;
}

const std::string& text() {
  static const std::string yaml = modelYaml(fullModel());
  return yaml;
}

std::string errorOf(const std::string& yaml) {
  try {
    parseModelYaml(yaml, "model.yaml");
  } catch (const ModelFileError& error) {
    return error.what();
  }
  return "";
}

/// What is said when the value behind a key is replaced; `within` is a text before the key.
std::string errorWith(const std::string& within, const std::string& key, const std::string& value) {
  const auto section = text().find(within);
  const auto at = text().find(key + ":", section == std::string::npos ? 0 : section);
  EXPECT_TRUE(section != std::string::npos && at != std::string::npos) << within << " " << key;
  const auto begin = at + key.size() + 1;
  const auto end = text().find_first_of(text()[begin + 1] == '[' ? "]" : ",}\n", begin);
  return errorOf(
      std::string(text()).replace(begin, end - begin + (text()[end] == ']'), " " + value));
}

TEST(DamagedModel, IsWholeBeforeItIsDamaged) { EXPECT_EQ(errorOf(text()), ""); }

struct Damage {
  const char *within, *key, *value, *piece;
};

const Damage kDamages[] = {
    {"now:", "covariance_v2", "[1e-6, 0, .nan]", "errors.now.covariance_v2"},
    {"now:", "covariance_v2", "[-1, 0, 1]", "errors.now.covariance_v2"},
    {"now:", "covariance_v2", "[1e-6, 1, 1e-6]", "errors.now.covariance_v2"},
    {"errors:", "white_std_v", "1e200", "errors.white_std_v is 1e+200"},
    {"errors:", "white_std_v", "1e-300", "errors.white_std_v"},
    {"errors:", "walk_std_v_per_sqrt_s", "1e300", "errors.walk_std_v_per_sqrt_s"},
    {"errors:", "ar_time_s", "-1", "errors.ar_time_s"},
    {"now:", "drift_v", "1e20", "errors.now.drift_v"},
    {"parameters:", "value", "-0.006", "parameters.r_discharge.value"},
    {"u_dc:", "value", "1e20", "parameters.u_dc.value is 1e+20"},
    {"parameters:", "std_error", "-1e9", "parameters.r_discharge.std_error"},
    {"parameters:", "std_error", "1e300", "parameters.r_discharge.std_error"},
    {"state:", "u_c2_v", "1e6", "state.u_c2_v"},
    {"state:", "u_c2_std_v", "-1", "state.u_c2_std_v"},
    {"state:", "current_a", "1e7", "state.current_a"},
    {"state:", "time_s", "1e15", "state.time_s"},
    {"window:", "to_s", "-5", "window.to_s is before from_s"},
    {"window:", "min_voltage_v", "1e9", "window.min_voltage_v"},
    {"fit:", "window_quality", "7", "fit.window_quality is 7"},
    {"fit:", "rmse_v", "-1", "fit.rmse_v"},
    {"source:", "voltage_lag_samples", "1000000000", "source.voltage_lag_samples"},
    {"source:", "max_gap_s", "1e300", "source.max_gap_s"},
    {"baseline:", "voltage_from_current", "[12, 0, 0.1, -1, 1, 0, 1, -7]",
     "baseline.voltage_from_current"},
    {"baseline:", "voltage_from_current", "[12, 0, 0.1, 1, -1, 0, 1, 7]", "lower error above"},
    {"baseline:", "cranks", "[1, 2, 3, 4, 5, 6, -1, 1, 1e300]", "baseline.cranks"},
};

TEST(DamagedModel, EveryNumberIsHeldAgainstWhatItCanBe) {
  for (const Damage& damage : kDamages) {
    const std::string said = errorWith(damage.within, damage.key, damage.value);
    EXPECT_NE(said.find(damage.piece), std::string::npos)
        << damage.key << ": " << damage.value << " gave: " << said;
  }
}

/// In a map or list on one line a comma ends a number: what stands before it must not be taken for
/// the whole.
TEST(DamagedModel, ADecimalCommaIsRefusedWhereverANumberStands) {
  const std::size_t first = text().find("effects:");
  int tried = 0;
  for (std::size_t at = first; (at = text().find('.', at)) != std::string::npos; ++at) {
    if (std::isdigit(text()[at - 1]) == 0 || std::isdigit(text()[at + 1]) == 0) continue;
    ++tried;
    EXPECT_NE(errorOf(std::string(text()).replace(at, 1, ",")), "")
        << text().substr(text().rfind('\n', at), 80);
  }
  EXPECT_GT(tried, 25);
  const std::string point = ": a comma ends a number, expected a decimal point";
  const std::string said = errorWith("parameters:", "std_error", "1,5");
  EXPECT_NE(said.find("parameters.r_discharge.5 is not a key with a value" + point),
            std::string::npos)
      << said;
}

TEST(DamagedModel, AListOfAnyLengthHasNoDecimalCommas) {
  FittedModel model = fullModel();
  model.fit.baseline.phase = BaselinePhase{5.0, {30.0, 20.5, 10.25}, 1.0, -1.0, 1.0, 3};
  const std::string good = modelYaml(model);
  EXPECT_EQ(errorOf(good), "");
  const std::string said = errorOf(std::string(good).replace(good.find("20.5"), 4, "20,5"));
  EXPECT_NE(
      said.find(
          "baseline.phase.current_a has some commas with a space behind them and some without"),
      std::string::npos)
      << said;
}

TEST(DamagedModel, WholeNumbersAreWholeAndDecimal) {
  for (const char* value : {"1.5", "0x10", "-1", "1e300", ".nan"})
    EXPECT_NE(
        errorWith("fit:", "iterations", value)
            .find("fit.iterations is \"" + std::string(value) + "\", expected a whole number"),
        std::string::npos)
        << value;
}

TEST(DamagedModel, ARecordingsNameIsWrittenAndReadAsUtf8) {
  FittedModel model = fullModel();
  model.provenance.recording = "dr\xFFive\x1b\n.csv";
  const std::string written = modelYaml(model);
  EXPECT_EQ(written.find_first_of("\xFF\x1b"), std::string::npos);
  EXPECT_EQ(parseModelYaml(written, "model.yaml").provenance.recording, "dr\\xffive\\x1b\\n.csv");
  EXPECT_EQ(modelYaml(parseModelYaml(written, "model.yaml")), written);
  std::string raw = written;
  raw.replace(raw.find("dr\\xff"), 6, "dr\xFF");
  EXPECT_EQ(parseModelYaml(raw, "model.yaml").provenance.recording.find("dr\\xffive"), 0u);
}

TEST(DamagedModel, CorrelationsAreSymmetricWithOnesOnTheDiagonalAndNoNegativeEigenvalue) {
  const auto withCorrelation = [](double diagonal, double upper, double lower) {
    FittedModel model = fullModel();
    const std::string good = modelYaml(model);
    const auto begin = good.find("\ncorrelation:") + 1, end = good.find("\nstate:");
    std::string rows = "correlation:\n";
    for (int j = 0; j < 6; ++j) {
      rows += "  - [";
      for (int k = 0; k < 6; ++k)
        rows += std::to_string(j == k ? diagonal : j < k ? upper : lower) + (k < 5 ? ", " : "]\n");
    }
    return errorOf(std::string(good).replace(begin, end - begin + 1, rows));
  };
  EXPECT_EQ(withCorrelation(1.0, 0.5, 0.5), "");
  EXPECT_NE(withCorrelation(-1.0, 0.0, 0.0).find("ones on its diagonal"), std::string::npos);
  EXPECT_NE(withCorrelation(1.0, 0.5, 0.4).find("symmetric"), std::string::npos);
  EXPECT_NE(withCorrelation(1.0, -0.9, -0.9).find("eigenvalue"), std::string::npos);
}

TEST(DamagedModel, ThatIsNotYamlIsToldByLineWithoutTheParsersWords) {
  const std::string said = errorOf("a: [1, 2\nb: }");
  EXPECT_NE(said.find("model.yaml: not YAML at line "), std::string::npos) << said;
  EXPECT_EQ(said.find("yaml-cpp"), std::string::npos);
}

/// Two thousand files with bytes changed, cut or doubled: each is refused with a sentence or makes
/// finite answers.
TEST(DamagedModel, TwoThousandDamagedFilesAreRefusedOrAnswerWithFiniteNumbers) {
  std::mt19937 random(7);
  const auto below = [&](std::size_t n) {
    return std::uniform_int_distribution<std::size_t>(0, n - 1)(random);
  };
  const std::string bytes = "0123456789eE+-.:,[]{}naif \n";
  CrankingQuery query{-20.0, 10.0, -200.0, 0.5, 7.2};
  int accepted = 0;
  for (int round = 0; round < 2000; ++round) {
    std::string damaged = text();
    for (std::size_t k = below(4) + 1; k > 0; --k)
      damaged[below(damaged.size())] = bytes[below(bytes.size())];
    if (round % 7 == 0) damaged.resize(below(damaged.size()));
    try {
      const CrankingAnswer answer = predictCranking(parseModelYaml(damaged, "damaged.yaml"), query);
      ++accepted;
      if (!answer.u_min) continue;
      EXPECT_TRUE(std::isfinite(answer.u_min->value) && std::isfinite(answer.u_min->lower) &&
                  std::isfinite(answer.u_min->upper))
          << round;
    } catch (const ModelFileError& error) {
      EXPECT_NE(std::string(error.what()).find("damaged.yaml"), std::string::npos);
    }
  }
  EXPECT_GT(accepted, 50);
  EXPECT_LT(accepted, 1900);
}

class ModelPosition : public test::InFolder {
 protected:
  ModelPosition() : InFolder("model place") {}
  static std::string refusal(const std::string& file) {
    try {
      readModelFile(file);
    } catch (const ModelFileError& error) {
      return error.what();
    }
    return "";
  }
};

TEST_F(ModelPosition, WhatIsNoRegularFileOrTooLargeIsRefusedAtOnce) {
  std::filesystem::create_symlink("loop", path("loop"));
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  std::string list = "a: [1";
  for (int n = 0; n < 1000000; ++n) list += ", 1";
  write("list.yaml", list + "]\n");
  EXPECT_NE(refusal(path("loop")).find("loop: cannot be read"), std::string::npos)
      << refusal(path("loop"));
  EXPECT_NE(refusal(path(std::string(300, 'x'))).find("cannot be read"), std::string::npos);
  EXPECT_NE(refusal(path("pipe")).find("is not a regular file"), std::string::npos);
  EXPECT_NE(refusal("/dev/zero").find("is not a regular file"), std::string::npos);
  EXPECT_NE(refusal(folder_.string()).find("is not a regular file"), std::string::npos);
  EXPECT_NE(refusal(path("list.yaml")).find("is too large"), std::string::npos);
}

}  // namespace
}  // namespace battery_sof
