#pragma once

// What an effect's file is written in. The hooks are templates over the scalar, so one definition
// serves values and derivatives; effectOf<Definition>() turns them into what a simulation calls.

#include <memory>
#include <tuple>
#include <type_traits>
#include <vector>

#include "model/closed_form_step.hpp"
#include "model/dual.hpp"
#include "model/effect.hpp"
#include "model/input_sequence.hpp"
#include "util/constants.hpp"

namespace battery_sof {

inline double valueOf(double x) { return x; }
inline double valueOf(const Dual& x) { return x.value(); }
inline double valueOf(const Slope& x) { return x.value(); }

/// The base model's parameters as effects leave them for one interval.
template <typename S>
struct Present {
  S r_discharge, r_charge;              ///< [Ohm]
  S c2;                                 ///< [F]
  S beta;                               ///< [1/V]
  S u_dc;                               ///< [V]
  S ocv_slope = S(0.0);                 ///< [V/Ah], of the open-circuit voltage over the charge
  S i0 = S(BaseParameters{}.i0);        ///< [A]
  S alpha = S(BaseParameters{}.alpha);  ///< [1]
  S acceptance = S(1.0);                ///< [1], factor on the limiting charge current
  S warming = S(0.0);                   ///< [K], above the temperature at the reference time
  S dispersion = S(0.0);      ///< [1], 1 - exponent of the double layer's fractional capacitance
  S reactivity = S(1.0);      ///< g [1], factor on the charging rate of the charge transfer
  S inverse_supply = S(0.0);  ///< 1/L [1/A], of the charging current that can be fed; 0: any
  double time = 0.0;          ///< [s] since the reference time, at the interval's end
};

/// The same in another arithmetic, each number as `number` makes it one.
template <typename T, typename S, typename Number>
Present<T> converted(const Present<S>& f, const Number& number) {
  return {number(f.r_discharge),
          number(f.r_charge),
          number(f.c2),
          number(f.beta),
          number(f.u_dc),
          number(f.ocv_slope),
          number(f.i0),
          number(f.alpha),
          number(f.acceptance),
          number(f.warming),
          number(f.dispersion),
          number(f.reactivity),
          number(f.inverse_supply),
          f.time};
}

/// An interval that was passed through.
template <typename S>
struct Passage {
  const S& current;  ///< [A], held
  double duration;   ///< [s]
  const S& u_c2;     ///< [V], mean of the double layer's voltage over the interval
  /// [A], mean of what reacted: the held current less what the double layer stored and side
  /// currents
  const S& reaction;
  const Present<S>& present;
};

/// The instant at the end of an interval.
template <typename S>
struct Instant {
  const S& current;  ///< [A], of the battery
  double slope;      ///< [A/s], of the measured current just before
  double duration;   ///< [s], of the interval before
  const Present<S>& present;
};

/// Forward and backward rate of the charge-transfer reaction at unit activity, in an implicit step.
template <typename S>
struct ReactionRates {
  const S& charging;     ///< I_0 exp(alpha beta u) [A]
  const S& discharging;  ///< I_0 exp((alpha - 1) beta u) [A]
};

/// What a simulation calls of an effect, in arithmetic S. p and x point to the effect's own
/// parameters and states.
template <typename S>
class EffectKernel {
 public:
  virtual ~EffectKernel() = default;
  /// Turns measured currents into the battery's: mean over the interval, and at its end.
  virtual void sense(const S* p, const InputStep& step, S& held, S& end) const = 0;
  /// Changes the base model's parameters for an interval.
  virtual void adapt(const S* p, const S* x, Present<S>& present) const = 0;
  /// @return current past the double layer's reaction [A].
  virtual S sideCurrent(const S* p, const S& u_c2, const Present<S>& present) const = 0;
  /// @return activity after an implicit Euler step of `duration` from `before`.
  virtual S activity(const S* p, const S& before, const ReactionRates<S>& rates,
                     const Present<S>& present, double duration) const = 0;
  /// Moves the effect's own states over an interval.
  virtual void advance(const S* p, S* x, const Passage<S>& passage) const = 0;
  /// @return voltage in series with the battery [V].
  virtual S voltage(const S* p, const S* x, const Instant<S>& instant) const = 0;
  /// Turns the terminal voltage into what the channel shows; once a sample.
  virtual void show(const S* p, S* x, const Instant<S>& instant, S& voltage) const = 0;
};

/// Which hooks an effect has.
struct EffectHooks {
  bool sense = false, adapt = false, side_current = false, activity = false, advance = false,
       voltage = false, show = false;
  bool is_ladder = false;  ///< its states are the ladder of a fractional double layer
  /// its states are stepped on both sides of the double layer's step
  bool steps_finely = false;
  bool limits_reaction = false;  ///< sets reactivity and inverse_supply
  bool adapts_for_others =
      false;  ///< `adapt` is for effects that need this one, and not called without
  /// [s], intervals are cut to it: its states act back within them; 0: never
  double longest_piece = 0.0;
};

/// Whether a definition has a member.
#define BATTERY_SOF_HAS(Name, member)    \
  template <typename D, typename = void> \
  struct Name : std::false_type {};      \
  template <typename D>                  \
  struct Name<D, std::void_t<decltype(member)>> : std::true_type {};
BATTERY_SOF_HAS(HasSense, &D::template sense<double>)
BATTERY_SOF_HAS(HasAdapt, &D::template adapt<double>)
BATTERY_SOF_HAS(HasSideCurrent, &D::template sideCurrent<double>)
BATTERY_SOF_HAS(HasActivity, &D::template activity<double>)
BATTERY_SOF_HAS(HasAdvance, &D::template advance<double>)
BATTERY_SOF_HAS(HasVoltage, &D::template voltage<double>)
BATTERY_SOF_HAS(HasShow, &D::template show<double>)
BATTERY_SOF_HAS(StepsFinely, D::kStepsFinely)
BATTERY_SOF_HAS(LimitsReaction, D::kLimitsReaction)
BATTERY_SOF_HAS(AdaptsForOthers, D::kAdaptsForOthers)
BATTERY_SOF_HAS(IsLadder, D::kIsLadder)
BATTERY_SOF_HAS(ActsAtEdges, D::kActsAtEdges)
BATTERY_SOF_HAS(OnRequest, D::kOnRequest)
BATTERY_SOF_HAS(HasLongestPiece, D::kLongestPiece)
#undef BATTERY_SOF_HAS

/// [s], of the pieces that intervals are cut to where an effect acts back on others; 0 where it
/// does not.
template <typename D>
constexpr double longestPieceOf() {
  if constexpr (HasLongestPiece<D>::value) return D::kLongestPiece;
  return 0.0;
}

/// An effect's hooks in arithmetic S; those it does not have change nothing.
template <typename D, typename S>
class KernelOf final : public EffectKernel<S> {
 public:
  void sense(const S* p, const InputStep& step, S& held, S& end) const override {
    if constexpr (HasSense<D>::value) D::sense(p, step, held, end);
  }
  void adapt(const S* p, const S* x, Present<S>& present) const override {
    if constexpr (HasAdapt<D>::value) D::adapt(p, x, present);
  }
  S sideCurrent(const S* p, const S& u_c2, const Present<S>& present) const override {
    if constexpr (HasSideCurrent<D>::value) return D::sideCurrent(p, u_c2, present);
    return S(0.0);
  }
  S activity(const S* p, const S& before, const ReactionRates<S>& rates, const Present<S>& present,
             double duration) const override {
    if constexpr (HasActivity<D>::value) return D::activity(p, before, rates, present, duration);
    return before;
  }
  void advance(const S* p, S* x, const Passage<S>& passage) const override {
    if constexpr (HasAdvance<D>::value) D::advance(p, x, passage);
  }
  S voltage(const S* p, const S* x, const Instant<S>& instant) const override {
    if constexpr (HasVoltage<D>::value) return D::voltage(p, x, instant);
    return S(0.0);
  }
  void show(const S* p, S* x, const Instant<S>& instant, S& voltage) const override {
    if constexpr (HasShow<D>::value) D::show(p, x, instant, voltage);
  }
};

/// An effect ready to be composed, its hooks in every arithmetic.
struct Effect {
  template <typename S>
  using Kernel = std::unique_ptr<EffectKernel<S>>;

  EffectInfo info;
  EffectHooks hooks;
  std::tuple<Kernel<double>, Kernel<Slope>, Kernel<Dual>> kernels;
};

template <typename D>
Effect effectOf() {
  Effect effect;
  effect.info = D::info();
  effect.info.on_request = OnRequest<D>::value;
  effect.info.acts_at_edges = ActsAtEdges<D>::value;
  effect.hooks = {HasSense<D>::value,       HasAdapt<D>::value,        HasSideCurrent<D>::value,
                  HasActivity<D>::value,    HasAdvance<D>::value,      HasVoltage<D>::value,
                  HasShow<D>::value,        IsLadder<D>::value,        StepsFinely<D>::value,
                  LimitsReaction<D>::value, AdaptsForOthers<D>::value, longestPieceOf<D>()};
  effect.kernels = {std::make_unique<KernelOf<D, double>>(), std::make_unique<KernelOf<D, Slope>>(),
                    std::make_unique<KernelOf<D, Dual>>()};
  return effect;
}

/// The hooks in the arithmetic of a number.
template <typename S>
const EffectKernel<S>& kernelOf(const Effect& effect, const S&) {
  return *std::get<Effect::Kernel<S>>(effect.kernels);
}

/// @return every effect, in the order in which a simulation applies them: instruments on the
/// current first.
const std::vector<Effect>& allEffects();

// ------------------------------------------------------------------------------------- what many effects need

/// Rungs of the ladder of a fractional double layer: two a decade from 1e-5 to 1e3 rad/s.
inline constexpr int kLadderRungs = 17;

/// max(x, 0), with the derivative of the side it is on.
template <typename S>
S positivePart(const S& x) {
  return valueOf(x) > 0.0 ? x : S(0.0);
}

template <typename S>
S magnitudeOf(const S& x) {
  return valueOf(x) < 0.0 ? S(-x) : x;
}

/// Voltage at which gassing is stated [V], and its slope [1/V] (Schiffer 2007,
/// docs/physics.md#gassing).
inline constexpr double kGassingVoltage = 14.4, kGassingSlope = 1.83;

/// exp(exponent), where gassing has an exponent: held at e^50, beyond which the current has long
/// become what is there to be taken.
template <typename S>
S gassingFactor(const S& exponent) {
  using std::exp;
  return S(exp(valueOf(exponent) > 50.0 ? S(50.0) : exponent));
}

/// Gassing over that at kGassingVoltage [1]. @param u_c2 [V].
template <typename S>
S gassingFactor(const S& u_c2, const Present<S>& present) {
  return gassingFactor(S(kGassingSlope * (present.u_dc + u_c2 - kGassingVoltage)));
}

/// Exact step of tau dx/dt = target - x under a held target.
template <typename S>
S relaxed(const S& x, const S& target, const S& tau, double duration) {
  using std::exp;
  const S kept = exp(S(-duration / tau));
  return S(target + (x - target) * kept);
}

/// A strength: zero removes its effect.
inline ParameterInfo strength(const std::string& name, const char* symbol, const char* unit,
                              double magnitude, double lower, double upper, const char* source) {
  ParameterInfo info{name, symbol, unit, magnitude, lower, upper, source};
  info.vanishes_at = 0.0;
  return info;
}

/// A strength in which the voltage is linear.
inline ParameterInfo linearStrength(const std::string& name, const char* symbol, const char* unit,
                                    double magnitude, double lower, double upper,
                                    const char* source) {
  ParameterInfo info = strength(name, symbol, unit, magnitude, lower, upper, source);
  info.linear = true;
  return info;
}

/// A time constant, capacitance or rate: known by its order of magnitude, to a factor e^prior_std.
inline ParameterInfo shape(const char* name, const char* symbol, const char* unit, double magnitude,
                           double lower, double upper, double prior_std, const char* source) {
  ParameterInfo info{name, symbol, unit, magnitude, lower, upper, source};
  info.logarithmic = true;
  info.prior_std = prior_std;
  return info;
}

/// The same, kept at its magnitude.
inline ParameterInfo held(ParameterInfo info) {
  info.held = true;
  return info;
}

}  // namespace battery_sof
