#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "regression/ridge.hpp"

namespace battery_sof {

/**
 * @brief What drove the battery lately, as numbers that move on with every sample and never look
 * ahead.
 *
 * Low passes of the controlled (else modelled) voltage, of the discharge current and of the
 * modelled current, and the times since a source last held the voltage and since it last did not.
 */
struct InputMemory {
  /// [s]
  static constexpr std::array<double, 4> kVoltageTimes = {3.0, 10.0, 30.0, 100.0};
  /// [s]
  static constexpr std::array<double, 5> kDischargeTimes = {3.0, 10.0, 30.0, 100.0, 300.0};
  /// [s]
  static constexpr std::array<double, 4> kCurrentTimes = {3.0, 10.0, 30.0, 100.0};
  /// [s]
  static constexpr std::array<double, 2> kHeldTimes = {10.0, 100.0};

  std::array<double, 4> voltage = {};    ///< [V]
  std::array<double, 5> discharge = {};  ///< [A]
  std::array<double, 4> current = {};    ///< [A]
  std::array<double, 2> held = {};       ///< [A], of whatever flowed
  double last_voltage = 0.0;             ///< [V]
  double last_discharge = 0.0;           ///< [A], where the current drove; 0 else
  double since_discharge = 300.0;        ///< [s], since the current last drove
  double since_source = 0.0;             ///< [s], since the voltage last drove
  bool begun = false;

  static constexpr std::size_t kNumbers = 20;
  static constexpr Eigen::Index kCurrentColumns = 35, kVoltageColumns = 9;
  std::vector<double> numbers() const;  ///< for a file: kNumbers of them
  /// @throws std::invalid_argument for another size
  static InputMemory fromNumbers(const std::vector<double>& x);

  /// A sample as it was driven and as the model made it.
  struct Moment {
    double duration = 0.0;  ///< [s], since the sample before
    bool voltage_controlled = false;
    double voltage = 0.0;  ///< [V], measured where it is the input, else modelled
    double current = 0.0;  ///< [A], modelled where the voltage is the input, else measured
  };
  /// Moves on to a sample. @return the columns of ResidualRegression: those of a current where the
  /// voltage is the input, else those of a voltage.
  Eigen::VectorXd advance(const Moment& moment);

 private:
  Eigen::VectorXd currentColumns(const Moment& moment, double change) const;
  Eigen::VectorXd voltageColumns(const Moment& moment, double change) const;
};

/**
 * @brief What a model misses in the well-posed direction, estimated over its window: a ridge
 * regression of the current's error where the voltage is the input, and of the voltage's error
 * where the current does, on InputMemory.
 *
 * Penalties are chosen by leaving six (five) blocks of the window out, predictions scaled by what
 * those ask for, columns held inside the range of the window. Where leaving out shows no gain
 * nothing is estimated. Equations first: it is fitted to what they leave.
 */
struct ResidualRegression {
  RidgeFit current;  ///< [A]
  RidgeFit voltage;  ///< [V]
  /// [A], of the window where the voltage drove; predictions stay inside
  double min_current = 0.0, max_current = 0.0;
  bool empty() const { return current.empty() && voltage.empty(); }
};

/// A window's samples as ResidualRegression is fitted to them.
struct ResidualSamples {
  std::vector<Eigen::VectorXd> columns;  ///< one a sample, as InputMemory::advance() returns them
  std::vector<double> error;             ///< [A] or [V], measured less modelled
  std::vector<char> voltage_controlled;
};

/**
 * @param left_out set to what would be predicted of every sample without its block [A] or [V].
 * @return empty parts where there are fewer than 60 samples of a current or 30 of a voltage.
 */
ResidualRegression fitResidualRegression(const ResidualSamples& samples,
                                         std::vector<double>& left_out);

}  // namespace battery_sof
