#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "bound_composition.hpp"
#include "narrow_layer.hpp"
#include "tangents.hpp"

namespace battery_sof {

/// The double layer of a composition in arithmetic T.
template <typename T>
DoubleLayer<T> layerOf(const BoundComposition& bound) {
  std::vector<BoundEffect> side;
  BoundEffect activity{nullptr, 0};
  for (const BoundComposition::Member& member : bound.members) {
    const BoundEffect own{member.effect, member.parameter};
    if (member.effect->hooks.side_current) side.push_back(own);
    if (member.effect->hooks.activity) activity = own;
  }
  return DoubleLayer<T>(side, activity.effect ? &activity : nullptr, bound.ladder_state >= 0,
                        bound.limits_reaction);
}

/// Layers for a simulation in arithmetic S, each in the narrowest arithmetic that serves.
template <typename S>
class LayerChoice {
 public:
  explicit LayerChoice(const BoundComposition& bound) : bound_(bound) {}

  /// @param tangents those that can reach the layer while the current is given.
  std::unique_ptr<LayerOf<S>> underCurrent(const std::vector<int>& tangents) const {
    std::unique_ptr<LayerOf<S>> layer = narrow<8>(tangents);
    if (!layer) layer = narrow<16>(tangents);
    if (!layer) layer = narrow<24>(tangents);
    return layer ? std::move(layer) : wide();
  }

  /// Every tangent may reach it: a current that follows from a voltage depends on all of them.
  std::unique_ptr<LayerOf<S>> behindSource() const {
    std::unique_ptr<LayerOf<S>> layer = local<8>();
    if (!layer) layer = local<16>();
    return layer ? std::move(layer) : wide();
  }

 private:
  std::unique_ptr<LayerOf<S>> wide() const {
    return std::make_unique<WideLayer<S>>(layerOf<S>(bound_));
  }
  std::size_t parameterCount() const {
    return static_cast<std::size_t>(bound_.model.parameterCount());
  }

  /// @return nothing unless N tangents suffice and are fewer than those of S.
  template <int N>
  std::unique_ptr<LayerOf<S>> narrow(const std::vector<int>& tangents) const {
    if constexpr (N < Width<S>::value) {
      typename NarrowLayer<S, N>::Shape shape{tangents, parameterCount(), bound_.ladder_state >= 0,
                                              bound_.adapts};
      if (tangents.size() <= static_cast<std::size_t>(N))
        return std::make_unique<NarrowLayer<S, N>>(layerOf<Dual<N>>(bound_), shape);
    }
    return nullptr;
  }

  /// @return nothing unless the layer has implicit steps, into which at most N quantities flow,
  /// fewer than S has tangents.
  template <int N>
  std::unique_ptr<LayerOf<S>> local() const {
    if constexpr (N < Width<S>::value) {
      typename LocalLayer<S, N>::Shape shape{bound_.parametersOfLayer(), parameterCount(),
                                             bound_.activity_state >= 0, bound_.adapts};
      const bool is_implicit =
          !shape.parameters.empty() && !bound_.limits_reaction && bound_.ladder_state < 0;
      if (is_implicit && shape.inputs() <= N)
        return std::make_unique<LocalLayer<S, N>>(layerOf<Dual<N>>(bound_), shape);
    }
    return nullptr;
  }

  const BoundComposition& bound_;
};

}  // namespace battery_sof
