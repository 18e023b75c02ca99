#include "composed_ceres.hpp"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace battery_sof_bench {
namespace {

using namespace battery_sof;

constexpr int kUnknowns = 17;
constexpr double kTolerance = 4e-5;  // [V], as in Simulation

double valueOf(double x) { return x; }
template <int N>
double valueOf(const ceres::Jet<double, N>& x) {
  return x.a;
}

/// What the search coordinates represent: logarithms, or shares of a magnitude.
struct Meaning {
  std::array<bool, kUnknowns> logarithmic{};
  std::array<double, kUnknowns> scale{};
};

Meaning meaningOf(const BatteryModel& model) {
  Meaning meaning;
  std::size_t k = 0;
  for (const ParameterInfo& info : model.parameters()) {
    if (info.held) continue;
    meaning.logarithmic.at(k) = info.logarithmic;
    meaning.scale.at(k++) = info.magnitude;
  }
  for (const StateInfo& info : model.states())
    if (info.initial_std) meaning.scale.at(k++) = *info.initial_std;
  if (k != kUnknowns)
    throw std::runtime_error("Ceres: the composition is not the one written down");
  return meaning;
}

template <typename T>
struct Unknowns {
  T r_discharge, r_charge, c2, beta, u_dc;
  T inverse_limit, refill_time;
  T acid_resistance_1, acid_time_1, acid_resistance_2, acid_time_2;
  T low_resistance, resistance_current;
  T u, log_activity, acid_1, acid_2;  // at the first sample

  Unknowns(const T* x, const Meaning& meaning) {
    // Catalogue order.
    T* const members[kUnknowns] = {&r_discharge,
                                   &r_charge,
                                   &c2,
                                   &beta,
                                   &u_dc,
                                   &inverse_limit,
                                   &refill_time,
                                   &low_resistance,
                                   &resistance_current,
                                   &acid_resistance_1,
                                   &acid_time_1,
                                   &acid_resistance_2,
                                   &acid_time_2,
                                   &u,
                                   &log_activity,
                                   &acid_1,
                                   &acid_2};
    for (int k = 0; k < kUnknowns; ++k)
      *members[k] = meaning.logarithmic[k] ? exp(x[k]) : x[k] * meaning.scale[k];
  }
};

/// Double layer and lead ions.
template <typename T>
struct Layer {
  T u, log_activity;
};

/// One implicit Euler step: C (u - u_0) / h = i - I_0 [p(u) exp(b u / 2) - exp(-b u / 2)], I_0 = 1
/// A.
template <typename T>
class EulerStep {
 public:
  EulerStep(const Unknowns<T>& p, const Layer<T>& from, double current, double h)
      : from_(from),
        storage_(p.c2 / h),
        half_beta_(0.5 * p.beta),
        inverse_limit_(p.inverse_limit),
        before_(exp(from.log_activity)),
        refill_(h / p.refill_time),
        current_(current) {}

  Layer<T> end() const {
    T slope;
    const T guess(root());
    const T excess = balance(guess, &slope);
    const T u = guess - excess / T(valueOf(slope));
    const T rising = exp(half_beta_ * u);
    return {u, log(activity(rising, 1.0 / rising))};
  }

 private:
  T activity(const T& rising, const T& falling) const {
    return (before_ + refill_ * (1.0 + falling * inverse_limit_)) /
           (1.0 + refill_ * (1.0 + rising * inverse_limit_));
  }
  T balance(const T& u, T* slope) const {
    const T rising = exp(half_beta_ * u), falling = 1.0 / rising;
    const T p = activity(rising, falling);
    const T fall = refill_ * inverse_limit_ * half_beta_ * (falling + p * rising) /
                   (1.0 + refill_ * (1.0 + rising * inverse_limit_));
    *slope = storage_ + half_beta_ * (p * rising + falling) - fall * rising;
    return storage_ * (u - from_.u) - current_ + p * rising - falling;
  }
  /// Newton's method in doubles, its steps cut to two half-lives of the exponentials.
  double root() const {
    const EulerStep<double> values(*this);
    double u = valueOf(from_.u), slope = 1.0;
    for (int k = 0; k < 100; ++k) {
      const double excess = values.balance(u, &slope);
      const double reach = 2.0 / valueOf(half_beta_);
      const double step = std::max(-reach, std::min(reach, -excess / slope));
      u += step;
      if (std::abs(step) < 1e-13) break;
    }
    return u;
  }

  template <typename>
  friend class EulerStep;
  template <typename Other>
  explicit EulerStep(const EulerStep<Other>& o)
      : from_{valueOf(o.from_.u), valueOf(o.from_.log_activity)},
        storage_(valueOf(o.storage_)),
        half_beta_(valueOf(o.half_beta_)),
        inverse_limit_(valueOf(o.inverse_limit_)),
        before_(valueOf(o.before_)),
        refill_(valueOf(o.refill_)),
        current_(o.current_) {}

  Layer<T> from_;
  T storage_, half_beta_, inverse_limit_, before_, refill_;
  double current_;
};

/// One interval, in as many extrapolated steps as the tolerance wants.
template <typename T>
void advanceLayer(const Unknowns<T>& p, double current, double duration, Layer<T>& layer,
                  double& suggested) {
  double left = duration;
  while (left > 0.0) {
    const double h = suggested < 0.999 * left ? suggested : left;
    const Layer<T> whole = EulerStep<T>(p, layer, current, h).end();
    const Layer<T> half = EulerStep<T>(p, layer, current, 0.5 * h).end();
    const Layer<T> halves = EulerStep<T>(p, half, current, 0.5 * h).end();
    const double error = std::abs(valueOf(whole.u) - valueOf(halves.u)) +
                         2.0 / valueOf(p.beta) *
                             std::abs(valueOf(whole.log_activity) - valueOf(halves.log_activity));
    const double factor = 0.9 * std::sqrt(kTolerance / std::max(error, 1e-12));
    const double wanted = h * std::max(0.2, std::min(4.0, factor));
    if (error > kTolerance) {
      suggested = wanted;
      continue;
    }
    layer = {2.0 * halves.u - whole.u, 2.0 * halves.log_activity - whole.log_activity};
    left -= h;
    suggested = std::max(wanted, h < suggested ? suggested : wanted);
  }
}

/// w (u_b - u_m) over the whole drive.
struct Residuals {
  const InputSequence& inputs;
  std::vector<double> root_weight;
  Meaning meaning;

  template <typename T>
  bool operator()(const T* x, T* residuals) const {
    using std::abs;
    const Unknowns<T> p(x, meaning);
    Layer<T> layer{p.u, p.log_activity};
    T acid_1 = p.acid_1, acid_2 = p.acid_2;
    double suggested = 1.0;  // [s]
    for (std::size_t n = 0; n < inputs.samples.size(); ++n) {
      const InputStep& step = inputs.samples[n].step;
      advanceLayer(p, step.held, step.duration, layer, suggested);
      acid_1 = step.held + (acid_1 - step.held) * exp(-step.duration / p.acid_time_1);
      acid_2 = step.held + (acid_2 - step.held) * exp(-step.duration / p.acid_time_2);
      const double i = step.current;
      const T r = (i < 0.0 ? p.r_discharge : p.r_charge) +
                  p.low_resistance / (1.0 + abs(i) / p.resistance_current);
      const T u =
          p.u_dc + layer.u + r * i + p.acid_resistance_1 * acid_1 + p.acid_resistance_2 * acid_2;
      residuals[n] = root_weight[n] * (inputs.samples[n].voltage - u);
    }
    return true;
  }
};

/// (x - mean) / std of every coordinate; weight 0 without a prior.
struct Priors {
  Eigen::VectorXd mean, root_weight;

  template <typename T>
  bool operator()(const T* x, T* residuals) const {
    for (int k = 0; k < kUnknowns; ++k) residuals[k] = root_weight[k] * (x[k] - mean[k]);
    return true;
  }
};

ceres::CostFunction* dataCost(const BatteryModel& model, const CompositionProblem& problem,
                              const InputSequence& inputs) {
  auto* residuals = new Residuals{inputs, {}, meaningOf(model)};
  for (std::size_t k = 0; k < inputs.samples.size(); ++k)
    residuals->root_weight.push_back(std::sqrt(problem.weightOf(k)));
  return new ceres::AutoDiffCostFunction<Residuals, ceres::DYNAMIC, kUnknowns>(
      residuals, static_cast<int>(inputs.samples.size()));
}

ceres::CostFunction* priorCost(const BatteryModel& model, const CompositionProblem& problem) {
  const Eigen::VectorXd mean =
      problem.coordinatesOf({model.typicalParameters(), model.restState()});
  const Eigen::VectorXd weight = problem.priorWeight() * problem.priorInformation(mean).diagonal();
  return new ceres::AutoDiffCostFunction<Priors, kUnknowns, kUnknowns>(
      new Priors{mean, weight.cwiseSqrt()});
}

}  // namespace

CeresEnd fitComposedWithCeres(const BatteryModel& model, const CompositionProblem& problem,
                              const InputSequence& inputs, const Eigen::VectorXd& start,
                              CeresAlgebra algebra) {
  CeresEnd end{start, 0, 0, ""};
  ceres::Problem ceres_problem;
  ceres_problem.AddResidualBlock(dataCost(model, problem, inputs), nullptr, end.x.data());
  ceres_problem.AddResidualBlock(priorCost(model, problem), nullptr, end.x.data());
  for (int k = 0; k < kUnknowns; ++k) {
    ceres_problem.SetParameterLowerBound(end.x.data(), k, problem.lower()[k]);
    ceres_problem.SetParameterUpperBound(end.x.data(), k, problem.upper()[k]);
  }
  ceres::Solver::Options options;
  options.linear_solver_type =
      algebra == CeresAlgebra::kQr ? ceres::DENSE_QR : ceres::DENSE_NORMAL_CHOLESKY;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &ceres_problem, &summary);
  end.residuals = summary.num_residual_evaluations;
  end.jacobians = summary.num_jacobian_evaluations;
  end.message = summary.message;
  if (!summary.IsSolutionUsable()) throw std::runtime_error("Ceres: " + summary.message);
  return end;
}

}  // namespace battery_sof_bench
