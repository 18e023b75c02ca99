#include "regression/residual_regression.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace battery_sof {
namespace {

// [s], of exp(-since discharge / time)
constexpr std::array<double, 4> kFadings = {1.5, 5.0, 15.0, 50.0};
constexpr double kNominal = 12.6;  // [V], a battery at rest
// [V], a modelled voltage is held inside
constexpr double kLowestVoltage = 9.0, kHighestVoltage = 15.0;
constexpr double kHighRate = -100.0;                         // [A]
constexpr std::size_t kMinCurrents = 60, kMinVoltages = 30;  // samples
constexpr int kCurrentBlocks = 6, kVoltageBlocks = 5;

template <std::size_t N>
void relax(std::array<double, N>& memory, const std::array<double, N>& times, double x,
           double duration) {
  for (std::size_t k = 0; k < N; ++k)
    memory[k] += (1.0 - std::exp(-duration / times[k])) * (x - memory[k]);
}

/// 0.01 to 10,000 by half decades, of normal equations that are not divided by the number of
/// samples.
std::vector<double> penalties() {
  std::vector<double> all;
  for (int k = -4; k <= 8; ++k) all.push_back(std::pow(10.0, 0.5 * k));
  return all;
}

RidgeFit fitPart(const ResidualSamples& samples, bool voltage_controlled, std::size_t least,
                 int blocks, std::vector<double>& left_out) {
  std::vector<std::size_t> rows;
  for (std::size_t n = 0; n < samples.error.size(); ++n)
    if (static_cast<bool>(samples.voltage_controlled[n]) == voltage_controlled) rows.push_back(n);
  if (rows.size() < least) return {};
  Eigen::MatrixXd X(rows.size(), samples.columns[rows.front()].size());
  Eigen::VectorXd y(X.rows());
  for (Eigen::Index k = 0; k < X.rows(); ++k) {
    X.row(k) = samples.columns[rows[k]].transpose();
    y[k] = samples.error[rows[k]];
  }
  RidgeOptions options;
  options.penalties = penalties();
  options.blocks = blocks;
  options.constant_penalty = 0.1;
  options.clipped = options.shrunk = true;
  Eigen::VectorXd without;
  RidgeFit fit = fitRidge(X, y, options, &without);
  for (std::size_t k = 0; k < rows.size(); ++k) left_out[rows[k]] = without[k];
  return fit;
}

/// Visits a memory's numbers but for `begun`, in the order of a file.
template <typename Memory, typename Visit>
void eachNumber(Memory& memory, Visit&& visit) {
  const auto all = [&](auto& values) {
    for (auto& x : values) visit(x);
  };
  all(memory.voltage);
  all(memory.discharge);
  all(memory.current);
  all(memory.held);
  for (auto* x : {&memory.last_voltage, &memory.last_discharge, &memory.since_discharge,
                  &memory.since_source})
    visit(*x);
}

}  // namespace

std::vector<double> InputMemory::numbers() const {
  std::vector<double> x;
  eachNumber(*this, [&](double number) { x.push_back(number); });
  x.push_back(begun ? 1.0 : 0.0);
  return x;
}

InputMemory InputMemory::fromNumbers(const std::vector<double>& x) {
  if (x.size() != kNumbers)
    throw std::invalid_argument("a memory of inputs has " + std::to_string(x.size()) +
                                " numbers, expected " + std::to_string(kNumbers));
  InputMemory memory;
  auto at = x.begin();
  eachNumber(memory, [&](double& number) { number = *at++; });
  memory.begun = *at != 0.0;
  return memory;
}

Eigen::VectorXd InputMemory::advance(const Moment& moment) {
  const double u = moment.voltage_controlled
                       ? moment.voltage
                       : std::clamp(moment.voltage, kLowestVoltage, kHighestVoltage);
  const double drawn = moment.voltage_controlled ? 0.0 : std::max(-moment.current, 0.0);
  if (!begun) {
    voltage.fill(u);
    current.fill(moment.current);
    held.fill(moment.current);
    last_voltage = u;
    begun = true;
  }
  const double change_u = u - last_voltage;
  const double driving = moment.voltage_controlled ? 0.0 : moment.current;
  const double change_i = driving - last_discharge;
  relax(voltage, kVoltageTimes, u, moment.duration);
  relax(discharge, kDischargeTimes, drawn, moment.duration);
  relax(current, kCurrentTimes, moment.current, moment.duration);
  relax(held, kHeldTimes, moment.current, moment.duration);
  since_discharge = moment.voltage_controlled ? since_discharge + moment.duration : 0.0;
  since_source = moment.voltage_controlled ? 0.0 : since_source + moment.duration;
  last_voltage = u;
  last_discharge = driving;
  return moment.voltage_controlled ? currentColumns(moment, change_u)
                                   : voltageColumns(moment, change_i);
}

Eigen::VectorXd InputMemory::currentColumns(const Moment& moment, double change) const {
  const double u = moment.voltage, i = moment.current, above = u - kNominal;
  std::vector<double> x = {u};
  for (const double low : voltage) x.push_back(u - low);
  x.insert(x.end(), {change, std::max(change, 0.0)});
  x.insert(x.end(), discharge.begin(), discharge.end());
  std::array<double, 4> faded;
  for (std::size_t k = 0; k < faded.size(); ++k)
    faded[k] = std::exp(-since_discharge / kFadings[k]);
  x.insert(x.end(), faded.begin(), faded.end());
  for (const double f : faded) x.push_back(f * above);
  for (std::size_t k = 1; k <= 3; ++k) x.push_back(discharge[k] * above);
  for (std::size_t k = 1; k <= 3; ++k)
    x.push_back(std::sqrt(std::max(discharge[k], 0.0) * kDischargeTimes[k]));
  x.push_back(i);
  for (const double low : current) x.push_back(i - low);
  x.push_back(std::abs(i));
  for (std::size_t k = 0; k < 3; ++k) x.push_back(i * faded[k]);
  return Eigen::Map<const Eigen::VectorXd>(x.data(), x.size());
}

Eigen::VectorXd InputMemory::voltageColumns(const Moment& moment, double change) const {
  const double i = moment.current;
  Eigen::VectorXd x(9);
  x << i, std::min(i - kHighRate, 0.0), std::exp(-since_source / 1.5),
      std::exp(-since_source / 10.0), std::sqrt(since_source), held[0], held[1], change,
      moment.voltage;
  return x;
}

ResidualRegression fitResidualRegression(const ResidualSamples& samples,
                                         std::vector<double>& left_out) {
  left_out.assign(samples.error.size(), 0.0);
  return {fitPart(samples, true, kMinCurrents, kCurrentBlocks, left_out),
          fitPart(samples, false, kMinVoltages, kVoltageBlocks, left_out)};
}

}  // namespace battery_sof
