#include <Eigen/Dense>
#include <ctime>
#include <iostream>
#include "composed_ceres.hpp"
#include "composed_record.hpp"
using namespace battery_sof;
using namespace battery_sof_bench;
template <typename F> double ms(F f) { auto b = std::clock(); f(); return 1e3 * double(std::clock() - b) / CLOCKS_PER_SEC; }
int main(int argc, char**) {
  const BatteryModel model = composedModel();
  const Series series = composedRecord(model, composedTruth(model), 1800.0);
  const Drive full = fullDrive(series, all(series));
  const CompositionPoint start = typicalStart(model, full);
  const CompositionProblem at_full(model, full, {}, start);
  Drive compressed;
  CompositionFit ours;
  const double t = ms([&] {
    compressed = compressedDrive(series, all(series));
    const CompositionProblem problem(model, compressed, {}, start);
    ours = fitComposition(problem, {start});
  });
  const CompositionProblem on_comp(model, compressed, {}, start);
  std::cout << full.samples.size() << " " << compressed.samples.size() << " ms " << t << " passes " << ours.passes << " it " << ours.iterations << " status " << describe(ours.status) << "\n";
  NormalEquations at, at2;
  std::cout << "pass compressed " << ms([&] { on_comp.evaluate(ours.x, at); }) << " full " << ms([&] { at_full.evaluate(ours.x, at); }) << " values " << ms([&] { at_full.residual(ours.x); }) << "\n";
  std::cout.precision(12);
  std::cout << "ours at full " << at.cost << "\n";
  {
    NormalEquations s;
    const Eigen::VectorXd g = at.hessian.ldlt().solve(at.gradient);
    std::cout << "promised at full " << at.gradient.dot(g) / at.cost << "\n";
    CompositionFit fine;
    std::cout << "refine ms " << ms([&] { fine = fitComposition(at_full, {ours.point}); }) << " passes " << fine.passes << " cost " << fine.at.cost << " " << describe(fine.status) << "\n";
    std::cout << (fine.x - ours.x).transpose() << "\n";
    Eigen::MatrixXd cov = fine.at.hessian.inverse() * fine.at.cost / full.samples.size();
    std::cout << (fine.x - ours.x).cwiseQuotient(cov.diagonal().cwiseSqrt()).transpose() << "\n";
  }
  if (argc > 1) return 0;
  for (auto alg : {CeresAlgebra::kQr, CeresAlgebra::kNormalCholesky}) {
    CeresEnd end;
    const double tc = ms([&] { end = fitComposedWithCeres(model, at_full, full, at_full.coordinatesOf(start), alg); });
    at_full.evaluate(end.x, at2);
    std::cout << "ceres ms " << tc << " res " << end.residuals << " jac " << end.jacobians << " cost " << at2.cost << " rel " << at2.cost / at.cost - 1 << " " << end.message << "\n";
    std::cout << (end.x - ours.x).transpose() << "\n";
  }
}
