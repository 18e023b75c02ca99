#include "our_fit.hpp"

#include <stdexcept>

#include "estimation/base_search.hpp"
#include "estimation/identification.hpp"

namespace battery_sof_bench {

using namespace battery_sof;

Fit searchOnly(const DriveWindow& window) {
  const IdentifyOptions options;
  const WindowSamples samples(window.series, window.range(),
                              {options.crank_weight, options.crank_weight_current}, window.max_gap,
                              options.masked);
  const BaseNormalEquations equations(samples, BaseParameters{}.i0);
  const CompositionFit fit = searchWindow(samples, equations, options);
  return {baseParameters(fit.point.parameters), fit.point.state[0], fit.at.cost, fit.iterations};
}

void requireSameAsIdentify(const DriveWindow& window, const Fit& searched) {
  const FittedModel model = identify(window.series, window.range());
  if (model.fit.status != FitStatus::kConverged)
    throw std::runtime_error("identify() did not converge: " + model.fit.message);
  const auto& a = model.fit.parameters;
  const auto& b = searched.parameters;
  if (a.r_discharge != b.r_discharge || a.r_charge != b.r_charge || a.c2 != b.c2 ||
      a.beta != b.beta || a.u_dc != b.u_dc)
    throw std::runtime_error(
        "searchOnly() is no longer the search of identify(): bench/our_fit.cpp");
}

}  // namespace battery_sof_bench
