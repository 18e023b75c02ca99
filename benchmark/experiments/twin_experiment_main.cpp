// Twin test: recordings that a known model made on a drive's own voltage and current, sampled once
// a second, with the errors of a vehicle's sensors injected, are fitted again. Prints which
// share of the parameters lies within two standard errors of the truth and how far the current of
// charges is off.
//
//     twin_experiment --seeds 100 --offset 0.1

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <random>

#include "estimation/identification.hpp"
#include "recording/channel_statistics.hpp"
#include "recording/events.hpp"
#include "state/state_estimator.hpp"

namespace {

using namespace battery_sof;

// [s] fitted, and predicted
constexpr double kWindow = 900.0;
constexpr double kSourceLimit = 14.2;                                              // [V]
constexpr double kVoltageStep = 0.025, kCurrentStep = 0.1, kVoltageNoise = 0.012;  // [V], [A], [V]

/// What is controlled on the battery once a second.
struct Imposed1Hz {
  std::vector<char> voltage_controlled;
  std::vector<double> current, voltage;
};

/// A start-stop drive: engine on with a source that changes its voltage, engine off with loads,
/// cranks.
Imposed1Hz startStopDrive(std::mt19937& dice) {
  std::uniform_real_distribution<double> any(0.0, 1.0);
  Imposed1Hz inputs;
  const auto add = [&](bool drives, double current, double voltage) {
    inputs.voltage_controlled.push_back(drives);
    inputs.current.push_back(current);
    inputs.voltage.push_back(voltage);
  };
  while (inputs.current.size() < 2.0 * kWindow + 1.0) {
    double voltage = 12.6 + 0.3 * any(dice);
    for (double rest = 20.0 + 60.0 * any(dice); rest > 0.0;) {
      const double wanted =
          any(dice) < 0.5 ? kSourceLimit - 0.3 * any(dice) : 12.6 + 0.6 * any(dice);
      for (double held = std::min(rest, 5.0 + 15.0 * any(dice)); held > 0.0;
           held -= 1.0, rest -= 1.0) {
        voltage += 0.5 * (wanted - voltage);
        add(true, 0.0, voltage);
      }
    }
    const double load = -(12.0 + 15.0 * any(dice));
    for (double stop = 5.0 + 35.0 * any(dice); stop > 0.0; stop -= 1.0)
      add(false, load * (0.9 + 0.2 * any(dice)), 0.0);
    add(false, -(150.0 + 100.0 * any(dice)), 0.0);
    add(false, 0.5 * load, 0.0);
  }
  return inputs;
}

double normal(std::mt19937& dice, double std) {
  return std::normal_distribution<double>(0.0, std)(dice);
}

/// A model whose parameters are drawn around their magnitudes.
ModelPoint drawnTruth(const BatteryModel& model, std::mt19937& dice) {
  ModelPoint truth{model.typicalParameters(), model.restState()};
  for (Eigen::Index j = 0; j < model.parameterCount(); ++j) {
    const ParameterInfo& info = model.parameters()[static_cast<std::size_t>(j)];
    const double spread = 0.1 * info.prior_std.value_or(2.0);
    if (!info.held && j != kRowUDc) truth.parameters[j] *= std::exp(normal(dice, spread));
  }
  truth.parameters[kRowUDc] = 12.6 + normal(dice, 0.1);
  return truth;
}

InputSequence inputsOf(const Series& series, const std::vector<char>& drives) {
  return inputSequence(series, {0, series.size()}, {}, drives);
}

/// The recording that the truth makes, without an error.
Series recordingOf(const BatteryModel& model, const ModelPoint& truth,
                   const Imposed1Hz& controlled) {
  Series series;
  for (std::size_t n = 0; n < controlled.current.size(); ++n) {
    series.append({static_cast<double>(n), controlled.current[n], controlled.voltage[n]});
  }
  Simulation simulation(model, truth);
  InputSequence inputs = inputsOf(series, controlled.voltage_controlled);
  for (std::size_t n = 0; n < inputs.samples.size(); ++n) {
    InputSample& sample = inputs.samples[n];
    if (n > 0) sample.step.held = 0.5 * (series.current[n - 1] + series.current[n]);
    simulation.follow(sample);
    if (sample.voltage_controlled)
      series.current[n] -= simulation.currentError();
    else
      series.voltage[n] = simulation.voltage();
  }
  return series;
}

double rounded(double x, double step) { return step * std::round(x / step); }

Series asMeasured(Series series, double offset, std::mt19937& dice) {
  for (std::size_t n = 0; n < series.size(); ++n) {
    series.current[n] = rounded(series.current[n] + offset, kCurrentStep);
    series.voltage[n] = rounded(series.voltage[n] + normal(dice, kVoltageNoise), kVoltageStep);
  }
  return series;
}

struct Tally {
  int inside = 0, asked = 0;
  std::vector<double> ratios;
};

struct Outcome {
  std::map<std::string, Tally> parameters;
  int charges = 0, near = 0;
  std::vector<double> charge_errors;  // [1], of the true current
  int refused = 0;
};

void judge(const BatteryModel& model, const ModelPoint& truth, const Series& measured,
           const Series& exact, const std::vector<char>& drives, Outcome& outcome) {
  ChargerControl source;
  source.voltage_controlled = drives;
  source.rule.present = true;
  source.seen = true;
  source.rule.min_current = -5.0;
  source.repair.dropped.assign(measured.size(), 0);
  IdentifyOptions options;
  options.effects = model.effects();
  options.source = source;
  const IndexRange window = indexRange(measured, 0.0, kWindow - 0.5);
  const FittedModel fitted = identify(measured, window, options);
  if (!isUsable(fitted.fit)) {
    ++outcome.refused;
    return;
  }
  for (std::size_t j = 0; j < fitted.fit.estimates.size(); ++j) {
    const ParameterEstimate& estimate = fitted.fit.estimates[j];
    if (estimate.held || !estimate.std) continue;
    Tally& tally = outcome.parameters[estimate.name];
    const double off = estimate.value - truth.parameters[static_cast<Eigen::Index>(j)];
    ++tally.asked;
    tally.inside += std::abs(off) <= 2.0 * *estimate.std;
    tally.ratios.push_back(off / *estimate.std);
  }
  FittedModel plain = fitted;
  plain.fit.residual_regression = {};
  StateEstimator follower(plain, false);
  InputSequence inputs = inputSequence(measured, {window.last - 1, measured.size()}, {}, drives);
  std::vector<double> current(measured.size(), 0.0);
  for (std::size_t k = 1; k < inputs.samples.size(); ++k)
    current[window.last - 1 + k] = follower.predict(inputs.samples[k]).current;
  const IndexRange ahead{window.last, measured.size()};
  for (const std::size_t first : chargeBeginnings(exact, ahead, drives)) {
    const auto charge = beginningOfCharge(exact, ahead, first, 10.0, drives);
    if (!charge) continue;
    double predicted = 0.0, true_current = 0.0;
    for (std::size_t n = charge->first; n < charge->last; ++n) {
      predicted += current[n];
      true_current += exact.current[n];
    }
    const double error = std::abs(predicted / true_current - 1.0);
    outcome.charge_errors.push_back(error);
    outcome.near += error <= 0.15;
    ++outcome.charges;
  }
}

void print(const char* name, const Outcome& outcome) {
  int inside = 0, asked = 0;
  for (const auto& [parameter, tally] : outcome.parameters) {
    inside += tally.inside;
    asked += tally.asked;
  }
  std::printf(
      "%s: %.1f %% of %d parameters within two standard errors; %.1f %% of %d charges within 15 %% "
      "(median error %.1f %%); %d refused\n",
      name, 100.0 * inside / std::max(asked, 1), asked,
      100.0 * outcome.near / std::max(outcome.charges, 1), outcome.charges,
      100.0 * quantile(outcome.charge_errors, 0.5), outcome.refused);
  for (const auto& [parameter, tally] : outcome.parameters)
    std::printf("  %-24s %5.1f %%   median of error / standard error %+.2f\n", parameter.c_str(),
                100.0 * tally.inside / tally.asked, quantile(tally.ratios, 0.5));
}

}  // namespace

int main(int argc, char** argv) {
  int seeds = 100;
  double offset = 0.1;
  CLI::App app("fits recordings that a known model made");
  app.add_option("--seeds", seeds, "recordings a model")->capture_default_str();
  app.add_option("--offset", offset, "of the current sensor [A]")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  for (const std::vector<std::string>& effects :
       {std::vector<std::string>{"fresh_sulphate"}, std::vector<std::string>{}}) {
    const BatteryModel model(effects);
    Outcome outcome;
    for (int seed = 1; seed <= seeds; ++seed) {
      std::mt19937 dice(static_cast<unsigned>(seed));
      const Imposed1Hz controlled = startStopDrive(dice);
      const ModelPoint truth = drawnTruth(model, dice);
      const Series exact = recordingOf(model, truth, controlled);
      judge(model, truth, asMeasured(exact, offset, dice), exact, controlled.voltage_controlled,
            outcome);
    }
    print(effects.empty() ? "base circuit" : "physics of charging", outcome);
  }
  return 0;
}
