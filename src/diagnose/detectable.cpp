#include "battery_sof/diagnose/detectable.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "battery_sof/diagnose/held_out_blocks.hpp"
#include "battery_sof/identify/parallel.hpp"

namespace battery_sof {
namespace {

constexpr double kNamed = 6.0;  // z: its square pays for two parameters and the evidence of a name, nearly
constexpr int kTrials = 6;      // of strengths, each twice the one before

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
    CompositionPoint point = signature.start;
    for (const ParameterInfo& info : effectInfo(signature.id).parameters)
      if (info.vanishes_at && !info.held && info.magnitude != *info.vanishes_at)
        point.parameters[*larger.parameterRow(info.name)] = scaled(info, times);
    Eigen::VectorXd added = simulatedVoltage(larger, point, drive_) - modelled_;
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

/// rms(s_free) / rms(e) over the samples on which s_free acts most; the larger of that and of all samples. @param error e, held out [V].
double shareOfError(const Eigen::VectorXd& free, const Eigen::VectorXd& error, const Drive& drive) {
  double share = 0.0;
  for (const double least : {0.0, leastActing(free)}) {
    double own = 0.0, all = 0.0;
    for (Eigen::Index n = 0; n < free.size(); ++n) {
      const double count = drive.samples[static_cast<std::size_t>(n)].count;
      if (!(count > 0.0) || std::abs(free[n]) < least) continue;
      own += count * free[n] * free[n];
      all += count * error[n] * error[n];
    }
    if (all > 0.0) share = std::max(share, std::sqrt(own / all));
  }
  return share;
}

/// z of the strongest that is not the effect itself nor one of its twins: it would be taken first.
double strongestBeside(const EffectInfo& info, const std::vector<Signature>& screened) {
  double score = 0.0;
  for (const Signature& other : screened)
    if (other.id != info.id && std::find(info.same_as.begin(), info.same_as.end(), other.id) == info.same_as.end())
      score = std::max(score, other.score);
  return std::sqrt(score);
}

/// rms(s_free) / rms(e) that takes a share out of sqrt(e^2 + s_free^2).
double addedShare(const EffectInfo& info, const DiagnosisThresholds& thresholds) {
  const double kept = 1.0 - (info.tier() == 'S' ? thresholds.least_structure_share : thresholds.least_share);
  return std::sqrt(1.0 / (kept * kept) - 1.0);
}

double freeParameters(const EffectInfo& info) {
  return static_cast<double>(std::count_if(info.parameters.begin(), info.parameters.end(), [](const ParameterInfo& parameter) { return !parameter.held; }));
}

/// Whether the effect, put in so many times as strong as it typically is, has what a name takes.
bool wouldBeNamed(const Beside& beside, const WhitenedFit& fit, const Drive& drive, const Signature& signature, double times,
                  const NameRule& rule, const Eigen::VectorXd& held_out) {
  const EffectInfo& info = effectInfo(signature.id);
  const WhitenedFit without = beside.fittedWith(beside.added(signature, times), rule.search);
  const double gain = without.deviance - fit.deviance;
  const double evidence = gain - penaltyOf(without, drive) * freeParameters(info);
  return gain >= rule.least_gain && evidence > evidenceNeeded(info.id, rule.accepted, rule.thresholds) &&
         shareOfError(without.residual - fit.residual, held_out, drive) >= addedShare(info, rule.thresholds);
}

}  // namespace

std::vector<Detectable> detectableBeside(const WhitenedFit& fit, const Drive& drive, const std::vector<Signature>& screened,
                                         const NameRule& rule, int threads) {
  const Beside beside(fit, drive);
  const Eigen::VectorXd held_out = heldOutErrors(fit, drive, kHeldOutBlocks, threads).error;
  std::vector<Detectable> list(screened.size());
  parallelFor(screened.size(), threads, [&](std::size_t k) {
    const Signature& signature = screened[k];
    const EffectInfo& info = effectInfo(signature.id);
    const ParameterInfo* told = toldStrength(info);
    if (!told) return;
    list[k] = {info.id, told->name, told->unit, std::nullopt, told->magnitude, false};
    const double share = shareOfError(beside.free(beside.added(signature, 1.0)), held_out, drive);
    if (!(signature.sensitivity > 0.0) || !(share > 0.0)) return;
    double times = std::max(std::max(kNamed, strongestBeside(info, screened)) / signature.sensitivity, addedShare(info, rule.thresholds) / share);
    const double from_nothing = told->magnitude - *told->vanishes_at;
    const auto isInRange = [&](double some) { return scaled(*told, some) == *told->vanishes_at + some * from_nothing; };
    for (int trial = 0; trial < kTrials && isInRange(times); ++trial, times *= 2.0) {
      if (!wouldBeNamed(beside, fit, drive, signature, times, rule, held_out)) continue;
      if (isInRange(-times) && !wouldBeNamed(beside, fit, drive, signature, -times, rule, held_out)) continue;
      list[k].strength = times * std::abs(from_nothing);
      list[k].visible = times <= 1.0;
      return;
    }
  });
  list.erase(std::remove_if(list.begin(), list.end(), [](const Detectable& one) { return one.id.empty(); }), list.end());
  return list;
}

}  // namespace battery_sof
