#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "simulator/out_of_model_battery.hpp"

namespace battery_sof_reference {

/**
 * @brief An instrument that shows something else than there is, of a form that no catalogue has.
 *
 * Turns a true course into the shown one. At strength 0 it shows the truth; at 1 the error is of
 * the order that its law says.
 */
class OutOfModelInstrument {
 public:
  virtual ~OutOfModelInstrument() = default;
  virtual Course shown(const Course& truth, double strength) const = 0;
};

struct OutOfModelInstrumentForm {
  std::string id;
  double max_strength;  ///< beyond, nobody would go on using it
  std::function<std::unique_ptr<OutOfModelInstrument>(Dice&, const Circumstances&)> draw;
};

/// dead_band, remanence, clock_drift, ringing_channel, thermostat_load (docs/validation.md).
const std::vector<OutOfModelInstrumentForm>& outOfModelInstrumentForms();

}  // namespace battery_sof_reference
