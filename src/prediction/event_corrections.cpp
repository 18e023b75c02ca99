#include "prediction/event_corrections.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "regression/ridge.hpp"

namespace battery_sof {
namespace {

constexpr double kPenalty = 0.3;            // of past cranks' normal equations
constexpr std::size_t kMinForLine = 4;      // cranks
constexpr std::size_t kMinForInterval = 3;  // events
// of past charges' normal equations
constexpr double kChargePenalty = 3.0;
constexpr std::size_t kMinForRegression = 4;  // charges
// [A], cranks that end alike end at the sensor's range
constexpr double kSameCurrent = 0.5;
// [V], of a charge that is another's like
constexpr double kAlikeVoltage = 0.5;
constexpr double kSupportVoltage = 0.3;  // [V]
// [A], an error below it says nothing
constexpr double kFloor = 0.02;
constexpr double kSupportShare = 0.25, kSupportCurrent = 1.0;  // [1], [A]

/// Half the width in which nine of ten of so few errors lie: their spread as a normal
/// distribution's.
double halfWidth(const std::vector<double>& errors) {
  double squares = 0.0;
  for (const double error : errors) squares += error * error;
  const double n = static_cast<double>(errors.size());
  return kNinetyPercent * std::sqrt(squares / n) * (1.0 + 1.0 / n);
}

/// The sensor's end of range: the recording showed it, or past cranks do.
std::optional<double> endOfRange(const FittedModel& model) {
  if (const auto limit = model.fit.excited.sensor_min_current) return limit;
  const std::vector<PastEvent>& cranks = model.intervals.event_history.cranks;
  if (cranks.size() < 2) return std::nullopt;
  double lowest = cranks.front().current;
  for (const PastEvent& crank : cranks) lowest = std::min(lowest, crank.current);
  const auto there = std::count_if(cranks.begin(), cranks.end(), [&](const PastEvent& crank) {
    return crank.current < lowest + kSameCurrent;
  });
  return there >= 2 ? std::optional<double>(lowest) : std::nullopt;
}

/// Past cranks of one kind, and what the equations and the line missed of them.
class CrankCorrection {
 public:
  /// @param line none: too few cranks for it.  @param cut_off by the sensor: their current is not
  /// known.
  CrankCorrection(std::vector<PastEvent> cranks, const std::optional<BaselineLine>& line,
                  bool cut_off)
      : cranks_(std::move(cranks)), cut_off_(cut_off) {
    if (line && cranks_.size() >= kMinForLine) line_ = line;
    for (const PastEvent& crank : cranks_) {
      of_model_.add(featuresOf(crank.current), crank.measured - crank.modelled);
      if (line_) of_line_.add(featuresOf(crank.current), crank.measured - line_->at(crank.current));
    }
  }

  bool empty() const { return cranks_.empty(); }

  /// @param modelled [V], by the equations.
  double at(double current, double modelled) const {
    return answer(current, modelled, of_model_, of_line_);
  }

  /// What was missed of each crank with the correction by the others.
  std::vector<double> errors() const {
    std::vector<double> errors;
    for (const PastEvent& crank : cranks_) {
      const Eigen::Vector2d f = featuresOf(crank.current);
      RidgeSums<2> model = of_model_, line = of_line_;
      model.add(f, crank.measured - crank.modelled, -1.0);
      if (line_) line.add(f, crank.measured - line_->at(crank.current), -1.0);
      errors.push_back(crank.measured - answer(crank.current, crank.modelled, model, line));
    }
    return errors;
  }

 private:
  Eigen::Vector2d featuresOf(double current) const {
    return {1.0, cut_off_ ? 0.0 : (current + 200.0) / 100.0};
  }
  double answer(double current, double modelled, const RidgeSums<2>& of_model,
                const RidgeSums<2>& of_line) const {
    const Eigen::Vector2d f = featuresOf(current);
    const double by_model = modelled + of_model.at(f);
    return line_ ? 0.5 * (by_model + line_->at(current) + of_line.at(f)) : by_model;
  }

  std::vector<PastEvent> cranks_;
  bool cut_off_;
  std::optional<BaselineLine> line_;
  RidgeSums<2> of_model_{kPenalty}, of_line_{kPenalty};
};

std::vector<PastEvent> alike(const EventHistory& event_history, double voltage, double duration,
                             double reach) {
  std::vector<PastEvent> charges;
  for (const PastEvent& charge : event_history.charges)
    if (charge.duration <= 2.0 * duration && duration <= 2.0 * charge.duration &&
        std::abs(charge.voltage - voltage) <= reach)
      charges.push_back(charge);
  return charges;
}

/// Median of a number of the charges but one. @param left_out beyond the last: none.
template <typename Number>
double medianWithout(const std::vector<PastEvent>& charges, std::size_t left_out, Number&& number) {
  std::vector<double> others;
  for (std::size_t k = 0; k < charges.size(); ++k)
    if (k != left_out) others.push_back(number(charges[k]));
  return medianOf(others);
}

double missedBy(const PastEvent& charge) { return charge.measured - charge.modelled; }

/// Model and median, each by the inverse of its median error.
double stackOf(const std::vector<PastEvent>& charges, double modelled, std::size_t left_out) {
  const double median =
      medianWithout(charges, left_out, [](const PastEvent& c) { return c.measured; });
  const double a =
      medianWithout(charges, left_out, [](const PastEvent& c) { return std::abs(missedBy(c)); });
  const double b = medianWithout(charges, left_out,
                                 [&](const PastEvent& c) { return std::abs(c.measured - median); });
  const double share = (b + kFloor) / (a + b + 2.0 * kFloor);
  return share * modelled + (1.0 - share) * median;
}

Eigen::Vector4d chargeFeatures(double voltage, double first_voltage, double modelled) {
  return {1.0, 2.0 * (voltage - 13.0), 2.0 * (first_voltage - 13.0), 0.1 * modelled - 1.0};
}

/// What past charges' errors say of a charge's.
double regressedError(const std::vector<PastEvent>& charges, const ChargeBeginning& at,
                      double modelled, std::size_t left_out) {
  const double usual = kFloor + medianWithout(charges, left_out, [](const PastEvent& c) {
                         return std::abs(missedBy(c));
                       });
  RidgeSums<4> sums(kChargePenalty);
  for (std::size_t k = 0; k < charges.size(); ++k) {
    if (k == left_out) continue;
    const double error = missedBy(charges[k]);
    sums.add(chargeFeatures(charges[k].voltage, charges[k].first_voltage, charges[k].modelled),
             error, std::min(1.0, 2.0 * usual / std::max(std::abs(error), 1e-9)));
  }
  return sums.at(chargeFeatures(at.voltage, at.first_voltage, modelled));
}

/// @param enough errors for an interval of their own.
Interval around(double value, const std::vector<double>& errors, const IntervalCalibration& scale,
                const Interval& otherwise, std::size_t enough = kMinForInterval) {
  if (errors.size() >= enough) {
    const double half = scale.factor * halfWidth(errors);
    return {value, value - half, value + half};
  }
  return {value, value + otherwise.lower - otherwise.value,
          value + otherwise.upper - otherwise.value};
}

}  // namespace

std::optional<Interval> expectedBy(const BaselinePredictor& baseline, const PastEvent& event) {
  return event.kind == PastEvent::Kind::kCharge
             ? baselineChargeCurrent(baseline, event.voltage, event.duration)
             : baselineCrankMinimum(baseline, event.current);
}

EventComparison ofSeries(EventComparison event, double series_blocks) {
  const bool is_charge = event.kind == PastEvent::Kind::kCharge;
  for (double* voltage : is_charge ? std::array{&event.voltage, &event.first_voltage}
                                   : std::array{&event.measured, &event.modelled})
    *voltage *= series_blocks;
  if (is_charge) return event;
  event.expected = ofSeries(event.expected, series_blocks);
  if (event.baseline) event.baseline = ofSeries(*event.baseline, series_blocks);
  return event;
}

std::optional<double> usualVoltage(const std::vector<PastEvent>& charges) {
  std::vector<double> voltages;
  for (const PastEvent& charge : charges) voltages.push_back(charge.voltage);
  return voltages.empty() ? std::nullopt : std::optional<double>(medianOf(std::move(voltages)));
}

Interval correctCrankPrediction(const FittedModel& model, double current, const Interval& modelled,
                                CurrentMeaning meaning) {
  const std::optional<double> end = endOfRange(model);
  std::vector<PastEvent> whole, cut_off;
  for (const PastEvent& crank : model.intervals.event_history.cranks) {
    const bool is_bound = end && crank.current < *end + kSameCurrent;
    if (is_bound) cut_off.push_back(crank);
    // A bound that is violated says as much as a crank that was measured whole.
    if (!is_bound || crank.measured > crank.modelled) whole.push_back(crank);
  }
  const auto& line = model.fit.baseline.voltage_from_current;
  const IntervalCalibration& calibration = model.intervals.calibrations.cranks;
  const auto answer = [&](const CrankCorrection& past, std::size_t enough) {
    return around(past.at(current, modelled.value), past.errors(), calibration, modelled, enough);
  };
  const Interval exact = answer({whole, line, false}, kMinForInterval);
  const bool is_at_end = end && std::abs(current - *end) < kSameCurrent;
  if (!is_at_end || cut_off.empty()) return exact;
  // What the sensor shows as its end is this current or more.
  const Interval beyond = answer({cut_off, line, true}, 1);
  if (meaning == CurrentMeaning::kShown && cut_off.size() >= kMinForInterval) return beyond;
  return {beyond.value, std::min(beyond.lower, exact.lower), std::max(beyond.upper, exact.upper)};
}

Interval correctChargePrediction(const FittedModel& model, const ChargeBeginning& charge,
                                 const Interval& modelled) {
  const std::vector<PastEvent> charges =
      alike(model.intervals.event_history, charge.voltage, charge.duration, kAlikeVoltage);
  if (charges.size() < kMinForInterval) return modelled;
  const auto answer = [&](const ChargeBeginning& at, double of_model, std::size_t left_out) {
    const double stacked = stackOf(charges, of_model, left_out);
    if (charges.size() < kMinForRegression) return stacked;
    return 0.5 * (stacked + of_model + regressedError(charges, at, of_model, left_out));
  };
  std::vector<double> errors;
  for (std::size_t k = 0; k < charges.size(); ++k)
    errors.push_back(charges[k].measured -
                     answer({charges[k].voltage, charges[k].first_voltage, charges[k].duration},
                            charges[k].modelled, k));
  return around(answer(charge, modelled.value, charges.size()), errors,
                model.intervals.calibrations.charges, modelled);
}

ChargeEvidence chargeEvidence(const EventHistory& event_history, double voltage, double duration) {
  ChargeEvidence evidence;
  std::vector<double> errors, currents;
  for (const PastEvent& charge : alike(event_history, voltage, duration, kSupportVoltage)) {
    errors.push_back(std::abs(missedBy(charge)));
    currents.push_back(std::abs(charge.measured));
  }
  evidence.charges = static_cast<int>(errors.size());
  evidence.median_error = medianOf(errors);
  evidence.typical = medianOf(currents);
  evidence.is_supported =
      evidence.charges >= ChargeEvidence::kLeast &&
      evidence.median_error <= std::max(kSupportShare * evidence.typical, kSupportCurrent);
  return evidence;
}

}  // namespace battery_sof
