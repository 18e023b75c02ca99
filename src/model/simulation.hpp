#pragma once

#include <Eigen/Core>
#include <memory>
#include <utility>
#include <vector>

#include "model/battery_model.hpp"
#include "model/dual.hpp"
#include "model/input_sequence.hpp"

namespace battery_sof {

/// Where a simulation begins.
struct ModelPoint {
  Eigen::VectorXd parameters;  ///< in the order of BatteryModel::parameters()
  Eigen::VectorXd state;       ///< in the order of BatteryModel::states()
  double time = 0.0;           ///< [s], of the state
  /// [s], where drifts and steps count their time from: the window's first sample
  double reference_time = 0.0;
  /// of a discrepancy model, see Simulation::regressorMemory(); empty: it begins with the
  /// simulation
  std::vector<double> regressor_memory = {};
};

/// A T of its own, of a kind known at run time: copied by T::clone(). Never empty but when moved
/// from.
template <typename T>
class Cloned {
 public:
  Cloned(std::unique_ptr<T> own) : own_(std::move(own)) {}  // NOLINT(google-explicit-constructor)
  Cloned(const Cloned& other) : own_(other.own_->clone()) {}
  Cloned(Cloned&&) noexcept = default;
  Cloned& operator=(Cloned other) noexcept {
    own_ = std::move(other.own_);
    return *this;
  }
  ~Cloned() = default;
  T& operator*() const { return *own_; }
  T* operator->() const { return own_.get(); }

 private:
  std::unique_ptr<T> own_;
};

/**
 * @brief A battery model in time, sample by sample, with the derivatives of everything to whatever
 * is wanted.
 *
 *     C_2 du_c2/dt = i - i_r2(u_c2, ...) - side currents,   u = u_dc + u_c2 + r(i) i + voltages of the effects
 *
 * Without an effect on the double layer a step is exact (ClosedFormStep); without one that has a
 * memory there it is exact for a current matched at its beginning, its length chosen so that it
 * misses at most 2 uV (matchedFlow). Otherwise layer, activity and ladder of a fractional
 * capacitance are stepped together by an implicit Euler step, extrapolated to second order (a step
 * against two halves) and so long that the two differ by at most 0.04 mV: L-stable, positive
 * activities stay positive, no interval is too long. Where a source controls the voltage, these and
 * a limited reaction take one implicit Euler step of layer and effects. Effects' own states have
 * exact steps; where they act back on others, intervals are cut to 0.2 s (history, warming) or
 * 0.5 s (drift), or to a two-hundredth of the time for which the measured current has been the same
 * within 5 % where that is longer. Beyond |alpha beta u_c2| = 300 the reaction's exponentials stay at
 * that value.
 *
 * Derivatives are forward sensitivities of the very step that is taken: every number carries its
 * derivatives along (Dual). A tangent is a direction in the space of parameters and first states, a
 * column of `seeds`: unit vectors give plain derivatives, a factor L of a covariance L L' gives
 * standard deviations.
 */
class Simulation {
 public:
  static constexpr Eigen::Index kMaxTangents = Dual::kMaxTangents;
  using Derivatives =
      Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxTangents, 1>;  ///< one a tangent

  /**
   * @param model  copied.
   * @param start  first state, not stepped.
   * @param seeds  (parameters + states) x tangents, d(parameters, first state) / d(tangent); no
   * columns for values alone.
   * @throws std::invalid_argument for sizes that do not fit, values that are not finite, r, c2 or
   * beta not above zero, or more than kMaxTangents tangents.
   */
  Simulation(const BatteryModel& model, const ModelPoint& start,
             const Eigen::Ref<const Eigen::MatrixXd>& seeds = Eigen::MatrixXd());

  /// Moves to the end of an interval under the measured current. @param step duration >= 0.
  void advance(const InputStep& step) { engine_->advance(step); }
  /// The same of a current that does not change. @param duration >= 0.
  void hold(double current, double duration) {
    advance({time() + duration, duration, current, current});
  }

  /**
   * @brief Moves over `duration` under the one held current that ends at a wanted terminal voltage.
   *
   *     u(t + duration; i) = voltage,   i <= max_current
   *
   * solved by a safeguarded Newton method to 1e-8 A; as a step in the state it is the implicit
   * Euler step of an ideal voltage source, so no interval is too long for it.
   *
   * @return the current [A]; max_current where that leaves the voltage below the wanted one. Its
   * derivatives:
   *   currentDerivatives().
   * @throws std::invalid_argument unless voltage and max_current are finite and duration > 0.
   */
  double advanceAtVoltage(double voltage, double duration, double max_current);

  /**
   * @brief Moves to a sample up to which a source held the voltage: the voltage is the input, the
   * current is the answer.
   *
   *     u goes linearly from where the simulation stands to `voltage`;  i is what makes it so
   *
   * in holds of at most 0.5 s (eight of them at slow rates), each as advanceAtVoltage(). The
   * direction is well posed where that from the current is not: a blocked electrode takes half an
   * ampere whatever its voltage (docs/model.md). A step of no duration only places the sample:
   * nothing is compared there. In a gap the battery rests but for its last second.
   *
   * @param step    current is what was measured; it is compared, it is no input.
   * @param voltage [V], measured at the step's end.
   */
  void followVoltage(const InputStep& step, double voltage);

  /// Moves to a sample in the direction that is controlled there. @return measured less modelled
  /// current [A] where the voltage is the input, voltage [V] elsewhere.
  double follow(const InputSample& sample);

  /// Measured less modelled current of the last followVoltage() [A], the current as the
  /// instruments' effects let it be known.
  double currentError() const { return engine_->currentError(); }
  /// d currentError / d tangent [A].
  Derivatives currentErrorDerivatives() const { return engine_->currentErrorDerivatives(); }

  /// @return d u / d i of a current held for `duration` from here on [Ohm], at its end; moves
  /// nothing.
  double resistanceOver(double current, double duration) {
    return engine_->resistanceOver(current, duration);
  }

  /// Terminal voltage as the voltage channel shows it [V], at the end of the last step.
  double voltage() const { return engine_->voltage(); }
  /// d voltage / d tangent, as many as seeds had columns.
  Derivatives voltageDerivatives() const { return engine_->voltageDerivatives(); }
  /// Derivatives of the last current that advanceAtVoltage() found.
  Derivatives currentDerivatives() const { return engine_->currentDerivatives(); }

  double time() const { return engine_->time(); }
  Eigen::VectorXd state() const { return engine_->state(); }
  /// d state / d tangent, states x tangents.
  Eigen::MatrixXd stateDerivatives() const { return engine_->stateDerivatives(); }
  /// What a discrepancy model remembers, DiscrepancyModel::memorySize() numbers; empty without one.
  std::vector<double> regressorMemory() const { return engine_->regressorMemory(); }
  /// By how much a discrepancy model would differ if it were not held inside what it was estimated
  /// on [V]; 0 without one.
  double beyondIdentified() const { return engine_->beyondIdentified(); }
  Eigen::Index tangents() const { return engine_->tangents(); }
  /// As they were given.
  const Eigen::MatrixXd& seeds() const { return *seeds_; }

  /// What a simulation is in one of its arithmetics.
  class Engine {
   public:
    virtual ~Engine() = default;
    virtual std::unique_ptr<Engine> clone() const = 0;
    virtual void advance(const InputStep& step) = 0;
    virtual double advanceAtVoltage(double voltage, double duration, double max_current) = 0;
    virtual void followVoltage(const InputStep& step, double voltage) = 0;
    virtual double resistanceOver(double current, double duration) = 0;
    virtual double currentError() const = 0;
    virtual Derivatives currentErrorDerivatives() const = 0;
    virtual double voltage() const = 0;
    virtual Derivatives voltageDerivatives() const = 0;
    virtual Derivatives currentDerivatives() const = 0;
    virtual double time() const = 0;
    virtual Eigen::VectorXd state() const = 0;
    virtual Eigen::MatrixXd stateDerivatives() const = 0;
    virtual std::vector<double> regressorMemory() const = 0;
    virtual double beyondIdentified() const = 0;
    virtual Eigen::Index tangents() const = 0;
  };

 private:
  Cloned<Engine> engine_;
  std::shared_ptr<const Eigen::MatrixXd> seeds_;
};

}  // namespace battery_sof
