// Fits base + three effects to 30 minutes at 100 Hz with our search and with Ceres, in turns, and
// writes the times as JSON.
#include <Eigen/Cholesky>
#include <cmath>
#include <functional>

#include "composed_ceres.hpp"
#include "composed_record.hpp"
#include "program.hpp"
#include "stopwatch.hpp"

namespace {

using namespace battery_sof;
using namespace battery_sof_bench;

constexpr double kDuration = 1800.0;    // [s]
constexpr double kSameCost = 1e-4;      // share, evaluated at full rate
constexpr double kSameParameter = 0.5;  // standard errors

/// What every contender is given.
struct Task {
  BatteryModel model = composedModel();
  Series series = composedRecord(model, composedTruth(model), kDuration);
  InputSequence full = inputSequence(series, all(series));
  CompositionPoint start = typicalStart(model, full);
  CompositionProblem problem{model, full, {}, start};
};

struct End {
  Eigen::VectorXd x;
  std::string passes;
};

struct Contender {
  std::string name;
  std::function<End()> run;
  bool must_agree;  // with our optimum at full rate
};

CompositionFit fitCompressed(const Task& task) {
  const InputSequence inputs = compressedInputs(task.series, all(task.series));
  const CompositionProblem problem(task.model, inputs, {}, task.start);
  return fitComposition(problem, {task.start});
}

End ourCompressed(const Task& task) {
  const CompositionFit fit = fitCompressed(task);
  return {fit.x, std::to_string(fit.passes) + " short"};
}

End ours(const Task& task) {
  const CompositionFit near = fitCompressed(task);
  const CompositionFit fit = fitComposition(task.problem, {near.point});
  return {fit.x, std::to_string(near.passes) + " short, " + std::to_string(fit.passes)};
}

End ourFullRate(const Task& task) {
  const CompositionFit fit = fitComposition(task.problem, {task.start});
  return {fit.x, std::to_string(fit.passes)};
}

End ceres(const Task& task, CeresAlgebra algebra) {
  const CeresEnd end = fitComposedWithCeres(task.model, task.problem, task.full,
                                            task.problem.coordinatesOf(task.start), algebra);
  return {end.x, std::to_string(end.residuals) + " values, " + std::to_string(end.jacobians) +
                     " Jacobians"};
}

std::vector<Contender> contendersFor(const Task& task) {
  return {{"ours: compressed, then full rate", [&task] { return ours(task); }, true},
          {"ours: of that on the compressed drive", [&task] { return ourCompressed(task); }, false},
          {"ours: full rate from the start", [&task] { return ourFullRate(task); }, true},
          {"Ceres autodiff, QR", [&task] { return ceres(task, CeresAlgebra::kQr); }, true},
          {"Ceres autodiff, Cholesky",
           [&task] { return ceres(task, CeresAlgebra::kNormalCholesky); }, true}};
}

/// Standard errors of the coordinates, from the curvature at the optimum.
Eigen::VectorXd standardErrors(const Task& task, const Eigen::VectorXd& x) {
  NormalEquations at;
  task.problem.evaluate(x, at);
  const Eigen::Index n = x.size();
  const Eigen::MatrixXd inverse = at.hessian.ldlt().solve(Eigen::MatrixXd::Identity(n, n));
  return (inverse.diagonal() * (at.cost / static_cast<double>(task.full.samples.size())))
      .cwiseSqrt();
}

double costAt(const Task& task, const Eigen::VectorXd& x) {
  NormalEquations at;
  task.problem.evaluate(x, at);
  return at.cost;
}

void requireSame(const Contender& contender, double cost_share, double errors) {
  if (!contender.must_agree || (std::abs(cost_share) <= kSameCost && errors <= kSameParameter))
    return;
  throw std::runtime_error(contender.name + " ended elsewhere: cost away by a share of " +
                           std::to_string(cost_share) + ", a coordinate by " +
                           std::to_string(errors) + " standard errors");
}

/// Ends of all contenders against the first one's.
nlohmann::json endsAsJson(const Task& task, const std::vector<Contender>& contenders) {
  const End first = contenders.front().run();
  const double cost = costAt(task, first.x);
  const Eigen::VectorXd errors = standardErrors(task, first.x);
  nlohmann::json ends = nlohmann::json::array();
  for (const Contender& contender : contenders) {
    const End end = contender.run();
    const double share = costAt(task, end.x) / cost - 1.0;
    const double away = (end.x - first.x).cwiseQuotient(errors).cwiseAbs().maxCoeff();
    requireSame(contender, share, away);
    ends.push_back({{"name", contender.name},
                    {"passes", end.passes},
                    {"cost_share", share},
                    {"standard_errors", away},
                    {"milliseconds", nlohmann::json::array()}});
  }
  return ends;
}

void compare(int rounds, const std::string& out) {
  const Task task;
  const std::vector<Contender> contenders = contendersFor(task);
  nlohmann::json ends = endsAsJson(task, contenders);
  for (int round = 0; round < rounds; ++round)
    for (std::size_t k = 0; k < contenders.size(); ++k)
      ends[k]["milliseconds"].push_back(processorMilliseconds([&] { contenders[k].run(); }));
  writeJson(out, {{"contenders", ends}});
}

}  // namespace

int main(int argc, char** argv) {
  return runBenchmark<int>(argc, argv, "composed_fit ROUNDS OUT.json",
                           [&](int rounds) { compare(rounds, argv[2]); });
}
