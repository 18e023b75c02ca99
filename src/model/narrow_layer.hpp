#pragma once

#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "composed_effects.hpp"
#include "double_layer.hpp"

namespace battery_sof {

/**
 * @brief In numbers of N derivatives, for a simulation that carries more: only those tangents that
 * can reach the layer.
 *
 * Most parameters never do (series resistances, u_dc, acid), and the layer's implicit steps are
 * where the time goes.
 */
template <typename S, int N>
class NarrowLayer final : public LayerOf<S> {
 public:
  /// @param tangents those of S that may differ from zero in what the layer is given; at most N.
  NarrowLayer(const BoundComposition& bound, std::vector<int> tangents)
      : layer_(bound),
        tangents_(std::move(tangents)),
        parameters_(bound.model.parameterCount()),
        has_ladder_(bound.ladder_state >= 0),
        adapts_(bound.adapts) {}
  std::unique_ptr<LayerOf<S>> clone() const override {
    return std::make_unique<NarrowLayer>(*this);
  }

  void advance(const S* p, const Present<S>& present, const S& current, double duration,
               LayerPace& pace, S& u, S* log_activity, S* ladder) override {
    prepare(p, present);
    const Dual<N> held = gathered(current);
    Dual<N> narrow_u = gathered(u);
    Dual<N> narrow_activity = log_activity ? gathered(*log_activity) : Dual<N>(0.0);
    std::array<Dual<N>, kLadderRungs> rungs;
    if (has_ladder_)
      for (int k = 0; k < kLadderRungs; ++k) rungs[k] = gathered(ladder[k]);
    layer_.advance(p_.data(), present_, held, duration, pace, narrow_u,
                   log_activity ? &narrow_activity : nullptr, has_ladder_ ? rungs.data() : nullptr);
    scatter(narrow_u, u);
    if (log_activity) scatter(narrow_activity, *log_activity);
    if (has_ladder_)
      for (int k = 0; k < kLadderRungs; ++k) scatter(rungs[k], ladder[k]);
  }

 private:
  void prepare(const S* p, const Present<S>& present) {
    if (p_.empty()) {
      for (std::size_t j = 0; j < parameters_; ++j) p_.push_back(gathered(p[j]));
      present_ = gathered(present);
    }
    if (adapts_) present_ = gathered(present);
    present_.time = present.time;
  }
  Dual<N> gathered(const S& x) const {
    Dual<N> narrow(x.value());
    for (std::size_t k = 0; k < tangents_.size(); ++k)
      narrow.derivatives()[k] = x.derivatives()[tangents_[k]];
    return narrow;
  }
  Present<Dual<N>> gathered(const Present<S>& f) const {
    return converted<Dual<N>>(f, [this](const S& x) { return gathered(x); });
  }
  void scatter(const Dual<N>& narrow, S& x) const {
    x.value() = narrow.value();
    for (std::size_t k = 0; k < tangents_.size(); ++k)
      x.derivatives()[tangents_[k]] = narrow.derivatives()[k];
  }

  DoubleLayer<Dual<N>> layer_;
  std::vector<int> tangents_;
  std::size_t parameters_;
  bool has_ladder_, adapts_;
  std::vector<Dual<N>> p_;
  Present<Dual<N>> present_;
};

/// @return nothing unless N tangents suffice and are fewer than those of S.
template <typename S, int N>
std::unique_ptr<LayerOf<S>> narrowLayer(const BoundComposition& bound,
                                        const std::vector<int>& tangents) {
  if constexpr (N < Width<S>::value)
    if (tangents.size() <= static_cast<std::size_t>(N))
      return std::make_unique<NarrowLayer<S, N>>(bound, tangents);
  return nullptr;
}

/// In the narrowest arithmetic that serves. @param tangents those that can reach the layer while the
/// current is given.
template <typename S>
std::unique_ptr<LayerOf<S>> layerUnderCurrent(const BoundComposition& bound,
                                              const std::vector<int>& tangents) {
  std::unique_ptr<LayerOf<S>> layer = narrowLayer<S, 8>(bound, tangents);
  if (!layer) layer = narrowLayer<S, 16>(bound, tangents);
  if (!layer) layer = narrowLayer<S, 24>(bound, tangents);
  if (!layer) layer = std::make_unique<DoubleLayer<S>>(bound);
  return layer;
}

}  // namespace battery_sof
