#include "estimation/physics_choice.hpp"

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "estimation/block_score.hpp"
#include "estimation/fit_quality.hpp"
#include "estimation/fit_window.hpp"
#include "estimation/moved_charge.hpp"

namespace battery_sof {
namespace {

using Effects = std::vector<std::string>;

constexpr const char* kChargingPhysics = "fresh_sulphate";

bool showsOneLoad(const Series& series, IndexRange range) {
  const ExcitedRange excited = excitedRange(series, range, gapThreshold(series));
  return isOneLoad(excited.min_current, excited.max_current);
}

/// @return at least one composition.
std::vector<Effects> rivalsOf(const Series& series, IndexRange range,
                              const IdentifyOptions& options) {
  const MovedCharge moved = movedCharge(series, range);
  const bool is_controlled = isVoltageControlled(options, range);
  const Effects shallow = is_controlled ? Effects{kChargingPhysics} : Effects{};
  const Effects deep = moved.physicsOfDepth(capacityOf(options), is_controlled);
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
