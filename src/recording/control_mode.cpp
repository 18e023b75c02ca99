#include "recording/control_mode.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>

#include "recording/channel_statistics.hpp"
#include "recording/edges.hpp"
#include "recording/events.hpp"
#include "recording/series_blocks.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr double kBeta = 35.0;               // [1/V], start-stop cars' batteries: 22 to 56
constexpr double kHelpShare = 0.2;           // of the largest twentieth; beyond it engines stand
constexpr double kClearlyCurrent = 3.0;      // sigma_i
constexpr double kMinChargeShare = 0.01;     // of all charge that flows
constexpr double kBand = 8.0;                // sigma, range of a thousand samples of noise
constexpr double kSetPointAccuracy = 0.005;  // of a programmed current
constexpr double kRegulation = 0.001;        // of a regulated voltage
constexpr double kMoved = 10.0;              // sigma_v
constexpr double kTurned = 4.0;              // sigma_v, the range of two samples of noise
constexpr double kTakesCurrent = 160.0;      // sigma_i: the band is 5 % of such a current
constexpr double kRestBand = 2.0;            // sigma_i
constexpr double kLargestStep = 0.5;         // of the whole move
constexpr double kRestDuration = 60.0;       // [s], a source is rarely left alone for so long
constexpr double kAboveOhmic = 10.0;         // times what the current's own spread makes
constexpr double kHeldShare = 0.5;           // of the change that the battery's resistance makes
constexpr double kLargeChange = 5.0;         // sigma_i
constexpr double kEdgeShare = 0.1;           // of the range of current
constexpr double kFewestEdges = 10;
constexpr double kFinestShare = 1.0 / 4096 / 3.4641016;  // of the range: 12 bits, step / sqrt(12)
constexpr std::size_t kFewestSamples = 5;
constexpr std::size_t kFewestChanges = 30;
constexpr double kFollows = 0.9;  // r^2 of changes of voltage on changes of current
// [V] of a block: 2.25 V a cell, a float charger's least, below where gassing begins
// (docs/physics.md#gassing). A battery at rest falls below it within minutes.
constexpr double kFloatVoltage = 13.5;

/// Sizes of the changes that are looked at [A].
struct ChangeSizes {
  double least = 0.0, most = 1e9;
};

/// @param within bool(current [A]), of both samples of a change.
template <typename Within>
ChangeSums changesWithin(const Series& series, const ControlModeRule& rule, ChangeSizes sizes,
                         Within within) {
  return changeSums(series, 1, [&](std::size_t k, double di) {
    return series.time[k] - series.time[k - 1] <= rule.max_gap && std::abs(di) >= sizes.least &&
           std::abs(di) <= sizes.most && within(series.current[k]) && within(series.current[k - 1]);
  });
}

/// Charge into the battery above the noise, as a share of all that flows.
double chargeShare(const Series& series, const ControlModeRule& rule) {
  double in = 0.0, all = 0.0;
  for (std::size_t k = 1; k < series.size(); ++k) {
    const double duration = series.time[k] - series.time[k - 1];
    if (duration > rule.max_gap) continue;
    const double current = series.current[k];
    if (std::abs(current) <= kClearlyCurrent * rule.current_noise) continue;
    all += std::abs(current) * duration;
    in += std::max(0.0, current) * duration;
  }
  return all > 0.0 ? in / all : 0.0;
}

/// Whether the voltage stands at a float charger's for kControlModeLookBack and stays within its
/// regulation, without a discharge: no battery does so by itself, however little it takes.
bool holdsFloatVoltage(const Series& series, const ControlModeRule& rule) {
  const double least = kFloatVoltage * seriesBlocksAt(quantile(series.voltage, 0.5));
  double lowest = 0.0, highest = 0.0, duration = 0.0;
  for (std::size_t k = 1; k < series.size(); ++k) {
    const double step = series.time[k] - series.time[k - 1], voltage = series.voltage[k];
    const bool is_float = voltage >= least && step <= rule.max_gap &&
                          series.current[k] >= -kBand * rule.current_noise;
    const double band = std::max(kBand * rule.voltage_noise, kRegulation * std::abs(voltage));
    lowest = std::min(lowest, voltage);
    highest = std::max(highest, voltage);
    if (!is_float || highest - lowest > band) lowest = highest = voltage, duration = 0.0;
    if (is_float) duration += step;
    if (duration >= kControlModeLookBack) return true;
  }
  return false;
}

double rangeOf(const std::vector<double>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return values.empty() ? 0.0 : *high - *low;
}

/// Noise, resistance and gap, and where there is a source the least current above which a driven
/// current is well posed: what is known before anything is known of how charges begin.
ControlModeRule firstRuleOf(const Series& series) {
  ControlModeRule rule;
  const auto current_step = findStep(series.current), voltage_step = findVoltageStep(series);
  rule.current_noise =
      std::max(noiseLevel(series.current, current_step), kFinestShare * rangeOf(series.current));
  const double voltage_noise = noiseLevel(series.voltage, voltage_step);
  rule.voltage_noise = std::max(voltage_noise, 0.5 * voltage_step.value_or(0.0));
  rule.max_gap = gapThreshold(series);
  const auto edges = edgeResponse(series);
  if (edges && edges->resistance > 0.0 && edges->correlation > 0.0)
    rule.resistance = edges->resistance;
  rule.present = chargeShare(series, rule) >= kMinChargeShare || holdsFloatVoltage(series, rule);
  if (rule.present)
    rule.min_current =
        -(kClearlyCurrent * rule.current_noise +
          (voltage_noise > 0.0 ? rule.current_noise / (kBeta * voltage_noise) : 0.0));
  return rule;
}

/// Small changes within discharges compared with large ones: a battery answers to both, a held
/// voltage to neither.
bool holdsVoltageInDischarge(const Series& series, const ControlModeRule& rule, double lowest) {
  const auto is_load = [&](double i) { return i < rule.min_current; };
  const auto is_light = [&](double i) { return is_load(i) && i > lowest; };
  const double edge = kEdgeShare * rangeOf(series.current);
  const auto heavy = changesWithin(series, rule, {edge}, is_load);
  const auto light =
      changesWithin(series, rule, {kLargeChange * rule.current_noise, edge}, is_light);
  if (heavy.count < kFewestEdges || light.count < kFewestChanges) return false;
  const double unexplained = light.voltage / light.current - light.slope() * light.slope();
  const double error = std::sqrt(std::max(0.0, unexplained) / static_cast<double>(light.count));
  return std::abs(light.slope()) + 2.0 * error < kHeldShare * heavy.slope();
}

/// Where a source controls the voltage the battery may help it out; how far grows with what the
/// battery carries.
double helpedOutAbove(const Series& series, const ControlModeRule& rule,
                      const EventLimits& limits) {
  const double half_crank = limits.crankLevel();
  if (holdsVoltageInDischarge(series, rule, half_crank)) return half_crank;
  std::vector<double> sizes;
  for (const double current : series.current) sizes.push_back(std::abs(current));
  return std::min(rule.min_current, -kHelpShare * quantile(std::move(sizes), 0.95));
}

bool followsCurrent(const Series& series, const ControlModeRule& rule) {
  const auto is_charge = [&](double i) { return i > kClearlyCurrent * rule.current_noise; };
  double highest = 0.0;
  for (const double current : series.current) highest = std::max(highest, current);
  const auto sums = changesWithin(series, rule, {kEdgeShare * highest}, is_charge);
  return sums.count >= kFewestChanges && sums.voltage > 0.0 && sums.slope() > 0.0 &&
         sums.product * sums.product / (sums.current * sums.voltage) >= kFollows;
}

struct Judged {
  std::vector<ControlModeReason> reasons;
  std::size_t charges = 0, constant_charges = 0;
};

/// Every sample as the watch judges it, evidence carried back over the stretch it is about.
Judged judgeAll(const Series& series, const ControlModeRule& rule) {
  Judged judged;
  judged.reasons.resize(series.size());
  ControlModeDetector watch(rule);
  bool was_charge = false, counted = false;
  std::size_t in_charge = 0;
  for (std::size_t k = 0; k < series.size(); ++k) {
    watch.add(series.time[k], series.current[k], series.voltage[k]);
    const std::size_t reach = std::clamp<std::size_t>(watch.evidenceReach(), 1, k + 1);
    const auto behind = judged.reasons.begin() + static_cast<std::ptrdiff_t>(k + 1);
    std::fill(behind - static_cast<std::ptrdiff_t>(reach), behind, watch.reason());
    const bool is_charge = series.current[k] > kTakesCurrent * rule.current_noise;
    if (!was_charge) in_charge = 0, counted = false;
    was_charge = is_charge;
    if (!is_charge) continue;
    if (++in_charge == kFewestSamples) ++judged.charges;
    if (counted || watch.reason() != ControlModeReason::kConstantCurrent) continue;
    counted = true;
    ++judged.constant_charges;
  }
  return judged;
}

ControlMode controlModeOf(ControlModeReason reason) {
  return reason == ControlModeReason::kHeldVoltage || reason == ControlModeReason::kSource
             ? ControlMode::kVoltage
             : ControlMode::kCurrent;
}

std::string summaryOf(const ControlModeOverview& source, const ControlModeRule& rule) {
  if (!source.seen) return "Nothing charges the battery, so the current is controlled throughout.";
  if (source.share == 0.0)
    return "The battery is charged by a source that controls the current; no voltage is held.";
  return format("A source holds the voltage in %.3g %% of the samples, those above %.3g A%s.",
                100.0 * source.share, rule.min_current,
                rule.charge_begins == ControlMode::kCurrent
                    ? "; charges begin with a controlled current"
                    : "");
}

void requireValid(const ControlModeRule& rule) {
  requireThat(true, "ControlModeRule: min_current [A]", rule.min_current, "a finite number");
  requireThat(rule.current_noise >= 0.0, "ControlModeRule: current_noise [A]", rule.current_noise,
              "at least 0");
  requireThat(rule.voltage_noise >= 0.0, "ControlModeRule: voltage_noise [V]", rule.voltage_noise,
              "at least 0");
  requireThat(rule.max_gap > 0.0, "ControlModeRule: max_gap [s]", rule.max_gap, "above 0");
  const double resistance = rule.resistance.value_or(1.0);
  requireThat(resistance > 0.0, "ControlModeRule: resistance [Ohm]", resistance, "above 0");
}

}  // namespace

std::string toString(ControlModeReason reason) {
  constexpr std::array kSentences = {
      "nothing in the recording charges the battery",
      "a load: the current is lower than while a source is connected",
      "the current is held within its noise while the voltage moves one way",
      "a rest without a source: the voltage relaxes",
      "a charge that begins as this recording's charges do, with a controlled current",
      "the voltage is held while the current moves",
      "a source is connected: the current is higher than with loads alone"};
  return kSentences.at(static_cast<std::size_t>(reason));
}

bool ControlModeDetector::Run::add(double time, double held, double other, double band) {
  const bool stays = samples > 0 && std::max(highest, held) - std::min(lowest, held) <= band;
  if (!stays) {
    *this = Run{};
    from = time;
    lowest = highest = held;
    last = other_lowest = other_highest = other;
  }
  ++samples;
  lowest = std::min(lowest, held);
  highest = std::max(highest, held);
  other_lowest = std::min(other_lowest, other);
  other_highest = std::max(other_highest, other);
  rise = std::max(rise, other - other_lowest);
  fall = std::max(fall, other_highest - other);
  largest_step = std::max(largest_step, std::abs(other - last));
  last = other;
  return stays;
}

ControlModeDetector::ControlModeDetector(const ControlModeRule& rule) : rule_(rule) {
  requireValid(rule);
}

double ControlModeDetector::currentBand(double current) const {
  return std::max(kBand * rule_.current_noise, kSetPointAccuracy * std::abs(current));
}

void ControlModeDetector::beginCharge() {
  charging_ = true;
  steady_current_ = steady_voltage_ = Run{};
  reason_ = rule_.charge_begins == ControlMode::kCurrent ? ControlModeReason::kChargeAsBefore
                                                         : ControlModeReason::kSource;
}

void ControlModeDetector::follow(double time, double current, double voltage) {
  const double voltage_band =
      std::max(kBand * rule_.voltage_noise, kRegulation * std::abs(voltage));
  const bool may_fall = steady_voltage_.samples > 0 && voltage < steady_voltage_.lowest;
  const bool current_stays = steady_current_.add(time, current, voltage, currentBand(current));
  const bool voltage_stays = steady_voltage_.add(time, voltage, current, voltage_band);
  voltage_fell_ = may_fall && !voltage_stays;
  if (!current_stays && rule_.charge_begins == ControlMode::kVoltage &&
      reason_ == ControlModeReason::kConstantCurrent)
    reason_ = ControlModeReason::kSource;
}

bool ControlModeDetector::movedOneWay() const {
  const Run& run = steady_current_;
  const double moved = std::max(run.rise, run.fall);
  const double ohmic = kAboveOhmic * rule_.resistance.value_or(0.0) * run.spread();
  return run.samples >= kFewestSamples && moved >= std::max(kMoved * rule_.voltage_noise, ohmic) &&
         std::min(run.rise, run.fall) <= kTurned * rule_.voltage_noise &&
         run.largest_step <= kLargestStep * moved;
}

bool ControlModeDetector::isConstantCurrent() const {
  return steady_current_.lowest >= kTakesCurrent * rule_.current_noise && movedOneWay();
}

bool ControlModeDetector::isRestApart(double time) const {
  const Run& run = steady_current_;
  const bool is_no_current = std::max(std::abs(run.lowest), std::abs(run.highest)) <=
                             kClearlyCurrent * rule_.current_noise;
  const bool let_go = rule_.charge_begins == ControlMode::kCurrent && voltage_fell_;
  const bool relaxes = time - run.from >= kRestDuration &&
                       run.spread() <= kRestBand * rule_.current_noise && movedOneWay();
  return is_no_current && (let_go || relaxes);
}

bool ControlModeDetector::isHeldVoltage() const {
  const Run& run = steady_voltage_;
  const double held = std::max(run.spread(), kTurned * rule_.voltage_noise);
  return run.samples >= kFewestSamples && run.fall > currentBand(run.other_highest) &&
         rule_.resistance && *rule_.resistance * run.fall >= held / kHeldShare;
}

bool ControlModeDetector::add(double time, double current, double voltage) {
  if (!std::isfinite(time) || !std::isfinite(current) || !std::isfinite(voltage))
    throw std::invalid_argument("ControlModeDetector::add: time is " + std::to_string(time) +
                                " s, current " + std::to_string(current) + " A and voltage " +
                                std::to_string(voltage) + " V; all are expected finite");
  const bool joined = last_time_ && time > *last_time_ && time - *last_time_ <= rule_.max_gap;
  last_time_ = time;
  reach_ = 0;
  if (!joined) charging_ = false;
  if (!rule_.present || current <= rule_.min_current) {
    charging_ = false;
    reason_ = rule_.present ? ControlModeReason::kLoad : ControlModeReason::kNoSource;
    return false;
  }
  if (!charging_) beginCharge();
  follow(time, current, voltage);
  if (isHeldVoltage()) {
    reason_ = ControlModeReason::kHeldVoltage;
    reach_ = steady_voltage_.samples;
  } else if (isConstantCurrent()) {
    reason_ = ControlModeReason::kConstantCurrent;
    reach_ = steady_current_.samples;
  } else if (isRestApart(time)) {
    reason_ = ControlModeReason::kRestApart;
    reach_ = steady_current_.samples;
  }
  return controlModeOf(reason_) == ControlMode::kVoltage;
}

ControlModes detectControlMode(const Series& series, const EventLimits& limits) {
  ControlModes source;
  ControlModeRule& rule = source.rule;
  rule = firstRuleOf(series);
  Judged judged = judgeAll(series, rule);
  if (rule.present) {
    const bool constant = judged.charges > 0 && 2 * judged.constant_charges >= judged.charges;
    if (constant || followsCurrent(series, rule))
      rule.charge_begins = ControlMode::kCurrent;
    else
      rule.min_current = helpedOutAbove(series, rule, limits);
    judged = judgeAll(series, rule);
  }
  for (const ControlModeReason reason : judged.reasons)
    source.voltage_controlled.push_back(controlModeOf(reason) == ControlMode::kVoltage);
  static_cast<ControlModeOverview&>(source) = overviewOf(series, judged.reasons, rule);
  return source;
}

std::string toString(ControlMode controlled) {
  return controlled == ControlMode::kVoltage ? "voltage" : "current";
}

ControlModeOverview overviewOf(const Series& series, const std::vector<ControlModeReason>& reasons,
                               const ControlModeRule& rule) {
  const auto goes_on = [&](std::size_t k) {
    return k < series.size() && series.time[k] - series.time[k - 1] <= rule.max_gap;
  };
  const auto joined = [&](std::size_t k) { return reasons[k] == reasons[k - 1] && goes_on(k); };
  ControlModeOverview overview;
  overview.seen = rule.present;
  std::map<std::string, ControlModeTotals> by_reason;
  std::size_t controlled = 0;
  for (const IndexRange& range : cutWhere({0, series.size()}, joined)) {
    const ControlModeReason reason = reasons[range.first];
    ControlModeTotals& totals = by_reason[toString(reason)];
    totals.reason = toString(reason);
    totals.mode = controlModeOf(reason);
    ++totals.stretches;
    totals.samples += range.size();
    if (totals.mode != ControlMode::kVoltage) continue;
    controlled += range.size();
    const double from = series.time[range.first],
                 to = series.time[goes_on(range.last) ? range.last : range.last - 1];
    if (!overview.times.empty() && overview.times.back().to == from)
      overview.times.back().to = to;
    else
      overview.times.push_back({from, to});
  }
  for (const auto& [reason, totals] : by_reason) overview.totals.push_back(totals);
  if (!series.empty())
    overview.share = static_cast<double>(controlled) / static_cast<double>(series.size());
  overview.summary = summaryOf(overview, rule);
  return overview;
}

}  // namespace battery_sof
