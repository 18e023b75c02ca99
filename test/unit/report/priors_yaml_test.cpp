#include "report/priors_yaml.hpp"

#include <gtest/gtest.h>

#include "report/model_yaml.hpp"

namespace battery_sof {
namespace {

constexpr char kPriors[] = R"(schema: battery_sof/priors/1
priors:
- {vehicle_type: '', effects: [], parameters: {beta: {value: 20, std: 0.3, logarithmic: true}}}
- {vehicle_type: '', effects: [fresh_sulphate], parameters: {u_dc: {value: 12.5, std: 0.2, logarithmic: false}}}
- {vehicle_type: van, effects: [fresh_sulphate], parameters: {u_dc: {value: 12.9, std: 0.1, logarithmic: false}}}
- {vehicle_type: bus, effects: [fresh_sulphate], parameters: {u_dc: {value: 24.9, std: 0.1, logarithmic: false}}}
)";

TEST(PriorsYaml, APopulationOfTheTypeComesBeforeThatOfAllTypes) {
  const auto of_van = parsePriorsYaml(kPriors, "priors.yaml", "van");
  ASSERT_EQ(of_van.size(), 2u);
  EXPECT_TRUE(of_van[0].effects.empty());
  EXPECT_EQ(of_van[0].parameters.at(0).name, "beta");
  EXPECT_TRUE(of_van[0].parameters.at(0).logarithmic);
  EXPECT_EQ(of_van[1].parameters.at(0).value, 12.9);
  const auto of_tram = parsePriorsYaml(kPriors, "priors.yaml", "tram");
  ASSERT_EQ(of_tram.size(), 2u);
  EXPECT_EQ(of_tram[1].parameters.at(0).value, 12.5);
}

std::string refusal(const std::string& text, const std::string& vehicle_type = "") {
  try {
    parsePriorsYaml(text, "priors.yaml", vehicle_type);
  } catch (const ModelFileError& error) {
    return error.what();
  }
  return "";
}

TEST(PriorsYaml, WhatIsWrongIsNamedWithItsPlace) {
  EXPECT_EQ(refusal("schema: other"),
            "priors.yaml: schema is \"other\", expected battery_sof/priors/1");
  const std::string head =
      "schema: battery_sof/priors/1\npriors: [{vehicle_type: '', effects: [], parameters: {beta: {";
  EXPECT_NE(refusal(head + "value: 20, std: 0, logarithmic: true}}}]")
                .find("priors[0].parameters.beta.std is 0"),
            std::string::npos);
  EXPECT_NE(refusal(head + "value: -1, std: 1, logarithmic: true}}}]")
                .find("priors[0].parameters.beta.value is -1, expected 1 to 1000"),
            std::string::npos);
  EXPECT_NE(refusal(head + "value: 1e9, std: 1, logarithmic: true}}}]")
                .find("priors[0].parameters.beta.value is 1e+09, expected 1 to 1000"),
            std::string::npos);
  EXPECT_NE(refusal("schema: battery_sof/priors/1\npriors: [{vehicle_type: '', effects: [], "
                    "parameters: {u_dc: {value: 0, std: 1, logarithmic: true}}}]")
                .find("priors[0].parameters.u_dc.value is not positive"),
            std::string::npos);
  const std::string entries = "schema: battery_sof/priors/1\npriors:\n";
  EXPECT_NE(refusal(entries + "- {vehicle_type: '', effects: [], parameters: {bta: {value: 1}}}\n")
                .find("priors[0].parameters.bta is not a known key here"),
            std::string::npos);
  EXPECT_NE(refusal(entries + "- {vehicle_type: '', effects: [gasing], parameters: {}}\n")
                .find("priors[0].effects are not those of a model"),
            std::string::npos);
  const std::string entry = "- {vehicle_type: '', effects: [], parameters: {}}\n";
  EXPECT_NE(refusal(entries + entry + entry).find("priors[1].effects are those of an entry before"),
            std::string::npos);
  EXPECT_NE(refusal(entries + "- {vehicle_type: '', effects: [], parameters: {? [a, b] : 1}}\n")
                .find("priors[0].parameters"),
            std::string::npos);
  EXPECT_NE(refusal("{").find("not YAML at line 1"), std::string::npos);
  const std::string of_vans =
      "schema: battery_sof/priors/1\npriors: [{vehicle_type: van, effects: [], parameters: {}}]";
  EXPECT_EQ(refusal(of_vans),
            "priors.yaml: priors has no entry of all types of vehicle, and no type was given");
  EXPECT_EQ(refusal(of_vans, "bus"),
            "priors.yaml: priors has no entry of the type \"bus\" nor of all types of vehicle");
  EXPECT_EQ(refusal(of_vans, "van"), "");
}

}  // namespace
}  // namespace battery_sof
