#include <Eigen/Eigenvalues>
#include <cmath>

#include "discrepancy_yaml.hpp"
#include "estimation/residual_filter.hpp"
#include "model_parts.hpp"
#include "prediction/query.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

// of a parameter's range: far above what an undetermined one shows
constexpr double kMaxStd = 1e9;
constexpr double kMaxFurtherStd = 1e9;  // in the state's unit
constexpr double kSame = 1e-9;          // files hold correlations with twelve digits
constexpr double kMinEigenvalue = -1e-6;

/// Fits with a penalty go a little beyond the bounds, and bounds differ between versions: a decade,
/// or as much again.
Range rangeOf(const ParameterInfo& info) {
  if (info.instant) return kTimes;
  if (info.lower > 0.0) return {0.1 * info.lower, 10.0 * info.upper};
  const double span = info.upper - info.lower;
  return {info.lower - span, info.upper + span};
}

ParameterEstimate estimateOf(const Reader& parameters, const ParameterInfo& info) {
  const Reader field = parameters.at(info.name);
  ParameterEstimate estimate;
  estimate.name = info.name;
  estimate.unit = field.text("unit");
  estimate.value = field.number("value", rangeOf(info));
  if (field.has("std_error"))
    estimate.std = field.number("std_error", {0.0, kMaxStd * (info.upper - info.lower)});
  if (field.has("held")) estimate.held = field.get<bool>("held", "true or false");
  estimate.at_bound = field.get<bool>("at_bound", "true or false");
  estimate.determined = field.get<bool>("determined", "true or false");
  return estimate;
}

void readParameters(const Reader& root, Fit& fit) {
  const Reader parameters = root.at("parameters");
  const BatteryModel composition = compositionOf(fit);
  for (const ParameterInfo& info : composition.parameters())
    fit.estimates.push_back(estimateOf(parameters, info));
  const Reader fixed = root.at("fixed");
  auto& p = fit.parameters;
  p.r_discharge = fit.estimates[kRowRDischarge].value;
  p.r_charge = fit.estimates[kRowRCharge].value;
  p.c2 = fit.estimates[kRowC2].value;
  p.beta = fit.estimates[kRowBeta].value;
  p.u_dc = fit.estimates[kRowUDc].value;
  p.i0 = fixed.number("i0_a", {1e-6, 1e6});
  p.alpha = fixed.number("alpha");
  try {
    requireValid(p);
  } catch (const std::invalid_argument& error) {
    parameters.fail("", error.what());
  }
}

/// What "parameters" and "effects" say must be a composition.
void readEffects(const Reader& root, Fit& fit) {
  const auto ids = root.get<std::vector<std::string>>("effects", "a list of ids");
  if (root.has("discrepancy"))
    fit.discrepancy =
        std::make_shared<const DiscrepancyModel>(discrepancyOf(root.at("discrepancy")));
  try {
    fit.effects = BatteryModel(ids, fit.discrepancy).effects();
  } catch (const std::invalid_argument& error) {
    root.fail("effects", std::string("cannot be used: ") + error.what());
  }
}

void readState(const Reader& root, FittedModel& model) {
  const Reader state = root.at("state");
  model.state = {state.number("time_s", kTimes), state.number("u_c2_v", kVoltages),
                 state.number("current_a", kCurrents)};
  const BatteryModel composition = compositionOf(model.fit);
  for (std::size_t j = 1; j < composition.states().size(); ++j)
    model.state.further.push_back(
        state.at("further").at(composition.states()[j].name).number("value", kNumbers));
}

/// Standard errors of parameters and states.
Eigen::VectorXd stdOf(const Reader& state, const Fit& fit, const BatteryModel& composition) {
  const Eigen::Index parameters = composition.parameterCount();
  Eigen::VectorXd std(parameters + composition.stateCount());
  for (Eigen::Index j = 0; j < parameters; ++j)
    std[j] = fit.estimates[static_cast<std::size_t>(j)].std.value_or(0.0);
  std[parameters] = state.number("u_c2_std_v", {0.0, kMaxFurtherStd});
  for (Eigen::Index j = 1; j < composition.stateCount(); ++j) {
    const std::string& name = composition.states()[static_cast<std::size_t>(j)].name;
    std[parameters + j] = state.at("further").at(name).number("std_error", {0.0, kMaxFurtherStd});
  }
  return std;
}

void requireCorrelation(const Reader& root, const Eigen::MatrixXd& correlation) {
  if (((correlation.diagonal().array() - 1.0).abs() > kSame).any())
    root.fail("correlation", "must have ones on its diagonal");
  if (((correlation - correlation.transpose()).array().abs() > kSame).any())
    root.fail("correlation", "must be symmetric");
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(correlation, Eigen::EigenvaluesOnly);
  const double least = eigen.eigenvalues().minCoeff();
  if (!(least >= kMinEigenvalue))
    root.fail("correlation", format("has the eigenvalue %g, expected none below 0", least));
}

void readCovariance(const Reader& root, Fit& fit) {
  const BatteryModel composition = compositionOf(fit);
  const Eigen::VectorXd std = stdOf(root.at("state"), fit, composition);
  const Eigen::Index size = std.size();
  const std::string expected =
      std::to_string(size) + " rows of " + std::to_string(size) + " numbers";
  const auto rows = root.rows("correlation", expected.c_str());
  Eigen::MatrixXd correlation(size, size);
  const auto wanted = static_cast<std::size_t>(size);
  for (std::size_t j = 0; j < wanted; ++j)
    for (std::size_t k = 0; k < wanted; ++k) {
      if (rows.size() != wanted || rows[j].size() != wanted ||
          !(std::abs(rows[j][k]) <= 1.0 + kSame))
        root.fail("correlation", "must be " + expected + " between -1 and 1");
      correlation(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(k)) = rows[j][k];
    }
  requireCorrelation(root, correlation);
  fit.covariance = std.asDiagonal() * correlation * std.asDiagonal();
}

IntervalCalibration scaleOf(const Reader& field) {
  IntervalCalibration scale;
  scale.factor = field.number("factor");
  scale.events = field.whole<int>("events");
  scale.inside = field.whole<int>("inside");
  if (!(scale.factor > 0.0 && scale.factor <= 1e6) || scale.inside < 0 ||
      scale.events < scale.inside)
    field.fail("factor", "must be above 0, with events >= inside >= 0");
  return scale;
}

ResidualState residualStateOf(const Reader& now) {
  const auto p = now.numbers("covariance_v2", "three numbers");
  if (p.size() != 3) now.fail("covariance_v2", "must be three numbers");
  const ResidualState d{now.number("drift_v", kVoltages), now.number("colored_v", kVoltages), p[0],
                        p[1], p[2]};
  constexpr double kMaxVariance = 1e4;  // [V^2]
  const bool is_covariance = d.p_dd >= 0.0 && d.p_dd <= kMaxVariance && d.p_aa >= 0.0 &&
                             d.p_aa <= kMaxVariance &&
                             d.p_da * d.p_da <= d.p_dd * d.p_aa * (1.0 + kSame) + 1e-24;
  if (!is_covariance)
    now.fail("covariance_v2", format("is [%g, %g, %g], expected variance of the drift, covariance, "
                                     "variance of the colored part",
                                     d.p_dd, d.p_da, d.p_aa));
  return d;
}

/// Files of earlier versions have no "errors".
void readErrors(const Reader& root, FittedModel& model) {
  if (!root.has("errors")) return;
  const Reader errors = root.at("errors");
  model.intervals.crank_calibration = scaleOf(errors.at("crank_intervals"));
  model.intervals.charge_calibration = scaleOf(errors.at("charge_intervals"));
  if (!errors.has("white_std_v")) return;
  constexpr Range kStd{0.0, 10.0};  // [V] and [V/sqrt(s)], of a 12 V battery's error
  model.fit.noise = NoiseModel{
      errors.number("white_std_v", {1e-9, kStd.most}), errors.number("ar_std_v", kStd),
      errors.number("ar_time_s", {1e-6, 1e9}), errors.number("walk_std_v_per_sqrt_s", kStd)};
  model.state.residual_state = residualStateOf(errors.at("now"));
}

}  // namespace

void readEquations(const Reader& root, FittedModel& model) {
  readEffects(root, model.fit);
  readParameters(root, model.fit);
  readState(root, model);
  readCovariance(root, model.fit);
  readErrors(root, model);
}

void requireRuns(const Reader& root, const FittedModel& model) {
  constexpr double kDuration = 1.0, kCurrent = 20.0;  // [s], [A]
  try {
    for (const double current : {-kCurrent, kCurrent}) {
      Simulation simulation = uncertainSimulationOf(model);
      hold(simulation, current, kDuration);
      const Interval u = voltageAnswer(simulation, ResidualFilter(model).forecast(kDuration),
                                       model.fit.scores.rmse, model.intervals.crank_calibration);
      if (!(std::isfinite(u.value) && std::isfinite(u.lower) && std::isfinite(u.upper)))
        root.fail("parameters", "and state make no finite voltage");
    }
  } catch (const std::invalid_argument& error) {
    root.fail("parameters", std::string("and state cannot be run: ") + error.what());
  }
}

}  // namespace battery_sof
