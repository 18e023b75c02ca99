#include "state/posterior.hpp"

#include <algorithm>
#include <cmath>

namespace battery_sof {
namespace {

constexpr double kMostSigmas = 4.0;  // of an error that is taken in

// What a parking changes in the long run, and how soon (docs/model.md#from-trip-to-trip).
constexpr double kParkedTime = 86400.0;     // [s]
constexpr double kParkedShare = 0.05;       // of a resistance, of the capacitance, of the slope
constexpr double kParkedVoltage = 0.08;     // [V] of a block
constexpr double kShareOfKelvin = 0.01;     // [1/K]
constexpr double kVoltageOfKelvin = 0.003;  // [V/K] of a block

// Of the population: standard deviations of logarithms, and of the open-circuit voltage.
constexpr double kTableCapacity = 50.0;  // [Ah], of Table I's battery
constexpr double kResistanceSpread = 0.6;
constexpr double kCapacitanceSpread = 0.7;
constexpr double kSlopeSpread = 0.5;
constexpr double kUsualVoltage = 12.6;         // [V] of a block of six cells
constexpr double kVoltageSpread = 0.3;         // [V]
constexpr double kPopulationError = 0.15;      // [V], what the base circuit misses of a drive
constexpr double kPopulationCrankError = 0.3;  // [V], of a crank's minimum

bool isPositive(const ParameterInfo& info) { return info.lower > 0.0; }

double moved(const ParameterInfo& info, double value, double change) {
  const double next =
      isPositive(info) && value > 0.0 ? value * std::exp(change / value) : value + change;
  return std::clamp(next, std::min(info.lower, value), std::max(info.upper, value));
}

void setParameter(Fit& fit, Eigen::Index row, double value) {
  BaseParameters& base = fit.parameters;
  double* const of_base[] = {&base.r_discharge, &base.r_charge, &base.c2, &base.beta, &base.u_dc};
  if (row < kBaseRows) *of_base[row] = value;
  if (row < static_cast<Eigen::Index>(fit.estimates.size())) fit.estimates[row].value = value;
}

}  // namespace

double determinedBelow(const Fit& fit, std::size_t row) {
  return row == kRowUDc ? 0.5 : 0.5 * std::abs(fit.estimates[row].value);
}

void takeStandardErrors(Fit& fit) {
  for (std::size_t j = 0; j < fit.estimates.size(); ++j) {
    ParameterEstimate& estimate = fit.estimates[j];
    const auto row = static_cast<Eigen::Index>(j);
    const double variance = fit.covariance(row, row);
    if (estimate.held || !(variance > 0.0) || !std::isfinite(variance)) continue;
    estimate.std = std::sqrt(variance);
    estimate.determined = *estimate.std < determinedBelow(fit, j);
    estimate.at_bound = false;
  }
}

std::vector<KnownParameter> knownOf(const std::vector<KnownPopulation>& populations,
                                    const std::vector<std::string>& effects) {
  for (const KnownPopulation& population : populations)
    if (std::is_permutation(effects.begin(), effects.end(), population.effects.begin(),
                            population.effects.end()))
      return population.parameters;
  return {};
}

const KnownParameter* find(const std::vector<KnownParameter>& known, const std::string& name) {
  const auto one = std::find_if(known.begin(), known.end(), [&](const KnownParameter& parameter) {
    return parameter.name == name;
  });
  return one == known.end() ? nullptr : &*one;
}

double takeIn(FittedModel& model, const Innovation& innovation) {
  const Eigen::VectorXd& h = innovation.modelled;
  const double variance = h.squaredNorm() + innovation.std_error * innovation.std_error;
  const double most = kMostSigmas * std::sqrt(variance);
  const double error = std::clamp(innovation.error, -most, most);
  const Eigen::VectorXd shared = innovation.factor * h;
  Eigen::VectorXd gain = shared / variance;
  if (!innovation.rows.empty()) {
    gain.setZero();
    for (const Eigen::Index row : innovation.rows) gain[row] = shared[row] / variance;
  }
  const Eigen::VectorXd change = gain * error;
  const BatteryModel composition = compositionOf(model.fit);
  const Eigen::VectorXd before = pointOf(model).parameters;
  const Eigen::Index parameters = composition.parameterCount();
  for (Eigen::Index j = 0; j < parameters; ++j)
    if (change[j] != 0.0)
      setParameter(model.fit, j, moved(composition.parameters()[j], before[j], change[j]));
  model.state.states += change.segment(parameters, model.state.states.size());
  Eigen::MatrixXd& covariance = model.fit.covariance;
  covariance = innovation.factor * innovation.factor.transpose();
  covariance +=
      variance * gain * gain.transpose() - gain * shared.transpose() - shared * gain.transpose();
  takeStandardErrors(model.fit);
  // What the moved rows take up: of the whole gain h'h / S of the error.
  const double taken = innovation.rows.empty() ? h.squaredNorm() / variance : 0.0;
  return innovation.error - taken * error;
}

FittedModel parked(FittedModel model, double duration, std::optional<double> temperature) {
  const double part = 1.0 - std::exp(-std::max(0.0, duration) / kParkedTime);
  std::optional<double>& known_at = model.fit.excited.temperature;
  const double warmer = temperature && known_at ? *temperature - *known_at : 0.0;
  if (known_at && temperature) known_at = temperature;
  if (std::abs(warmer) > kTemperatureReach) model.intervals.event_history = {};
  const auto infos = compositionOf(model.fit).parameters();
  Eigen::MatrixXd& covariance = model.fit.covariance;
  for (std::size_t j = 0; j < model.fit.estimates.size(); ++j) {
    const ParameterEstimate& estimate = model.fit.estimates[j];
    const auto row = static_cast<Eigen::Index>(j);
    if (estimate.held || row >= covariance.rows()) continue;
    const bool is_voltage = estimate.name == "u_dc";
    if (!is_voltage && !isPositive(infos[j])) continue;
    const double scale = is_voltage ? 1.0 : estimate.value;
    covariance(row, row) +=
        part * std::pow(scale * (is_voltage ? kParkedVoltage : kParkedShare), 2) +
        std::pow(scale * warmer * (is_voltage ? kVoltageOfKelvin : kShareOfKelvin), 2);
  }
  const double colored = model.fit.noise ? model.fit.noise->ar_std : 0.0;
  model.state.residual_state = {0.0, 0.0, 0.0, 0.0, colored * colored};
  model.state.missed_crank = {};
  takeStandardErrors(model.fit);
  return model;
}

void carryCranks(Fit& fit, const Fit& before) {
  const double current = before.excited.min_current;
  if (fit.scores.cranks > 0 || before.scores.cranks == 0 || current >= fit.excited.min_current)
    return;
  const double apart = (fit.parameters.r_discharge - before.parameters.r_discharge) * current +
                       fit.parameters.u_dc - before.parameters.u_dc;
  fit.scores.crank_error_std = std::hypot(before.scores.crank_error_std, apart);
  fit.scores.cranks = before.scores.cranks;
  fit.excited.min_current = current;
  fit.excited.min_voltage = std::min(fit.excited.min_voltage, before.excited.min_voltage);
}

FittedModel populationPrior(double capacity, const std::vector<KnownParameter>& fleet, double time,
                            double current, double voltage) {
  FittedModel model;
  Fit& fit = model.fit;
  const double ratio = capacity / kTableCapacity;
  fit.parameters.r_discharge /= ratio;
  fit.parameters.r_charge /= ratio;
  fit.parameters.c2 *= ratio;
  fit.parameters.u_dc = kUsualVoltage;
  const BatteryModel composition = compositionOf(fit);
  const Eigen::VectorXd values = pointOf(model).parameters;
  const double spreads[] = {kResistanceSpread, kResistanceSpread, kCapacitanceSpread, kSlopeSpread,
                            kVoltageSpread / kUsualVoltage};
  fit.covariance = Eigen::MatrixXd::Zero(kCovarianceRows, kCovarianceRows);
  for (Eigen::Index j = 0; j < kBaseRows; ++j) {
    const ParameterInfo& info = composition.parameters()[j];
    fit.estimates.push_back({info.name, info.unit, values[j], std::nullopt});
    double spread = spreads[j] * values[j];
    if (const KnownParameter* known = find(fleet, info.name)) {
      setParameter(fit, j, std::clamp(known->value, info.lower, info.upper));
      spread = known->logarithmic ? known->std * known->value : known->std;
    }
    fit.covariance(j, j) = spread * spread;
  }
  fit.status = FitStatus::kIterationLimit;
  fit.message = "nothing was fitted yet";
  fit.start = "robust";
  fit.window = {time, time, 0};
  fit.scores.rmse = kPopulationError;
  fit.scores.crank_error_std = kPopulationCrankError;
  fit.scores.cranks = 1;
  fit.excited.min_voltage = fit.excited.max_voltage = voltage;
  model.state.time = time;
  model.state.current = current;
  takeStandardErrors(fit);
  return model;
}

}  // namespace battery_sof
