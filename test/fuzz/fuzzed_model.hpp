#pragma once

#include <fuzzer/FuzzedDataProvider.h>

#include <limits>

#include "support/answer_laws.hpp"
#include "support/known_model.hpp"

namespace battery_sof::fuzz {

/// Any number: mostly one of a range, now and then one of all there are.
inline double anyNumber(FuzzedDataProvider& data, double lower, double upper) {
  constexpr double kOdd[] = {0.0,
                             -0.0,
                             1e-300,
                             -1e300,
                             1e300,
                             std::numeric_limits<double>::quiet_NaN(),
                             std::numeric_limits<double>::infinity(),
                             -std::numeric_limits<double>::infinity()};
  if (data.ConsumeIntegralInRange<int>(0, 15) > 0)
    return data.ConsumeFloatingPointInRange<double>(lower, upper);
  return data.ConsumeBool() ? data.PickValueInArray(kOdd) : data.ConsumeFloatingPoint<double>();
}

constexpr int kMaxEffects = 3;

/// Some effects with what they need.
inline std::vector<std::string> effectsIn(FuzzedDataProvider& data, int most = kMaxEffects) {
  std::vector<std::string> ids;
  for (int k = data.ConsumeIntegralInRange<int>(0, most); k > 0; --k) {
    const auto& all = effectCatalogue();
    for (const std::string& id :
         test::withNeeds(all[data.ConsumeIntegralInRange<std::size_t>(0, all.size() - 1)].id))
      if (std::find(ids.begin(), ids.end(), id) == ids.end()) ids.push_back(id);
  }
  return ids;
}

/// A model with parameters anywhere inside their bounds.
inline FittedModel modelIn(FuzzedDataProvider& data, int max_effects = kMaxEffects) {
  FittedModel model = test::uncertainModel(data.ConsumeFloatingPointInRange(0.0, 1.0),
                                           effectsIn(data, max_effects));
  const BatteryModel composition = compositionOf(model.fit);
  for (std::size_t j = 0; j < model.fit.estimates.size(); ++j) {
    const ParameterInfo& info = composition.parameters()[j];
    if (data.ConsumeBool())
      model.fit.estimates[j].value = data.ConsumeFloatingPointInRange(info.lower, info.upper);
  }
  test::takeEstimates(model.fit);
  model.state.states[0] = data.ConsumeFloatingPointInRange(-5.0, 5.0);
  return model;
}

}  // namespace battery_sof::fuzz
