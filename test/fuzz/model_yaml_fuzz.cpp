#include "fuzzed.hpp"
#include "report/model_yaml.hpp"
#include "support/answer_laws.hpp"

/// A model file is refused with a sentence that names it, or makes a model whose answers keep the
/// laws of answers and that reads back as it was written.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace battery_sof;
  try {
    const FittedModel model =
        parseModelYaml(std::string(reinterpret_cast<const char*>(data), size), "fuzzed.yaml");
    fuzz::require(
        test::brokenLaw(predictCranking(model, {-20.0, 10.0, -200.0, 0.5, 7.2}), model.fit));
    const double capacity = capacityFor(model.fit, std::nullopt);
    const StopTimeQuery stop{-20.0, -200.0, 0.5, 7.2};
    fuzz::require(test::brokenLaw(predictStopTime(model, stop), stop, capacity));
    const ChargeAcceptanceQuery charge{14.4, 10.0};
    fuzz::require(test::brokenLaw(predictChargeAcceptance(model, charge), charge, capacity));
    const std::string text = modelYaml(model);
    fuzz::require(modelYaml(parseModelYaml(text, "written.yaml")) == text,
                  "a model reads back as it was written");
  } catch (const ModelFileError& error) {
    fuzz::require(std::string(error.what()).find("fuzzed.yaml") == 0,
                  "an error begins with the file");
  }
  return 0;
}
