#pragma once

#include <vector>

#include "simulator/simulation.hpp"

namespace battery_sof_simulator {

/// A charge [Ah] taken up, or given out when negative, at a current counted positive [A].
Phase swing(double charge_ah, double current);

/// What a crank is drawn from: inrush for kInrush, then a plateau; currents counted positive.
struct CrankRanges {
  Range inrush_a, plateau_s, plateau_a;
};
void appendCrank(std::vector<Phase>& phases, const CrankRanges& ranges, Dice& dice);

/// Has a drive play phases from an instant on [s], among those that are there.
void insertAt(Scenario& scenario, double at, std::vector<Phase> phases);

}  // namespace battery_sof_simulator
