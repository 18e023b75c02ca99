#include <cmath>

#include "model_parts.hpp"

namespace battery_sof {
namespace {

constexpr double kMaxSamples = 1e12;
constexpr double kMinStep = 1e-3;     // [s], of a phase and a charge
constexpr std::size_t kMaxLag = 100;  // [samples], ten seconds of the slowest fast recording

std::size_t countOf(const Reader& node, const char* key, double value) {
  if (!(value >= 0.0 && value <= kMaxSamples))
    node.fail(key, "counts a number of samples or events that cannot be");
  return static_cast<std::size_t>(value);
}

void requireBounds(const Reader& node, const char* key, double lower, double upper) {
  if (!(lower <= upper)) node.fail(key, "has a lower error above the upper one");
}

std::optional<BaselineLine> lineOf(const Reader& node, const char* key) {
  if (!node.has(key)) return std::nullopt;
  const auto x = node.finiteNumbers(key, 8);
  requireBounds(node, key, x[3], x[4]);
  if (!(x[2] >= 0.0 && x[6] >= 0.0)) node.fail(key, "has a deviation or spread below 0");
  BaselineLine line;
  line.intercept = x[0];
  line.slope = x[1];
  line.std = x[2];
  line.lower_error = x[3];
  line.upper_error = x[4];
  line.centre = x[5];
  line.spread = x[6];
  line.samples = countOf(node, key, x[7]);
  return line;
}

std::optional<BaselineHistory> historyOf(const Reader& node, const char* key) {
  if (!node.has(key)) return std::nullopt;
  const auto x = node.finiteNumbers(key, 5);
  requireBounds(node, key, x[2], x[3]);
  return BaselineHistory{x[0], x[1], x[2], x[3], countOf(node, key, x[4])};
}

std::optional<BaselinePhase> phaseOf(const Reader& node) {
  if (!node.has("phase")) return std::nullopt;
  const Reader phase = node.at("phase");
  BaselinePhase p;
  p.current = phase.finiteNumbers("current_a", 0, kCurrents);
  p.step = phase.number("step_s", kTimes);
  const auto errors = phase.finiteNumbers("errors", 4);
  requireBounds(phase, "errors", errors[1], errors[2]);
  p.std = errors[0];
  p.lower_error = errors[1];
  p.upper_error = errors[2];
  p.charges = countOf(phase, "errors", errors[3]);
  if (p.current.empty() || !(p.step >= kMinStep))
    phase.fail("current_a", "must not be empty, step_s above 0");
  return p;
}

std::optional<BaselineCranks> cranksOf(const Reader& node) {
  if (!node.has("cranks")) return std::nullopt;
  const auto x = node.finiteNumbers("cranks", 9);
  requireBounds(node, "cranks", x[6], x[7]);
  BaselineCranks c;
  c.last = {x[0], x[1]};
  c.median = {x[2], x[3]};
  c.intercept = x[4];
  c.slope = x[5];
  c.lower_error = x[6];
  c.upper_error = x[7];
  c.events = countOf(node, "cranks", x[8]);
  return c;
}

void readBaseline(const Reader& root, Fit& fit) {
  if (!root.has("baseline")) return;
  const Reader node = root.at("baseline");
  fit.baseline.current_from_voltage = lineOf(node, "current_from_voltage");
  fit.baseline.voltage_from_current = lineOf(node, "voltage_from_current");
  fit.baseline.charge_10s = historyOf(node, "charge_10s");
  fit.baseline.charge_60s = historyOf(node, "charge_60s");
  fit.baseline.phase = phaseOf(node);
  fit.baseline.cranks = cranksOf(node);
}

void readSource(const Reader& root, Fit& fit) {
  if (!root.has("source")) return;
  const Reader node = root.at("source");
  ControlModeRule rule;
  rule.present = true;
  rule.min_current = node.number("min_current_a", kCurrents);
  const std::string begins = node.text("charge_begins");
  if (begins != "voltage" && begins != "current")
    node.fail("charge_begins", "is \"" + begins + "\", expected voltage or current");
  rule.charge_begins = begins == "voltage" ? ControlMode::kVoltage : ControlMode::kCurrent;
  rule.current_noise = node.number("current_noise_a", kCurrents);
  rule.voltage_noise = node.number("voltage_noise_v", kVoltages);
  if (node.has("resistance_ohm")) rule.resistance = node.number("resistance_ohm", {-1e3, 1e3});
  rule.max_gap = node.number("max_gap_s", kTimes);
  try {
    ControlModeDetector sound(rule);
  } catch (const std::invalid_argument& error) {
    node.fail("min_current_a", std::string("and its neighbours cannot be used: ") + error.what());
  }
  fit.source = rule;
  fit.voltage_lag = node.whole<std::size_t>("voltage_lag_samples");
  if (fit.voltage_lag > kMaxLag)
    node.fail("voltage_lag_samples", "is " + std::to_string(fit.voltage_lag) + ", expected 0 to " +
                                         std::to_string(kMaxLag));
}

/// Rows of numbers, each in its range.
std::vector<std::vector<double>> rowsOf(const Reader& node, const std::string& key,
                                        const std::vector<Range>& ranges) {
  if (!node.has(key)) return {};
  const std::string expected = "rows of " + std::to_string(ranges.size()) + " numbers";
  const auto rows = node.rows(key, expected.c_str());
  for (const auto& row : rows) {
    if (row.size() != ranges.size()) node.fail(key, "must be " + expected);
    for (std::size_t k = 0; k < row.size(); ++k) node.requireIn(key, row[k], ranges[k]);
  }
  return rows;
}

void readEventHistory(const Reader& root, EventHistory& event_history) {
  if (!root.has("event_history")) return;
  const Reader node = root.at("event_history");
  for (const auto& x : rowsOf(node, "cranks", {kTimes, kCurrents, kVoltages, kVoltages}))
    event_history.add(PastCrank{x[0], x[1], x[2], x[3]});
  for (const auto& x :
       rowsOf(node, "charges",
              {kTimes, {kMinStep, kTimes.most}, kVoltages, kVoltages, kCurrents, kCurrents}))
    event_history.add(PastCharge{x[0], x[1], x[2], x[3], x[4], x[5]});
  for (const auto& x : rowsOf(node, "stops", {kTimes, kCurrents, kVoltages, kVoltages}))
    event_history.add(PastStop{x[0], x[1], x[2], x[3]});
}

RidgeFit ridgeOf(const Reader& node) {
  const auto take = [&](const char* key) {
    const auto x = node.finiteNumbers(key, 0);
    return Eigen::VectorXd(
        Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(x.size())));
  };
  RidgeFit fit;
  fit.centre = take("centre");
  fit.scale = take("scale");
  fit.weight = take("weight");
  fit.lower = take("lower");
  fit.upper = take("upper");
  fit.constant = node.number("constant", kNumbers);
  fit.penalty = node.number("penalty");
  fit.gain = node.number("gain");
  const bool fits = fit.centre.size() == fit.weight.size() &&
                    fit.scale.size() == fit.weight.size() && fit.lower.size() == fit.upper.size() &&
                    (fit.lower.size() == 0 || fit.lower.size() == fit.weight.size());
  if (!fits || !(fit.scale.array() > 0.0).all())
    node.fail("weight", "and its neighbours must be as many finite numbers, scales above 0");
  if (!(fit.lower.array() <= fit.upper.array()).all())
    node.fail("lower", "must not be above upper");
  return fit;
}

void readDiscrepancy(const Reader& root, FittedModel& model) {
  if (root.at("state").has("memory"))
    model.state.memory =
        InputMemory::fromNumbers(root.at("state").finiteNumbers("memory", InputMemory::kNumbers));
  if (model.fit.discrepancy)
    model.state.regressor_memory =
        root.at("state").finiteNumbers("regressor_memory", model.fit.discrepancy->memorySize());
  if (!root.has("residual_regression")) return;
  const Reader node = root.at("residual_regression");
  const auto read = [&](const char* key, Eigen::Index columns, RidgeFit& fit) {
    if (!node.has(key)) return;
    fit = ridgeOf(node.at(key));
    if (fit.weight.size() != columns)
      node.at(key).fail("weight", "has " + std::to_string(fit.weight.size()) +
                                      " numbers, expected " + std::to_string(columns));
  };
  read("current", InputMemory::kCurrentColumns, model.fit.residual_regression.current);
  if (node.has("current")) {
    const auto range = node.finiteNumbers("current_range_a", 2, kCurrents);
    model.fit.residual_regression.min_current = range[0];
    model.fit.residual_regression.max_current = range[1];
    if (!(range[0] <= range[1])) node.fail("current_range_a", "must rise");
  }
  read("voltage", InputMemory::kVoltageColumns, model.fit.residual_regression.voltage);
}

}  // namespace

void readLessons(const Reader& root, FittedModel& model) {
  readBaseline(root, model.fit);
  readSource(root, model.fit);
  readEventHistory(root, model.intervals.event_history);
  readDiscrepancy(root, model);
}

}  // namespace battery_sof
