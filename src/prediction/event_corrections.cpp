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

/// The sensor's end of range, if past cranks show one.
std::optional<double> endOfRange(const std::vector<PastEvent>& cranks) {
  if (cranks.size() < 2) return std::nullopt;
  double lowest = cranks.front().current;
  for (const PastEvent& crank : cranks) lowest = std::min(lowest, crank.current);
  const auto there = std::count_if(cranks.begin(), cranks.end(), [&](const PastEvent& crank) {
    return crank.current < lowest + kSameCurrent;
  });
  return there >= 2 ? std::optional<double>(lowest) : std::nullopt;
}

Eigen::Vector3d featuresOf(double current, const std::optional<double>& end) {
  const bool clipped = end && std::abs(current - *end) < kSameCurrent;
  return {1.0, clipped ? 1.0 : 0.0, clipped ? 0.0 : (current + 200.0) / 100.0};
}

/// Corrections of one base of cranks, estimated from all past ones or all but one.
class CrankCorrection {
 public:
  /// @param bases [V], one a past crank.
  CrankCorrection(const std::vector<PastEvent>& cranks, const std::vector<double>& bases)
      : end_(endOfRange(cranks)) {
    for (std::size_t k = 0; k < cranks.size(); ++k)
      sums_.add(featuresOf(cranks[k].current, end_), cranks[k].measured - bases[k]);
  }
  double at(double current) const { return sums_.at(featuresOf(current, end_)); }
  double without(const PastEvent& crank, double base) const {
    const Eigen::Vector3d f = featuresOf(crank.current, end_);
    RidgeSums<3> others = sums_;
    others.add(f, crank.measured - base, -1.0);
    return others.at(f);
  }

 private:
  std::optional<double> end_;
  RidgeSums<3> sums_{kPenalty};
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

Interval around(double value, const std::vector<double>& errors, const IntervalCalibration& scale,
                const Interval& otherwise) {
  if (errors.size() >= kMinForInterval) {
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

Interval correctCrankPrediction(const FittedModel& model, double current,
                                const Interval& modelled) {
  const std::vector<PastEvent>& cranks = model.intervals.event_history.cranks;
  if (cranks.empty()) return modelled;
  const auto& line = model.fit.baseline.voltage_from_current;
  const bool takes_line = line && cranks.size() >= kMinForLine;
  std::vector<double> by_model, by_line;
  for (const PastEvent& crank : cranks) {
    by_model.push_back(crank.modelled);
    by_line.push_back(takes_line ? line->at(crank.current) : 0.0);
  }
  const CrankCorrection of_model(cranks, by_model), of_line(cranks, by_line);
  double value = modelled.value + of_model.at(current);
  if (takes_line) value = 0.5 * (value + line->at(current) + of_line.at(current));
  std::vector<double> errors;
  for (std::size_t k = 0; k < cranks.size() && cranks.size() >= kMinForInterval; ++k) {
    double without = by_model[k] + of_model.without(cranks[k], by_model[k]);
    if (takes_line) without = 0.5 * (without + by_line[k] + of_line.without(cranks[k], by_line[k]));
    errors.push_back(cranks[k].measured - without);
  }
  return around(value, errors, model.intervals.crank_calibration, modelled);
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
                model.intervals.charge_calibration, modelled);
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
