#include "estimation/depth_physics.hpp"

namespace battery_sof {
namespace {

constexpr double kSmallCurrent = 0.002;  // of a capacity's current of an hour: a sensor's zero
constexpr double kBeginningShare = 0.1;  // of what a discharge draws

}  // namespace

std::vector<std::string> physicsOfDepth(const MovedCharge& moved, double capacity,
                                        bool is_controlled) {
  if (!moved.isDeep(capacity)) return {};
  std::vector<std::string> effects = {kMovedByCharge};
  if (is_controlled && moved.isChargedDeep(capacity)) effects.push_back(kFilledUp);
  if (moved.isDrawnDeep(capacity)) effects.push_back(kUsedUp);
  return effects;
}

std::optional<IndexRange> dischargeUnderWay(const Series& series, IndexRange searched,
                                            double capacity) {
  const double charging = kSmallCurrent * capacity;
  if (searched.size() < 2 || series.current[searched.last - 1] > -charging) return std::nullopt;
  std::size_t first = searched.last - 1;
  while (first > searched.first && series.current[first - 1] <= charging) --first;
  const double drawn = movedCharge(series, {first, searched.last}).span;
  if ((1.0 - kBeginningShare) * drawn < kDeepShare * capacity) return std::nullopt;
  const double max_gap = gapThreshold(series);
  double beginning = kBeginningShare * drawn;
  std::size_t begin = first;
  while (beginning > 0.0 && begin + 1 < searched.last)
    beginning += chargeOfStep(series, ++begin, max_gap);
  return IndexRange{begin, searched.last};
}

}  // namespace battery_sof
