#include "stage_locate.hpp"

#include "battery_sof/diagnose/absorption.hpp"
#include "battery_sof/diagnose/locate.hpp"

namespace battery_sof {

Located locateErrors(const Prepared& prepared) {
  Located located;
  located.regimes = regimesOf(prepared.quiet);
  located.findings = regimeFindings(prepared.base, prepared.quiet, located.regimes);
  located.absorption = absorptionMap(prepared.base, prepared.quiet, located.regimes);
  return located;
}

}  // namespace battery_sof
