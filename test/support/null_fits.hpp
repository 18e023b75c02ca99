#pragma once

#include <Eigen/QR>
#include <cmath>

#include "diagnosis/whitened_fit.hpp"
#include "support/base_drive.hpp"

/// Fits of the base model to its own voltage plus any error, linear in the parameters: one
/// simulation for all draws.
namespace battery_sof::test {

/// White, coloured and walking noise as NoiseModel has it [V], one a sample of the drive; 0 where
/// count is 0.
inline Eigen::VectorXd drawnNoise(const NoiseModel& noise, const InputSequence& inputs,
                                  std::uint64_t seed) {
  Random random(seed * 0x2545F4914F6CDD1DULL + 7);
  Eigen::VectorXd error(static_cast<Eigen::Index>(inputs.samples.size()));
  double drift = 0.0, colored = noise.ar_std * random.normal();
  for (Eigen::Index n = 0; n < error.size(); ++n) {
    const InputSample& sample = inputs.samples[static_cast<std::size_t>(n)];
    const double persistence = std::exp(-sample.step.duration / noise.ar_time);
    colored = persistence * colored +
              noise.ar_std * std::sqrt(1.0 - persistence * persistence) * random.normal();
    drift += noise.walk_std * std::sqrt(sample.step.duration) * random.normal();
    error[n] = sample.count > 0.0
                   ? drift + colored + noise.white_std / std::sqrt(sample.count) * random.normal()
                   : 0.0;
  }
  return error;
}

/// A memory of ten seconds and a walk of 1 mV a minute.
inline const NoiseModel kDrawnNoise{0.002, 0.002, 10.0, 0.001 / std::sqrt(60.0)};

/// The compressed drive whose base model answers it exactly. @param duration [s].
inline InputSequence exactInputs(double duration) {
  const Series series = baseDrive(5, duration, 0.0);
  return compressedInputs(series, {0, series.size()});
}

class NullFits {
 public:
  /// @param drive kept by reference.
  explicit NullFits(const InputSequence& inputs, const BaseParameters& battery = drivenBattery())
      : inputs_(inputs) {
    const BatteryModel model;
    CompositionPoint truth{Eigen::VectorXd(kBaseRows), model.restState()};
    truth.parameters << battery.r_discharge, battery.r_charge, battery.c2, battery.beta,
        battery.u_dc;
    const CompositionProblem problem(model, inputs, FitCost{}, truth);
    const Eigen::MatrixXd seeds = problem.seedsAt(problem.coordinatesOf(truth));
    Simulation simulation(
        model, {truth.parameters, truth.state, inputs.first_time, inputs.first_time}, seeds);
    fit_.model = model;
    fit_.point = truth;
    fit_.jacobian.resize(static_cast<Eigen::Index>(inputs.samples.size()), seeds.cols());
    for (Eigen::Index n = 0; n < fit_.jacobian.rows(); ++n) {
      const InputSample& sample = inputs.samples[static_cast<std::size_t>(n)];
      simulation.advance(sample.step);
      fit_.jacobian.row(n) = simulation.voltageDerivatives().transpose();
    }
    for (Eigen::Index k = 0; k < problem.size(); ++k) fit_.rows.push_back(problem.rowOf(k));
  }

  /// As fitWhitened() would: parameters by squares, noise of what is left, parameters again, noise
  /// again.
  WhitenedFit of(const Eigen::VectorXd& error) const {
    WhitenedFit fit = fit_;
    Eigen::MatrixXd columns = fit.jacobian;
    Eigen::VectorXd target = error;
    for (std::size_t n = 0; n < inputs_.samples.size(); ++n) {
      const double weight = std::sqrt(inputs_.samples[n].count);
      columns.row(static_cast<Eigen::Index>(n)) *= weight;
      target[static_cast<Eigen::Index>(n)] *= weight;
    }
    fit.residual = error - fit.jacobian * columns.householderQr().solve(target);
    clearMasked(fit.residual);
    fit.noise = fitNoise(fit.residual, inputs_.samples);
    for (int round = 0; round < 2; ++round) {
      const Whitening whitening(fit.noise, inputs_.samples);
      for (Eigen::Index k = 0; k < columns.cols(); ++k)
        columns.col(k) = whitening.whitened(fit.jacobian.col(k));
      const auto qr = columns.householderQr();
      fit.residual = error - fit.jacobian * qr.solve(whitening.whitened(error));
      clearMasked(fit.residual);
      if (round == 0) {
        fit.noise = fitNoise(fit.residual, inputs_.samples);
        continue;
      }
      fit.innovation = whitening.whitened(fit.residual);
      fit.biased = Eigen::MatrixXd::Identity(columns.rows(), columns.cols());
      fit.biased.applyOnTheLeft(qr.householderQ());
    }
    fit.deviance = deviance(fit.noise, fit.residual, inputs_.samples);
    return fit;
  }

 private:
  void clearMasked(Eigen::VectorXd& residual) const {
    for (Eigen::Index n = 0; n < residual.size(); ++n)
      if (inputs_.samples[static_cast<std::size_t>(n)].count <= 0.0) residual[n] = 0.0;
  }

  const InputSequence& inputs_;
  WhitenedFit fit_{BatteryModel(), {}, {}, {}, {}, {}, {}, {}, 0.0};
};

inline const InputSequence& tenMinutes() {
  static const InputSequence inputs = exactInputs(600.0);
  return inputs;
}

/// Ten minutes fitted with an error [V] added to kDrawnNoise.
inline WhitenedFit fitOf(const Eigen::VectorXd& error, std::uint64_t seed = 1) {
  static const NullFits fits(tenMinutes());
  return fits.of(drawnNoise(kDrawnNoise, tenMinutes(), seed) + error);
}

inline WhitenedFit nullFit(std::uint64_t seed) {
  return fitOf(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(tenMinutes().samples.size())), seed);
}

}  // namespace battery_sof::test
