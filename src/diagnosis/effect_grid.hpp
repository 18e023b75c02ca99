#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "explanation_fits.hpp"

namespace battery_sof {

/// What an effect adds to a state at one point of its grid.
struct EffectGridPoint {
  std::string id;
  CompositionPoint point;  // of the base circuit with it
  bool one_sided;
  Eigen::VectorXd added;  // counted rows [V]
};

/// A grid point added to a state, linear in its strength.
struct GridGain {
  double value = 0.0;     ///< of ln evidence
  double strength = 0.1;  ///< multiple of the point that the state's errors ask for; |.| >= 0.1
};

/// Effects of the catalogue on grids of their shapes and instants, in addition to a state: what each
/// promises, where its fit begins, and how strong it must be to be found.
class EffectGrid {
 public:
  /// @param fits must outlive this.  @param ids effects of the grid; those of the state are left out.
  /// @param threads as of DiagnoseOptions.
  EffectGrid(const ExplanationFits& fits, const ExplanationState& state,
             const std::vector<std::string>& ids, int threads = 1);

  const std::vector<EffectGridPoint>& points() const { return points_; }
  /// One a point; noise taken again.
  std::vector<GridGain> gainsOf(const ExplanationState& state) const;
  /// Places of points to try, one an effect: the most promising, and the first of every mechanism.
  /// @param gains as of gainsOf().  @param only these effects, whatever they promise; empty: all.
  std::vector<std::size_t> promising(const std::vector<GridGain>& gains,
                                     const std::vector<std::string>& only) const;
  /// Gains of gainsOf(), the best of every effect.
  std::map<std::string, double> bestGains(const ExplanationState& state) const;
  /// Where a fit of a state with one effect more begins. @param strength as of GridGain.
  CompositionPoint startOf(const ExplanationState& state, const BatteryModel& larger,
                           const EffectGridPoint& from, double strength) const;
  /// Detection limits: the smallest strengths that would have been selected (linearised). Counts
  /// what neither the state nor another mechanism's regressors take up of a typical signature, less
  /// the residual that looks like it. @param needed gain of a mechanism.
  std::vector<DetectionLimit> minStrengths(const ExplanationState& state,
                                           const std::function<double(Mechanism)>& needed) const;

 private:
  /// The base circuit with an effect at its magnitudes.
  CompositionPoint magnitudesOf(const BatteryModel& model) const;
  std::vector<CompositionPoint> shapesOf(const BatteryModel& model) const;
  std::vector<EffectGridPoint> pointsOf(const ExplanationState& state, const std::string& id) const;
  /// @param times a typical strength.  @return none of an effect without a strength.
  std::optional<DetectionLimit> minStrength(const EffectGridPoint& point, double times) const;

  const ExplanationFits& fits_;
  int threads_;
  std::vector<EffectGridPoint> points_;
};

}  // namespace battery_sof
