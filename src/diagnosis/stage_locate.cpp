#include "stage_locate.hpp"

#include "diagnosis/locate.hpp"
#include "diagnosis/parameter_bias.hpp"

namespace battery_sof {

Located locateErrors(const Prepared& prepared) {
  Located located;
  located.regimes = regimesOf(prepared.quiet);
  located.findings = regimeFindings(prepared.base, prepared.quiet, located.regimes);
  located.parameter_bias = parameterBiases(prepared.base, prepared.quiet, located.regimes);
  return located;
}

}  // namespace battery_sof
