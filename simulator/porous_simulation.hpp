#pragma once

#include "simulator/porous_block.hpp"
#include "simulator/simulation.hpp"

namespace battery_sof_reference {

/**
 * @brief Drives a porous block through a scenario's profile and records it.
 *
 * Of the scenario battery, effects and additions do not act; the temperature is 25 degC. The
 * balance has its charges, not its energies.
 *
 * @throws std::invalid_argument naming every fault; NoSolution when the equations have none.
 */
Simulation simulatePorous(const Scenario& scenario, const PorousParameters& parameters);

}  // namespace battery_sof_reference
