#include "simulator/generator/physical_difference.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "simulator/fields.hpp"
#include "simulator/generator/series.hpp"
#include "simulator/power_source.hpp"

namespace battery_sof_simulator {
namespace {

constexpr double kGap = 3.0;                         // times the median interval
constexpr double kPerInterval = 0.25;                // of the interval is a step
constexpr double kShortest = 1e-3, kLongest = 0.25;  // steps [s]
constexpr double kAtOnce = 1e9;                      // [A/s]
constexpr double kLeastCharging = 0.5;               // [A]
constexpr double kLeastRegulated = 13.0;             // [V], above every rest
constexpr double kContact = 1e-3;                    // [Ohm] at strength 1
constexpr double kGassingRise = 20.0;                // at strength 1: antimony, or a hot block
constexpr double kSlowerDiffusion = 8.0;             // at strength 1
constexpr double kHydrogenShift = 0.04;              // [V] at strength 1

using Course = PhysicalCause::Course;

PorousParameters soundBlock(double capacity_ah) {
  PorousParameters block;
  const double size = capacity_ah / block.capacity_ah;
  block.capacity_ah *= size;
  block.area_m2 *= size;
  block.grid_ohm /= size;
  block.gas_current_a *= size;
  block.lead_ion_limit_a *= size;
  block.gassing = block.lead_ion = true;
  return block;
}

/// The blocks of an order: what a cause's amount makes of them at a share of the duration.
class Blocks {
 public:
  Blocks(const DifferenceOrder& order, double step)
      : sound_(soundBlock(order.capacity_ah)), step_(step) {
    for (const auto& part : order.parts) {
      const auto& all = physicalCauses();
      const auto found =
          std::find_if(all.begin(), all.end(), [&](const auto& one) { return one.id == part.id; });
      if (found == all.end()) throw std::invalid_argument("no cause is \"" + part.id + "\"");
      if (!(part.strength >= 0.0 && std::isfinite(part.strength)))
        throw std::invalid_argument(faultOf("strength", part.strength, "0 or more"));
      parts_.push_back({&*found, part.strength});
    }
  }
  PorousBlock sound() const { return {sound_, kReferenceSoc, step_}; }
  PorousBlock changed(double share) const {
    PorousParameters block = sound_;
    for (const auto& [cause, strength] : parts_) {
      const double course = cause->course == Course::kGrowing       ? share
                            : cause->course == Course::kFromInstant ? share >= kInstantShare
                                                                    : 1.0;
      cause->change(block, strength * course);
    }
    return {block, kReferenceSoc, step_};
  }

 private:
  PorousParameters sound_;
  double step_;
  std::vector<std::pair<const PhysicalCause*, double>> parts_;
};

double medianInterval(const std::vector<RecordedSample>& samples) {
  std::vector<double> passed;
  for (std::size_t n = 1; n < samples.size(); ++n)
    passed.push_back(std::max(0.0, samples[n].time - samples[n - 1].time));
  return quantile(passed, 0.5);
}

}  // namespace

const std::vector<PhysicalCause>& physicalCauses() {
  using Block = PorousParameters;
  static const std::vector<PhysicalCause> causes{
      {"charge_limit", "acceptance", Course::kAlways,
       [](Block& b, double a) { b.lead_ion_limit_a /= 1.0 + a; }},
      {"slow_dissolution", "acceptance", Course::kAlways,
       [](Block& b, double a) { b.lead_ion_time_s *= 1.0 + a; }},
      {"slow_diffusion", "acid", Course::kAlways,
       [](Block& b, double a) { b.diffusion_factor /= 1.0 + kSlowerDiffusion * a; }},
      {"more_gassing", "side_reactions", Course::kAlways,
       [](Block& b, double a) { b.gas_current_a *= 1.0 + kGassingRise * a; }},
      {"early_hydrogen", "side_reactions", Course::kAlways,
       [](Block& b, double a) { b.hydrogen_potential_v += kHydrogenShift * a; }},
      {"lost_plates", "open_circuit", Course::kAlways,
       [](Block& b, double a) {
         b.capacity_ah /= 1.0 + a;
         b.area_m2 /= 1.0 + a;
       }},
      {"slow_positive", "structure", Course::kAlways,
       [](Block& b, double a) { b.positive.exchange_a_per_m2 /= 1.0 + a; }},
      {"negative_layer", "structure", Course::kAlways,
       [](Block& b, double a) { b.negative.layer_f_per_m2 *= 1.0 + a; }},
      {"corroding_grid", "ageing", Course::kGrowing,
       [](Block& b, double a) { b.grid_ohm *= 1.0 + a; }},
      {"shrinking_surface", "ageing", Course::kGrowing,
       [](Block& b, double a) {
         b.negative.surface_per_m /= 1.0 + a;
         b.positive.surface_per_m /= 1.0 + a;
       }},
      {"loose_contact", "instrument", Course::kFromInstant,
       [](Block& b, double a) { b.grid_ohm += kContact * a; }}};
  return causes;
}

bool isRegulated(const RecordedSample& sample) {
  return sample.current > kLeastCharging && sample.voltage >= kLeastRegulated;
}

std::vector<RecordedSample> withDifference(const std::vector<RecordedSample>& measured,
                                           const DifferenceOrder& order) {
  if (measured.size() < 3)
    throw std::invalid_argument("recording has " + std::to_string(measured.size()) +
                                " samples, expected 3 or more");
  const double interval = medianInterval(measured);
  const double step = std::clamp(kPerInterval * interval, kShortest, kLongest);
  const Blocks blocks(order, step);
  const PorousBlock sound = blocks.sound();
  const double strongest =
      std::max_element(measured.begin(), measured.end(), [](const auto& a, const auto& b) {
        return a.current < b.current;
      })->current;
  const double duration = std::max(step, measured.back().time - measured.front().time);
  const PowerSource charger(kAtOnce);
  PorousState before = sound.rested(), after = blocks.changed(0.0).rested();
  std::vector<RecordedSample> samples = measured;
  for (std::size_t to = 1; to < samples.size(); ++to) {
    const double passed = std::max(0.0, measured[to].time - measured[to - 1].time);
    const PorousBlock changed =
        blocks.changed(std::clamp((measured[to].time - measured[0].time) / duration, 0.0, 1.0));
    const bool gap = passed > kGap * interval;
    const long steps = std::lround(passed / step);
    for (long n = 1; n <= steps; ++n) {
      const double share = static_cast<double>(n) / static_cast<double>(steps);
      const double between =
          measured[to - 1].current + share * (measured[to].current - measured[to - 1].current);
      const double current = gap && n < steps ? 0.0 : between;
      before = sound.advance(before, current);
      after = isRegulated(measured[to]) && current > 0.0
                  ? charger.step(changed, after, {strongest, sound.voltage(before)})
                  : changed.advance(after, current);
    }
    samples[to].current += after.current - before.current;
    samples[to].voltage += changed.voltage(after) - sound.voltage(before);
  }
  return samples;
}

}  // namespace battery_sof_simulator
