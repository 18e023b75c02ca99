#pragma once

#include "battery_sof/queries.hpp"

namespace battery_sof {

/// @return a voltage of one block, of a row of them [V].
inline Interval inRow(const Interval& of_one, double blocks) {
  return {blocks * of_one.value, blocks * of_one.lower, blocks * of_one.upper};
}

}  // namespace battery_sof
