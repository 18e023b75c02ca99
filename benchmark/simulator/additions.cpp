#include "simulator/additions.hpp"

#include <algorithm>

#include "simulator/fields.hpp"

namespace battery_sof_simulator {
namespace {

constexpr double kMaxDepletion = 0.99;
constexpr double kGateTime = 2.0;  // [s]
constexpr double kGateFrom = 5.0;  // [A]

double signOf(double x) { return x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : 0.0; }

double hysteresisAfter(const Additions& a, double before, double charge) {
  const double goal = signOf(charge);
  return goal + (before - goal) * std::exp(-std::abs(charge) / (kSecondsPerHour * a.hysteresis_ah));
}

/// A share that discharge brings towards 1 over one charge [Ah], and charging to 0 over another.
double builtByDischarge(double before, double charge, double building_ah, double erasing_ah) {
  if (charge > 0.0) return before * std::exp(-charge / (kSecondsPerHour * erasing_ah));
  return 1.0 - (1.0 - before) * std::exp(charge / (kSecondsPerHour * building_ah));
}

double sulphateAfter(const Additions& a, double before, double charge, double step) {
  const double made = charge < 0.0 ? -charge : -a.sulphate_charge_share * charge;
  const double goal = 1.0 + made / (kSecondsPerHour * a.sulphate_ah) * (a.sulphate_time_s / step);
  const double after = goal + (before - goal) * std::exp(-step / a.sulphate_time_s);
  return std::max(a.sulphate_least, after);
}

/// Q and N of the crystals; N keeps its share of Q while charging.
void ripenCrystals(const Additions& a, double charge, double step, AddedState& s) {
  const double drawn_ah = -charge / kSecondsPerHour;
  const double after = std::max(0.0, s.fresh_ah + drawn_ah);
  if (drawn_ah > 0.0)
    s.crystals += drawn_ah / a.crystal_nuclei_ah;
  else if (s.fresh_ah > 0.0)
    s.crystals *= after / s.fresh_ah;
  s.crystals *= std::exp(-step / a.crystal_ripening_s);
  s.fresh_ah = after;
}

}  // namespace

bool anyOn(Additions a) {
  const Fields fields = fieldsOf(a);
  return a.parasitic_load_a != 0.0 ||
         std::any_of(fields.begin(), fields.end(), [](const Field& field) {
           const auto* const flag = std::get_if<bool*>(&field.place);
           return flag != nullptr && **flag;
         });
}

AddedVoltages::AddedVoltages(const Additions& additions, double step)
    : additions_(additions),
      step_(step),
      rc_ohm_{additions.fast_arc ? additions.fast_arc_ohm : 0.0,
              additions.acid_transport ? additions.acid_1_ohm : 0.0,
              additions.acid_transport ? additions.acid_2_ohm : 0.0},
      rc_{LowPass(additions.fast_arc_time_s, step), LowPass(additions.acid_1_time_s, step),
          LowPass(additions.acid_2_time_s, step)},
      depletion_(additions.depletion_time_s, step),
      memory_(additions.memory_time_s, step),
      gate_(kGateTime, step) {}

AddedState AddedVoltages::settled(double current) const {
  AddedState state;
  for (std::size_t k = 0; k < rc_.size(); ++k) state.rc[k] = rc_ohm_[k] * current;
  state.nuclei = additions_.coup_nuclei_at_start;
  return state;
}

AddedState AddedVoltages::advance(const AddedState& before, double begin, double end) const {
  const Additions& a = additions_;
  const double charge = 0.5 * (begin + end) * step_;
  AddedState s = before;
  for (std::size_t k = 0; k < rc_.size(); ++k)
    s.rc[k] = rc_[k].advance(s.rc[k], rc_ohm_[k] * begin, rc_ohm_[k] * end);
  if (a.ocv_hysteresis) s.hysteresis = hysteresisAfter(a, s.hysteresis, charge);
  if (a.high_rate_depletion)
    s.depletion = depletion_.advance(s.depletion, std::max(0.0, -begin) / a.depletion_limit_a,
                                     std::max(0.0, -end) / a.depletion_limit_a);
  if (a.coup_de_fouet) {
    s.nuclei = builtByDischarge(s.nuclei, charge, a.coup_nuclei_ah, a.coup_erasing_ah);
    s.onset = builtByDischarge(s.onset, charge, a.coup_onset_ah, a.coup_onset_ah);
  }
  if (a.sulphate_history) s.sulphate = sulphateAfter(a, s.sulphate, charge, step_);
  if (a.sulphate_crystals) ripenCrystals(a, charge, step_, s);
  if (a.memory_resistance)
    s.remembered = memory_.advance(s.remembered, std::abs(begin), std::abs(end));
  const double moving = std::abs(end) > kGateFrom ? 1.0 : 0.0;
  if (a.gated_tone) s.gate = gate_.advance(s.gate, moving, moving);
  if (a.hysteretic_r && std::abs(end) > a.hysteretic_from_a) s.last_large_sign = signOf(end);
  return s;
}

double AddedVoltages::voltage(const AddedState& s, double time, double current) const {
  const Additions& a = additions_;
  double sum = s.rc[0] + s.rc[1] + s.rc[2];
  if (a.ocv_hysteresis) sum += a.hysteresis_v * s.hysteresis;
  if (a.high_rate_depletion)
    sum += a.depletion_v * std::log1p(-std::min(s.depletion, kMaxDepletion));
  if (a.coup_de_fouet) sum -= a.coup_v * (1.0 - s.nuclei) * s.onset;
  if (a.memory_resistance) sum += a.memory_ohm_per_a * s.remembered * current;
  if (a.step_force && std::abs(current) > a.step_force_above_a)
    sum += signOf(current) * a.step_force_v;
  if (a.gated_tone)
    sum += a.gated_tone_v * s.gate * std::sin(kTwoPi * time / a.gated_tone_period_s);
  return sum;
}

double AddedVoltages::chargeLimitFactor(const AddedState& s) const {
  if (!additions_.sulphate_crystals) return s.sulphate;
  return s.sulphate *
         (1.0 + additions_.crystal_supply * std::cbrt(s.crystals * s.fresh_ah * s.fresh_ah));
}

double AddedVoltages::resistance(const AddedState& s, double time) const {
  double sum = 0.0;
  if (additions_.contact_step && time >= additions_.contact_from_s) sum += additions_.contact_ohm;
  if (additions_.hysteretic_r) sum += additions_.hysteretic_ohm * s.last_large_sign;
  return sum;
}

}  // namespace battery_sof_simulator
