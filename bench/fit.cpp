#include "fit.hpp"

#include <cmath>
#include <sstream>
#include <stdexcept>

namespace battery_sof_bench {
namespace {

void requireClose(const std::string& contender, const std::string& name, double ours, double theirs,
                  double tolerance) {
  if (std::abs(theirs - ours) <= tolerance * std::abs(ours)) return;
  std::ostringstream message;
  message.precision(10);
  message << contender << " ended elsewhere: " << name << " is " << theirs << ", ours is " << ours
          << ", allowed share " << tolerance << "; times of different answers are not compared";
  throw std::runtime_error(message.str());
}

}  // namespace

void requireSameOptimum(const Fit& ours, const Fit& theirs, const std::string& contender) {
  const auto& a = ours.parameters;
  const auto& b = theirs.parameters;
  requireClose(contender, "r_discharge", a.r_discharge, b.r_discharge, kSameOptimum);
  requireClose(contender, "r_charge", a.r_charge, b.r_charge, kSameOptimum);
  requireClose(contender, "c2", a.c2, b.c2, kSameOptimum);
  requireClose(contender, "beta", a.beta, b.beta, kSameOptimum);
  requireClose(contender, "the cost", ours.cost, theirs.cost, kSameCost);
}

}  // namespace battery_sof_bench
