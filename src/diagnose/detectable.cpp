#include "battery_sof/diagnose/detectable.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "battery_sof/diagnose/held_out_blocks.hpp"
#include "battery_sof/identify/parallel.hpp"

namespace battery_sof {
namespace {

constexpr double kNamed = 6.0;  // z: its square pays for two parameters and the evidence of a name, nearly
constexpr int kTrials = 6;      // of strengths
constexpr int kConfirmations = 3;   // strengths that are asked of a diagnosis
constexpr double kLeastStep = 2.0;  // between them
constexpr double kMostStep = 8.0;

/// The effect's strength that is told; none for one without a typical strength.
const ParameterInfo* toldStrength(const EffectInfo& info) {
  const auto found = std::find_if(info.parameters.begin(), info.parameters.end(), [](const ParameterInfo& parameter) {
    return !parameter.held && parameter.vanishes_at && parameter.magnitude != *parameter.vanishes_at;
  });
  return found == info.parameters.end() ? nullptr : &*found;
}

/// A strength at its magnitude for 1, gone for 0, within its range.
double scaled(const ParameterInfo& info, double times) {
  return std::clamp(*info.vanishes_at + times * (info.magnitude - *info.vanishes_at), info.lower, info.upper);
}

/// The effect so many times as strong as it typically is. @param larger the model with it.
CompositionPoint strengthened(const BatteryModel& larger, const Signature& signature, double times) {
  CompositionPoint point = signature.start;
  for (const ParameterInfo& info : effectInfo(signature.id).parameters)
    if (info.vanishes_at && !info.held && info.magnitude != *info.vanishes_at)
      point.parameters[*larger.parameterRow(info.name)] = scaled(info, times);
  return point;
}

/// What effects would add to the voltage beside a fit, and what its parameters would not take up of it.
class Beside {
 public:
  Beside(const WhitenedFit& fit, const Drive& drive)
      : fit_(fit), drive_(drive), whitening_(fit.noise, drive.samples), modelled_(simulatedVoltage(fit.model, fit.point, drive)) {
    Eigen::MatrixXd columns(fit.jacobian.rows(), fit.jacobian.cols());
    for (Eigen::Index k = 0; k < columns.cols(); ++k) columns.col(k) = whitening_.whitened(fit.jacobian.col(k));
    qr_.compute(columns);
  }

  /// @return what the effect adds where something was measured [V]; zeros where it cannot be computed.
  Eigen::VectorXd added(const Signature& signature, double times) const {
    const BatteryModel larger = enlarged(fit_.model, signature.id);
    Eigen::VectorXd added = simulatedVoltage(larger, strengthened(larger, signature, times), drive_) - modelled_;
    if (!added.allFinite()) return Eigen::VectorXd::Zero(added.size());
    for (Eigen::Index n = 0; n < added.size(); ++n)
      if (!(drive_.samples[static_cast<std::size_t>(n)].count > 0.0)) added[n] = 0.0;
    return added;
  }

  /// What linear parameters leave of it [V].
  Eigen::VectorXd free(const Eigen::VectorXd& added) const { return added - fit_.jacobian * qr_.solve(whitening_.whitened(added)); }

  /// The same model fitted to the voltage with the addition in it.
  WhitenedFit fittedWith(const Eigen::VectorXd& added, const WhitenedSearch& search) const {
    Drive changed = drive_;
    for (Eigen::Index n = 0; n < added.size(); ++n) changed.samples[static_cast<std::size_t>(n)].voltage += added[n];
    return fitWhitened(fit_.model, changed, {fit_.point}, fit_.noise, search);
  }

 private:
  const WhitenedFit& fit_;
  const Drive& drive_;
  Whitening whitening_;
  Eigen::VectorXd modelled_;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr_;
};

/// z of the strongest that is not the effect itself nor one of its twins: it would be taken first.
double strongestBeside(const EffectInfo& info, const std::vector<Signature>& screened) {
  double score = 0.0;
  for (const Signature& other : screened)
    if (other.id != info.id && std::find(info.same_as.begin(), info.same_as.end(), other.id) == info.same_as.end())
      score = std::max(score, other.score);
  return std::sqrt(score);
}

double addedShare(const EffectInfo& info, const DiagnosisThresholds& thresholds) {
  return leastAddedRatio(info.tier() == 'S' ? thresholds.least_structure_share : thresholds.least_share);
}

double freeParameters(const EffectInfo& info) {
  return static_cast<double>(std::count_if(info.parameters.begin(), info.parameters.end(), [](const ParameterInfo& parameter) { return !parameter.held; }));
}

/// How many times stronger the effect, put in so many times as strong as it typically is, would have to be for a name, were
/// the model linear; at most 1 where it has what a name takes.
double lackingFor(const Beside& beside, const WhitenedFit& fit, const Drive& drive, const Signature& signature, double times,
                  const NameRule& rule, const Eigen::VectorXd& held_out, double left) {
  const EffectInfo& info = effectInfo(signature.id);
  const WhitenedFit without = beside.fittedWith(beside.added(signature, times), rule.search);
  const double gain = without.deviance - fit.deviance;
  const double share = addedRatio(without.residual - fit.residual, held_out, drive);
  if (!(gain > 0.0) || !(share > 0.0)) return std::numeric_limits<double>::infinity();
  // With it in, what is left is what this model leaves.
  const NameBeside of_it{1.0 - 1.0 / std::hypot(1.0, share), left};
  const double needed = evidenceNeeded(info.id, rule.accepted, rule.thresholds, of_it) + penaltyOf(without, drive) * freeParameters(info);
  return std::max(std::sqrt(std::max(rule.least_gain, needed) / gain), addedShare(info, rule.thresholds) / share);
}

}  // namespace

std::vector<Detectable> detectableBeside(const WhitenedFit& fit, const Drive& drive, const std::vector<Signature>& screened,
                                         const NameRule& rule, int threads) {
  const Beside beside(fit, drive);
  const Eigen::VectorXd held_out = heldOutErrors(fit, drive, kHeldOutBlocks, threads).error;
  const double left = leftUnexplained(fit, drive);
  std::vector<Detectable> list(screened.size());
  parallelFor(screened.size(), threads, [&](std::size_t k) {
    const Signature& signature = screened[k];
    const EffectInfo& info = effectInfo(signature.id);
    const ParameterInfo* told = toldStrength(info);
    if (!told) return;
    list[k] = {info.id, told->name, told->unit, std::nullopt, told->magnitude, false};
    const double share = addedRatio(beside.free(beside.added(signature, 1.0)), held_out, drive);
    if (!(signature.sensitivity > 0.0) || !(share > 0.0)) return;
    double times = std::max(std::max(kNamed, strongestBeside(info, screened)) / signature.sensitivity, addedShare(info, rule.thresholds) / share);
    const double from_nothing = told->magnitude - *told->vanishes_at;
    const auto isInRange = [&](double some) { return scaled(*told, some) == *told->vanishes_at + some * from_nothing; };
    const BatteryModel larger = enlarged(fit.model, info.id);
    const bool asks = std::find(rule.confirm.begin(), rule.confirm.end(), info.id) != rule.confirm.end();
    const auto isConfirmed = [&](double some) { return rule.is_named(larger, strengthened(larger, signature, some), info.id); };
    int asked = 0;
    for (int trial = 0; trial < kTrials && isInRange(times); ++trial) {
      double lacking = lackingFor(beside, fit, drive, signature, times, rule, held_out, left);
      if (lacking <= 1.0 && isInRange(-times)) lacking = lackingFor(beside, fit, drive, signature, -times, rule, held_out, left);
      if (lacking <= 1.0 && asks && ++asked > kConfirmations) return;
      if (lacking <= 1.0 && (!asks || (isConfirmed(times) && (!isInRange(-times) || isConfirmed(-times))))) {
        list[k].strength = times * std::abs(from_nothing);
        list[k].visible = times <= 1.0;
        return;
      }
      times *= std::clamp(lacking, kLeastStep, kMostStep);
    }
  });
  list.erase(std::remove_if(list.begin(), list.end(), [](const Detectable& one) { return one.id.empty(); }), list.end());
  return list;
}

}  // namespace battery_sof
