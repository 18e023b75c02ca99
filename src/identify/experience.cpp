#include "battery_sof/identify/experience.hpp"

#include <algorithm>

namespace battery_sof {
namespace {

/// In order of time: a window gives its charges kind by kind.
template <typename T>
void keep(std::vector<T>& past, const T& event, std::size_t most) {
  const auto later = std::upper_bound(past.begin(), past.end(), event,
                                      [](const T& one, const T& other) { return one.time < other.time; });
  past.insert(later, event);
  if (past.size() > most) past.erase(past.begin());
}

}  // namespace

void Experience::add(const PastCrank& crank) { keep(cranks, crank, kMost); }
void Experience::add(const PastCharge& charge) { keep(charges, charge, 2 * kMost); }

}  // namespace battery_sof
