#include "battery_sof/identify/identification.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <tuple>

#include "battery_sof/identify/base_search.hpp"
#include "battery_sof/identify/composition_identification.hpp"
#include "battery_sof/identify/covariance.hpp"
#include "battery_sof/identify/error_tracker.hpp"
#include "battery_sof/identify/fit_description.hpp"
#include "battery_sof/identify/fit_quality.hpp"
#include "battery_sof/identify/follower.hpp"
#include "battery_sof/identify/window.hpp"
#include "battery_sof/recording/events.hpp"

namespace battery_sof {
namespace {

// A window whose current moves less than this cannot tell a resistance from an offset.
constexpr double kMinCurrentSpan = 0.5;  // [A]
constexpr const char* kChargingPhysics = "fresh_sulphate";
constexpr double kSlowSampling = 0.25;   // [s], from here on a crank's rise falls between samples

void requirePositiveOption(bool ok, const char* name, double value, const char* expected) {
  if (ok) return;
  std::ostringstream message;
  message << name << " is " << value << ", expected " << expected;
  throw std::invalid_argument(message.str());
}

void requireValid(const IdentifyOptions& options, const Series& series, IndexRange range) {
  requirePositiveOption(std::isfinite(options.crank_weight) && options.crank_weight >= 1.0,
                        "crank_weight", options.crank_weight, "at least 1");
  requirePositiveOption(
      std::isfinite(options.crank_weight_current) && options.crank_weight_current < 0.0,
      "crank_weight_current [A]", options.crank_weight_current, "below 0");
  requirePositiveOption(options.max_iterations > 0, "max_iterations", options.max_iterations,
                        "at least 1");
  for (std::size_t j = 0; j < options.initial.size(); ++j) {
    const auto& info = tableOne()[j];
    const double value = options.initial[j];
    requirePositiveOption(value >= info.lower && value <= info.upper,
                          ("initial " + info.name).c_str(), value, "inside Table I's bounds");
  }
  requirePositiveOption(options.more_starts >= 0, "more_starts", options.more_starts, "at least 0");
  requirePositiveOption(options.threads >= 0, "threads", options.threads, "at least 0");
  BatteryModel known(options.effects);
  if (!options.masked.empty() && options.masked.size() != series.size())
    throw std::invalid_argument("masked has " + std::to_string(options.masked.size()) +
                                " entries for a recording of " + std::to_string(series.size()));
  if (options.source && options.source->imposes_voltage.size() != series.size())
    throw std::invalid_argument("source has " + std::to_string(options.source->imposes_voltage.size()) +
                                " entries for a recording of " + std::to_string(series.size()));
  if (options.start == FitStart::kPaper && options.source)
    throw std::invalid_argument("the paper's start drives with the current alone: no source");
  if (options.start == FitStart::kPaper && (options.whiten || !options.effects.empty()))
    throw std::invalid_argument(
        "the paper's start fits the base model to eq. 3 alone: no effects, no whitening");
  if (range.last > series.size() || range.first > range.last)
    throw std::invalid_argument("window of samples " + std::to_string(range.first) + " to " +
                                std::to_string(range.last) + " in a recording of " +
                                std::to_string(series.size()));
}

/// Paper: the first sample sets the state and is left out of the sums (n = 2 to N in eqs. 3 and 4).
BaseFit searchPaper(std::vector<BaseNormalEquations::Sample> samples, const FirstSample& first,
                    const IdentifyOptions& options) {
  samples.front().weight = 0.0;
  return searchAsInPaper(BaseNormalEquations(samples, BaseParameters{}.i0), options, first);
}

bool atBound(const ParameterInfo& info, double value) {
  return value <= info.lower * (1.0 + 1e-6) || value >= info.upper * (1.0 - 1e-6);
}

/// d(r_discharge, r_charge, c2, beta, u_dc, first state) / d(the pass's columns), a diagonal.
Eigen::VectorXd physicalScale(const BaseParameters& p) {
  Eigen::VectorXd scale(static_cast<int>(kCovarianceRows));
  scale << 1.0, 1.0, 1.0, p.c2, p.beta, 1.0;
  return scale;
}

/// Columns with those of parameters held at a bound emptied: nothing is estimated there.
void holdBounded(BaseNormalEquations::Columns& columns, const BaseParameters& p) {
  if (atBound(tableOne()[0], p.r_discharge)) columns.col(kColumnDischarge).setZero();
  if (atBound(tableOne()[1], p.r_charge)) columns.col(kColumnCharge).setZero();
  if (atBound(tableOne()[2], p.c2)) columns.col(kColumnLogC2).setZero();
  if (atBound(tableOne()[3], p.beta)) columns.col(kColumnLogBeta).setZero();
}

/// From the order of BaseColumn to that of CovarianceRow.
Eigen::MatrixXd inPhysicalOrder(const Eigen::MatrixXd& covariance, const BaseParameters& p) {
  static constexpr std::array<int, kCovarianceRows> kColumnOfRow = {
      kColumnDischarge, kColumnCharge, kColumnLogC2, kColumnLogBeta, kColumnOne, kColumnInitial};
  const Eigen::VectorXd scale = physicalScale(p);
  Eigen::MatrixXd ordered(static_cast<int>(kCovarianceRows), static_cast<int>(kCovarianceRows));
  for (int j = 0; j < kCovarianceRows; ++j)
    for (int k = 0; k < kCovarianceRows; ++k)
      ordered(j, k) = covariance(kColumnOfRow[j], kColumnOfRow[k]) * scale[kColumnOfRow[j]] *
                      scale[kColumnOfRow[k]];
  return ordered;
}

/// State at the window's last sample, from the pass's last row.
Overpotential lastState(const Series& series, IndexRange range,
                        const BaseNormalEquations& equations,
                        const BaseNormalEquations::Columns& columns, const BaseParameters& p) {
  const auto row = columns.row(columns.rows() - 1);
  return {series.voltage[range.last - 1] - equations.offset() - row[kColumnTarget],
          row[kColumnInitial], row[kColumnLogC2] / p.c2, row[kColumnLogBeta] / p.beta};
}

std::vector<ParameterEstimate> estimatesOf(const BaseParameters& p,
                                           const Eigen::MatrixXd& covariance) {
  const std::array<double, 4> values = {p.r_discharge, p.r_charge, p.c2, p.beta};
  std::vector<ParameterEstimate> estimates;
  for (int j = 0; j < 4; ++j) {
    const auto& info = tableOne()[j];
    const auto std = standardError(covariance, j);
    const bool bound = atBound(info, values[j]);
    estimates.push_back(
        {info.name, info.unit, values[j], std, bound, !bound && std && *std < 0.5 * values[j]});
  }
  const auto std = standardError(covariance, kRowUDc);
  estimates.push_back({"u_dc", "V", p.u_dc, std, false, std && *std < 0.5});
  return estimates;
}

/// Replaces the state's row of a covariance by that of the state it became: V <- T V T'.
void carryCovariance(Eigen::MatrixXd& covariance, const Overpotential& carried) {
  Eigen::MatrixXd T = Eigen::MatrixXd::Identity(kCovarianceRows, kCovarianceRows);
  T(kRowState, kRowState) = carried.d_initial;
  T(kRowState, kRowC2) = carried.d_c2;
  T(kRowState, kRowBeta) = carried.d_beta;
  covariance = T * covariance * T.transpose();
}

/// Fills in everything that follows from where the search ended.
FittedModel describeFit(const Series& series, IndexRange range, const IdentifyOptions& options,
                        const BaseFit& fit, const BaseNormalEquations& equations,
                        const Eigen::VectorXd& weight) {
  const BaseParameters& p = fit.parameters;
  auto columns = equations.columns({p.c2, p.beta, fit.u_c2_first});
  const Eigen::VectorXd residual =
      (columns.col(kColumnTarget) - p.r_discharge * columns.col(kColumnDischarge) -
       p.r_charge * columns.col(kColumnCharge))
          .array() -
      (p.u_dc - equations.offset());
  const double rho = std::clamp(lagOneCorrelation(residual), -0.9999, 0.9999);

  const Overpotential last = lastState(series, range, equations, columns, p);
  holdBounded(columns, p);

  FittedModel model = unfitted(series, range, {}, fit.status, "");
  model.parameters = p;
  model.iterations = fit.iterations;
  model.covariance =
      inPhysicalOrder(sandwichCovariance(columns.leftCols(static_cast<int>(kCovarianceRows)),
                                         residual, weight, bartlettWidth(rho, residual.size())),
                      p);
  model.estimates = estimatesOf(p, model.covariance);
  model.scores = scoresOf(series, range, residual, rho, options.crank_weight_current);
  if (std::none_of(model.estimates.begin(), model.estimates.begin() + kRowUDc,
                   [](const ParameterEstimate& estimate) { return estimate.determined; }))
    model.status = FitStatus::kNotExcited;
  model.message = sentenceOf(model);
  model.state = {series.time[range.last - 1], last.value, series.current[range.last - 1]};
  model.first_state = {fit.u_c2_first};
  carryCovariance(model.covariance, last);
  return model;
}

bool imposesVoltage(const IdentifyOptions& options, IndexRange range) {
  if (!options.source) return false;
  const auto begin = options.source->imposes_voltage.begin();
  return std::any_of(begin + static_cast<std::ptrdiff_t>(range.first),
                     begin + static_cast<std::ptrdiff_t>(range.last), [](char imposed) { return imposed; });
}

}  // namespace

FittedModel identify(const Series& series, IndexRange range, const IdentifyOptions& options) {
  requireValid(options, series, range);
  if (options.chooses_effects && options.effects.empty() && imposesVoltage(options, range)) {
    IdentifyOptions charging = options;
    charging.effects = {kChargingPhysics};
    return identify(series, range, charging);
  }
  const std::string start = options.start == FitStart::kPaper ? "paper" : "robust";
  const auto refuse = [&](FitStatus status, const std::string& message) {
    FittedModel model = unfitted(series, range, options.effects, status, message);
    model.start = start;
    return model;
  };
  if (range.size() < kMinFitSamples)
    return refuse(FitStatus::kWindowTooShort, "the window has " + std::to_string(range.size()) +
                                                  " samples, at least " +
                                                  std::to_string(kMinFitSamples) + " are needed");
  const auto [low, high] =
      std::minmax_element(series.current.begin() + static_cast<std::ptrdiff_t>(range.first),
                          series.current.begin() + static_cast<std::ptrdiff_t>(range.last));
  if (*high - *low < kMinCurrentSpan) {
    std::ostringstream message;
    message << "the current moves by " << *high - *low << " A in the window, at least "
            << kMinCurrentSpan << " A are needed to tell a resistance from an offset";
    return refuse(FitStatus::kNotExcited, message.str());
  }
  auto samples = fitSamples(series, range, options.crank_weight, options.crank_weight_current);
  if (!options.masked.empty())
    for (std::size_t n = 0; n < samples.size(); ++n)
      if (options.masked[range.first + n]) samples[n].weight = 0.0;
  const BaseNormalEquations equations(samples, BaseParameters{}.i0);
  const FirstSample first = {series.current[range.first], series.voltage[range.first]};
  const BaseFit fit = options.start == FitStart::kPaper ? searchPaper(samples, first, options)
                                                        : searchWindow(samples, equations, options);
  Eigen::VectorXd weight(static_cast<Eigen::Index>(samples.size()));
  for (std::size_t n = 0; n < samples.size(); ++n) weight[n] = samples[n].weight;
  FittedModel model =
      options.effects.empty() && !options.whiten && !imposesVoltage(options, range)
          ? describeFit(series, range, options, fit, equations, weight)
          : identifyComposition(series, range, options, fit);
  model.start = start;
  if (!model.source) model.naive = fitNaive(series, range, std::vector<char>(series.size(), 0));
  model.suitability = model.scores.left_out_share_percent
                          ? std::clamp(*model.scores.left_out_share_percent / 100.0, 0.0, 1.0)
                          : predictionSuitability(model.scores.rmse, windowExcitation(series, range));
  return model;
}

std::optional<DrivingSource> drivingSource(const Series& series) {
  if (medianInterval(series) < kSlowSampling) return std::nullopt;
  Source source = findSource(series);
  if (!source.seen || source.share <= 0.0) return std::nullopt;
  return DrivingSource{std::move(source), findVoltageRepair(series)};
}

std::optional<DrivingSource> drivingSource(const Series& series, std::size_t last) {
  std::optional<DrivingSource> source = drivingSource(slice(series, {0, last}));
  if (!source) return source;
  source->imposes_voltage.resize(series.size(), 0);
  source->repair.dropped.resize(series.size(), 0);
  return source;
}

void carryState(FittedModel& model, const Series& series, std::size_t last) {
  const auto at = std::lower_bound(series.time.begin(), series.time.end(), model.state.time);
  if (at == series.time.end() || *at != model.state.time || last >= series.size() ||
      series.time[last] < model.state.time)
    throw std::invalid_argument(
        "carryState: the state must stand at a sample at or before the end");
  const auto first = static_cast<std::size_t>(at - series.time.begin());
  const Drive drive = driveOf(model, series, {first, last + 1});
  Follower follower(model, true);
  ErrorTracker errors(model);
  for (std::size_t n = 1; n < drive.samples.size(); ++n) {
    const DriveSample& sample = drive.samples[n];
    const FollowedSample followed = follower.follow(sample);
    if (followed.voltage_drives)
      errors.wait(sample.step.duration);
    else
      errors.observe(sample.step.duration, sample.voltage - followed.voltage);
  }
  takeState(model, follower, series.current[last]);
  model.discrepancy = errors.discrepancy();
}

}  // namespace battery_sof
