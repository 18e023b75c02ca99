#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "explanation_fits.hpp"

namespace battery_sof {

/// Tries effects of the catalogue in addition to a state: each on a grid of its shapes and
/// instants, the promising ones fitted.
class EffectSearch {
 public:
  /// @param ids effects that may be tried.
  /// @param threads as of DiagnoseOptions.
  EffectSearch(ExplanationFits& fits, const std::vector<std::string>& ids, int threads = 1);

  const std::vector<std::string>& ids() const { return ids_; }
  /// Takes what every effect adds to the base circuit; before anything else.
  void takeGrid();
  /// A state with one effect more, fitted from where it promises most; none where it cannot be
  /// placed.
  std::optional<ExplanationState> with(const ExplanationState& state, const std::string& id);
  /// Gain of ln evidence by each grid point added to a state, noise taken again, any multiple of
  /// it allowed.
  std::vector<double> gridGains(const ExplanationState& state,
                                const std::vector<EffectGridPoint>& grid) const;
  /// The same with the base circuit's grid, the best of every effect.
  std::map<std::string, double> bestGains(const ExplanationState& state) const;
  /// A state with one effect more, from a point of its grid; the first steps of its fit. @param
  /// gain that the grid promises.
  ExplanationState withMember(const ExplanationState& state, const EffectGridPoint& from,
                              double gain) const;
  /// The likeliest effects added to a state, each fitted; best first. @param only of one mechanism,
  /// its grid taken again with the state: a side reaction shows where the circuit with its
  /// acceptance lets the voltage rise, and not where the circuit alone does.
  std::vector<ExplanationState> withMembers(const ExplanationState& state,
                                            std::optional<Mechanism> only);
  /// Detection limits: the smallest strengths that would have been selected (linearised). Counts
  /// what neither the state nor another mechanism's regressors take up of a typical signature, less
  /// the residual that looks like it. @param needed gain of a mechanism.
  std::vector<DetectionLimit> minStrengths(const ExplanationState& state,
                                           const std::function<double(Mechanism)>& needed) const;

  /// By what one explanation is taken before another: of two that are as good the one with fewer
  /// effects, an equation before regressors.
  double rankOf(const ExplanationState& state) const;

  /// what was fitted, in the order in which it first came, each at its best gain
  const std::vector<WeighedMember>& weighed() const { return weighed_; }

 private:
  /// The base circuit with an effect at its magnitudes.
  CompositionPoint magnitudesOf(const BatteryModel& model) const;
  std::vector<CompositionPoint> gridOf(const BatteryModel& model) const;
  /// What an effect adds to a state at the points of its grid.
  std::vector<EffectGridPoint> gridFor(const ExplanationState& state, const std::string& id) const;
  std::vector<EffectGridPoint> gridsFor(const ExplanationState& state,
                                        const std::vector<std::string>& ids) const;
  /// A state with one effect more at a multiple of a grid point's strengths; not placed.
  ExplanationState enlargedBy(const ExplanationState& state, const EffectGridPoint& from,
                              double share) const;
  /// Multiple of a grid point that a state's errors ask for; at least a tenth.
  double strengthOf(const ExplanationState& state, const EffectGridPoint& from) const;
  /// @param times a typical strength.  @return none of an effect without a strength.
  std::optional<DetectionLimit> minStrength(const EffectGridPoint& point, double times) const;

  ExplanationFits& fits_;
  std::vector<std::string> ids_;
  int threads_;
  std::vector<EffectGridPoint> grid_;  // with the base circuit
  std::vector<WeighedMember> weighed_;
};

}  // namespace battery_sof
