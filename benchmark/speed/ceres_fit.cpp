#include "ceres_fit.hpp"

#include <ceres/ceres.h>

#include <array>
#include <cmath>
#include <stdexcept>

namespace battery_sof_bench {
namespace {

using battery_sof::tableOne;

constexpr int kUnknowns = 6;
constexpr double kMaxFirstState = 2.0;  // [V], as in searchWindow()
// Ceres' own default. Down to 1e-14 it costs Ceres up to one evaluation more and changes no
// parameter by 1e-5.
constexpr double kFunctionTolerance = 1e-6;

/// What of one sample does not depend on the unknowns; e_plus = (i + R) / (2 I_0), m = 1 / e_plus.
struct Term {
  double e_plus, m, half_rate_dt;
  double current, voltage, root_weight;
};

std::vector<Term> termsOf(const Samples& samples, double i0) {
  std::vector<Term> terms;
  terms.reserve(samples.size());
  for (const auto& sample : samples) {
    const double i = sample.held.current;
    const double R = std::sqrt(i * i + 4.0 * i0 * i0);
    const double larger = (R + std::abs(i)) / (2.0 * i0);
    const double smaller = 1.0 / larger;
    terms.push_back({i < 0.0 ? smaller : larger, i < 0.0 ? larger : smaller,
                     0.5 * R * sample.held.duration, sample.discharge + sample.charge,
                     sample.voltage, std::sqrt(sample.weight)});
  }
  return terms;
}

/// Magnitudes that the unknowns are normalised by.
std::array<double, kUnknowns> magnitudes() {
  return {tableOne()[0].magnitude,
          tableOne()[1].magnitude,
          tableOne()[2].magnitude,
          tableOne()[3].magnitude,
          battery_sof::BaseParameters{}.u_dc,
          1.0};
}

template <typename T>
struct Unknowns {
  T r_discharge, r_charge, c2, beta, u_dc, u_c2_first;
  explicit Unknowns(const T* x) {
    const auto scale = magnitudes();
    T* const members[kUnknowns] = {&r_discharge, &r_charge, &c2, &beta, &u_dc, &u_c2_first};
    for (int j = 0; j < kUnknowns; ++j) *members[j] = x[j] * scale[j];
  }
  T residual(const Term& term, const T& u_c2) const {
    const T& r = term.current < 0.0 ? r_discharge : r_charge;
    return term.root_weight * (term.voltage - (u_dc + r * term.current + u_c2));
  }
};

struct PlainResiduals {
  std::vector<Term> terms;

  template <typename T>
  bool operator()(const T* x, T* residuals) const {
    using std::exp;
    using std::log;
    const Unknowns<T> p(x);
    T u_c2 = p.u_c2_first;
    for (std::size_t n = 0; n < terms.size(); ++n) {
      const T D = exp(-p.beta * terms[n].half_rate_dt / p.c2);
      const T e_plus(terms[n].e_plus), m(terms[n].m), P = 1.0 - D;
      const T E = exp(0.5 * p.beta * u_c2);
      u_c2 = 2.0 / p.beta * log((E * (e_plus + m * D) + P) / (E * P + e_plus * D + m));
      residuals[n] = p.residual(terms[n], u_c2);
    }
    return true;
  }
};

struct TunedResiduals {
  std::vector<Term> terms;

  template <typename T>
  bool operator()(const T* x, T* residuals) const {
    using std::exp;
    using std::log;
    const Unknowns<T> p(x);
    const T rate = p.beta / p.c2;
    const T scale = 2.0 / p.beta;
    T E = exp(0.5 * p.beta * p.u_c2_first);
    for (std::size_t n = 0; n < terms.size(); ++n) {
      const Term& t = terms[n];
      const T D = exp(-t.half_rate_dt * rate);
      const T P = 1.0 - D;
      const T den = E * P + t.e_plus * D + t.m;
      E = (E * (t.e_plus + t.m * D) + P) / den;
      residuals[n] = p.residual(t, scale * log(E));
    }
    return true;
  }
};

template <typename Residuals>
ceres::CostFunction* autoDiff(std::vector<Term> terms) {
  const int size = static_cast<int>(terms.size());
  return new ceres::AutoDiffCostFunction<Residuals, ceres::DYNAMIC, kUnknowns>(
      new Residuals{std::move(terms)}, size);
}

void setBounds(ceres::Problem& problem, double* x) {
  for (int j = 0; j < 4; ++j) {
    const auto& info = tableOne()[j];
    problem.SetParameterLowerBound(x, j, info.lower / info.magnitude);
    problem.SetParameterUpperBound(x, j, info.upper / info.magnitude);
  }
  problem.SetParameterLowerBound(x, 5, -kMaxFirstState);
  problem.SetParameterUpperBound(x, 5, kMaxFirstState);
}

ceres::Solver::Options solverOptions(bool cholesky) {
  ceres::Solver::Options options;
  options.linear_solver_type = cholesky ? ceres::DENSE_NORMAL_CHOLESKY : ceres::DENSE_QR;
  options.function_tolerance = kFunctionTolerance;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  return options;
}

Optimum fitOf(const double* x, const ceres::Solver::Summary& summary) {
  const Unknowns<double> p(x);
  Optimum fit;
  fit.parameters.r_discharge = p.r_discharge;
  fit.parameters.r_charge = p.r_charge;
  fit.parameters.c2 = p.c2;
  fit.parameters.beta = p.beta;
  fit.parameters.u_dc = p.u_dc;
  fit.u_c2_first = p.u_c2_first;
  fit.cost = 2.0 * summary.final_cost;  // Ceres minimises half the sum of squares
  fit.evaluations = summary.num_residual_evaluations + summary.num_jacobian_evaluations;
  return fit;
}

}  // namespace

std::string toString(const CeresSettings& settings) {
  return std::string("Ceres autodiff, ") +
         (settings.form == CeresForm::kPlain ? "plain, " : "tuned, ") +
         (settings.cholesky ? "Cholesky" : "QR") + (settings.bounds ? ", bounds" : "");
}

std::vector<CeresSettings> allCeresSettings() {
  std::vector<CeresSettings> all;
  for (const CeresForm form : {CeresForm::kPlain, CeresForm::kTuned})
    for (const bool cholesky : {false, true})
      for (const bool bounds : {true, false}) all.push_back({form, cholesky, bounds});
  return all;
}

ceres::CostFunction* makeCostFunction(const Samples& samples, CeresForm form) {
  auto terms = termsOf(samples, battery_sof::BaseParameters{}.i0);
  return form == CeresForm::kPlain ? autoDiff<PlainResiduals>(std::move(terms))
                                   : autoDiff<TunedResiduals>(std::move(terms));
}

Optimum fitWithCeres(const Samples& samples, const CeresSettings& settings) {
  std::array<double, kUnknowns> x = {1.0, 1.0, 1.0, 1.0, 1.0, 0.0};
  ceres::Problem problem;
  problem.AddResidualBlock(makeCostFunction(samples, settings.form), nullptr, x.data());
  if (settings.bounds) setBounds(problem, x.data());
  ceres::Solver::Summary summary;
  ceres::Solve(solverOptions(settings.cholesky), &problem, &summary);
  if (summary.termination_type != ceres::CONVERGENCE)
    throw std::runtime_error(toString(settings) + " did not converge: " + summary.message);
  return fitOf(x.data(), summary);
}

}  // namespace battery_sof_bench
