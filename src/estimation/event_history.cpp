#include "estimation/event_history.hpp"

namespace battery_sof {
namespace {

template <typename T>
void keep(std::vector<T>& past, const T& event, std::size_t most) {
  past.push_back(event);
  if (past.size() > most) past.erase(past.begin());
}

}  // namespace

void EventHistory::add(const PastCrank& crank) { keep(cranks, crank, kMost); }
void EventHistory::add(const PastCharge& charge) { keep(charges, charge, 2 * kMost); }

void EventHistory::moveBy(double moved) {
  for (PastCrank& crank : cranks) crank.time += moved;
  for (PastCharge& charge : charges) charge.time += moved;
}

}  // namespace battery_sof
