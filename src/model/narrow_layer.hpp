#pragma once

#include <array>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "composed_effects.hpp"
#include "double_layer.hpp"
#include "narrow_layer.hpp"

namespace battery_sof {

/// A double layer that takes and returns numbers in arithmetic S, whatever it counts in itself.
template <typename S>
class LayerOf {
 public:
  virtual ~LayerOf() = default;
  virtual std::unique_ptr<LayerOf> clone() const = 0;
  /// As DoubleLayer::advance().
  virtual void advance(const S* p, const Present<S>& present, const S& current, double duration,
                       LayerPace& pace, S& u, S* log_activity, S* ladder) = 0;
  /// As DoubleLayer::atSource(), and imbalance(): a current that follows from a voltage depends on
  /// every tangent, so it is stepped in the wide layer alone (wideLayer()).
  virtual SourceStep atSource(const S*, const Present<S>&, double, double, double, double) {
    throw std::logic_error("a narrow layer has no step at a source");
  }
  virtual S imbalance(const S*, const Present<S>&, const S&, double, const S&, double) const {
    throw std::logic_error("a narrow layer has no step at a source");
  }
};

/// In S itself.
template <typename S>
class WideLayer final : public LayerOf<S> {
 public:
  explicit WideLayer(DoubleLayer<S> layer) : layer_(std::move(layer)) {}
  std::unique_ptr<LayerOf<S>> clone() const override { return std::make_unique<WideLayer>(*this); }
  void advance(const S* p, const Present<S>& present, const S& current, double duration,
               LayerPace& pace, S& u, S* log_activity, S* ladder) override {
    layer_.advance(p, present, current, duration, pace, u, log_activity, ladder);
  }
  SourceStep atSource(const S* p, const Present<S>& present, double emf, double resistance,
                      double duration, double u) override {
    return layer_.atSource(p, present, emf, resistance, duration, u);
  }
  S imbalance(const S* p, const Present<S>& present, const S& current, double duration,
              const S& before, double u) const override {
    return layer_.imbalance(p, present, current, duration, before, u);
  }

 private:
  DoubleLayer<S> layer_;
};

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
  /// What of it never changes, and what the layer is given.
  struct Shape {
    /// those of S that may differ from zero in what the layer is given; at most N
    std::vector<int> tangents;
    std::size_t parameters;
    bool has_ladder;
    bool adapts;  ///< an effect changes the base model's parameters
  };
  NarrowLayer(DoubleLayer<Dual<N>> layer, Shape shape)
      : layer_(std::move(layer)), shape_(std::move(shape)) {}
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
    if (shape_.has_ladder)
      for (int k = 0; k < kLadderRungs; ++k) rungs[k] = gathered(ladder[k]);
    layer_.advance(p_.data(), present_, held, duration, pace, narrow_u,
                   log_activity ? &narrow_activity : nullptr,
                   shape_.has_ladder ? rungs.data() : nullptr);
    scatter(narrow_u, u);
    if (log_activity) scatter(narrow_activity, *log_activity);
    if (shape_.has_ladder)
      for (int k = 0; k < kLadderRungs; ++k) scatter(rungs[k], ladder[k]);
  }

 private:
  void prepare(const S* p, const Present<S>& present) {
    if (p_.empty()) {
      for (std::size_t j = 0; j < shape_.parameters; ++j) p_.push_back(gathered(p[j]));
      present_ = gathered(present);
    }
    if (shape_.adapts) present_ = gathered(present);
    present_.time = present.time;
  }
  Dual<N> gathered(const S& x) const {
    Dual<N> narrow(x.value());
    for (std::size_t k = 0; k < shape_.tangents.size(); ++k)
      narrow.derivatives()[static_cast<Eigen::Index>(k)] = x.derivatives()[shape_.tangents[k]];
    return narrow;
  }
  Present<Dual<N>> gathered(const Present<S>& f) const {
    return converted<Dual<N>>(f, [this](const S& x) { return gathered(x); });
  }
  void scatter(const Dual<N>& narrow, S& x) const {
    x.value() = narrow.value();
    for (std::size_t k = 0; k < shape_.tangents.size(); ++k)
      x.derivatives()[shape_.tangents[k]] = narrow.derivatives()[static_cast<Eigen::Index>(k)];
  }

  DoubleLayer<Dual<N>> layer_;
  Shape shape_;
  std::vector<Dual<N>> p_;
  Present<Dual<N>> present_;
};

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

/// Every tangent may reach it: a current that follows from a voltage depends on all of them.
template <typename S>
std::unique_ptr<LayerOf<S>> wideLayer(const BoundComposition& bound) {
  return std::make_unique<WideLayer<S>>(layerOf<S>(bound));
}

/// @return nothing unless N tangents suffice and are fewer than those of S.
template <typename S, int N>
std::unique_ptr<LayerOf<S>> narrowLayer(const BoundComposition& bound,
                                        const std::vector<int>& tangents) {
  if constexpr (N < Width<S>::value)
    if (tangents.size() <= static_cast<std::size_t>(N))
      return std::make_unique<NarrowLayer<S, N>>(
          layerOf<Dual<N>>(bound),
          typename NarrowLayer<S, N>::Shape{tangents,
                                            static_cast<std::size_t>(bound.model.parameterCount()),
                                            bound.ladder_state >= 0, bound.adapts});
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
  return layer ? std::move(layer) : wideLayer<S>(bound);
}

}  // namespace battery_sof
