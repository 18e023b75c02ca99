#pragma once

#include <string>
#include <vector>

#include "simulator/simulation.hpp"

namespace battery_sof_reference {

/// Kinds of drives: city, start_stop, bench, motorway, turns.
const std::vector<std::string>& outOfModelDrives();

/**
 * @brief Gives a scenario a drive of a kind, with what a mechanism needs to be seen all through it.
 *
 * city: stop and go with recuperation. start_stop: a crank after every stop. bench: pulses and
 * rests of a test stand. motorway: long charges at the limit and loads between them. turns: charge
 * and discharge in quick turns. The same things happen in the last quarter as before it.
 *
 * @param scenario its duration is set.  @param mechanism a label's; "" adds nothing to the kind.
 * @throws std::invalid_argument for an unknown kind.
 */
void drawOutOfModelDrive(Scenario& scenario, const std::string& kind, const std::string& mechanism,
                         Dice& dice);

}  // namespace battery_sof_reference
