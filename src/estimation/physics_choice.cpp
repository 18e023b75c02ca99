#include "estimation/physics_choice.hpp"

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "estimation/block_score.hpp"
#include "estimation/depth_physics.hpp"
#include "estimation/fit_quality.hpp"
#include "estimation/fit_window.hpp"

namespace battery_sof {
namespace {

using Effects = std::vector<std::string>;

constexpr const char* kChargingPhysics = "fresh_sulphate";
constexpr double kShownCharging =
    60.0;  // [s] at a controlled voltage: acceptance fades over minutes

bool showsOneLoad(const Series& series, IndexRange range) {
  const ExcitedRange excited = excitedRange(series, range, gapThreshold(series));
  return isOneLoad(excited.min_current, excited.max_current);
}

/// Whether a window holds enough charging at a controlled voltage to tell how it fades.
bool showsCharging(const Series& series, IndexRange range, const IdentifyOptions& options) {
  if (!options.source) return false;
  const double max_gap = gapThreshold(series);
  double duration = 0.0;
  for (std::size_t n = range.first + 1; n < range.last; ++n) {
    const double step = series.time[n] - series.time[n - 1];
    if (options.source->voltage_controlled[n] && series.current[n] > 0.0 && step <= max_gap)
      duration += step;
  }
  return duration >= kShownCharging;
}

/// @return at least one composition.
std::vector<Effects> rivalsOf(const Series& series, IndexRange range,
                              const IdentifyOptions& options) {
  const MovedCharge moved = movedCharge(series, range);
  const Effects shallow =
      showsCharging(series, range, options) ? Effects{kChargingPhysics} : Effects{};
  const Effects deep =
      physicsOfDepth(moved, nominalCapacity(options.capacity), isVoltageControlled(options, range));
  if (deep.empty()) return {shallow};
  std::vector<Effects> rivals = {deep};
  if (!showsOneLoad(series, range)) {
    rivals.push_back(deep);
    rivals.back().insert(rivals.back().begin() + 1, kLessConducting);
  }
  if (!moved.isOneCycle()) rivals.push_back(shallow);
  return rivals;
}

/// Compositions of a window, fitted effect by effect; each is fitted once.
class NestedFits {
 public:
  NestedFits(const Series& series, IndexRange range, const IdentifyOptions& options)
      : series_(series), range_(range), options_(options) {}

  /// @return the composition's fit, else that of the largest one at its beginning which is usable.
  const FittedModel& upTo(const Effects& effects) {
    const auto known = fits_.find(effects);
    if (known != fits_.end()) return known->second;
    const FittedModel* smaller = nullptr;
    if (effects.size() > 1) smaller = &upTo({effects.begin(), effects.end() - 1});
    options_.effects = effects;
    options_.starts.clear();
    if (smaller && isUsable(smaller->fit))
      options_.starts = startsInLarger(compositionOf(smaller->fit), optimumOf(*smaller),
                                       BatteryModel(effects, options_.discrepancy));
    FittedModel model = identify(series_, range_, options_);
    requirePlausible(model.fit);
    if (smaller && !isUsable(model.fit)) model = *smaller;
    return fits_.emplace(effects, std::move(model)).first->second;
  }

 private:
  const Series& series_;
  IndexRange range_;
  IdentifyOptions options_;
  std::map<Effects, FittedModel> fits_;
};

}  // namespace

FittedModel identifyWithChosenPhysics(const Series& series, IndexRange range,
                                      const IdentifyOptions& given) {
  IdentifyOptions options = given;
  options.chooses_effects = false;
  if (!options.effects.empty() || options.start == FitStart::kPaper)
    return identify(series, range, options);
  const std::vector<Effects> rivals = rivalsOf(series, range, options);
  NestedFits fits(series, range, options);
  const FittedModel* best = nullptr;
  std::optional<BlockScore> of_best;
  for (const Effects& effects : rivals) {
    const FittedModel& model = fits.upTo(effects);
    if (!isUsable(model.fit)) continue;
    std::optional<BlockScore> score;
    if (rivals.size() > 1)
      score = scoreBlocks(compositionOf(model.fit), optimumOf(model), series, range, options,
                          kScoreBlocks);
    if (best) {
      const ScoreGain gain = gainOf(*score, *of_best, kMostApart);
      if (gain.value <= gain.std_error) continue;  // the simplest of those that are as good
    }
    best = &model;
    of_best = std::move(score);
  }
  return best ? *best : fits.upTo({});
}

}  // namespace battery_sof
